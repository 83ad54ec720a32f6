//! A thick trefoil knot with folds, scales and scanner's noise: like a scanned statue, closed, with small, nearly
//! equilateral triangles of no main direction, vertices off their grid and diagonals either way.

use glam::DVec3;
use rayon::prelude::*;

use super::noise::{fbm, h32, ridged, u01};
use super::trig::sin_cos;
use super::zeros;
use crate::scene::{Camera, Progress, Scene, SceneError};

/// Triangles of the whole surface: 2180 cells along, 200 around.
pub(super) const FULL: u64 = 872_000;
const SEED: u32 = 0xD7A9;

/// About `count` triangles, to the nearest ring of cells: 2 triangles in every cell of a grid 10.9 times as long as
/// round, at least 3 by 3.
pub(super) fn generate(name: &str, count: u64, progress: Progress) -> Result<Scene, SceneError> {
    let surface = Surface::new(count);
    let around = surface.around as usize;
    let cells = surface.along as usize * around;
    let mut positions = zeros::<[f32; 3]>(name, cells)?;
    let mut triangles = zeros::<[u32; 3]>(name, 2 * cells)?;
    let bar = progress.count(format!("generating {name}"), triangles.len() as u64);
    positions
        .par_chunks_exact_mut(around)
        .zip(triangles.par_chunks_exact_mut(2 * around))
        .enumerate()
        .for_each(|(u, (ring, cells))| {
            for (v, (p, pair)) in ring.iter_mut().zip(cells.chunks_exact_mut(2)).enumerate() {
                *p = surface.point(u as u32, v as u32).as_vec3().to_array();
                surface.cell(u as u32, v as u32, pair);
            }
            bar.inc(cells.len() as u64);
        });
    bar.finish_and_clear();
    let camera = Camera { eye: [2.2, 3.4, 8.6], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y: 45.0 };
    Ok(Scene { name: name.to_owned(), positions, triangles, views: vec![camera], ..Scene::default() })
}

/// A grid of cells, closed both ways.
struct Surface {
    along: u32,
    around: u32,
    /// A mean edge, scene units.
    edge: f64,
}

impl Surface {
    fn new(count: u64) -> Self {
        let around = ((count as f64 / 21.8).sqrt() + 0.5).floor().max(3.0) as u64;
        let along = ((count + around) / (2 * around)).max(3);
        // The knot is about 33 long.
        Self { along: along as u32, around: around as u32, edge: 33.0 / along as f64 }
    }

    /// Vertex (u, v) of the grid.
    fn point(&self, u: u32, v: u32) -> DVec3 {
        let jitter = |k: u32| 0.3 * (2.0 * u01(u, v, SEED + k) - 1.0);
        let s = (f64::from(u) + jitter(0)) / f64::from(self.along);
        let t = (f64::from(v) + jitter(1)) / f64::from(self.around);
        let (spine, across, up) = knot(s);
        let (sin, cos) = sin_cos(t);
        let normal = across * cos + up * sin;
        // A body: thick in the middle, thin where head and tail meet. The half turn's sine, whichever side of 0.
        let radius = 0.45 * (0.35 + 0.65 * sin_cos(s / 2.0).0.abs());
        let p = spine + normal * radius;
        let scales = (sin_cos(40.0 * s).1 * sin_cos(24.0 * t).1).max(0.0);
        let height = 0.25 * fbm(p * 2.0, 4, SEED + 8)
            + 0.12 * (ridged(p * 7.0, 3, SEED + 16) - 1.0)
            + 0.05 * scales
            + 0.01 * fbm(p * 60.0, 3, SEED + 24);
        let scan = 0.15 * self.edge * (2.0 * u01(u, v, SEED + 2) - 1.0);
        // Kept off the spine, so that the surface never turns inside out.
        spine + normal * (radius * (1.0 + height).max(0.2) + scan)
    }

    /// The two triangles from vertex (u, v) to the next ring, cut along a diagonal by hash, outside anticlockwise.
    fn cell(&self, u: u32, v: u32, pair: &mut [[u32; 3]]) {
        let at = |du: u32, dv: u32| (u + du) % self.along * self.around + (v + dv) % self.around;
        let (a, b, c, d) = (at(0, 0), at(0, 1), at(1, 1), at(1, 0));
        [pair[0], pair[1]] = match h32(u, v, SEED + 3) & 1 {
            0 => [[a, b, c], [a, c, d]],
            _ => [[b, c, d], [b, d, a]],
        };
    }
}

/// The trefoil at `s` of its length, and two unit vectors across it. It lies on a torus, whose normal makes the frame:
/// one that closes after a round.
fn knot(s: f64) -> (DVec3, DVec3, DVec3) {
    let ((sin2, cos2), (sin3, cos3)) = (sin_cos(2.0 * s), sin_cos(3.0 * s));
    let ring = DVec3::new(cos2, sin2, 0.0);
    let across = ring * cos3 + DVec3::Z * sin3;
    let spine = ring * 2.0 + across;
    let tangent = DVec3::new(-sin2, cos2, 0.0) * (2.0 * (2.0 + cos3)) + (DVec3::Z * cos3 - ring * sin3) * 3.0;
    let tangent = tangent.normalize();
    (spine, across, tangent.cross(across))
}
