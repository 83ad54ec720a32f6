//! A round brilliant of 96 facets, each cut into 16 coplanar triangles.

use glam::DVec3;

use crate::scene::procedural::assembly::{Pen, Size};
use crate::scene::procedural::shapes::{facet, facet_size};
use crate::scene::procedural::trig::sin_cos;

/// Cuts of a facet's edge.
const CUTS: usize = 4;
const FACETS: usize = 96;
/// Size of a [`brilliant`].
pub(in crate::scene::procedural) const SIZE: Size =
    Size { vertices: FACETS * facet_size(CUTS).vertices, triangles: FACETS * facet_size(CUTS).triangles };

/// A stone of radius 1, its table up the z axis.
pub(in crate::scene::procedural) fn brilliant(pen: &mut Pen) {
    for corners in facets() {
        facet(pen, corners, CUTS, |p| p);
    }
}

/// Point `i` of `n` about the axis, turned on by `shift` of a step.
fn around(i: usize, n: usize, shift: f64, radius: f64, z: f64) -> DVec3 {
    let (sin, cos) = sin_cos((i as f64 + shift) / n as f64);
    DVec3::new(radius * cos, radius * sin, z)
}

/// Table 8, crown 24, girdle 32, pavilion 24, culet 8; anticlockwise from outside.
fn facets() -> Vec<[DVec3; 3]> {
    let table = |i: usize| around(i % 8, 8, 0.5, 0.56, 0.35);
    let upper = |i: usize| around(i % 16, 16, 0.0, 1.0, 0.03);
    let lower = |i: usize| around(i % 16, 16, 0.0, 1.0, -0.03);
    let middle = |i: usize| around(i % 8, 8, 0.5, 0.45, -0.5);
    let (top, culet) = (DVec3::Z * 0.35, DVec3::NEG_Z * 0.88);
    let mut facets = Vec::with_capacity(FACETS);
    for i in 0..8 {
        // Table corner i stands above girdle corner 2 i + 1.
        facets.push([top, table(i), table(i + 1)]);
        facets.push([table(i), upper(2 * i), upper(2 * i + 1)]);
        facets.push([table(i), upper(2 * i + 1), upper(2 * i + 2)]);
        facets.push([table(i), upper(2 * i + 2), table(i + 1)]);
        facets.push([middle(i), lower(2 * i + 1), lower(2 * i)]);
        facets.push([middle(i), lower(2 * i + 2), lower(2 * i + 1)]);
        facets.push([middle(i), middle(i + 1), lower(2 * i + 2)]);
        facets.push([culet, middle(i + 1), middle(i)]);
    }
    for i in 0..16 {
        facets.push([lower(i), lower(i + 1), upper(i + 1)]);
        facets.push([lower(i), upper(i + 1), upper(i)]);
    }
    facets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_facet_faces_outwards() {
        let facets = facets();
        assert_eq!(facets.len(), FACETS);
        for [a, b, c] in facets {
            assert!((b - a).cross(c - a).dot(a + b + c) > 1e-3, "{a} {b} {c}");
        }
    }
}
