//! Builds a tree, has rays traced through it, and judges the answers.

use super::{Answer, Kind, NONSENSE, Setting};
use crate::abi::{Hit, INVALID, Ray};
use crate::bvh::{self, Bvh, SceneBuffers};
use crate::device::{Device, DeviceError, Timing};
use crate::oracle::compare::{self, Verdict, compare};
use crate::oracle::reference::Reference;
use crate::oracle::validate::{Claims, validate};
use crate::trace::{self, Batch, Options, Precision, Query};
use serde::Serialize;
use std::ops::Range;
use std::sync::Arc;

/// Rays of a set among those of a scene.
#[derive(Debug, Clone)]
pub(super) struct Segment {
    /// The set.
    pub(super) name: &'static str,
    /// Its rays.
    pub(super) range: Range<usize>,
}

/// What answers are like. All but the last two: on rays that rounding doesn't excuse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Total {
    /// Missed hits.
    pub missed: usize,
    /// Hits where there is none.
    pub false_hits: usize,
    /// Hits on another surface.
    pub leaked: usize,
    /// Hits on the right surface, of a triangle that no tie explains.
    pub wrong_triangle: usize,
    /// Records that no query could have written.
    pub malformed: usize,
    /// Any of the first four where rounding decides: see [`compare::Arithmetic`].
    pub unsure: usize,
    /// Answers that are not, bit for bit, the first tree's and walk's.
    pub differing: usize,
}

impl Total {
    /// Adds all but what differs.
    pub(super) fn add(&mut self, other: &Self) {
        self.missed += other.missed;
        self.false_hits += other.false_hits;
        self.leaked += other.leaked;
        self.wrong_triangle += other.wrong_triangle;
        self.malformed += other.malformed;
        self.unsure += other.unsure;
    }

    /// Wrong answers that nothing excuses, all kinds together.
    pub fn faults(&self) -> usize {
        self.missed + self.false_hits + self.leaked + self.wrong_triangle + self.malformed
    }

    fn of(v: &Verdict) -> Self {
        let stable = v.missed_stable + v.false_stable + v.leaked_stable + v.wrong_triangle_stable;
        Self {
            missed: v.missed_stable,
            false_hits: v.false_stable,
            leaked: v.leaked_stable,
            wrong_triangle: v.wrong_triangle_stable,
            malformed: v.malformed,
            unsure: v.missed + v.false_hits + v.leaked + v.wrong_triangle - stable,
            differing: 0,
        }
    }
}

/// Hits that were judged. Many trees and walks give the same ones: these are judged once.
#[derive(Debug)]
pub(super) struct Known {
    pub(super) setting: Setting,
    pub(super) options: Options,
    pub(super) hits: Vec<Hit>,
    pub(super) total: Total,
    /// What is wrong, and a ray that shows it.
    pub(super) fault: Option<(Option<usize>, String)>,
}

impl Known {
    /// Rays whose hits in `other` are different.
    pub(super) fn differing(&self, other: &[Hit]) -> Vec<usize> {
        let same = |i: &usize| bytemuck::bytes_of(&self.hits[*i]) == bytemuck::bytes_of(&other[*i]);
        (0..self.hits.len().min(other.len())).filter(|i| !same(i)).collect()
    }
}

/// Hits, or why a tree is too deep to be traced.
type Answered = Result<Vec<Hit>, String>;

/// A scene and its rays on the device.
pub(super) struct Arena<'a> {
    device: &'a Arc<Device>,
    answer: Answer<'a>,
    reference: &'a Reference<'a>,
    rays: &'a [Ray],
    segments: &'a [Segment],
    buffers: SceneBuffers,
    batch: Batch,
}

