//! A part of a profile: one thing, run again and again with either kind of stamps.

use super::Result;
use super::copied::{Copied, gb_s};
use crate::bench::{Spread, by_kernel};
use crate::device::{Event, Times, Timing, Traffic, Work};
use std::time::Instant;

/// All passes of one kernel, in one run.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct KernelRow {
    /// `stage/verb`; `fill`, `update`, `copy`; of work on the host likewise.
    pub name: String,
    /// Passes.
    pub calls: usize,
    /// Time of all of them, ms.
    pub ms: Spread,
    /// Share of all passes' time, per cent.
    pub percent: f64,
    /// Bytes that it moves, as the [module](super) takes them; none where nothing tells.
    pub bytes: Option<u64>,
    /// These by the median time.
    pub gb_s: Option<f64>,
    /// Likewise, per cent of the copy's.
    pub percent_of_copy: Option<f64>,
    /// Invocations that the device counted.
    pub invocations: Option<u64>,
    /// Invocations that it was asked for, where the host knows.
    pub asked: Option<u64>,
}

/// A build, or a set of rays.
#[derive(Debug, serde::Serialize)]
pub struct Part {
    /// `build`, or the kind of rays.
    pub name: &'static str,
    /// By kernel, in order of first use.
    pub kernels: Vec<KernelRow>,
    /// Sum of all passes, of the runs with a stamp each, ms.
    pub sum_ms: Spread,
    /// Between the outer stamps of the same runs, ms.
    pub outer_ms: Spread,
    /// What the passes' stamps cost, ms.
    pub stamps_ms: f64,
    /// Between the outer stamps of runs without any others, ms.
    pub unstamped_ms: Spread,
    /// By how much the sum of a run's passes is off what lies between its outer stamps, at most, per cent.
    pub off_percent: f64,
    /// The last run with a stamp a pass, and when it began and ended.
    #[serde(skip)]
    pub(super) last: (Times, [Instant; 2]),
}

impl Part {
    /// Runs once to warm up and to have invocations counted, then `runs` times with outer stamps and with a stamp a pass
    /// in turn, so that what drifts hits both.
    ///
    /// # Errors
    /// Those of `run`.
    pub(super) fn measure(
        name: &'static str,
        runs: usize,
        mut run: impl FnMut(Timing) -> Result<Times>,
    ) -> Result<Self> {
        let counted = run(Timing::Statistics)?;
        let (mut unstamped, mut stamped) = (vec![], vec![]);
        let mut last = (counted.clone(), [Instant::now(); 2]);
        for _ in 0..runs {
            unstamped.push(run(Timing::Outer)?.device_ms);
            let began = Instant::now();
            let times = run(Timing::Passes)?;
            last = (times.clone(), [began, Instant::now()]);
            stamped.push(times);
        }
        take_counts(&mut last.0, &counted);
        let sums: Vec<f64> = stamped.iter().map(|t| t.passes.iter().map(|p| p.ms).sum()).collect();
        let outer: Vec<f64> = stamped.iter().map(|t| t.device_ms).collect();
        let off = sums.iter().zip(&outer).map(|(sum, outer)| percent_off(*sum, *outer));
        Ok(Self {
            name,
            kernels: rows(&stamped, &last.0),
            sum_ms: Spread::of(&sums),
            outer_ms: Spread::of(&outer),
            stamps_ms: 0.0,
            unstamped_ms: Spread::of(&unstamped),
            off_percent: off.fold(0.0, |a, b| if b.abs() > f64::abs(a) { b } else { a }),
            last,
        })
    }

    /// The kernel `name` moves `traffic` in a run, by what was counted.
    pub(super) fn walked(&mut self, name: &str, traffic: Traffic) {
        for row in self.kernels.iter_mut().filter(|row| row.name == name) {
            row.bytes = Some(traffic.bytes());
        }
        let events = self.last.0.submits.iter_mut().flat_map(|s| &mut s.events);
        events.filter(|e| e.name == name).for_each(|e| e.traffic = traffic);
    }

    /// Passes of a run.
    pub fn calls(&self) -> usize {
        self.kernels.iter().map(|row| row.calls).sum()
    }

    /// By how much runs with a stamp a pass take longer than those without, beside what stamps cost, per cent: noise, but
    /// for what their cost is no measure of. None where no time was seen.
    pub fn differs_percent(&self) -> Option<f64> {
        let without = self.unstamped_ms.median;
        (without > 0.0).then(|| percent_off(self.outer_ms.median - self.stamps_ms, without))
    }

    /// Fills in bandwidths, and what stamps cost.
    pub(super) fn weigh(&mut self, copy: &Copied, stamp_ms: f64) {
        let stamped: usize = self.last.0.submits.iter().map(|s| s.events.len()).sum();
        self.stamps_ms = stamp_ms * stamped as f64;
        for row in &mut self.kernels {
            row.gb_s = row.bytes.and_then(|bytes| gb_s(bytes, row.ms.median));
            row.percent_of_copy = row.gb_s.filter(|_| copy.gb_s > 0.0).map(|x| 100.0 * x / copy.gb_s);
        }
    }
}

/// By how much `sum` is more than `whole`, per cent.
fn percent_off(sum: f64, whole: f64) -> f64 {
    if whole > 0.0 { 100.0 * (sum / whole - 1.0) } else { 0.0 }
}

