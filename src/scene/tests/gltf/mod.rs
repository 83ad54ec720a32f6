//! glTF and GLB against the walk over plain JSON.

mod bad;
pub(super) mod walk;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::*;

/// Bytes of a buffer, a part at a time.
#[derive(Default)]
struct Bin(Vec<u8>);

impl Bin {
    /// Appends a part and gives its place as a buffer view.
    fn view(&mut self, bytes: impl IntoIterator<Item = u8>) -> Value {
        self.0.resize(self.0.len().next_multiple_of(4), 0xAA);
        let start = self.0.len();
        self.0.extend(bytes);
        json!({ "buffer": 0, "byteOffset": start, "byteLength": self.0.len() - start })
    }
}

fn floats(v: &[[f32; 3]]) -> Vec<u8> {
    v.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()
}

/// A GLB of `doc`, whose first buffer is `bin`.
pub(super) fn glb(doc: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = serde_json::to_vec(doc).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend_from_slice(&((12 + 8 + text.len() + 8 + bin.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", bin)] {
        out.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
        out.extend_from_slice(kind);
        out.extend_from_slice(&chunk);
    }
    out
}

/// The same as JSON with the buffer in it.
pub(super) fn embedded(doc: &Value, bin: &[u8]) -> Vec<u8> {
    let mut doc = doc.clone();
    doc["buffers"][0]["uri"] =
        format!("data:application/octet-stream;base64,{}", STANDARD.encode(bin)).into();
    serde_json::to_vec_pretty(&doc).unwrap()
}

/// The document and the first buffer of what [`glb`] or [`embedded`] made.
pub(super) fn split(file: &[u8]) -> (Value, Vec<u8>) {
    if file.starts_with(b"glTF") {
        let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
        return (serde_json::from_slice(&file[20..20 + length]).unwrap(), file[28 + length..].to_vec());
    }
    let doc: Value = serde_json::from_slice(file).unwrap();
    let uri = doc["buffers"][0]["uri"].as_str().unwrap();
    let bin = STANDARD.decode(uri.split_once(',').unwrap().1).unwrap();
    (doc, bin)
}

/// A plain soup: one mesh, no indices, no transform.
pub(super) fn plain(vertices: &[[f32; 3]]) -> (Value, Vec<u8>) {
    let mut bin = Bin::default();
    let view = bin.view(floats(vertices));
    let doc = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": vertices.len(), "type": "VEC3" }],
        "bufferViews": [view], "buffers": [{ "byteLength": bin.0.len() }]
    });
    (doc, bin.0)
}

