//! A ball of tangled strands: long thin triangles, diagonal to every axis, overlapping everywhere.
//! After the Hairball of Laine and Karras (2.88 million triangles), made anew.

use rayon::prelude::*;

use super::noise::{curl, u01, unit_vector};
use super::shapes::{transported, tube_sides};
use super::zeros;
use crate::scene::{Camera, Progress, Scene, SceneError};

/// Segments of a strand.
const SEGMENTS: usize = 60;
/// Sides of a strand; the ring below is made of one vector, its normal and their opposites.
const SIDES: usize = 4;
/// Radius of a strand at its root, in radii of the ball.
const RADIUS: f64 = 0.0035;
const SEED: u32 = 0x4A12;

/// About `n` triangles, to the nearest segment of 8: whole strands, and a shorter last one.
pub(super) fn generate(name: &str, n: u64, progress: Progress) -> Result<Scene, SceneError> {
    let side_triangles = 2 * SIDES;
    let segments = ((n as usize + side_triangles / 2) / side_triangles).max(1);
    let strands = segments.div_ceil(SEGMENTS);
    let mut positions = zeros::<[f32; 3]>(name, (segments + strands) * SIDES)?;
    let mut triangles = zeros::<[u32; 3]>(name, segments * side_triangles)?;
    let strand_vertices = (SEGMENTS + 1) * SIDES;
    let bar = progress.count(format!("generating {name}"), strands as u64);
    positions
        .par_chunks_mut(strand_vertices)
        .zip(triangles.par_chunks_mut(SEGMENTS * side_triangles))
        .enumerate()
        .for_each(|(i, (positions, triangles))| {
            strand(i as u32, positions);
            tube((i * strand_vertices) as u32, triangles);
            if i.is_multiple_of(256) {
                bar.inc(256);
            }
        });
    bar.finish_and_clear();
    // About 3.2 radii out, so that the ball fills the picture's height.
    let camera = Camera { eye: [1.6, 1.15, 2.55], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y: 45.0 };
    Ok(Scene { name: name.to_owned(), positions, triangles, views: vec![camera], ..Scene::default() })
}

/// The rings of strand `i`, as many as there is room for; each strand is as it would be at full length.
fn strand(i: u32, rings: &mut [[f32; 3]]) {
    let outward = unit_vector(i, 0, SEED);
    let mut p = outward * (0.05 + 0.25 * u01(i, 1, SEED));
    let mut d = (outward + unit_vector(i, 2, SEED) * 0.6).normalize();
    let step = (2.2 + 0.8 * u01(i, 3, SEED)) / SEGMENTS as f64;
    let mut across = d.any_orthonormal_vector();
    for (k, ring) in rings.chunks_exact_mut(SIDES).enumerate() {
        across = transported(across, d);
        let up = d.cross(across);
        let r = RADIUS * (1.0 - 0.7 * k as f64 / SEGMENTS as f64);
        for (vertex, v) in ring.iter_mut().zip([across, up, -across, -up]) {
            *vertex = (p + v * r).as_vec3().to_array();
        }
        p += d * step;
        d += curl(p * 2.3, SEED) * 0.16 + unit_vector(i, 4 + k as u32, SEED) * 0.15;
        let distance = p.length();
        if distance > 1.0 {
            d -= p / distance * (0.5 + 2.0 * (distance - 1.0));
        }
        d = d.try_normalize().unwrap_or(outward);
    }
}

/// The sides between rings that start at vertex `first`.
fn tube(first: u32, triangles: &mut [[u32; 3]]) {
    for (pair, [a, b, c, d]) in triangles.chunks_exact_mut(2).zip(tube_sides(first, SIDES)) {
        pair[0] = [a, b, c];
        pair[1] = [a, c, d];
    }
}
