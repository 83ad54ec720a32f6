//! Which tree to take: of the builders of a scene, the one that has so many rays traced first, its build included. What
//! traces them by a test that leaks is no answer.

use crate::bench::{Report, Views};

/// A builder that is the best from some number of rays on.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Step {
    /// Its name.
    pub builder: String,
    /// Rays from which on it is: 0 of the first.
    pub from: f64,
}

/// What to take for a scene's rays of one set.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Answer {
    /// The scene.
    pub scene: String,
    /// Which rays.
    pub set: String,
    /// What to take, by how many rays there are to trace after a build, fewest first.
    pub steps: Vec<Step>,
    /// Whose rays are the fastest, builds aside.
    pub fastest: String,
    /// Its millions of rays a second: the median.
    pub mrays_s: f64,
    /// Those whose rays are as fast: their quartiles overlap.
    pub alike: Vec<String>,
    /// Against whom it is held: the first builder with axis-aligned boxes.
    pub against: Option<Against>,
}

/// The fastest over another builder.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Against {
    /// Whom.
    pub builder: String,
    /// Rays a second over theirs.
    pub rate: f64,
    /// What tests cost a ray over what they cost there; none where no cost is known.
    pub tests: Option<f64>,
    /// Build time over theirs.
    pub build: f64,
}

/// A builder's share in the race: a build, then rays one after another.
#[derive(Debug, Clone, Copy)]
struct Racer<'r> {
    views: &'r Views<'r>,
    build_ms: f64,
    ms_per_ray: f64,
    /// None where a driver traces.
    cost_per_ray: Option<f64>,
}

/// Of each scene and set of a run.
pub fn answers(report: &Report) -> Vec<Answer> {
    let sets = report.sets();
    let mut asked: Vec<[&str; 2]> = sets.iter().map(|v| [v.scene, v.set]).collect();
    asked.dedup();
    asked.iter().filter_map(|[scene, set]| answer(report, scene, set, &sets)).collect()
}

fn answer<'v>(report: &Report, scene: &str, set: &str, sets: &'v [Views<'v>]) -> Option<Answer> {
    let racer = |views: &'v Views<'v>| {
        let Views { builder, trace_ms, rays, tests, .. } = views;
        let build = report.builds().iter().find(|b| b.scene == scene && b.builder == *builder)?;
        let costs = report.header().costs;
        let n = (*rays).max(1) as f64;
        let cost_per_ray = tests.map(|t| costs.per_ray(&t, *rays)).filter(|cost| *cost > 0.0);
        let (build_ms, ms_per_ray) = (build.build_ms.median, trace_ms.median / n);
        Some(Racer { views, build_ms, ms_per_ray, cost_per_ray })
    };
    let racers: Vec<Racer> = sets
        .iter()
        .filter(|v| (v.scene, v.set) == (scene, set) && v.rays > 0 && !v.is_fast())
        .filter_map(racer)
        .collect();
    let fastest = racers.iter().min_by(|a, b| a.ms_per_ray.total_cmp(&b.ms_per_ray))?;
    let rate = fastest.views.mrays_s();
    let alike = |r: &&Racer| r.views.builder != fastest.views.builder && r.views.mrays_s().q3 >= rate.q1;
    let aligned = report.header().order.aligned.as_deref();
    let other = racers.iter().find(|r| Some(r.views.builder) == aligned);
    let against = other.filter(|o| o.views.builder != fastest.views.builder).map(|o| Against {
        builder: o.views.builder.to_owned(),
        rate: o.ms_per_ray / fastest.ms_per_ray,
        tests: fastest.cost_per_ray.zip(o.cost_per_ray).map(|(a, b)| a / b),
        build: fastest.build_ms / o.build_ms,
    });
    Some(Answer {
        scene: scene.to_owned(),
        set: set.to_owned(),
        steps: steps(&racers),
        fastest: fastest.views.builder.to_owned(),
        mrays_s: rate.median,
        alike: racers.iter().filter(alike).map(|r| r.views.builder.to_owned()).collect(),
        against,
    })
}

/// The lower envelope of the racers' lines: time by rays.
fn steps(racers: &[Racer]) -> Vec<Step> {
    let first = |a: &&Racer, b: &&Racer| {
        a.build_ms.total_cmp(&b.build_ms).then(a.ms_per_ray.total_cmp(&b.ms_per_ray))
    };
    let Some(mut now) = racers.iter().min_by(first) else { return vec![] };
    let mut steps = vec![Step { builder: now.views.builder.to_owned(), from: 0.0 }];
    // The next is the one whose line crosses this one's first; of several the flattest.
    let crossing = |now: &Racer, r: &Racer| (r.build_ms - now.build_ms) / (now.ms_per_ray - r.ms_per_ray);
    while let Some(next) = racers.iter().filter(|r| r.ms_per_ray < now.ms_per_ray).min_by(|a, b| {
        crossing(now, a).total_cmp(&crossing(now, b)).then(a.ms_per_ray.total_cmp(&b.ms_per_ray))
    }) {
        steps.push(Step { builder: next.views.builder.to_owned(), from: crossing(now, next).round() });
        now = next;
    }
    steps
}

#[cfg(test)]
mod tests;
