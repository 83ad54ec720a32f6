//! glTF 2.0 in one file (GLB), a node, a mesh and a material a part. Each face has vertices of its own, for its normal.

use super::{Part, halves};
use crate::scene::SceneError;
use glam::DVec3;
use serde_json::{Value, json};

/// `componentType` of accessors, and `target` of buffer views (glTF 2.0, 5.1.3, 5.11.5).
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// Bytes of the JSON and the headers, at most: a part takes below 2 KB.
const MARGIN: u64 = 1 << 16;

/// GLB of `parts`; those without a face are left out.
///
/// # Errors
/// No face at all; more than a GLB's lengths can say, 4 GiB.
pub fn glb(name: &str, parts: &[Part]) -> Result<Vec<u8>, SceneError> {
    let too_large = |what| SceneError::TooLarge { name: name.to_owned(), what };
    let faces: u64 = parts.iter().map(|p| p.faces.len() as u64).sum();
    if faces == 0 {
        return Err(SceneError::Empty { path: name.into(), what: format!("{} parts", parts.len()) });
    }
    // Four vertices of two vectors, six indices.
    let bytes = faces * (4 * 24 + 6 * 4);
    if bytes + MARGIN > u32::MAX.into() {
        return Err(too_large(format!("{faces} faces take {bytes} bytes, and a GLB holds 4 GiB")));
    }
    let mut file = File { bytes: Vec::with_capacity(bytes as usize), ..File::default() };
    parts.iter().filter(|p| !p.faces.is_empty()).for_each(|p| file.part(p));
    let nodes: Vec<usize> = (0..file.nodes.len()).collect();
    let root = json!({
        "asset": { "version": "2.0", "generator": concat!("boxwood ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "name": name, "nodes": nodes }],
        "nodes": file.nodes,
        "meshes": file.meshes,
        "materials": file.materials,
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{ "byteLength": file.bytes.len() }],
    });
    let json = root.to_string().into_bytes().into();
    let header = gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 };
    let glb = gltf::Glb { header, json, bin: Some(file.bytes.into()) };
    glb.to_vec().map_err(|e| too_large(e.to_string()))
}

/// What the document names, so far.
#[derive(Default)]
struct File {
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    bytes: Vec<u8>,
}

impl File {
    fn part(&mut self, part: &Part) {
        let corners: Vec<[f32; 3]> =
            part.faces.iter().flatten().map(|v| part.positions[*v as usize]).collect();
        let normals: Vec<[f32; 3]> =
            corners.as_chunks().0.iter().flat_map(|face| [normal(face); 4]).collect();
        let indices: Vec<u32> = (0..part.faces.len() as u32)
            .flat_map(|f| halves([0, 1, 2, 3].map(|k| 4 * f + k)))
            .flatten()
            .collect();
        let floats = |of: &[[f32; 3]]| of.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
        let bound = |pick: fn(f32, f32) -> f32| {
            corners.iter().copied().reduce(|a, b| std::array::from_fn(|k| pick(a[k], b[k])))
        };
        let (min, max) = (bound(f32::min), bound(f32::max));
        let vertices = json!({ "componentType": FLOAT, "type": "VEC3", "count": corners.len() });
        let mut bounded = vertices.clone();
        (bounded["min"], bounded["max"]) = (json!(min), json!(max));
        let position = self.accessor(&floats(&corners), ARRAY_BUFFER, bounded);
        let normal = self.accessor(&floats(&normals), ARRAY_BUFFER, vertices);
        let index = self.accessor(
            &indices.iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<_>>(),
            ELEMENT_ARRAY_BUFFER,
            json!({ "componentType": UNSIGNED_INT, "type": "SCALAR", "count": indices.len() }),
        );
        let number = self.meshes.len();
        self.materials.push(json!({
            "name": part.name,
            "alphaMode": if part.color[3] < 1.0 { "BLEND" } else { "OPAQUE" },
            "pbrMetallicRoughness": { "baseColorFactor": part.color, "metallicFactor": 0, "roughnessFactor": 1 },
        }));
        self.meshes.push(json!({
            "name": part.name,
            "primitives": [{
                "attributes": { "POSITION": position, "NORMAL": normal },
                "indices": index,
                "material": number,
            }],
        }));
        self.nodes.push(json!({ "name": part.name, "mesh": number }));
    }

    /// Takes `bytes`, a multiple of four, as a view of its own for `accessor`; its number.
    fn accessor(&mut self, bytes: &[u8], target: u32, mut accessor: Value) -> usize {
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target,
        }));
        self.bytes.extend_from_slice(bytes);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

/// Outward from a face; one without area has some normal, for it must have one of unit length.
fn normal(face: &[[f32; 3]; 4]) -> [f32; 3] {
    let [a, b, c, d] = face.map(|p| DVec3::from_array(p.map(f64::from)));
    let [first, second] = [c - a, d - b].map(|v| v.normalize_or_zero());
    first.cross(second).normalize_or(DVec3::Z).as_vec3().to_array()
}
