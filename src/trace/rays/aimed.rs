//! Rays that are aimed at what triangles share, where tests that round leak: vertices and edges.

use super::sampler::mixed;
use crate::abi::Ray;
use crate::scene::Scene;
use glam::DVec3;

/// What rays are aimed at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aimed {
    /// Vertices of triangles.
    Vertices,
    /// Points of their edges.
    Edges,
}

impl Aimed {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Vertices, Self::Edges];

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertices => "vertices",
            Self::Edges => "edges",
        }
    }

    /// `count` rays from random points of the box around `scene` at random triangles' vertices or edges, endless; none of
    /// a scene without triangles. Directions are not unit vectors: they reach to the aim. In f64, rounded once: the same on
    /// every machine.
    pub fn rays(self, scene: &Scene, count: usize) -> Vec<Ray> {
        let triangles = scene.triangles.len() as u64;
        if triangles == 0 {
            return vec![];
        }
        let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let bounds = scene.bounds();
        let (lo, hi) = (wide(bounds.lo), wide(bounds.hi));
        let ray = |i: u64| {
            let word = |k: u64| mixed((i * 8 + k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let share = |k: u64| (word(k) >> 11) as f64 / (1u64 << 53) as f64;
            let corners = scene.corners((word(0) % triangles) as usize).map(wide);
            let first = (word(1) % 3) as usize;
            let aim = match self {
                Self::Vertices => corners[first],
                Self::Edges => corners[first].lerp(corners[(first + 1) % 3], share(2)),
            };
            let origin = (lo + (hi - lo) * DVec3::new(share(3), share(4), share(5))).as_vec3();
            let direction = (aim - origin.as_dvec3()).as_vec3();
            Ray {
                origin: origin.to_array(),
                t_min: 0.0,
                direction: direction.to_array(),
                t_max: f32::INFINITY,
            }
        };
        (0..count as u64).map(ray).collect()
    }
}
