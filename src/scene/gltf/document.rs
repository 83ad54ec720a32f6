//! The JSON document, validated: every index in it names something.

use std::path::Path;

use gltf::json;
use gltf::json::Root;
use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Error, Validate};

use super::DAMAGED;
use crate::scene::SceneError;

/// Extensions, or beginnings of their names, that may be required: they change no triangle, or are known here.
const KNOWN: &[&str] = &[
    "EXT_lights_",
    "EXT_texture_",
    "KHR_animation_pointer",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_mesh_quantization",
    "KHR_texture_",
    "MSFT_texture_dds",
];
/// Bytes of the header of a GLB.
const HEADER: usize = 12;

/// The document and, of a GLB, its bytes.
///
/// # Errors
/// No JSON, no glTF 2.0, a required extension that isn't known, an index that names nothing.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<(Root, Option<Vec<u8>>), SceneError> {
    let invalid = |place: &str, what, fix: &str| SceneError::invalid(path, place, what, fix);
    // The crate takes 12 from the length without looking.
    if bytes.starts_with(b"glTF") {
        let length = bytes.get(8..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        if length.is_none_or(|l| (l as usize) < HEADER) {
            return Err(invalid("header", "it is no GLB header of 12 bytes".to_owned(), DAMAGED));
        }
    }
    let read = gltf::Gltf::from_slice_without_validation(bytes);
    let gltf::Gltf { document, blob } = read.map_err(|e| match e {
        gltf::Error::Deserialize(e) => invalid("JSON", format!("no glTF 2.0: {e}"), DAMAGED),
        e => invalid("chunks", e.to_string(), DAMAGED),
    })?;
    let root = document.into_json();
    let version = &root.asset.version;
    if !version.starts_with("2.") {
        return Err(invalid("asset.version", format!("{version:?} is not 2.0"), "export it as glTF 2.0"));
    }
    if let Some(unknown) = root.extensions_required.iter().find(|e| !KNOWN.iter().any(|k| e.starts_with(k))) {
        let fix = if unknown.contains("compression") {
            "unpack it: gltf-transform copy packed.glb plain.glb"
        } else {
            "export it without"
        };
        return Err(invalid(
            "extensionsRequired",
            format!("the file needs {unknown}, which is not read"),
            fix,
        ));
    }
    match fault(&root) {
        Some((place, error)) => Err(invalid(&place, error.to_string(), DAMAGED)),
        None => Ok((root, blob)),
    }
}

/// The first fault that matters here, and where it is.
fn fault(root: &Root) -> Option<(String, Error)> {
    let positions = Checked::Valid(Semantic::Positions);
    // The crate's validation itself indexes by these.
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if primitive.attributes.get(&positions).is_some_and(|a| a.value() >= root.accessors.len()) {
                let place = format!("meshes[{m}].primitives[{p}].attributes[\"POSITION\"]");
                return Some((place, Error::IndexOutOfBounds));
            }
        }
    }
    let mut first = None;
    root.validate(root, json::Path::new, &mut |path, error| {
        let path = path();
        let path = path.as_str();
        let harmless = match error {
            // Judged above.
            Error::Unsupported => true,
            // Bounds that are said are not used, nor are attributes of unknown names.
            Error::Missing | Error::Invalid => {
                path.ends_with(".min") || path.ends_with(".max") || path.contains(".attributes[\"<invalid")
            }
            Error::IndexOutOfBounds | Error::Oversize => false,
        };
        if !harmless && first.is_none() {
            first = Some((path.to_owned(), error));
        }
    });
    first
}
