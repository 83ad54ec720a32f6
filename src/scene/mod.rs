//! Meshes: what a scene is, and where it comes from.

mod camera;
mod error;
mod fetch;
mod gltf;
mod manifest;
mod memory;
mod mesh;
mod mtl;
mod obj;
mod open;
mod packed;
mod ply;
mod printable;
mod procedural;
mod progress;
mod siblings;
mod stl;
mod terrain;
mod transform;
mod tri;
pub mod write;

pub use camera::Camera;
pub use error::SceneError;
pub use fetch::{Archive, cache_folder, mesh_in};
pub use manifest::{Entry, Fetched, Manifest, ManifestError, Registry, Source, manifest, set};
pub use open::{FILES, Options, fetch, is_cached, names, open, parse, triangles_of};
pub(crate) use printable::in_line;
pub use printable::printable;
pub use procedural::Generator;
pub use progress::Progress;
pub use siblings::Siblings;
pub use transform::Transform;

use crate::abi::Aabb;

/// The most triangles of a scene: an index and its corners' indices fit 32 bits with room to spare.
pub const MAX_TRIANGLES: u64 = 1 << 30;

/// Triangles whose corners are hashed at once.
const HASHED: usize = 4096;

/// A triangle mesh in input order. Triangles that can't be hit stay in it, so that indices keep their meaning.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// What the user called it: a name with its size (`hairball:100000`) or a file's path.
    pub name: String,
    /// Vertex positions, scene units.
    pub positions: Vec<[f32; 3]>,
    /// Vertex indices, three a triangle; always within `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// What was odd about the input and how often.
    pub warnings: Vec<Warning>,
    /// Where from it is looked at, the best one first. [`open`] gives five; none: views of its bounds.
    pub views: Vec<Camera>,
    /// What its surfaces look like.
    pub materials: Materials,
}

/// Colours of a scene's triangles, for pictures: trees and rays don't know them.
#[derive(Debug, Clone, Default)]
pub struct Materials {
    /// Base colours, linear light, 0 to 1.
    pub colors: Vec<[f32; 3]>,
    /// Index of each triangle's colour in `colors`, or [`Materials::NONE`]; empty: no triangle has a colour.
    pub of_triangles: Vec<u32>,
}

impl Materials {
    /// Stands for a triangle without a colour.
    pub const NONE: u32 = u32::MAX;

    /// The base colour of triangle `i`, where it has one.
    pub fn color(&self, i: usize) -> Option<[f32; 3]> {
        self.of_triangles.get(i).and_then(|c| self.colors.get(*c as usize)).copied()
    }
}

/// Something left out or mended while reading a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// What, in words that stand before a count: `faces of fewer than 3 vertices, left out`.
    pub what: String,
    /// How often.
    pub count: u64,
    /// The first place it was seen: a line, a face, a byte.
    pub first: String,
}

impl Scene {
    /// The corners of triangle `i`. Denormal coordinates (below 2⁻¹²⁶) count as 0, for many devices compute so.
    pub fn corners(&self, i: usize) -> [[f32; 3]; 3] {
        let settled = |x: f32| if x.abs() < f32::MIN_POSITIVE { 0f32.copysign(x) } else { x };
        self.triangles[i].map(|v| self.positions[v as usize].map(settled))
    }

    /// BLAKE3 of all corners in input order, in hexadecimal: the same for scenes whose trees are the same.
    pub fn corners_hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let mut words = Vec::with_capacity(9 * HASHED);
        for from in (0..self.triangles.len()).step_by(HASHED) {
            words.clear();
            let to = self.triangles.len().min(from + HASHED);
            words.extend((from..to).flat_map(|t| self.corners(t)).flatten().map(|x| x.to_bits().to_le()));
            hasher.update(bytemuck::cast_slice(&words));
        }
        hasher.finalize().to_hex().to_string()
    }

    /// The scene's own first view, or else a three-quarter view of its bounds.
    pub fn view(&self) -> Camera {
        self.views.first().copied().unwrap_or_else(|| Camera::default_for(&self.bounds()))
    }

    /// Five views: the scene's own, and views of its bounds where it has fewer.
    pub fn views_or_default(&self) -> [Camera; 5] {
        let mut five = Camera::five_for(&self.bounds());
        five.iter_mut().zip(&self.views).for_each(|(default, own)| *default = *own);
        five
    }

    /// Bounds of all finite triangles; empty (lo > hi) where there are none.
    pub fn bounds(&self) -> Aabb {
        let mut b = Aabb { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };
        for t in 0..self.triangles.len() {
            let corners = self.corners(t);
            if corners.iter().flatten().all(|x| x.is_finite()) {
                for p in corners {
                    for (k, x) in p.into_iter().enumerate() {
                        b.lo[k] = b.lo[k].min(x);
                        b.hi[k] = b.hi[k].max(x);
                    }
                }
            }
        }
        b
    }
}

#[cfg(test)]
mod tests;
