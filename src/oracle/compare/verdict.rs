//! What [`super::compare`] found: counts, errors, examples, and how they are added up and printed.

use super::Query;
use crate::abi::{Hit, Ray};
use crate::oracle::brute::{self, Hit64};
use crate::oracle::reference::Reference;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Examples that a verdict keeps.
const EXAMPLES: usize = 5;

/// How an answer can be wrong. A ray has at most one fault: the first that applies, malformed before all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Fault {
    /// No query could have written this record.
    Malformed,
    /// A miss where the reference hits.
    Missed,
    /// A hit where the reference misses.
    False,
    /// t off by more than 1e-4: another surface.
    Leaked,
    /// The right t, but a triangle that is neither the reference's nor tied with it.
    WrongTriangle,
}

/// A faulty ray.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Example {
    /// Its place among the rays.
    pub ray: usize,
    /// What was wrong.
    pub fault: Fault,
    /// Whether rounding is no excuse.
    pub stable: bool,
    /// Origin, t_min, direction, t_max.
    pub values: [f32; 8],
    /// The device's t; not finite is `null` in JSON.
    pub t: f32,
    /// The device's triangle.
    pub triangle: u32,
    /// What the reference says; for an any-hit query some hit, not the first.
    pub expected: Option<Hit64>,
}

impl Example {
    pub(super) fn new(
        at: usize,
        fault: Fault,
        stable: bool,
        ray: &Ray,
        hit: &Hit,
        expected: Option<Hit64>,
    ) -> Self {
        let values = bytemuck::cast(*ray);
        Self { ray: at, fault, stable, values, t: hit.t, triangle: hit.triangle, expected }
    }
}

/// Distribution of an error; zeros where nothing was measured.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Quantiles {
    /// Median.
    pub p50: f64,
    /// 99 in 100 are at most this.
    pub p99: f64,
    /// The worst.
    pub max: f64,
}

impl Quantiles {
    /// Of `values`, which it sorts.
    fn of(values: &mut [f32]) -> Self {
        values.par_sort_unstable_by(f32::total_cmp);
        let at = |share: f64| {
            let last = values.len().saturating_sub(1) as f64;
            values.get((last * share).ceil() as usize).copied().map_or(0.0, f64::from)
        };
        Self { p50: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}

/// How the references compare among themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct BruteCheck {
    /// Rays tried.
    pub rays: usize,
    /// Rays on which the reference and brute force differ in any bit; any is a fault of the reference.
    pub disagreements: usize,
    /// The first of them.
    pub first: Option<usize>,
}

/// What a comparison found. `*_stable` counts those of the count before it that rounding doesn't excuse.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// What was asked.
    pub query: Query,
    /// Rays judged.
    pub rays: usize,
    /// Rays on which the reference hits.
    pub hits: usize,
    /// Records that no query could have written: index out of range, t NaN or out of the ray's range, weights outside
    /// [0, 1] by more than 1e-3, a miss with an index; and rays without a record. Not judged further.
    pub malformed: usize,
    /// Missed hits.
    pub missed: usize,
    /// Missed hits on stable rays.
    pub missed_stable: usize,
    /// Hits where there is none.
    pub false_hits: usize,
    /// False hits on stable rays.
    pub false_stable: usize,
    /// Hits with t off by more than 1e-4.
    pub leaked: usize,
    /// Leaked hits on stable rays.
    pub leaked_stable: usize,
    /// Hits with the right t on a triangle that no tie explains.
    pub wrong_triangle: usize,
    /// Wrong triangles on stable rays.
    pub wrong_triangle_stable: usize,
    /// Hits on another triangle than the reference's, as near within 1e-6: no fault.
    pub ties: usize,
    /// Error of t relative to t, over hits of the reference's own triangle.
    pub t_error: Quantiles,
    /// Error of t in f32 ulps of the true t, over the same.
    pub t_error_ulps: Quantiles,
    /// Greatest error of u or v, over the same.
    pub weight_error_max: f64,
    /// The reference checked in its turn.
    pub brute: Option<BruteCheck>,
    /// Up to five faulty rays, stable ones first.
    pub examples: Vec<Example>,
}

