//! Errors of pictures: ambient occlusion and light of the sky as the samples of a hit grow, by Halton's points and by
//! chance, against a picture of many more samples; and the time that tracing them takes.

use super::plan::{ImagePlan, Key};
use super::run::{Progress, Stage};
use super::stats::enough;
use super::{Result, Rows, Spread};
use crate::picture::Studio;
use crate::trace::rays::{Sampler, Secondary};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Pictures by chance, each of another seed, whose errors are taken together: the hits of a picture share their points, so
/// one alone may be lucky.
const SEEDS: u64 = 8;

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

    /// What a ray along `direction`, which met nothing, brings.
    fn brings(self, direction: Vec3, up: Vec3) -> f32 {
        match self {
            Self::Ao => 1.0,
            Self::Diffuse => direction.dot(up).max(0.0),
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
    /// Root of the mean squared difference from the converged picture; of `random`, over pictures of eight seeds.
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
    let Some(painter) = stage.plan.painter_of(stage.spec) else { return Ok(()) };
    let Some((contender, bvh)) = stage.own_trees().find(|tree| tree.0 == painter) else { return Ok(()) };
    let key = |shows: Shows, sampler: &str, n: u32| {
        Key::image(stage.spec, &contender.name, shows.name(), sampler, n)
    };
    for shows in Shows::ALL {
        let missing = |sampler: &str| plan.samples.iter().any(|n| !rows.has(&key(shows, sampler, *n)));
        if !missing("halton") && !missing("random") {
            continue;
        }
        progress(&format!("{}: a converged picture, {}", stage.spec, shows.name()), rows);
        let studio = stage.studio(plan.size, bvh)?;
        // Of other points than the pictures that it is held against.
        let converged = expose(stage, &studio, shows, Sampler::Halton(plan.converged), plan.converged)?.0;
        let samplers =
            [("halton", vec![Sampler::Halton(0)]), ("random", (0..SEEDS).map(Sampler::Random).collect())];
        for (name, samplers) in samplers {
            for samples in &plan.samples {
                if rows.has(&key(shows, name, *samples)) {
                    continue;
                }
                progress(&format!("{}: {}, {samples} samples, {name}", stage.spec, shows.name()), rows);
                // The first warm up.
                let expose = |sampler: &Sampler| expose(stage, &studio, shows, *sampler, *samples);
                let pictures = samplers.iter().map(|s| Ok(expose(s)?.0)).collect::<Result<Vec<Values>>>()?;
                let mut ms = vec![];
                while !enough(stage.plan.runs, &ms) {
                    ms.push(expose(&samplers[ms.len() % samplers.len()])?.1);
                }
                rows.push_image(ImageRow {
                    scene: stage.spec.to_owned(),
                    builder: contender.name.clone(),
                    shows: shows.name().to_owned(),
                    sampler: name.to_owned(),
                    samples: *samples,
                    pixels: converged.iter().flatten().count(),
                    trace_ms: Spread::of(&ms),
                    rmse: rmse(&pictures, &converged),
                    converged: plan.converged,
                })?;
            }
        }
    }
    Ok(())
}

/// A value a primary ray, if it met a surface.
type Values = Vec<Option<f64>>;

/// The picture by so many samples, and what tracing them took, ms.
fn expose(
    stage: &Stage,
    studio: &Studio,
    shows: Shows,
    sampler: Sampler,
    samples: u32,
) -> Result<(Values, f64)> {
    let up = Vec3::from(stage.scene.views_or_default()[0].up).normalize_or(Vec3::Y);
    let kind = Secondary { samples, sampler, ..shows.rays(stage) };
    let found = studio.gathered(&kind, |d| Vec3::splat(shows.brings(d, up)), &|_| ())?;
    Ok((found.means.iter().map(|mean| mean.map(|m| f64::from(m.x))).collect(), found.trace_ms))
}

/// Root of the mean squared difference of all pixels of `pictures` that show a surface; 0 of none.
fn rmse(pictures: &[Values], converged: &Values) -> f64 {
    let differences = pictures.iter().flat_map(|p| p.iter().zip(converged));
    let squares = differences.filter_map(|(a, b)| Some((a.as_ref()? - b.as_ref()?).powi(2)));
    let (sum, count) = squares.fold((0.0, 0usize), |(sum, n), square| (sum + square, n + 1));
    (sum / count.max(1) as f64).sqrt()
}
