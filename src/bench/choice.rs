//! Which walk a set of rays is fastest with, whether sorting them pays, and of trees that keep both, whether oriented boxes
//! do: tried on some of them, the sort's own time included.

use super::Result;
use crate::abi::Ray;
use crate::bvh::Bvh;
use crate::device::{Device, Timing};
use crate::trace::{Batch, Boxes, Options, RayOrder, Walk, trace};
use std::sync::Arc;

/// Rays that are tried, at most. They are neighbours, so that they lie as densely as all of a batch: a sample of every
/// n-th ray would be sorted in vain. A quarter of a batch, which gains a little less from a sort than the whole.
const SAMPLE: usize = 1 << 18;
/// Fewer rays than this tell nothing.
const LEAST: usize = 1 << 15;
/// Rays that a kernel is first run with, untimed: drivers compile at its first dispatch.
const WARM_UP: usize = 1 << 12;
/// Timed runs of each; the least counts.
const ROUNDS: usize = 3;
/// What took this much longer than the fastest isn't run again.
const HOPELESS: f64 = 1.25;
/// Share of the time that a sort must save: less is noise.
const LEAST_GAIN: f64 = 0.03;
/// Share that a tree's axis-aligned boxes must save: the mixed ones were chosen for fewer tests, weighted by their costs.
const LEAST_GAIN_OF_BOXES: f64 = 0.02;

/// How long a walk took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Which walk.
    pub walk: Walk,
    /// In which order.
    pub order: RayOrder,
    /// Through which boxes.
    pub boxes: Boxes,
    /// Least device time, ms, with the sort.
    pub ms: f64,
}

/// What to trace with, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The walk and the order to take, the rest as given.
    pub options: Options,
    /// Rays tried; 0 where there are too few to tell.
    pub rays: usize,
    /// What was tried.
    pub trials: Vec<Trial>,
}

impl Choice {
    /// The fastest trial with rays in `order`, with axis-aligned boxes only where those gain more than noise would.
    pub fn fastest(&self, order: RayOrder) -> Option<&Trial> {
        let of = |boxes| {
            let trials = self.trials.iter().filter(move |t| t.order == order && t.boxes == boxes);
            trials.min_by(|a, b| a.ms.total_cmp(&b.ms))
        };
        let (mixed, aligned) = (of(Boxes::Mixed), of(Boxes::AxisAligned));
        let pays = |a: &&Trial| mixed.is_none_or(|m| a.ms <= m.ms * (1.0 - LEAST_GAIN_OF_BOXES));
        aligned.filter(pays).or(mixed)
    }

    /// Takes the fastest, sorted rays only where that gains more than noise would.
    fn decide(&mut self) {
        let (given, sorted) = (self.fastest(RayOrder::AsGiven), self.fastest(RayOrder::Sorted));
        let pays = |s: &&Trial| given.is_none_or(|g| s.ms <= g.ms * (1.0 - LEAST_GAIN));
        if let Some(Trial { walk, order, boxes, .. }) = sorted.filter(pays).or(given).copied() {
            self.options = Options { walk, order, boxes, ..self.options };
        }
    }
}

/// The walk, and of `orders` the order, that a run of neighbouring rays is fastest with. Few rays are traced as
/// `options` say, in the first of `orders`.
///
/// # Errors
/// A failed Vulkan call, or not enough device memory for the sample.
pub fn choose_walk(
    device: &Arc<Device>,
    bvh: &Bvh,
    rays: &[Ray],
    options: Options,
    orders: &[RayOrder],
) -> Result<Choice> {
    let count = rays.len().min(SAMPLE);
    if count < LEAST {
        let order = orders.first().copied().unwrap_or_default();
        return Ok(Choice { options: Options { order, ..options }, rays: 0, trials: vec![] });
    }
    let mut batch = Batch::new(device, count, false)?;
    let middle = (rays.len() - count) / 2;
    batch.set(&rays[middle..middle + count])?;
    fastest_walk(device, bvh, &mut batch, options, orders)
}