impl Verdict {
    /// Whether nothing is wrong that rounding doesn't excuse, and the reference is sound as far as it was checked.
    pub fn is_clean(&self) -> bool {
        let faults = self.missed_stable + self.false_stable + self.leaked_stable + self.wrong_triangle_stable;
        faults + self.malformed == 0 && self.brute.is_none_or(|b| b.disagreements == 0)
    }

    /// Adds a check of the reference itself against brute force, on `n` evenly spaced rays.
    pub fn sample_brute(mut self, reference: &Reference, rays: &[Ray], n: usize) -> Self {
        let n = n.min(rays.len());
        let differs = |i: &usize| {
            let (scene, ray) = (reference.scene(), &rays[*i]);
            let closest = brute::closest(scene, ray);
            closest != reference.closest(ray) || closest.is_some() != reference.any(ray)
        };
        let bad: Vec<usize> = (0..n).into_par_iter().map(|k| k * rays.len() / n).filter(differs).collect();
        self.brute = Some(BruteCheck { rays: n, disagreements: bad.len(), first: bad.first().copied() });
        self
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let word = if self.is_clean() { "clean" } else { "FAULTY" };
        writeln!(
            f,
            "{word}: {} rays, {} hits by the reference, {} malformed",
            self.rays, self.hits, self.malformed
        )?;
        writeln!(
            f,
            "missed {} ({} stable), false {} ({}), leaked {} ({}), wrong triangle {} ({}), ties {}",
            self.missed,
            self.missed_stable,
            self.false_hits,
            self.false_stable,
            self.leaked,
            self.leaked_stable,
            self.wrong_triangle,
            self.wrong_triangle_stable,
            self.ties
        )?;
        if self.query == Query::Closest {
            let (t, ulps) = (self.t_error, self.t_error_ulps);
            writeln!(
                f,
                "error of t: relative p50 {:.1e}, p99 {:.1e}, max {:.1e}; ulps {:.1}, {:.1}, {:.1}; of u, v: max {:.1e}",
                t.p50, t.p99, t.max, ulps.p50, ulps.p99, ulps.max, self.weight_error_max
            )?;
        }
        if let Some(b) = self.brute {
            write!(f, "reference against brute force: {} of {} rays differ", b.disagreements, b.rays)?;
            b.first.map_or(Ok(()), |i| write!(f, ", ray {i} first"))?;
            writeln!(f)?;
        }
        for e in &self.examples {
            let stable = if e.stable { "stable" } else { "unstable" };
            write!(f, "ray {} {:?} ({stable}) {:?}: ", e.ray, e.fault, e.values)?;
            write!(f, "t {} triangle {}, should be ", e.t, e.triangle as i32)?;
            match e.expected {
                Some(h) => writeln!(f, "t {} triangle {}", h.t, h.triangle)?,
                None => writeln!(f, "a miss")?,
            }
        }
        Ok(())
    }
}

/// A verdict in the making.
pub(super) struct Tally {
    verdict: Verdict,
    relative: Vec<f32>,
    ulps: Vec<f32>,
}

impl Default for Tally {
    fn default() -> Self {
        let verdict = Verdict {
            query: Query::Closest,
            rays: 0,
            hits: 0,
            malformed: 0,
            missed: 0,
            missed_stable: 0,
            false_hits: 0,
            false_stable: 0,
            leaked: 0,
            leaked_stable: 0,
            wrong_triangle: 0,
            wrong_triangle_stable: 0,
            ties: 0,
            t_error: Quantiles::default(),
            t_error_ulps: Quantiles::default(),
            weight_error_max: 0.0,
            brute: None,
            examples: vec![],
        };
        Self { verdict, relative: vec![], ulps: vec![] }
    }
}

