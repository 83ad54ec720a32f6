//! Parts as other programs read them: by the crate `gltf`, which validates, and by our own readers.

use super::{QUIET, Scene, open, read};
use crate::scene::write::{Part, glb, halves, mtl, obj};
use std::fs;

/// A leaf with two sides and an edge without area, and a square.
fn parts() -> [Part; 2] {
    let third = 1.0 / 3.0;
    let positions = vec![[0.1, 0.0, -0.0], [third, 0.0, 0.0], [third, 2e-7, 3e5], [0.1, 2e-7, 3e5]];
    let faces = vec![[0, 1, 2, 3], [3, 2, 1, 0], [0, 0, 1, 1]];
    let square = vec![[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [1.0, 1.0, 5.0], [0.0, 1.0, 5.0]];
    [
        Part { name: "leaf".into(), color: [0.0, 0.25, 1.0, 0.5], positions, faces },
        Part {
            name: "square".into(),
            color: [1.0, 0.5, 0.0, 1.0],
            positions: square,
            faces: vec![[0, 1, 2, 3]],
        },
    ]
}

/// Corners of all triangles, in order.
fn corners(parts: &[Part]) -> Vec<[[u32; 3]; 3]> {
    let of = |p: &Part| {
        let at = |v: u32| p.positions[v as usize].map(f32::to_bits);
        p.faces.iter().flat_map(|f| halves(*f)).map(|t| t.map(at)).collect::<Vec<_>>()
    };
    parts.iter().flat_map(of).collect()
}

fn corners_read(scene: &Scene) -> Vec<[[u32; 3]; 3]> {
    scene.triangles.iter().map(|t| t.map(|v| scene.positions[v as usize].map(f32::to_bits))).collect()
}

#[test]
fn parts_come_back_from_glb() {
    let parts = parts();
    let bytes = glb("two", &parts).unwrap();
    // Validates the document.
    let document = ::gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = document.blob.as_deref().unwrap();
    assert_eq!(document.nodes().filter_map(|n| n.name()).collect::<Vec<_>>(), ["leaf", "square"]);
    for (node, part) in document.nodes().zip(&parts) {
        let primitive = node.mesh().unwrap().primitives().next().unwrap();
        assert_eq!(primitive.material().pbr_metallic_roughness().base_color_factor(), part.color);
        let reader = primitive.reader(|_| Some(blob));
        let normals: Vec<_> = reader.read_normals().unwrap().map(glam::Vec3::from).collect();
        let positions: Vec<_> = reader.read_positions().unwrap().map(glam::Vec3::from).collect();
        assert!(normals.len() == 4 * part.faces.len() && positions.len() == normals.len());
        for (n, p) in normals.chunks_exact(4).zip(positions.chunks_exact(4)) {
            assert!(n.iter().all(|x| *x == n[0]) && (n[0].length() - 1.0).abs() < 1e-6, "{n:?}");
            let outward = (p[1] - p[0]).cross(p[2] - p[0]);
            assert!(outward.length() == 0.0 || outward.normalize().dot(n[0]) > 0.9999, "{n:?} {p:?}");
        }
        let bounds = primitive.bounding_box();
        let all = |pick: fn(glam::Vec3, glam::Vec3) -> glam::Vec3| {
            positions.iter().copied().reduce(pick).unwrap().to_array()
        };
        assert_eq!((bounds.min, bounds.max), (all(glam::Vec3::min), all(glam::Vec3::max)));
    }
    let scene = read("glb", &bytes).unwrap();
    assert_eq!(corners_read(&scene), corners(&parts));
    assert_eq!(
        (scene.materials.color(0), scene.materials.color(7)),
        (Some([0.0, 0.25, 1.0]), Some([1.0, 0.5, 0.0]))
    );
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn parts_without_a_face_are_no_nodes() {
    let [leaf, square] = parts();
    let empty = Part { faces: vec![], ..leaf };
    let bytes = glb("one", &[empty.clone(), square]).unwrap();
    assert_eq!(::gltf::Gltf::from_slice(&bytes).unwrap().nodes().count(), 1);
    assert!(glb("none", &[empty]).is_err_and(|e| e.to_string().contains("no triangle")));
}

#[test]
fn parts_come_back_from_obj() {
    let parts = parts();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(folder.path().join("a b.mtl"), mtl(&parts)).unwrap();
    fs::write(&path, obj(&parts, "a b.mtl")).unwrap();
    let scene = open(path.to_str().unwrap(), &QUIET).unwrap();
    assert_eq!(corners_read(&scene), corners(&parts));
    let colors: Vec<_> = (0..8).map(|i| scene.materials.color(i).unwrap()).collect();
    assert_eq!(colors, [[[0.0, 0.25, 1.0]; 6].as_slice(), &[[1.0, 0.5, 0.0]; 2]].concat());
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}