impl<'a> Arena<'a> {
    /// Uploads the scene of `reference`, and `rays`.
    pub(super) fn new(
        device: &'a Arc<Device>,
        answer: Answer<'a>,
        reference: &'a Reference<'a>,
        rays: &'a [Ray],
        segments: &'a [Segment],
    ) -> Result<Self, DeviceError> {
        let buffers = SceneBuffers::upload(device, reference.scene())?;
        let mut batch = Batch::new(device, rays.len(), false)?;
        batch.set(rays)?;
        Ok(Self { device, answer, reference, rays, segments, buffers, batch })
    }

    /// A sound tree.
    pub(super) fn build(&self, setting: &Setting) -> Result<Bvh, (Kind, String)> {
        let recipe = setting.recipe();
        let built = bvh::build(self.device, &self.buffers, &recipe, Timing::Off);
        let bvh = built.map_err(|e| (Kind::Build, e.to_string()))?.bvh;
        let tree = bvh.read().map_err(|e| (Kind::Build, e.to_string()))?;
        match validate(self.reference.scene(), &tree, &Claims::of(&bvh, recipe.collapse)) {
            Ok(_) => Ok(bvh),
            Err(invalid) => Err((Kind::Tree, invalid.to_string())),
        }
    }

    /// What the device answers, or what it refuses with reason.
    pub(super) fn hits(&self, bvh: &Bvh, options: Options) -> Result<Answered, String> {
        // What a kernel doesn't write is no answer.
        let nothing = Hit { t: f32::NAN, triangle: INVALID - 1, u: f32::NAN, v: f32::NAN };
        self.batch.hits.write(&vec![nothing; self.rays.len()]).map_err(|e| e.to_string())?;
        let entries = trace::stack_entries(bvh);
        match (self.answer)(self.device, bvh, &self.batch, options) {
            Ok(_) if entries > trace::MAX_STACK => {
                Err(format!("traced with a stack that may want {entries} entries, and has fewer"))
            }
            Ok(hits) => Ok(Ok(hits)),
            Err(e @ DeviceError::Limit { .. }) if entries > trace::MAX_STACK => Ok(Err(e.to_string())),
            Err(e) => Err(e.to_string()),
        }
    }

    /// The place in `known` of what these hits are like.
    pub(super) fn judged(
        &self,
        known: &mut Vec<Known>,
        setting: Setting,
        options: Options,
        hits: Vec<Hit>,
    ) -> usize {
        let bytes = bytemuck::cast_slice::<Hit, u8>;
        let same = |k: &Known| {
            (k.options.query, k.options.precision) == (options.query, options.precision)
                && bytes(&k.hits) == bytes(&hits)
        };
        if let Some(at) = known.iter().position(same) {
            return at;
        }
        let (total, fault) = self.judge(options, &hits);
        known.push(Known { setting, options, hits, total, fault });
        known.len() - 1
    }

    /// What hits are like, and what of it is a failure.
    pub(super) fn judge(&self, options: Options, hits: &[Hit]) -> (Total, Option<(Option<usize>, String)>) {
        let query = match options.query {
            Query::Closest => compare::Query::Closest,
            Query::Any => compare::Query::Any,
        };
        let (mut total, mut fault) = (Total::default(), None);
        for Segment { name, range } in self.segments {
            let given = range.start.min(hits.len())..range.end.min(hits.len());
            let verdict = compare(
                self.reference,
                &self.rays[range.clone()],
                &hits[given],
                query,
                options.precision.into(),
            );
            let found = Total::of(&verdict);
            total.add(&found);
            let bad = match options.precision {
                Precision::Robust => found.faults(),
                // The fast test leaks by nature; what can't be hit it doesn't hit.
                Precision::Fast if *name == NONSENSE => found.faults(),
                Precision::Fast => found.malformed,
            };
            if bad > 0 && fault.is_none() {
                let example = verdict.examples.first();
                let ray = example.map(|e| range.start + e.ray);
                fault = Some((ray, format!("{name}: {}", verdict.to_string().trim_end())));
            }
        }
        (total, fault)
    }
}