/// Everything at once: see the keys.
fn rich() -> (Value, Vec<u8>) {
    let mut bin = Bin::default();
    let points: Vec<[f32; 3]> =
        (0..8).map(|i| [i as f32 * 0.7 - 1.0, (i * i % 5) as f32, (i % 3) as f32 * 0.3]).collect();
    let mut views = vec![bin.view(floats(&points))];
    views.push(bin.view([0u8, 1, 2, 2, 1, 7, 3, 4])); // two too many
    views.push(bin.view([0u16, 1, 2, 3, 4, 5].iter().flat_map(|i| i.to_le_bytes())));
    views.push(bin.view([6u32, 5, 4, 0].iter().flat_map(|i| i.to_le_bytes())));
    // Interleaved: 12 bytes of position, 4 of something else.
    views.push(bin.view(points.iter().flat_map(|p| [floats(&[*p]), vec![9; 4]].concat())));
    views[4]["byteStride"] = 16.into();
    views.push(bin.view([1u16, 4].iter().flat_map(|i| i.to_le_bytes())));
    views.push(bin.view(floats(&[[9.0, 8.0, 7.0], [-3.0, 0.5, 2.0]])));
    views.push(
        bin.view(
            [-32768i16, 0, 32767, 0, 100, 200, 300, 0, -5, 7, 9, 0].iter().flat_map(|i| i.to_le_bytes()),
        ),
    );
    views[7]["byteStride"] = 8.into();
    views.push(bin.view([0u8, 128, 255, 0, 3, 4, 5, 0, 90, 80, 70, 0]));
    views[8]["byteStride"] = 4.into();
    let f32s = |view: usize, offset: usize, count: usize| json!({ "bufferView": view, "byteOffset": offset, "componentType": 5126, "count": count, "type": "VEC3" });
    let indices = |view: usize, kind: usize, count: usize| json!({ "bufferView": view, "componentType": kind, "count": count, "type": "SCALAR" });
    let sparse = json!({ "count": 2, "indices": { "bufferView": 5, "componentType": 5123 }, "values": { "bufferView": 6 } });
    let mut based = f32s(0, 0, 6);
    based["sparse"] = sparse.clone();
    let accessors = json!([
        f32s(0, 0, 8), indices(1, 5121, 8), indices(2, 5123, 6), indices(3, 5125, 4), f32s(4, 32, 6),
        based, { "componentType": 5126, "count": 6, "type": "VEC3", "sparse": sparse },
        { "bufferView": 7, "componentType": 5122, "normalized": true, "count": 3, "type": "VEC3" },
        { "bufferView": 7, "componentType": 5123, "count": 3, "type": "VEC3" },
        { "bufferView": 8, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC3" },
        { "bufferView": 8, "componentType": 5120, "count": 3, "type": "VEC3" },
    ]);
    let of = |position: usize| json!({ "attributes": { "POSITION": position, "_CUSTOM": 0 } });
    let with = |position: usize, indices: usize, mode: usize, material: usize| json!({ "attributes": { "POSITION": position }, "indices": indices, "mode": mode, "material": material });
    let half = 0.5f64.sqrt();
    let doc = json!({
        "asset": { "version": "2.0" }, "scene": 0,
        "extensionsUsed": ["KHR_mesh_quantization", "KHR_materials_unlit"], "extensionsRequired": ["KHR_mesh_quantization", "KHR_materials_unlit"],
        "scenes": [{ "nodes": [0, 3] }, { "nodes": [4] }],
        "nodes": [
            { "children": [1, 2], "translation": [1, -2, 3], "rotation": [0, half, 0, half], "scale": [2, 1, 0.5] },
            { "mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1] },
            { "mesh": 1, "scale": [-1, 1, 1], "children": [5], "rotation": [0.5, 0.5, 0.5, 0.5] },
            { "mesh": 0 }, { "mesh": 1 }, { "mesh": 2, "scale": [1, 1, -3] }
        ],
        "meshes": [
            { "primitives": [with(0, 1, 4, 0), with(4, 2, 5, 1), with(0, 3, 6, 0)] },
            { "primitives": [of(5), of(6), { "attributes": { "POSITION": 0 }, "mode": 1 }, { "attributes": { "POSITION": 0 }, "mode": 0 }] },
            { "primitives": [of(7), of(8), of(9), of(10)] }
        ],
        "materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 0.125, 1] } }, {}],
        "accessors": accessors, "bufferViews": views, "buffers": [{ "byteLength": bin.0.len() }]
    });
    (doc, bin.0)
}

#[track_caller]
fn same_as_walked(scene: &Scene, doc: &Value, bin: &[u8]) {
    let walked = walk::triangles(doc, &[bin.to_vec()]);
    assert_eq!(scene.triangles.len(), walked.len());
    for (i, (corners, material)) in walked.iter().enumerate() {
        for (read, walked) in scene.corners(i).iter().flatten().zip(corners.iter().flatten()) {
            let off = (f64::from(*read) - walked).abs();
            assert!(
                off <= 1e-6 * (1.0 + walked.abs()),
                "triangle {i}: {:?} and {corners:?}",
                scene.corners(i)
            );
        }
        let factor = |m: &usize| -> [f32; 3] {
            let c = &doc["materials"][*m]["pbrMetallicRoughness"]["baseColorFactor"];
            std::array::from_fn(|k| c[k].as_f64().unwrap_or(1.0) as f32)
        };
        assert_eq!(scene.materials.color(i), material.as_ref().map(factor), "triangle {i}");
    }
}

#[test]
fn the_walk_agrees() {
    let (doc, bin) = rich();
    for (extension, file) in
        [("gltf", embedded(&doc, &bin)), ("GLB", glb(&doc, &bin)), ("gltf", glb(&doc, &bin))]
    {
        let scene = read(extension, &file).unwrap();
        same_as_walked(&scene, &doc, &bin);
        let warned: Vec<_> = scene.warnings.iter().map(|w| (w.count, w.first.as_str())).collect();
        assert_eq!(
            warned,
            [(2, "primitive 2 (mesh 1)"), (1, "primitive 0 (mesh 0)")],
            "{:?}",
            scene.warnings
        );
    }
}

#[test]
fn which_nodes_are_taken() {
    let (mut doc, bin) = rich();
    let count = |doc: &Value| read("glb", &glb(doc, &bin)).unwrap().triangles.len();
    let all = count(&doc);
    doc["scene"] = 1.into();
    assert_eq!(count(&doc), 4, "the default scene");
    doc.as_object_mut().unwrap().remove("scene");
    assert_eq!(count(&doc), all + 4, "every scene");
    doc["scenes"][1]["nodes"] = json!([3, 4]);
    assert_eq!(count(&doc), all + 4, "each root once");
    doc.as_object_mut().unwrap().remove("scenes");
    assert_eq!(count(&doc), all + 4, "the nodes that are no node's child");
}

#[test]
fn fronts_stay_fronts() {
    let (mut doc, bin) = plain(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    doc["nodes"][0]["scale"] = json!([1, 1, -1]);
    let s = read("glb", &glb(&doc, &bin)).unwrap();
    assert_eq!(s.corners(0), [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
    doc["nodes"][0]["scale"] = json!([-1, 1, -1]);
    let s = read("glb", &glb(&doc, &bin)).unwrap();
    assert_eq!(s.corners(0), [[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}

proptest::proptest! {
    #[test]
    fn any_bits_as_glb(raw in proptest::collection::vec(proptest::array::uniform9(proptest::num::u32::ANY), 1..30)) {
        let vertices: Vec<[f32; 3]> =
            raw.iter().flat_map(|r| [0, 3, 6].map(|k| [0, 1, 2].map(|i| f32::from_bits(r[k + i])))).collect();
        let (doc, bin) = plain(&vertices);
        for file in [glb(&doc, &bin), embedded(&doc, &bin)] {
            let scene = read("glb", &file).unwrap();
            let bits = |v: &[[f32; 3]]| v.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
            proptest::prop_assert_eq!(bits(&scene.positions), bits(&vertices));
            proptest::prop_assert_eq!(scene.triangles.len(), raw.len());
        }
    }
}
