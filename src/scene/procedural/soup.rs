//! Small triangles scattered evenly in a cube: nothing shared, nothing aligned, sizes from hair to several spacings.
//! The cube's edge is the cube root of the count, so that all sizes are equally dense.

use glam::DVec3;
use rayon::prelude::*;

use super::noise::{u01, unit_vector};
use super::trig::cube_root;
use super::zeros;
use crate::scene::{Camera, Progress, Scene, SceneError};

const SEED: u32 = 0x50FB;

/// Exactly `count` triangles.
pub(super) fn generate(name: &str, count: u64, progress: Progress) -> Result<Scene, SceneError> {
    let n = count.max(1) as usize;
    let edge = cube_root(n as f64);
    let mut positions = zeros::<[f32; 3]>(name, 3 * n)?;
    let mut triangles = zeros::<[u32; 3]>(name, n)?;
    let bar = progress.count(format!("generating {name}"), n as u64);
    positions.par_chunks_exact_mut(3).zip(triangles.par_iter_mut()).enumerate().for_each(
        |(i, (corners, triangle))| {
            let i = i as u32;
            let u = |k: u32| u01(i, k, SEED);
            let middle = DVec3::new(u(0), u(1), u(2)) * edge;
            let size = 0.05 + 1.2 * u(3) * u(3);
            for (k, corner) in corners.iter_mut().enumerate() {
                let p = middle + unit_vector(i, 4 + k as u32, SEED) * size;
                *corner = p.as_vec3().to_array();
            }
            *triangle = [3 * i, 3 * i + 1, 3 * i + 2];
            if i.is_multiple_of(4096) {
                bar.inc(4096);
            }
        },
    );
    bar.finish_and_clear();
    let e = edge as f32;
    let camera =
        Camera { eye: [1.6 * e, 1.3 * e, 2.1 * e], target: [0.5 * e; 3], up: [0.0, 1.0, 0.0], fov_y: 45.0 };
    Ok(Scene { name: name.to_owned(), positions, triangles, views: vec![camera], ..Scene::default() })
}