/// Takes invocations over from `counted`, a run of the same passes; of dispatches of unknown size, bytes by their share of
/// the kernel's largest, none where nothing was counted.
fn take_counts(times: &mut Times, counted: &Times) {
    for (submit, counted) in times.submits.iter_mut().zip(&counted.submits) {
        for (event, counted) in submit.events.iter_mut().zip(&counted.events) {
            if event.name == counted.name {
                event.invocations = counted.invocations;
            }
        }
    }
    let most: Vec<(&str, u64)> = events(times).filter_map(|e| Some((e.name, e.invocations?))).collect();
    let most = |name: &str| most.iter().filter(|m| m.0 == name).map(|m| m.1).max();
    let of_most: Vec<(Option<u64>, Option<u64>)> =
        events(times).map(|e| (e.invocations, most(e.name))).collect();
    let all = times.submits.iter_mut().flat_map(|s| &mut s.events);
    for (event, (count, most)) in all.zip(of_most) {
        if let Work::Indirect { .. } = event.work {
            let share = |bytes: u64| match (count, most) {
                (Some(count), Some(most @ 1..)) => {
                    (u128::from(bytes) * u128::from(count) / u128::from(most)) as u64
                }
                _ => 0,
            };
            event.traffic =
                Traffic { read: share(event.traffic.read), written: share(event.traffic.written) };
        }
    }
}

fn events(times: &Times) -> impl Iterator<Item = &Event> {
    times.submits.iter().flat_map(|s| &s.events)
}

/// Bytes of a pass; none where the device alone knows its size and doesn't tell.
pub(super) fn bytes(event: &Event) -> Option<Traffic> {
    let unknown = matches!(event.work, Work::Indirect { .. }) && event.invocations.is_none();
    (!unknown).then_some(event.traffic)
}

/// A row a kernel: times of all `runs`, the rest of the `last`.
fn rows(runs: &[Times], last: &Times) -> Vec<KernelRow> {
    let by_run: Vec<_> = runs.iter().map(|t| by_kernel(&t.passes)).collect();
    let mut rows = vec![];
    for kernel in by_kernel(&last.passes) {
        let ms: Vec<f64> = by_run
            .iter()
            .filter_map(|kernels| kernels.iter().find(|k| k.name == kernel.name).map(|k| k.ms))
            .collect();
        let of_kernel = || events(last).filter(|e| e.name == kernel.name);
        let on_host = of_kernel().next().is_none();
        let sum = |each: fn(&Event) -> Option<u64>| match on_host {
            true => None,
            false => of_kernel().map(each).sum(),
        };
        rows.push(KernelRow {
            calls: kernel.count,
            ms: Spread::of(&ms),
            percent: 0.0,
            bytes: sum(|e| bytes(e).map(Traffic::bytes)),
            gb_s: None,
            percent_of_copy: None,
            invocations: sum(|e| e.invocations),
            asked: sum(|e| e.work.invocations()),
            name: kernel.name.into_owned(),
        });
    }
    let all: f64 = rows.iter().map(|row| row.ms.median).sum();
    for row in &mut rows {
        row.percent = if all > 0.0 { 100.0 * row.ms.median / all } else { 0.0 };
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::Submit;

    fn event(name: &'static str, work: Work, read: u64, invocations: Option<u64>) -> Event {
        let traffic = Traffic { read, written: read / 2 };
        Event { name, at: Instant::now(), ms: 1.0, work, traffic, invocations }
    }

    fn times(events: Vec<Event>) -> Times {
        let at = Instant::now();
        let submit = Submit { at, wall_ms: 4.0, device_at: at, device_ms: 3.0, unsure_ms: None, events };
        Times { submits: vec![submit], ..Times::default() }
    }

    /// Three rounds of a kernel, one of them empty, and a dispatch of known size.
    fn run(counts: [Option<u64>; 4]) -> Times {
        let rounds = Work::Indirect { size: 8 };
        times(vec![
            event("a/b", rounds, 100, counts[0]),
            event("a/b", rounds, 100, counts[1]),
            event("a/b", rounds, 100, counts[2]),
            event("a/c", Work::Groups { groups: 2, size: 8 }, 100, counts[3]),
        ])
    }

    #[test]
    fn smaller_rounds_move_less() {
        let mut timed = run([None; 4]);
        take_counts(&mut timed, &run([Some(800), Some(200), Some(0), Some(16)]));
        let all: Vec<_> = events(&timed).map(bytes).collect();
        let traffic = |read, written| Some(Traffic { read, written });
        assert_eq!(all, [traffic(100, 50), traffic(25, 12), traffic(0, 0), traffic(100, 50)]);
        assert!(events(&timed).map(|e| e.invocations).eq([Some(800), Some(200), Some(0), Some(16)]));
    }

    #[test]
    fn rounds_that_nobody_counts_move_nobody_knows_what() {
        let mut timed = run([None; 4]);
        take_counts(&mut timed, &run([None; 4]));
        let all: Vec<_> = events(&timed).map(|e| bytes(e).is_some()).collect();
        assert_eq!(all, [false, false, false, true]);
    }

    #[test]
    fn counts_of_other_passes_are_not_taken() {
        let mut timed = times(vec![event("a/b", Work::Groups { groups: 1, size: 8 }, 100, None)]);
        take_counts(&mut timed, &times(vec![event("x/y", Work::Groups { groups: 1, size: 8 }, 1, Some(8))]));
        assert_eq!(events(&timed).next().and_then(|e| e.invocations), None);
    }

    #[test]
    fn sums_are_off_by_what_is_missing() {
        assert_eq!((percent_off(95.0, 100.0).round(), percent_off(1.0, 0.0)), (-5.0, 0.0));
    }
}
