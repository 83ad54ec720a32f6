//! Rows of rays that differ in their view alone, added up.

use super::row::{Check, RayRow};
use super::{Spread, TestTotals};
use crate::oracle::compare::Quantiles;
use crate::trace::Boxes;

/// The views of a set, added up.
#[derive(Debug, Clone, PartialEq)]
pub struct Views<'r> {
    /// As the plan has it.
    pub scene: &'r str,
    /// The contender's name.
    pub builder: &'r str,
    /// Which rays, as typed.
    pub set: &'r str,
    /// Rays of a run of each view.
    pub rays: usize,
    /// Those that hit something.
    pub hits: usize,
    /// Device time, ms: sums of medians and of quartiles, the latter no quartiles of the sum, but no smaller spread.
    pub trace_ms: Spread,
    /// Tests of all rays; none where a driver traced them.
    pub tests: Option<TestTotals>,
    /// With which triangle test.
    pub precision: &'r str,
    /// Counts of the hits judged, and the greatest of the views' errors of t; no verdict.
    pub check: Check,
    /// Kernels that traced them, each once: with what was done beside.
    pub kernels: Vec<String>,
}

impl<'r> Views<'r> {
    /// Of all `rows`, in the order in which a set's first view comes.
    pub fn of_all(rows: &[&'r RayRow]) -> Vec<Self> {
        let mut sets: Vec<Vec<&RayRow>> = vec![];
        for row in rows {
            let same = |r: &RayRow| (&r.scene, &r.builder, &r.set) == (&row.scene, &row.builder, &row.set);
            match sets.iter_mut().find(|views| same(views[0])) {
                Some(views) => views.push(row),
                None => sets.push(vec![row]),
            }
        }
        sets.iter().map(|views| Self::of(views[0], views)).collect()
    }

    fn of(first: &'r RayRow, rows: &[&RayRow]) -> Self {
        let sum = |f: fn(&RayRow) -> usize| rows.iter().map(|r| f(r)).sum();
        let tests: Option<Vec<TestTotals>> = rows.iter().map(|r| r.tests).collect();
        let ms = |f: fn(&Spread) -> f64| rows.iter().map(|r| f(&r.trace_ms)).sum();
        let check = |f: fn(&Check) -> usize| rows.iter().filter_map(|r| r.check.as_ref()).map(f).sum();
        let error = |f: fn(&Quantiles) -> f64| {
            rows.iter().filter_map(|r| r.check.as_ref()).map(|c| f(&c.t_error)).fold(0.0, f64::max)
        };
        let title = |r: &&RayRow| {
            let sorted = if r.sorted { ", sorted" } else { "" };
            let boxes = if r.boxes.as_deref() == Some(Boxes::AxisAligned.name()) {
                ", axis-aligned boxes"
            } else {
                ""
            };
            format!("{}{sorted}{boxes}", r.kernel)
        };
        let mut kernels: Vec<String> = rows.iter().map(title).collect();
        kernels.sort_unstable();
        kernels.dedup();
        Self {
            scene: &first.scene,
            builder: &first.builder,
            set: &first.set,
            rays: sum(|r| r.rays),
            hits: sum(|r| r.hits),
            trace_ms: Spread {
                median: ms(|s| s.median),
                min: ms(|s| s.min),
                max: ms(|s| s.max),
                q1: ms(|s| s.q1),
                q3: ms(|s| s.q3),
                runs: rows.iter().map(|r| r.trace_ms.runs).min().unwrap_or(0),
            },
            tests: tests.map(|all| TestTotals {
                boxes: all.iter().map(|t| t.boxes).sum(),
                oriented: all.iter().map(|t| t.oriented).sum(),
                triangles: all.iter().map(|t| t.triangles).sum(),
            }),
            check: Check {
                rays: check(|c| c.rays),
                faults: check(|c| c.faults),
                unsure: check(|c| c.unsure),
                missed: check(|c| c.missed),
                false_hits: check(|c| c.false_hits),
                leaked: check(|c| c.leaked),
                wrong_triangle: check(|c| c.wrong_triangle),
                t_error: Quantiles { p50: error(|q| q.p50), p99: error(|q| q.p99), max: error(|q| q.max) },
                verdict: None,
            },
            precision: &first.precision,
            kernels,
        }
    }

    /// Millions of rays a second.
    pub fn mrays_s(&self) -> Spread {
        self.trace_ms.rate(self.rays)
    }
}
