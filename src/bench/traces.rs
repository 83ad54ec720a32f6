//! Rays from the host, traced and timed, however many there are: in submits that no watchdog ends.

use super::{KernelTime, Result, Spread, by_kernel, stats};
use crate::abi::{Hit, Ray};
use crate::bvh::Bvh;
use crate::device::{Device, Times, Timing};
use crate::trace::{BATCH, Batch, Options, RayOrder, Walk, trace};
use std::sync::Arc;

/// Rays of the first submit on a device whose speed isn't known yet.
const FIRST: usize = 1 << 16;
/// Rays of any submit at least: beyond this the launch is what takes time.
const LEAST: usize = 1 << 10;
/// A submit's aim, ms: watchdogs end work after 2 s on some systems, and the slowest chunk may take twice the usual.
const SUBMIT_MS: f64 = 500.0;
/// Submits that took less, ms, don't tell a rate.
const TELLING_MS: f64 = 0.5;
/// Growth of a submit over the one before it.
const GROWTH: usize = 4;

/// Whether a pass more counts the tests. Timed runs never do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Counting {
    /// No such pass.
    #[default]
    Off,
    /// One pass of the counting kernels, not timed.
    On,
}

/// How to measure.
#[derive(Debug, Clone, Copy)]
pub struct Protocol {
    /// Timed runs over all rays, after a warm-up.
    pub runs: usize,
    /// Whether to count tests as well.
    pub counting: Counting,
}

/// Box and triangle tests of a whole set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct TestTotals {
    /// Axis-aligned child boxes tested.
    pub boxes: u64,
    /// Child boxes of oriented nodes tested.
    #[serde(default)]
    pub oriented: u64,
    /// Triangles tested.
    pub triangles: u64,
}

/// A set of rays, traced.
#[derive(Debug)]
pub struct Traced {
    /// One a ray.
    pub hits: Vec<Hit>,
    /// Device time of all rays, ms.
    pub device: Spread,
    /// Wall time from submit to fence of all rays, ms: no copies.
    pub wall: Spread,
    /// Rays a submit.
    pub chunk: usize,
    /// Submits a run.
    pub submits: usize,
    /// One row a kernel, in order; those of a sort from a run of its own with a stamp behind every pass.
    pub kernels: Vec<KernelTime>,
    /// With [`Counting::On`].
    pub tests: Option<TestTotals>,
}

impl Traced {
    /// Device time of the passes that sort, ms; 0 where rays were taken as they came.
    pub fn sort_ms(&self) -> f64 {
        let sorting = |k: &&KernelTime| !k.name.starts_with("trace/");
        self.kernels.iter().filter(sorting).map(|k| k.ms).sum()
    }
}

/// Traces `rays`, timed by `protocol`. All runs of one chunk follow each other, so that each is copied once. `progress`
/// is told how many rays have had all their runs.
///
/// # Errors
/// A failed Vulkan call, or not enough device memory for a chunk.
pub fn trace_all(
    device: &Arc<Device>,
    bvh: &Bvh,
    rays: &[Ray],
    options: Options,
    protocol: Protocol,
    progress: &dyn Fn(usize),
) -> Result<Traced> {
    let mut batch = Batch::new(device, rays.len().min(BATCH), false)?;
    let chunk = warm_up(device, bvh, rays, options, &mut batch)?;
    let (mut device_ms, mut wall_ms) = (vec![0.0; protocol.runs], vec![0.0; protocol.runs]);
    let mut hits = Vec::with_capacity(rays.len());
    let mut passes = vec![];
    let submits = rays.len().div_ceil(chunk);
    for part in rays.chunks(chunk) {
        batch.set(part)?;
        for (device_ms, wall_ms) in device_ms.iter_mut().zip(&mut wall_ms) {
            let times = trace(device, bvh, &batch, options, Timing::Outer)?;
            *device_ms += times.device_ms;
            *wall_ms += times.wall_ms;
        }
        if options.order == RayOrder::Sorted {
            passes.extend(trace(device, bvh, &batch, options, Timing::Kernels)?.passes);
        }
        hits.extend(batch.hits.read_first(part.len())?);
        progress(part.len());
    }
    drop(batch);
    let tests = match protocol.counting {
        Counting::Off => None,
        Counting::On => Some(count_tests(device, bvh, rays, options, chunk)?),
    };
    let (device, wall) = (Spread::of(&device_ms), Spread::of(&wall_ms));
    let kernels = match options.order {
        RayOrder::Sorted => by_kernel(&passes),
        RayOrder::AsGiven => {
            vec![KernelTime { name: options.walk.kernel_name().into(), count: submits, ms: device.median }]
        }
    };
    Ok(Traced { hits, device, wall, chunk, submits, kernels, tests })
}

