//! Thin pipes in all directions, uncut between their bends: triangles a hundred times as long as wide, which no
//! axis-aligned box holds well. Pipes to the volume are the same at all sizes.

use glam::DVec3;

use super::assembly::{Pen, Run, assemble, total};
use super::noise::{u01, unit_vector};
use super::shapes::{tube, tube_size};
use super::trig::cube_root;
use crate::scene::{Camera, Progress, Scene, SceneError};

const SIDES: usize = 16;
/// Straight pieces of a whole pipe.
const PIECES: usize = 8;
/// Pieces' lengths, in edges of the cube that a million triangles fill.
const LENGTHS: [f64; 2] = [0.05, 0.25];
const RADII: [f64; 2] = [0.001, 0.003];
const SEED: u32 = 0x919E;

/// Edge of the cube: at least two of the longest pieces, for pipes turn back at the walls.
fn edge(triangles: u64) -> f64 {
    cube_root((triangles as f64 / 1e6).max(0.125))
}

/// Whole pipes, and a shorter last one.
pub(super) fn runs(count: u64) -> Vec<Run> {
    let piece = tube_size(2, SIDES).triangles as u64;
    let pieces = ((count + piece / 2) / piece).max(1);
    let (whole, rest) = (pieces / PIECES as u64, (pieces % PIECES as u64) as usize);
    let edge = edge(pieces * piece);
    let run = |pipes, first: u32, pieces| {
        Run::new(pipes, tube_size(pieces + 1, SIDES), move |i, pen| pipe(pen, first + i, pieces, edge))
    };
    [run(whole, 0, PIECES)].into_iter().chain((rest > 0).then(|| run(1, whole as u32, rest))).collect()
}

/// About `count` triangles, to the nearest piece of 32.
pub(super) fn generate(name: &str, count: u64, progress: Progress) -> Result<Scene, SceneError> {
    let runs = runs(count);
    let edge = edge(total(&runs).triangles as u64) as f32;
    let at = |p: [f32; 3]| p.map(|x| x * edge);
    let camera =
        Camera { eye: at([-0.5, 0.9, 1.7]), target: at([0.5, 0.45, 0.5]), up: [0.0, 1.0, 0.0], fov_y: 50.0 };
    assemble(name, &runs, camera, progress)
}

/// The first `pieces` pieces of pipe `i`.
fn pipe(pen: &mut Pen, i: u32, pieces: usize, edge: f64) {
    let between = |[lo, hi]: [f64; 2], k: u32| lo + (hi - lo) * u01(i, k, SEED);
    let mut p = DVec3::new(u01(i, 0, SEED), u01(i, 1, SEED), u01(i, 2, SEED)) * edge;
    let mut d = unit_vector(i, 3, SEED);
    let mut path = vec![p];
    for k in 0..pieces as u32 {
        let step = d * between(LENGTHS, 4 + 2 * k);
        // A wall sends it back.
        let stays = (p + step).cmpge(DVec3::ZERO) & (p + step).cmple(DVec3::splat(edge));
        let back = DVec3::select(stays, DVec3::ONE, DVec3::NEG_ONE);
        p += step * back;
        path.push(p);
        d = (d * back + unit_vector(i, 5 + 2 * k, SEED) * 0.8).normalize();
    }
    let radius = between(RADII, 4 + 2 * PIECES as u32);
    tube(pen, &path, SIDES, |_| radius);
}
