//! What the surface area heuristic doesn't see of a packed tree \[AILA13\]: end-point overlap, leaf-count variability;
//! and areas level by level.
//!
//! **EPO** = Σ_n C_n · A((S \ Q(n)) ∩ n) / A(S): S the triangles of the tree, Q(n) those below node n, C_n what a visit
//! of n costs. It is the cost, expected at a point of the surface, of the nodes that hold the point and not its
//! triangle. **LCV** = √(E\[N²\] − E\[N\]²), N the leaves that a ray meets.
//!
//! What is ours:
//! - Nodes are the packed ones, their boxes as they are decoded and cut by those above them, as a ray meets them; boxes
//!   that hold the triangle in question cut nothing, for it may stick out by a rounding.
//! - C_n is c_I for each triangle of a leaf, and c_T / 2 for each child of a packed node: c_T is the cost of two boxes.
//!   [`Quality::wide_sah`] is the SAH cost by the same C_n; that of a build is of the binary tree.
//! - A ray is a line through the scene's box, uniform over all such lines, and nothing ends it: the rays that SAH means.
//!   So E\[N\] is the leaves' area over the scene's, a little more for boxes on grids.
//! - Triangles lie where the build put them: in unit space, their corners less the anchor rounded to f32 as boxes are.
//!
//! The same on every machine and thread count: f64, sums in a fixed order, hashes for chance.

mod lines;
mod overlap;
mod survey;

pub use self::lines::{Line, lines};
pub use self::overlap::Overlap;
pub use self::survey::{Level, Survey};

use super::validate::Claims;
use crate::bvh::HostTree;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Box tests that a measure may take before it does with less; a second or two of one core.
const WORK: u64 = 1 << 26;
/// Points that EPO is estimated from where it can't be had exactly; fewer where these take too long.
const POINTS: [usize; 4] = [1 << 18, 1 << 15, 1 << 12, 1 << 9];
/// Lines that leaves are counted on, likewise.
const LINES: [usize; 4] = [1 << 14, 1 << 12, 1 << 10, 1 << 8];

/// How good a tree is beside its SAH cost. All 0 but the counts where the scene has no area.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Quality {
    /// SAH cost of the packed tree: Σ_n C_n · A(n) / A(scene).
    pub wide_sah: f64,
    /// End-point overlap.
    pub epo: f64,
    /// Of it, what inner nodes cost.
    pub epo_inner: f64,
    /// Of it, what leaves cost.
    pub epo_leaf: f64,
    /// Standard error of `epo`; 0 where it is exact.
    pub epo_error: f64,
    /// Points of the surface that it is estimated from; 0 where it is exact.
    pub epo_sampled: usize,
    /// Mean number of leaves that a line through the scene's box meets.
    pub leaves_per_ray: f64,
    /// Leaf-count variability: its standard deviation.
    pub lcv: f64,
    /// Lines that both were counted on.
    pub lines: usize,
    /// Areas by level, the root's first.
    pub levels: Vec<Level>,
}

/// Measures `tree`, which must be sound (see [`super::validate`]). Exact where that takes no more than a few seconds.
pub fn measure(tree: &HostTree, claims: &Claims) -> Quality {
    let survey = Survey::new(tree, claims);
    // Twice: sphere, city and hairball of 100k took 1.9, 1.2 and 1.7 times the least.
    let exact = if 2 * survey.least_tests() <= WORK { survey.overlap(&Budget::new(WORK)) } else { None };
    let overlap = exact.unwrap_or_else(|| affordable(&POINTS, |n, budget| survey.estimate(n, budget)));
    let (lines, counts) = affordable(&LINES, |n, budget| {
        let lines = lines(&claims.bounds, n);
        Some((lines.len(), survey.leaves_met(&lines, budget)?))
    });
    let (leaves_per_ray, lcv) = mean_and_deviation(&counts);
    Quality {
        wide_sah: survey.wide_sah(),
        epo: overlap.inner + overlap.leaf,
        epo_inner: overlap.inner,
        epo_leaf: overlap.leaf,
        epo_error: overlap.error,
        epo_sampled: overlap.points,
        leaves_per_ray,
        lcv,
        lines,
        levels: survey.into_levels(),
    }
}

/// What `measure` says of the first of `sizes` whose box tests can be paid; of the last in any case.
fn affordable<T: Default>(sizes: &[usize], measure: impl Fn(usize, &Budget) -> Option<T>) -> T {
    let limits = (1..=sizes.len()).map(|i| if i < sizes.len() { WORK } else { u64::MAX });
    let mut trials = sizes.iter().zip(limits);
    trials.find_map(|(size, limit)| measure(*size, &Budget::new(limit))).unwrap_or_default()
}

/// Of a population.
fn mean_and_deviation(counts: &[u32]) -> (f64, f64) {
    let n = counts.len().max(1) as f64;
    let mean = counts.iter().map(|c| f64::from(*c)).sum::<f64>() / n;
    let variance = counts.iter().map(|c| (f64::from(*c) - mean).powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

/// Box tests that may be done. Whether they suffice doesn't hang on who spends first.
#[derive(Debug)]
pub struct Budget {
    limit: u64,
    spent: AtomicU64,
}

impl Budget {
    /// Of `limit` tests.
    pub fn new(limit: u64) -> Self {
        Self { limit, spent: AtomicU64::new(0) }
    }

    /// Without end.
    pub fn unlimited() -> Self {
        Self::new(u64::MAX)
    }

    /// None once all is spent.
    fn spend(&self, tests: u64) -> Option<()> {
        (self.spent.fetch_add(tests, Relaxed).saturating_add(tests) <= self.limit).then_some(())
    }
}

/// Hashed numbers in (0, 1), as many as are asked for: SplitMix64.
#[derive(Debug)]
pub(crate) struct Chance(u64);

impl Chance {
    /// Those of thing `index` of a kind.
    pub(crate) fn new(kind: u64, index: usize) -> Self {
        let mut seeds = Self(kind << 48 ^ index as u64);
        Self(seeds.bits())
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// The next.
    pub(crate) fn share(&mut self) -> f64 {
        ((self.bits() >> 12) as f64 + 0.5) / (1u64 << 52) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_costs_too_much_is_done_with_less() {
        let paid = |dear: usize| {
            affordable(&[9, 5, 2], |n, budget| budget.spend(if n >= dear { u64::MAX } else { 1 }).map(|()| n))
        };
        assert_eq!([paid(10), paid(9), paid(5), paid(2)], [9, 5, 2, 2]);
    }

    #[test]
    fn chance_fills_its_range() {
        let shares: Vec<f64> = (0..4096).map(|i| Chance::new(1, i).share()).collect();
        let (mean, deviation) = (shares.iter().sum::<f64>() / 4096.0, (1.0f64 / 12.0).sqrt());
        assert!((mean - 0.5).abs() < 5.0 * deviation / 64.0, "{mean}");
        assert!(shares.iter().all(|s| *s > 0.0 && *s < 1.0));
        for part in 0..64 {
            let inside = shares.iter().filter(|s| (**s * 64.0) as usize == part).count();
            assert!((24..=104).contains(&inside), "{inside} of 4096 in part {part} of 64");
        }
    }

    #[test]
    fn deviation_is_a_populations() {
        assert_eq!(mean_and_deviation(&[2, 4, 4, 4, 5, 5, 7, 9]), (5.0, 2.0));
        assert_eq!(mean_and_deviation(&[]), (0.0, 0.0));
    }
}
