//! Two runs, row by row: ratios, and how sure they are. For gates: what is past a threshold, and not by noise.

use super::plan::Key;
use super::results::Results;
use super::row::{BuildRow, RayRow};
use super::{Costs, Spread};
use serde::Serialize;

/// What is compared; more is always worse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Device time of a build, ms.
    Build,
    /// Device time of a ray, ns.
    Trace,
    /// What a ray's tests cost by the first run's prices, ns.
    Tests,
    /// The tree's SAH cost.
    Sah,
    /// Bytes of the tree.
    Bytes,
    /// Hits that the reference contradicts, of those judged.
    Faults,
}

impl Quantity {
    /// As reports have it, with its unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::Build => "build, ms",
            Self::Trace => "ns a ray",
            Self::Tests => "cost of a ray's tests, ns",
            Self::Sah => "SAH cost",
            Self::Bytes => "tree, bytes",
            Self::Faults => "faults",
        }
    }

    /// Whether it is the same whenever it is measured, on any machine.
    pub fn is_count(self) -> bool {
        !matches!(self, Self::Build | Self::Trace)
    }
}

/// One quantity of a row that both runs have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ratio {
    /// What the row is about.
    #[serde(flatten)]
    pub key: Key,
    /// What of it.
    pub quantity: Quantity,
    /// In the first run: a median of times.
    pub first: f64,
    /// In the second.
    pub second: f64,
    /// Second over first; 1 where both are 0.
    pub ratio: f64,
    /// Where the ratio of times lies, about 95 % sure. From notches \[MCGILL78\]: a median is good to ±1.57 interquartile
    /// ranges over √runs; relative errors of both add as squares. None of counts, and of fewer than three runs.
    pub interval: Option<[f64; 2]>,
}

impl Ratio {
    /// Whether the second run is worse by more than `threshold` (a ratio above 1), and noise is not the reason.
    pub fn is_past(&self, threshold: f64) -> bool {
        let sure = self.quantity.is_count() || self.interval.is_some_and(|[low, _]| low > 1.0);
        self.ratio > threshold && sure
    }
}

/// What two runs have in common.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// In the first run's order.
    pub ratios: Vec<Ratio>,
    /// Rows of the first run alone.
    pub only_first: Vec<Key>,
    /// Rows of the second run alone.
    pub only_second: Vec<Key>,
}

/// Compares `second` with `first`.
pub fn compare(first: &Results, second: &Results) -> Comparison {
    let mut ratios = vec![];
    let mut only_first = vec![];
    for a in &first.builds {
        match second.builds.iter().find(|b| b.key() == a.key()) {
            Some(b) => ratios.extend(of_builds(a, b)),
            None => only_first.push(a.key()),
        }
    }
    for a in &first.rays {
        match second.rays.iter().find(|b| b.key() == a.key()) {
            Some(b) => ratios.extend(of_rays(a, b, first.header.costs)),
            None => only_first.push(a.key()),
        }
    }
    let keys = |r: &Results| -> Vec<Key> {
        r.builds.iter().map(BuildRow::key).chain(r.rays.iter().map(RayRow::key)).collect()
    };
    let there = keys(first);
    let only_second = keys(second).into_iter().filter(|key| !there.contains(key)).collect();
    Comparison { ratios, only_first, only_second }
}

fn of_builds(a: &BuildRow, b: &BuildRow) -> impl Iterator<Item = Ratio> {
    let sah = a.survey.as_ref().zip(b.survey.as_ref()).map(|(a, b)| [a.tree.sah, b.tree.sah]);
    [
        Some(of_times(a.key(), Quantity::Build, 1.0, [&a.build_ms, &b.build_ms])),
        sah.map(|sah| of_counts(a.key(), Quantity::Sah, sah)),
        Some(of_counts(a.key(), Quantity::Bytes, [a.bvh_bytes as f64, b.bvh_bytes as f64])),
    ]
    .into_iter()
    .flatten()
}

fn of_rays(a: &RayRow, b: &RayRow, costs: Costs) -> impl Iterator<Item = Ratio> {
    let cost = |r: &RayRow| r.tests.map(|t| costs.per_ray(&t, r.rays));
    let tests = cost(a).zip(cost(b)).map(|(x, y)| of_counts(a.key(), Quantity::Tests, [x, y]));
    let time = of_times(a.key(), Quantity::Trace, 1e6 / a.rays.max(1) as f64, [&a.trace_ms, &b.trace_ms]);
    let faults = a.check.as_ref().zip(b.check.as_ref());
    let faults = faults.map(|(a, b)| [a.faults as f64, b.faults as f64]);
    let faults = faults.map(|faults| of_counts(a.key(), Quantity::Faults, faults));
    [Some(time), tests, faults].into_iter().flatten()
}