impl Tally {
    pub(super) fn count_ray(&mut self, hit: bool) {
        self.verdict.rays += 1;
        self.verdict.hits += usize::from(hit);
    }

    pub(super) fn tie(&mut self) {
        self.verdict.ties += 1;
    }

    pub(super) fn fault(&mut self, example: Example) {
        let v = &mut self.verdict;
        let (all, stable) = match example.fault {
            Fault::Malformed => (&mut v.malformed, None),
            Fault::Missed => (&mut v.missed, Some(&mut v.missed_stable)),
            Fault::False => (&mut v.false_hits, Some(&mut v.false_stable)),
            Fault::Leaked => (&mut v.leaked, Some(&mut v.leaked_stable)),
            Fault::WrongTriangle => (&mut v.wrong_triangle, Some(&mut v.wrong_triangle_stable)),
        };
        *all += 1;
        if let (Some(count), true) = (stable, example.stable) {
            *count += 1;
        }
        v.examples.push(example);
        self.trim();
    }

    /// Adds the errors of a hit on the right triangle.
    pub(super) fn agreement(&mut self, hit: &Hit, expected: &Hit64) {
        let error = (f64::from(hit.t) - expected.t).abs();
        let size = expected.t.abs().max(f64::from(f32::MIN_POSITIVE));
        self.relative.push((error / size) as f32);
        self.ulps.push((error / ulp(expected.t as f32)) as f32);
        let weights = (f64::from(hit.u) - expected.u).abs().max((f64::from(hit.v) - expected.v).abs());
        self.verdict.weight_error_max = self.verdict.weight_error_max.max(weights);
    }

    pub(super) fn merged(mut self, mut other: Self) -> Self {
        let (a, b) = (&mut self.verdict, other.verdict);
        a.rays += b.rays;
        a.hits += b.hits;
        a.malformed += b.malformed;
        a.missed += b.missed;
        a.missed_stable += b.missed_stable;
        a.false_hits += b.false_hits;
        a.false_stable += b.false_stable;
        a.leaked += b.leaked;
        a.leaked_stable += b.leaked_stable;
        a.wrong_triangle += b.wrong_triangle;
        a.wrong_triangle_stable += b.wrong_triangle_stable;
        a.ties += b.ties;
        a.weight_error_max = a.weight_error_max.max(b.weight_error_max);
        a.examples.extend(b.examples);
        self.trim();
        self.relative.append(&mut other.relative);
        self.ulps.append(&mut other.ulps);
        self
    }

    pub(super) fn verdict(mut self, query: Query) -> Verdict {
        Verdict {
            query,
            t_error: Quantiles::of(&mut self.relative),
            t_error_ulps: Quantiles::of(&mut self.ulps),
            ..self.verdict
        }
    }

    fn trim(&mut self) {
        let examples = &mut self.verdict.examples;
        examples.sort_by_key(|e| (!e.stable, e.ray));
        examples.truncate(EXAMPLES);
    }
}

/// Spacing of f32 at `x`.
fn ulp(x: f32) -> f64 {
    let exponent = (x.to_bits() >> 23 & 0xff).max(1);
    f64::from_bits(u64::from(exponent + 1023 - 150) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ulp_is_the_gap_to_the_next_float() {
        for x in [0.0, f32::from_bits(1), f32::MIN_POSITIVE, 1.0, 3.5, -7.0e20f32] {
            assert_eq!(ulp(x), f64::from(x.abs().next_up()) - f64::from(x.abs()), "{x:e}");
        }
    }

    #[test]
    fn quantiles_of_little() {
        assert_eq!(Quantiles::of(&mut []), Quantiles::default());
        assert_eq!(Quantiles::of(&mut [3.0, 1.0]), Quantiles { p50: 3.0, p99: 3.0, max: 3.0 });
    }
}
