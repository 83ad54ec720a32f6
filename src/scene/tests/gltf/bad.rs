//! What must not be read, and must not hang or panic.

use super::*;

const CORNERS: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// The plain document, changed, must be refused.
#[track_caller]
fn changed(change: impl FnOnce(&mut Value), says: &[&str]) {
    let (mut doc, bin) = plain(&CORNERS);
    change(&mut doc);
    refused("glb", &glb(&doc, &bin), says);
}

#[test]
fn documents() {
    refused("gltf", b"", &["JSON"]);
    refused("gltf", b"{", &["JSON", "line 1"]);
    refused("gltf", b"{}", &["JSON", "asset"]);
    refused("gltf", br#"{"asset":{"version":"1.0"}}"#, &["asset.version", "1.0", "export"]);
    refused("gltf", br#"{"asset":{"version":"2.0"}}"#, &["no triangle"]);
    refused("gltf", &[b"[".repeat(100_000)].concat(), &["JSON"]);
    let sound = glb(&plain(&CORNERS).0, &plain(&CORNERS).1);
    refused("glb", &sound[..11], &["header"]);
    refused("glb", &sound[..sound.len() - 1], &["chunks"]);
    let mut short = sound.clone();
    short[8..12].fill(0);
    refused("glb", &short, &["header"]);
    let mut old = sound;
    old[4] = 1;
    refused("glb", &old, &["version"]);
}

#[test]
fn extensions() {
    let needs = |e: &str| {
        let e = e.to_owned();
        move |doc: &mut Value| doc["extensionsRequired"] = json!([e])
    };
    changed(needs("KHR_draco_mesh_compression"), &["extensionsRequired", "KHR_draco", "gltf-transform copy"]);
    changed(needs("EXT_meshopt_compression"), &["EXT_meshopt", "gltf-transform copy"]);
    changed(needs("EXT_mesh_gpu_instancing"), &["EXT_mesh_gpu_instancing", "export it without"]);
}

#[test]
fn nodes() {
    changed(|d| d["nodes"] = json!([{ "mesh": 0, "children": [0] }]), &["node 0", "reached twice"]);
    let ring = json!([{ "children": [1] }, { "children": [2], "mesh": 0 }, { "children": [1] }]);
    changed(|d| d["nodes"] = ring, &["node 1", "reached twice"]);
    // Each layer names the next one twice: 2^60 ways down.
    let doubled: Vec<Value> =
        (0..60).map(|i| json!({ "children": [i + 1, i + 1] })).chain([json!({ "mesh": 0 })]).collect();
    changed(|d| d["nodes"] = doubled.into(), &["node ", "reached twice"]);
    changed(|d| d["nodes"][0]["rotation"] = json!([0, 0, 0, 0]), &["node 0", "quaternion"]);
    changed(|d| d["nodes"][0]["mesh"] = 7.into(), &["nodes[0].mesh", "out of bounds"]);
    changed(|d| d["nodes"][0]["children"] = json!([9]), &["nodes[0].children", "out of bounds"]);
    changed(|d| d["scene"] = 3.into(), &["scene", "out of bounds"]);
    changed(|d| d["nodes"] = json!([{}]), &["no triangle"]);
    // As deep as one likes.
    let (mut doc, bin) = plain(&CORNERS);
    let step = |i: usize| json!({ "children": [i + 1], "translation": [1, 0, 0] });
    doc["nodes"] = (0..50_000).map(step).chain([json!({ "mesh": 0 })]).collect::<Vec<_>>().into();
    assert_eq!(read("glb", &glb(&doc, &bin)).unwrap().corners(0)[0], [50_000.0, 0.0, 0.0]);
}

#[test]
fn accessors() {
    let at = "primitive 0 (mesh 0)";
    changed(
        |d| d["accessors"][0]["count"] = 4.into(),
        &[at, "accessor 0", "4 elements", "beyond the 36 bytes"],
    );
    for huge in [u64::MAX, u64::MAX / 12, 1 << 40] {
        changed(|d| d["accessors"][0]["count"] = huge.into(), &[at, "accessor 0", "beyond the 36 bytes"]);
        changed(|d| d["accessors"][0]["byteOffset"] = huge.into(), &[at, "accessor 0", "beyond"]);
        changed(|d| d["bufferViews"][0]["byteOffset"] = huge.into(), &[at, "buffer view 0", "beyond"]);
        changed(|d| d["bufferViews"][0]["byteLength"] = huge.into(), &[at, "buffer view 0", "beyond"]);
        changed(|d| d["buffers"][0]["byteLength"] = huge.into(), &["buffer 0", "it should have"]);
    }
    changed(|d| d["accessors"][0]["count"] = 0.into(), &["no triangle"]);
    changed(|d| d["bufferViews"][0]["byteStride"] = 8.into(), &[at, "12 bytes 8 bytes apart"]);
    changed(|d| d["accessors"][0]["type"] = "VEC2".into(), &[at, "VEC3"]);
    changed(|d| d["accessors"][0]["type"] = "MAT4".into(), &[at, "beyond"]);
    changed(|d| d["accessors"][0]["componentType"] = 5125.into(), &[at, "VEC3"]);
    changed(|d| d["accessors"][0]["componentType"] = 1.into(), &["accessors[0].componentType"]);
    changed(
        |d| d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 5.into(),
        &["POSITION", "out of bounds"],
    );
    changed(|d| d["meshes"][0]["primitives"][0]["attributes"] = json!({}), &["POSITION", "Missing"]);
    changed(|d| d["meshes"][0]["primitives"][0]["indices"] = 0.into(), &[at, "SCALAR"]);
    changed(|d| d["meshes"][0]["primitives"][0]["mode"] = 9.into(), &["mode"]);
    let sparse = |count: u64, indices: u64| {
        json!([{ "componentType": 5126, "count": count, "type": "VEC3", "sparse": {
            "count": 2, "indices": { "bufferView": 0, "byteOffset": indices, "componentType": 5121 },
            "values": { "bufferView": 0 } } }])
    };
    changed(|d| d["accessors"] = sparse(3, 0), &[at, "do not ascend"]);
    // Bytes 15 and 16 are 3f and 0 (of 1.0); 14 and 15 are 80 and 3f.
    changed(|d| d["accessors"] = sparse(3, 15), &[at, "do not ascend"]);
    changed(|d| d["accessors"] = sparse(1 << 40, 13), &[at, "without a buffer view"]);
    changed(|d| d["accessors"] = sparse(3, 13), &[at, "beyond its count"]);
    // An index beyond the vertices.
    let (mut doc, mut bin) = plain(&CORNERS);
    bin.extend_from_slice(&[0, 1, 3, 0]);
    doc["buffers"][0]["byteLength"] = bin.len().into();
    doc["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "buffer": 0, "byteOffset": 36, "byteLength": 3 }));
    let indices = json!({ "bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR" });
    doc["accessors"].as_array_mut().unwrap().push(indices);
    doc["meshes"][0]["primitives"][0]["indices"] = 1.into();
    refused("glb", &glb(&doc, &bin), &[at, "index 2 names vertex 3, and there are 3"]);
}

#[test]
fn more_triangles_than_can_be_numbered() {
    let (mut doc, bin) = plain(&vec![[1.0; 3]; 3 << 16]);
    doc["nodes"] = vec![json!({ "mesh": 0 }); (1 << 14) + 1].into();
    doc["scenes"][0]["nodes"] = (0..(1 << 14) + 1).collect::<Vec<_>>().into();
    refused("glb", &glb(&doc, &bin), &["2^30"]);
}

#[test]
fn only_files_beside_it_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("in");
    fs::create_dir_all(inner.join("sub dir")).unwrap();
    let (mut doc, bin) = plain(&CORNERS);
    for file in ["in/a.bin", "in/sub dir/ä+b.bin", "outside.bin"] {
        fs::write(folder.path().join(file), &bin).unwrap();
    }
    fs::write(inner.join("short.bin"), &bin[1..]).unwrap();
    let mut open_with = |uri: &str| {
        doc["buffers"][0]["uri"] = uri.into();
        let path = inner.join("a.gltf");
        fs::write(&path, serde_json::to_vec(&doc).unwrap()).unwrap();
        open(path.to_str().unwrap(), &QUIET).map_err(|e| e.to_string())
    };
    for uri in ["a.bin", "./a.bin", "sub%20dir/%C3%A4+b.bin", "sub dir/ä+b.bin"] {
        assert_eq!(open_with(uri).unwrap().positions, CORNERS, "{uri}");
    }
    let outside = folder.path().join("outside.bin");
    let outside = outside.to_str().unwrap();
    let mut all = vec![
        ("../outside.bin".to_owned(), "out of the file's folder"),
        ("sub%20dir/../../outside.bin".to_owned(), "out of the file's folder"),
        ("%2e%2e/outside.bin".to_owned(), "out of the file's folder"),
        (outside.to_owned(), "out of the file's folder"),
        (outside.replace('/', "%2F"), "out of the file's folder"),
        (format!("file://{outside}"), "only files beside"),
        ("https://localhost/a.bin".to_owned(), "only files beside"),
        ("none.bin".to_owned(), "none.bin"),
        ("a.bin%00".to_owned(), "a.bin"),
        ("%ff.bin".to_owned(), "UTF-8"),
        (".".to_owned(), "directory"),
        (String::new(), "directory"),
        ("short.bin".to_owned(), "has 35"),
        ("data:;base64,AA*A".to_owned(), "base64"),
        ("data:;base64".to_owned(), "comma"),
        ("data:,abc".to_owned(), "has 3"),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(outside, inner.join("link.bin")).unwrap();
        std::os::unix::fs::symlink(folder.path(), inner.join("up")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", inner.join("zero.bin")).unwrap();
        all.push(("link.bin".to_owned(), "out of the file's folder"));
        all.push(("up/outside.bin".to_owned(), "out of the file's folder"));
        all.push(("zero.bin".to_owned(), "out of the file's folder"));
    }
    for (uri, says) in all {
        let error = open_with(&uri).unwrap_err();
        assert!(error.contains("a.gltf: buffer 0: ") && error.contains(says), "{uri}: {error}");
    }
}

/// Cuts and flipped bits: an answer of either kind.
#[test]
fn damage_never_panics() {
    let (doc, bin) = rich();
    let path = std::path::Path::new("mesh.glb");
    for sound in [glb(&doc, &bin), embedded(&doc, &bin)] {
        let sane = |bytes: &[u8]| {
            if let Ok(s) = crate::scene::gltf::parse(path, bytes, Siblings::None, Progress::Quiet) {
                assert!(s.triangles.iter().flatten().all(|&v| (v as usize) < s.positions.len()));
            }
        };
        for end in (0..sound.len()).step_by(7) {
            sane(&sound[..end]);
        }
        for at in 0..sound.len() {
            let mut damaged = sound.clone();
            damaged[at] ^= 1 << (at % 8);
            sane(&damaged);
            damaged[at] = b"019-,:"[at % 6];
            sane(&damaged);
        }
    }
}
