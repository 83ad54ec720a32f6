//! Errors of pictures: ambient occlusion and light of the sky as the samples of a hit grow, by Halton's points and by
//! chance, against a picture of many more samples; and the time that tracing them takes.

use super::plan::{ImagePlan, Key};
use super::run::{Progress, Stage};
use super::stats::enough;
use super::{Result, Rows, Spread};
use crate::abi::{Hit, Ray};
use crate::device::Timing;
use crate::trace::rays::{SECONDARY_BATCH, Sampler, Secondary, View, primary, secondary};
use crate::trace::{Batch, Options, Walk, trace};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Seed of the samples by chance.
const SEED: u64 = 1;

/// What a picture shows, a pixel's value from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shows {
    /// The share of ambient-occlusion rays that meet nothing.
    Ao,
    /// Light on a white surface of a sky that is black at the horizon and below, and brightens with height to 1.
    Diffuse,
}

impl Shows {
    const ALL: [Self; 2] = [Self::Ao, Self::Diffuse];

    fn name(self) -> &'static str {
        match self {
            Self::Ao => "ao",
            Self::Diffuse => "diffuse",
        }
    }

    fn rays(self, stage: &Stage) -> Secondary {
        match self {
            Self::Ao => Secondary::ao(&stage.scene.bounds()),
            Self::Diffuse => Secondary::diffuse(),
        }
    }

    /// What `ray`, which met nothing, brings.
    fn brings(self, ray: &Ray, up: Vec3) -> f64 {
        match self {
            Self::Ao => 1.0,
            Self::Diffuse => f64::from(Vec3::from(ray.direction).dot(up).max(0.0)),
        }
    }
}

/// A picture of a scene by some samples a hit, and how far it is from a converged one.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ImageRow {
    /// As the plan has it.
    pub scene: String,
    /// The contender's name.
    pub builder: String,
    /// `ao`: the share of open rays; `diffuse`: light of the sky on a white surface. Both from 0 to 1.
    pub shows: String,
    /// `halton`, `random`.
    pub sampler: String,
    /// Samples a hit.
    pub samples: u32,
    /// Pixels that show a surface.
    pub pixels: usize,
    /// Device time of tracing the samples, ms.
    pub trace_ms: Spread,
    /// Root of the mean squared difference from the converged picture.
    pub rmse: f64,
    /// Samples a hit of the converged picture.
    pub converged: u32,
}

impl ImageRow {
    /// What it is about.
    pub fn key(&self) -> Key {
        Key::image(&self.scene, &self.builder, &self.shows, &self.sampler, self.samples)
    }
}

/// Names of what pictures show and of how their samples are spread, in the order of the rows.
pub(super) fn kinds() -> impl Iterator<Item = [&'static str; 2]> {
    Shows::ALL.into_iter().flat_map(|s| ["halton", "random"].map(|sampler| [s.name(), sampler]))
}

/// Takes the pictures of the scene that `rows` lacks, through the first contender's tree, where it is built here.
pub(super) fn take(stage: &Stage, plan: &ImagePlan, rows: &mut Rows, progress: Progress) -> Result<()> {
    let Some(contender) = stage.plan.painter_of(stage.spec) else { return Ok(()) };
    let key = |shows: Shows, sampler: &str, n: u32| {
        Key::image(stage.spec, &contender.name, shows.name(), sampler, n)
    };
    for shows in Shows::ALL {
        let missing = |sampler: &str| plan.samples.iter().any(|n| !rows.has(&key(shows, sampler, *n)));
        if !missing("halton") && !missing("random") {
            continue;
        }
        progress(&format!("{}: a converged picture, {}", stage.spec, shows.name()), rows);
        let studio = Studio::new(stage, plan)?;
        // Of other points than the pictures that it is held against.
        let converged = studio.expose(shows, Sampler::Halton(plan.converged), plan.converged)?;
        let samplers = [("halton", Sampler::Halton(0)), ("random", Sampler::Random(SEED))];
        for (name, sampler) in samplers {
            for samples in &plan.samples {
                if rows.has(&key(shows, name, *samples)) {
                    continue;
                }
                progress(&format!("{}: {}, {samples} samples, {name}", stage.spec, shows.name()), rows);
                // The first warms up.
                let picture = studio.expose(shows, sampler, *samples)?;
                let mut ms = vec![];
                while !enough(stage.plan.runs, &ms) {
                    ms.push(studio.expose(shows, sampler, *samples)?.trace_ms);
                }
                rows.push_image(ImageRow {
                    scene: stage.spec.to_owned(),
                    builder: contender.name.clone(),
                    shows: shows.name().to_owned(),
                    sampler: name.to_owned(),
                    samples: *samples,
                    pixels: picture.values.len(),
                    trace_ms: Spread::of(&ms),
                    rmse: rmse(&picture.values, &converged.values),
                    converged: plan.converged,
                })?;
            }
        }
    }
    Ok(())
}

/// A scene's primary rays, traced.
struct Studio<'a> {
    stage: &'a Stage<'a>,
    primaries: Batch,
    up: Vec3,
}

/// A value a pixel that shows a surface, and what tracing took.
struct Picture {
    values: Vec<f64>,
    trace_ms: f64,
}

impl<'a> Studio<'a> {
    fn new(stage: &'a Stage<'a>, plan: &ImagePlan) -> Result<Self> {
        let [width, height] = plan.size;
        let view = View { camera: stage.scene.views_or_default()[0], width, height };
        let mut primaries = Batch::new(stage.device, view.pixels(), false)?;
        primary(stage.device, &view, &mut primaries, Timing::Off)?;
        let options = Options { walk: Walk::untried(stage.device, true), ..Options::default() };
        trace(stage.device, &stage.trees[0], &primaries, options, Timing::Off)?;
        Ok(Self { stage, primaries, up: Vec3::from(view.camera.up).normalize_or(Vec3::Y) })
    }

    fn expose(&self, shows: Shows, sampler: Sampler, samples: u32) -> Result<Picture> {
        let Stage { device, trees, buffers, .. } = self.stage;
        let kind = Secondary { samples, sampler, ..shows.rays(self.stage) };
        let options = Options { query: kind.query(), ..Options::default() };
        let mut batch = Batch::new(device, SECONDARY_BATCH, false)?;
        let mut picture = Picture { values: vec![], trace_ms: 0.0 };
        let mut start = 0;
        while start < self.primaries.count {
            start +=
                secondary(device, buffers, &self.primaries, &kind, start, &mut batch, Timing::Off)?.0.max(1);
            if batch.count == 0 {
                continue;
            }
            picture.trace_ms += trace(device, &trees[0], &batch, options, Timing::Outer)?.device_ms;
            let (rays, hits) = (batch.rays.read_first(batch.count)?, batch.hits.read_first(batch.count)?);
            let value = |(rays, hits): (&[Ray], &[Hit])| {
                let free = rays.iter().zip(hits).filter(|(_, hit)| !hit.is_hit());
                free.map(|(ray, _)| shows.brings(ray, self.up)).sum::<f64>() / f64::from(samples)
            };
            let n = samples as usize;
            picture.values.extend(rays.chunks_exact(n).zip(hits.chunks_exact(n)).map(value));
        }
        Ok(picture)
    }
}

/// Root of the mean squared difference; 0 of no pixels.
fn rmse(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / a.len().max(1) as f64).sqrt()
}
