//! Where the time of a build and of its rays goes: by kernel, on a timeline, against what the device's memory could do.
//!
//! **Time.** Stamps cost time, so runs with a stamp behind every pass take turns with runs that have outer stamps alone,
//! and both are told, with what stamps were found to cost. Within one submit nothing may be missing: its passes, fills,
//! updates and copies among them, are held against outer stamps of their own.
//!
//! **Bytes.** Of a kernel, those of all buffers that its arguments point to ([`crate::device::Traffic`]): what it must
//! move where it goes through each of them once. Dispatches whose size the device finds (rounds that have less and less
//! to do) count by their share of the largest one's invocations, and nothing where the device doesn't count them. A kernel
//! that looks at part of its buffers moves less than this, and may so seem faster than any copy. Traversal kernels take
//! what rays ask for instead, counted: nodes visited, triangles tested, rays and hits. A bandwidth is these bytes over the
//! kernel's time, and its measure a copy of a buffer too large for caches, its reads and writes added up.
//!
//! **Lanes.** See [`Lanes`].

mod copied;
mod lanes;
mod part;
mod stamps;
mod tables;
mod timeline;

pub use copied::Copied;
pub use lanes::{Active, Lanes};
pub use part::{KernelRow, Part};
pub use timeline::timeline;

use crate::bench::{BenchError, RayKind, choose_walk};
use crate::bvh::{BuildError, Bvh, Recipe, SceneBuffers, build};
use crate::device::{Device, DeviceError, Timing};
use crate::scene::Scene;
use crate::trace::rays::{SAMPLES, View, primary, secondary};
use crate::trace::{Batch, Options, RayOrder, Walk, trace};
use std::sync::Arc;
use std::time::Instant;

/// Name of the part that is the build; others have the names of their rays.
const BUILD: &str = "build";

/// What to profile.
#[derive(Debug, Clone)]
pub struct Plan {
    /// How the tree is built.
    pub recipe: Recipe,
    /// Which rays are traced.
    pub rays: Vec<RayKind>,
    /// What primaries see; of other kinds, as many rays as there are pixels, from the middle of the picture on.
    pub view: View,
    /// Runs of each kind of stamps.
    pub runs: usize,
}

/// A profile.
#[derive(Debug, serde::Serialize)]
pub struct Profile {
    /// The device's name.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// Commit of boxwood.
    pub commit: &'static str,
    /// The scene's name.
    pub scene: String,
    /// Its triangles.
    pub triangles: usize,
    /// Runs of each kind of stamps.
    pub runs: usize,
    /// Device time that a stamp behind a pass takes, ms, in that pass's time: on software drivers no little.
    pub stamp_ms: f64,
    /// The copy that bandwidths are measured by.
    pub copy: Copied,
    /// The build, then each kind of rays that there are any of.
    pub parts: Vec<Part>,
    /// How full subgroups were, of each kind by each walk.
    pub lanes: Vec<Lanes>,
    /// When it all began.
    #[serde(skip)]
    pub began: Instant,
}

/// A profile that can't be made.
#[derive(Debug, thiserror::Error)]
pub enum ProfileError {
    /// A measurement failed.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// There is no time by kernel.
    #[error("{0} has no timestamps, so there is no time by kernel to tell; `boxwood build` tells the wall's")]
    NoTimestamps(String),
}

impl From<BuildError> for ProfileError {
    fn from(e: BuildError) -> Self {
        Self::Bench(e.into())
    }
}

impl From<DeviceError> for ProfileError {
    fn from(e: DeviceError) -> Self {
        Self::Bench(e.into())
    }
}

/// Result of a profile.
pub type Result<T> = std::result::Result<T, ProfileError>;