fn over(second: f64, first: f64) -> f64 {
    if second == first { 1.0 } else { second / first }
}

fn of_counts(key: Key, quantity: Quantity, [first, second]: [f64; 2]) -> Ratio {
    Ratio { key, quantity, first, second, ratio: over(second, first), interval: None }
}

/// Times in ms, each `unit` times as much in the quantity's unit.
fn of_times(key: Key, quantity: Quantity, unit: f64, times: [&Spread; 2]) -> Ratio {
    let [first, second] = times.map(|t| unit * t.median);
    let ratio = over(second, first);
    let error = |t: &Spread| 1.57 * (t.q3 - t.q1) / (t.runs as f64).sqrt() / t.median;
    let enough = times.iter().all(|t| t.runs >= 3 && t.median > 0.0);
    let interval = enough.then(|| {
        // On a logarithmic scale, where ratios are as far either way.
        let wide = error(times[0]).hypot(error(times[1])).exp();
        [ratio / wide, ratio * wide]
    });
    Ratio { key, quantity, first, second, ratio, interval }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bench::{Check, Survey, TestTotals};

    fn results(ms: &[f64], boxes: u64, faults: usize) -> Results {
        let (scene, builder, set) = ("s".to_owned(), "b".to_owned(), "ao".to_owned());
        let check = Some(Check { rays: 9, faults, ..Check::default() });
        let tests = TestTotals { boxes, ..TestTotals::default() };
        let trace_ms = Spread::of(ms);
        let ray = RayRow {
            scene: scene.clone(),
            builder: builder.clone(),
            set,
            rays: 100,
            trace_ms,
            tests: Some(tests),
            check,
            ..RayRow::default()
        };
        let build = BuildRow {
            scene,
            builder,
            build_ms: trace_ms,
            bvh_bytes: 64,
            survey: Some(Survey::default()),
            ..BuildRow::default()
        };
        let header = super::super::Header::default();
        Results { header, builds: vec![build], rays: vec![ray], images: vec![], pictures: vec![] }
    }

    fn ratio(a: &Results, b: &Results, quantity: Quantity) -> Ratio {
        compare(a, b).ratios.into_iter().find(|r| r.quantity == quantity).unwrap()
    }

    #[test]
    fn a_slower_run_is_past_the_threshold() {
        let (before, after) =
            (results(&[10.0, 10.1, 10.2, 9.9], 5, 0), results(&[12.0, 12.1, 11.9, 12.2], 5, 0));
        for quantity in [Quantity::Build, Quantity::Trace] {
            let r = ratio(&before, &after, quantity);
            assert!((r.ratio - 1.2).abs() < 0.01 && r.is_past(1.05) && !r.is_past(1.25), "{r:?}");
            let [low, high] = r.interval.unwrap();
            assert!(1.1 < low && low < r.ratio && r.ratio < high && high < 1.3, "{r:?}");
            assert!(!ratio(&after, &before, quantity).is_past(1.0), "faster is no fault");
        }
    }

    #[test]
    fn noise_is_not_past_the_threshold() {
        let (before, after) = (results(&[8.0, 10.0, 14.0], 5, 0), results(&[9.0, 12.0, 17.0], 5, 0));
        let r = ratio(&before, &after, Quantity::Trace);
        assert!(r.ratio > 1.15 && !r.is_past(1.05), "{r:?}");
        let few = ratio(&results(&[1.0], 5, 0), &results(&[3.0], 5, 0), Quantity::Trace);
        assert!(few.interval.is_none() && !few.is_past(1.05));
    }

    #[test]
    fn counts_need_no_interval() {
        let (before, after) = (results(&[1.0; 3], 100, 0), results(&[1.0; 3], 106, 1));
        let tests = ratio(&before, &after, Quantity::Tests);
        assert!(tests.is_past(1.05) && !tests.is_past(1.07), "{tests:?}");
        let faults = ratio(&before, &after, Quantity::Faults);
        assert!(faults.ratio.is_infinite() && faults.is_past(1e9), "none, then one");
        assert_eq!(ratio(&before, &after, Quantity::Bytes).ratio, 1.0);
        assert_eq!(ratio(&before, &before, Quantity::Faults).ratio, 1.0);
    }

    #[test]
    fn what_one_run_lacks_is_told() {
        let (whole, mut part) = (results(&[1.0; 3], 1, 0), results(&[1.0; 3], 1, 0));
        part.rays.clear();
        let lacking = compare(&whole, &part);
        assert_eq!((lacking.ratios.len(), lacking.only_first.len(), lacking.only_second.len()), (3, 1, 0));
        assert_eq!(compare(&part, &whole).only_second, lacking.only_first);
    }
}
