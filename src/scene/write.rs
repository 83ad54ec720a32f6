//! Scenes as mesh files of other programs: positions bit for bit, triangles in order; no colours, no views. And shapes of
//! flat faces, with names and colours, for programs that model.

mod glb;
mod obj;

use super::Scene;

pub use glb::glb;
pub use obj::{mtl, obj};

/// A shape of flat faces, of one colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// What it is called: a word.
    pub name: String,
    /// Base colour, linear light, and opacity; 0 to 1.
    pub color: [f32; 4],
    /// Vertex positions, scene units; finite.
    pub positions: Vec<[f32; 3]>,
    /// Faces of four corners in a plane, counter-clockwise from outside.
    pub faces: Vec<[u32; 4]>,
}

/// The two triangles of a face.
pub fn halves([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// Binary little-endian PLY: vertices as the scene has them, faces of three.
pub fn ply(scene: &Scene) -> Vec<u8> {
    let (vertices, triangles) = (scene.positions.len(), scene.triangles.len());
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {vertices}\nproperty float x\n\
         property float y\nproperty float z\nelement face {triangles}\nproperty list uchar uint vertex_indices\n\
         end_header\n",
        scene.name.replace(|c: char| c.is_control(), " ")
    );
    let mut out = Vec::with_capacity(header.len() + 12 * vertices + 13 * triangles);
    out.extend_from_slice(header.as_bytes());
    out.extend(scene.positions.iter().flatten().flat_map(|x| x.to_le_bytes()));
    for triangle in &scene.triangles {
        out.push(3);
        out.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
    }
    out
}

/// `.tri`: nine little-endian f32 a triangle, no header. What triangles share is lost.
pub fn tri(scene: &Scene) -> Vec<u8> {
    (0..scene.triangles.len())
        .flat_map(|i| scene.corners(i).into_iter().flatten().flat_map(f32::to_le_bytes))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Progress, ply as read_ply, tri as read_tri};
    use super::*;
    use std::path::Path;

    #[test]
    fn what_is_written_is_read_bit_for_bit() {
        let odd = [[-0.0, 1e-42, 3.0e38], [0.1, f32::NAN, -7.5], [1.0, 2.0, f32::INFINITY], [4.0, 5.0, 6.0]];
        let triangles = vec![[0, 3, 1], [3, 3, 2], [2, 1, 0]];
        let scene =
            Scene { name: "odd\nname".to_owned(), positions: odd.to_vec(), triangles, ..Scene::default() };
        let bits = |s: &Scene| s.positions.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
        let read = read_ply::parse(Path::new("a.ply"), &ply(&scene), Progress::Quiet).unwrap();
        assert_eq!((bits(&read), &read.triangles), (bits(&scene), &scene.triangles));
        let read = read_tri::parse(Path::new("a.tri"), &tri(&scene)).unwrap();
        let corners =
            |s: &Scene| (0..3).map(|i| s.corners(i).map(|p| p.map(f32::to_bits))).collect::<Vec<_>>();
        assert_eq!(corners(&read), corners(&scene));
    }
}