/// Builds the tree of `scene` and traces its rays, as `plan` says.
///
/// # Errors
/// [`ProfileError`]: a failed build or trace, or no timestamps.
pub fn profile(device: &Arc<Device>, scene: &Scene, plan: &Plan) -> Result<Profile> {
    let info = device.info();
    if info.timestamp_bits == 0 || info.timestamp_period <= 0.0 {
        return Err(ProfileError::NoTimestamps(info.name.clone()));
    }
    let began = Instant::now();
    let copy = Copied::measure(device, plan.runs)?;
    let stamp_ms = stamps::stamp_ms(device)?;
    let buffers = SceneBuffers::upload(device, scene)?;
    let mut tree = None;
    let part = Part::measure(BUILD, plan.runs, |timing| {
        let built = build(device, &buffers, &plan.recipe, timing)?;
        tree = Some(built.bvh);
        Ok(built.times)
    })?;
    let (mut parts, mut lanes) = (vec![part], vec![]);
    if let Some(bvh) = &tree {
        let primaries = look(device, bvh, plan.view)?;
        for &kind in &plan.rays {
            if let Some(batch) = rays(device, scene, &buffers, &primaries, kind)? {
                let (part, walks) = profile_rays(device, bvh, batch, kind, plan.runs)?;
                parts.push(part);
                lanes.extend(walks);
            }
        }
    }
    parts.iter_mut().for_each(|part| part.weigh(&copy, stamp_ms));
    Ok(Profile {
        device: info.name.clone(),
        driver: info.driver.clone(),
        commit: env!("BOXWOOD_COMMIT"),
        scene: scene.name.clone(),
        triangles: scene.triangles.len(),
        runs: plan.runs,
        stamp_ms,
        copy,
        parts,
        lanes,
        began,
    })
}

/// The primary rays of a view, traced.
fn look(device: &Arc<Device>, bvh: &Bvh, view: View) -> Result<Batch> {
    let mut primaries = Batch::new(device, view.pixels(), false)?;
    primary(device, &view, &mut primaries, Timing::Off)?;
    trace(device, bvh, &primaries, options(device, RayKind::Primary), Timing::Off)?;
    Ok(primaries)
}

/// What to trace `kind` with, untried.
fn options(device: &Device, kind: RayKind) -> Options {
    let walk = Walk::untried(device, kind == RayKind::Primary);
    Options { query: kind.query(), walk, ..Options::default() }
}

/// Rays of `kind`; none where no primary has met anything that they could leave.
fn rays(
    device: &Arc<Device>,
    scene: &Scene,
    buffers: &SceneBuffers,
    primaries: &Batch,
    kind: RayKind,
) -> Result<Option<Batch>> {
    let room = primaries.count.max(SAMPLES as usize);
    let mut batch = Batch::new(device, room, false)?;
    match kind.secondary(&scene.bounds()) {
        None => batch.set(&primaries.rays.read_first(primaries.count)?)?,
        Some(how) => {
            for start in [primaries.count / 2, 0] {
                if batch.count == 0 {
                    secondary(device, buffers, primaries, &how, start, &mut batch, Timing::Off)?;
                }
            }
        }
    }
    Ok((batch.count > 0).then_some(batch))
}

/// Rays by the walk and in the order that are fastest; how full subgroups are by every walk.
fn profile_rays(
    device: &Arc<Device>,
    bvh: &Bvh,
    mut batch: Batch,
    kind: RayKind,
    runs: usize,
) -> Result<(Part, Vec<Lanes>)> {
    let orders = if kind == RayKind::Primary { &RayOrder::ALL[..1] } else { &RayOrder::ALL[..] };
    let rays = batch.rays.read_first(batch.count)?;
    let options = choose_walk(device, bvh, &rays, options(device, kind), orders)?.options;
    let mut part =
        Part::measure(kind.name(), runs, |timing| Ok(trace(device, bvh, &batch, options, timing)?))?;
    batch.count_steps(device)?;
    let mut lanes = vec![];
    for walk in Walk::ALL {
        let counted = Lanes::count(device, bvh, &batch, kind, Options { walk, ..options })?;
        if walk == options.walk {
            part.walked(walk.kernel_name(), counted.traffic());
        }
        lanes.push(counted);
    }
    Ok((part, lanes))
}
