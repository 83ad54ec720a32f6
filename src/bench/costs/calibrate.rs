//! The micro-benchmark: small generated scenes, each as trees that test much of one kind and little of the others, traced
//! by the kernels that trace everything else, and their times taken apart by what was tested.
//!
//! Robust rather than exact. All trees take turns, in runs of less than a millisecond, and the least time of each counts:
//! what else the machine does lengthens most runs, hardly all of them. On a software driver a run is one workgroup, so one
//! thread's, and its time is shared out among the threads: no run waits for the machine's other cores. Nodes and
//! triangles stay in caches: a large scene's tests take longer, all kinds of them.

use super::{Costs, Result, regression};
use crate::abi::{Aabb, Ray};
use crate::bench::TestTotals;
use crate::bvh::{Bvh, Collapse, Fit, Recipe, SceneBuffers, build};
use crate::device::{Device, Timing};
use crate::oracle::quality::Chance;
use crate::scene::{Generator, Progress};
use crate::trace::{Batch, Options, Walk, trace};
use regression::{Sample, taken_apart};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Strands, loose triangles, boxes off the axes: long boxes, much overlap, trees whose boxes are oriented.
const SCENES: [Generator; 3] = [Generator::Hairball, Generator::Soup, Generator::CityRotated];
/// Triangles of each.
const TRIANGLES: u64 = 8_000;
/// Costs of a node and of a triangle: trees that test mostly boxes, and mostly triangles.
const CUTS: [[f32; 2]; 2] = [[0.5, 2.0], [20.0, 2.0]];
/// The calibration's kind of chance.
const RAYS: u64 = 0xc0;
/// Rays of a run on a software driver, no more than a workgroup takes.
const CPU_RAYS: usize = 512;
/// Rays of a run where the device is a GPU: more than it runs at once.
const GPU_RAYS: usize = 1 << 18;
/// Runs of each.
const ROUNDS: usize = 64;
/// Runs of each at least, and the time after which more are not begun.
const LEAST_ROUNDS: usize = 5;
const TIME: Duration = Duration::from_secs(2);
/// No test costs less than this share of the dearest: noise must not make one free.
const LEAST_SHARE: f64 = 1.0 / 64.0;

/// A tree, rays, and what they test.
struct Case {
    bvh: Arc<Bvh>,
    batch: Batch,
    tests: TestTotals,
    /// Least so far, ms.
    ms: f64,
}

/// Measures `device`.
///
/// # Errors
/// A failed build or trace.
pub(super) fn calibrate(device: &Arc<Device>) -> Result<Costs> {
    let mut cases = cases(device)?;
    let options = Options { walk: Walk::Refill, ..Options::default() };
    let start = Instant::now();
    for round in 0..ROUNDS {
        if round >= LEAST_ROUNDS && start.elapsed() > TIME {
            break;
        }
        for case in &mut cases {
            let ms = trace(device, &case.bvh, &case.batch, options, Timing::Outer)?.device_ms;
            // The first run of each warms up.
            if round > 0 && ms > 0.0 {
                case.ms = case.ms.min(ms);
            }
        }
    }
    let threads = f64::from(device.shape().threads);
    let samples: Vec<_> = cases.iter().filter(|c| c.ms.is_finite()).map(|c| c.sample(threads)).collect();
    // The last is what a ray takes that tests nothing.
    let [boxes, oriented, triangles, _] = taken_apart(&samples);
    let least = LEAST_SHARE * boxes.max(oriented).max(triangles);
    let costs =
        Costs { boxes: boxes.max(least), oriented: oriented.max(least), triangles: triangles.max(least) };
    tracing::info!(
        "a box test takes {:.2} ns, an oriented one {:.2}, a triangle test {:.2}",
        costs.boxes,
        costs.oriented,
        costs.triangles
    );
    Ok(costs)
}

/// Every tree with rays from within it; one as well with rays that miss it.
fn cases(device: &Arc<Device>) -> Result<Vec<Case>> {
    let mut cases = vec![];
    for generator in SCENES {
        let scene = generator.generate("costs", TRIANGLES, Progress::Quiet)?;
        let (buffers, bounds) = (SceneBuffers::upload(device, &scene)?, scene.bounds());
        for fit in [Fit::Aabb, Fit::Dito(14)] {
            for [node_cost, triangle_cost] in CUTS {
                let collapse = Collapse { node_cost, triangle_cost, ..Recipe::default().collapse };
                // As cheap as others, so that most nodes are oriented.
                let recipe = Recipe { collapse, fit, oriented_cost: node_cost, ..Recipe::default() };
                let bvh = Arc::new(build(device, &buffers, &recipe, Timing::Off)?.bvh);
                if cases.is_empty() {
                    cases.push(Case::new(device, bvh.clone(), &bounds, Origins::Beyond)?);
                }
                cases.push(Case::new(device, bvh, &bounds, Origins::Within)?);
            }
        }
    }
    Ok(cases)
}

impl Case {
    fn new(device: &Arc<Device>, bvh: Arc<Bvh>, bounds: &Aabb, origins: Origins) -> Result<Self> {
        let shape = device.shape();
        let workgroup = (shape.refill * shape.trace_workgroup) as usize;
        let count = if device.info().is_cpu() { CPU_RAYS.min(workgroup) } else { GPU_RAYS };
        let mut batch = Batch::new(device, count, true)?;
        batch.set(&rays(bounds, origins, count))?;
        trace(device, &bvh, &batch, Options::default(), Timing::Off)?;
        let mut tests = TestTotals::default();
        tests.add(&batch)?;
        batch.tests = None;
        Ok(Self { bvh, batch, tests, ms: f64::INFINITY })
    }

    /// ns, were all of `threads` threads busy.
    fn sample(&self, threads: f64) -> Sample<4> {
        let TestTotals { boxes, oriented, triangles } = self.tests;
        let counts = [boxes as f64, oriented as f64, triangles as f64, self.batch.count as f64];
        Sample { counts, time: self.ms * 1e6 / threads }
    }
}

/// Where rays start.
#[derive(Clone, Copy)]
enum Origins {
    /// Anywhere in a box, in all directions.
    Within,
    /// Beyond its greatest corner, away from it.
    Beyond,
}

/// `count` rays from `origins` of `bounds`, without limits.
fn rays(bounds: &Aabb, origins: Origins, count: usize) -> Vec<Ray> {
    let ray = |i| {
        let mut chance = Chance::new(RAYS, i);
        let place: [f32; 3] = std::array::from_fn(|_| chance.share() as f32);
        let toward: [f32; 3] = std::array::from_fn(|_| chance.share() as f32);
        let (offset, direction) = match origins {
            Origins::Within => (0.0, toward.map(|x| 2.0 * x - 1.0)),
            Origins::Beyond => (1.5, toward),
        };
        let origin = |k: usize| bounds.lo[k] + (bounds.hi[k] - bounds.lo[k]) * (place[k] + offset);
        Ray { origin: std::array::from_fn(origin), t_min: 0.0, direction, t_max: f32::INFINITY }
    };
    (0..count).map(ray).collect()
}