/// Traces untimed, on a software driver until the times settle, and finds how many rays a submit may have: without a
/// watchdog whole batches.
fn warm_up(
    device: &Arc<Device>,
    bvh: &Bvh,
    rays: &[Ray],
    options: Options,
    batch: &mut Batch,
) -> Result<usize> {
    if device.info().is_cpu() {
        batch.set(&rays[..rays.len().min(BATCH)])?;
        stats::warm_up(stats::WARM_UPS, || {
            trace(device, bvh, batch, options, Timing::Outer).map(|times| times.device_ms)
        })?;
        return Ok(BATCH);
    }
    let mut pace = Pace::default();
    let mut left = rays;
    while !left.is_empty() {
        let (part, rest) = left.split_at(pace.chunk().min(left.len()));
        batch.set(part)?;
        pace.learn(part.len(), &trace(device, bvh, batch, options, Timing::Outer)?);
        left = rest;
    }
    Ok(pace.chunk())
}

/// How many rays a device may be given at once, by the slowest rate it has shown.
pub(super) struct Pace {
    chunk: usize,
    /// Rays a millisecond.
    slowest: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self { chunk: FIRST, slowest: f64::INFINITY }
    }
}

impl Pace {
    /// Rays of the next submit.
    pub(super) fn chunk(&self) -> usize {
        self.chunk
    }

    /// Takes in how long a submit of `count` rays took.
    pub(super) fn learn(&mut self, count: usize, times: &Times) {
        if times.device_ms >= TELLING_MS {
            self.slowest = self.slowest.min(count as f64 / times.device_ms);
        }
        let aim = (self.slowest * SUBMIT_MS).min(BATCH as f64) as usize;
        self.chunk = aim.clamp(LEAST, BATCH).min(self.chunk * GROWTH);
    }
}

/// Sums the tests of all rays, each walking alone: what the tree costs, whichever walk is fastest.
pub(super) fn count_tests(
    device: &Arc<Device>,
    bvh: &Bvh,
    rays: &[Ray],
    options: Options,
    chunk: usize,
) -> Result<TestTotals> {
    let options = Options { walk: Walk::Single, order: RayOrder::AsGiven, ..options };
    let mut batch = Batch::new(device, rays.len().min(chunk), true)?;
    let mut sum = TestTotals::default();
    for part in rays.chunks(chunk) {
        batch.set(part)?;
        trace(device, bvh, &batch, options, Timing::Off)?;
        sum.add(&batch)?;
    }
    Ok(sum)
}

impl TestTotals {
    /// Adds the tests of a traced batch that counts them.
    pub(super) fn add(&mut self, batch: &Batch) -> Result<()> {
        let Some(tests) = &batch.tests else { return Ok(()) };
        for t in tests.read_first(batch.count)? {
            self.boxes += u64::from(t.boxes);
            self.oriented += u64::from(t.oriented);
            self.triangles += u64::from(t.triangles);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(ms: f64) -> Times {
        Times { device_ms: ms, ..Times::default() }
    }

    #[test]
    fn chunks_keep_below_the_aim() {
        let mut pace = Pace::default();
        assert_eq!(pace.chunk(), FIRST);
        pace.learn(FIRST, &after(0.1));
        assert_eq!(pace.chunk(), FIRST * GROWTH, "too short to tell, so larger");
        pace.learn(FIRST * GROWTH, &after(1_000.0));
        assert_eq!(pace.chunk(), FIRST * GROWTH / 2);
        pace.learn(FIRST * GROWTH / 2, &after(10.0));
        assert_eq!(pace.chunk(), FIRST * GROWTH / 2, "the slowest counts");
        pace.learn(1, &after(1e9));
        assert_eq!(pace.chunk(), LEAST);
    }

    #[test]
    fn a_fast_device_gets_whole_batches() {
        let mut pace = Pace::default();
        for _ in 0..9 {
            pace.learn(pace.chunk(), &after(0.6));
        }
        assert_eq!(pace.chunk(), BATCH);
    }
}
