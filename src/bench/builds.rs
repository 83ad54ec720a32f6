//! Builds, timed: a warm-up, runs with outer stamps only, and one more with a stamp a kernel (which costs time itself).

use super::stats::{WARM_UPS, warm_up};
use super::{KernelTime, Result, Spread, by_kernel};
use crate::bvh::{Built, Recipe, SceneBuffers, build};
use crate::device::{Device, Timing};
use std::sync::Arc;

/// What building one scene took.
#[derive(Debug)]
pub struct Builds {
    /// The last build: every run gives the same tree.
    pub built: Built,
    /// Device time, ms.
    pub device: Spread,
    /// Wall time of the whole build, host work and waiting included, ms.
    pub wall: Spread,
    /// By kernel, of one run.
    pub kernels: Vec<KernelTime>,
}

/// Builds `runs` times after a warm-up.
///
/// # Errors
/// A failed build.
pub fn measure_builds(
    device: &Arc<Device>,
    scene: &SceneBuffers,
    recipe: &Recipe,
    runs: usize,
) -> Result<Builds> {
    warm_up(WARM_UPS, || build(device, scene, recipe, Timing::Outer).map(|b| b.times.device_ms))?;
    let (mut device_ms, mut wall_ms) = (vec![], vec![]);
    for _ in 0..runs {
        let run = build(device, scene, recipe, Timing::Outer)?;
        device_ms.push(run.times.device_ms);
        wall_ms.push(run.wall_ms);
    }
    let built = build(device, scene, recipe, Timing::Kernels)?;
    let kernels = by_kernel(&built.times.passes);
    Ok(Builds { built, device: Spread::of(&device_ms), wall: Spread::of(&wall_ms), kernels })
}