/// As [`choose_walk`], for rays on the device: tried are the first of `batch`, all where there is but one order.
pub(super) fn fastest_walk(
    device: &Arc<Device>,
    bvh: &Bvh,
    batch: &mut Batch,
    options: Options,
    orders: &[RayOrder],
) -> Result<Choice> {
    let mut trials = vec![];
    for &boxes in Boxes::of(bvh) {
        for &walk in Walk::all(device) {
            trials.extend(orders.iter().map(|&order| Trial { walk, order, boxes, ms: f64::INFINITY }));
        }
    }
    let run = |batch: &Batch, options| Ok(trace(device, bvh, batch, options, Timing::Outer)?.device_ms);
    fastest(trials, batch, options, orders, &run)
}

/// Traces a batch with options: how long that took, ms.
type Run<'r> = &'r dyn Fn(&Batch, Options) -> Result<f64>;

/// As [`fastest_walk`], of `trials` that `run` makes.
pub(super) fn fastest(
    trials: Vec<Trial>,
    batch: &mut Batch,
    options: Options,
    orders: &[RayOrder],
    run: Run,
) -> Result<Choice> {
    let all = batch.count;
    let rays = if orders.len() > 1 { all.min(SAMPLE) } else { all };
    let mut choice = Choice { options, rays, trials };
    batch.count = rays.min(WARM_UP);
    let mut tried = try_all(run, batch, options, &mut choice.trials, 1);
    if tried.is_ok() {
        batch.count = rays;
        choice.trials.iter_mut().for_each(|t| t.ms = f64::INFINITY);
        tried = try_all(run, batch, options, &mut choice.trials, ROUNDS);
    }
    batch.count = all;
    tried?;
    choice.decide();
    Ok(choice)
}

/// Runs all `trials` in turn, and those with hope again.
fn try_all(run: Run, batch: &Batch, options: Options, trials: &mut [Trial], rounds: usize) -> Result<()> {
    for _ in 0..rounds {
        let hope = HOPELESS * trials.iter().map(|t| t.ms).fold(f64::INFINITY, f64::min);
        for trial in trials.iter_mut().filter(|t| t.ms == f64::INFINITY || t.ms <= hope) {
            let options = Options { walk: trial.walk, order: trial.order, boxes: trial.boxes, ..options };
            trial.ms = trial.ms.min(run(batch, options)?);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(trials: Vec<Trial>) -> Options {
        let mut choice = Choice { options: Options::default(), rays: 1, trials };
        choice.decide();
        choice.options
    }

    fn decided(trials: &[(Walk, RayOrder, f64)]) -> (Walk, RayOrder) {
        let trial = |&(walk, order, ms)| Trial { walk, order, boxes: Boxes::Mixed, ms };
        let options = after(trials.iter().map(trial).collect());
        (options.walk, options.order)
    }

    #[test]
    fn axis_aligned_boxes_only_where_they_pay() {
        use Boxes::{AxisAligned, Mixed};
        let decided = |trials: &[(Boxes, f64)]| {
            let (walk, order) = (Walk::Single, RayOrder::AsGiven);
            after(trials.iter().map(|&(boxes, ms)| Trial { walk, order, boxes, ms }).collect()).boxes
        };
        assert_eq!(decided(&[(AxisAligned, 90.0), (Mixed, 100.0)]), AxisAligned);
        assert_eq!(decided(&[(AxisAligned, 99.0), (Mixed, 100.0)]), Mixed, "within the noise");
        assert_eq!(decided(&[(AxisAligned, 100.0), (Mixed, 70.0)]), Mixed);
        assert_eq!(decided(&[(AxisAligned, 100.0)]), AxisAligned, "nothing else there");
    }

    #[test]
    fn sorted_only_where_it_pays() {
        use RayOrder::{AsGiven, Sorted};
        use Walk::{Packet, Refill, Single};
        let given = [(Single, AsGiven, 100.0), (Refill, AsGiven, 120.0), (Packet, Sorted, 130.0)];
        assert_eq!(decided(&given), (Single, AsGiven));
        let little = [(Single, AsGiven, 100.0), (Refill, Sorted, 98.0)];
        assert_eq!(decided(&little), (Single, AsGiven), "within the noise");
        let much = [(Single, AsGiven, 100.0), (Packet, Sorted, 95.0), (Refill, Sorted, 90.0)];
        assert_eq!(decided(&much), (Refill, Sorted));
        assert_eq!(decided(&[(Refill, Sorted, 1e9)]), (Refill, Sorted), "nothing else asked for");
        assert_eq!(decided(&[]), (Single, AsGiven));
    }
}
