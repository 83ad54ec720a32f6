//! The page: what goes where. Text is escaped by the template, plots alone are markup already.

use super::plots::{Bar, Lines, Plot, Series, bars, curves, points};
use super::{Answer, Result, answers, errors, printed};
use crate::bench::{BuildRow, Key, PictureRow, Report, Results, Table, Views};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, Value, context};
use serde::Serialize;

const TEMPLATE: &str = include_str!("page.html");

/// One run.
#[derive(Debug, Serialize)]
struct Run {
    device: String,
    driver: String,
    commit: String,
    command: String,
    plan: String,
    /// Costs of a box, an oriented one and a triangle, ns.
    costs: [f64; 3],
    answers: Vec<Answer>,
    scenes: Vec<SceneSection>,
    /// Over all scenes.
    plots: Vec<Plot>,
    tables: Vec<Titled>,
    /// Rows that are not there.
    missing: Vec<String>,
    /// Of how many.
    planned: usize,
    /// What is wrong with hits.
    faults: Vec<String>,
    /// Likewise, with those of the driver's traversal.
    drivers_faults: Vec<String>,
    /// Hits of boxwood that were judged.
    checked: usize,
}

/// A table and what it is of.
#[derive(Debug, Serialize)]
struct Titled {
    title: &'static str,
    table: Table,
}

/// What is said of one scene.
#[derive(Debug, Serialize)]
struct SceneSection {
    name: String,
    triangles: usize,
    plots: Vec<Plot>,
    pictures: Vec<Shown>,
    /// A builder, and what its build did and skipped.
    explained: Vec<Explained>,
}

/// A picture.
#[derive(Debug, Serialize)]
struct Shown {
    title: String,
    /// PNG, in base 64.
    png: String,
}

#[derive(Debug, Serialize)]
struct Explained {
    builder: String,
    sentences: Vec<String>,
}

/// The page of `runs`.
///
/// # Errors
/// A plot or the page fails: no data does that.
pub fn html(runs: &[Results]) -> Result<String> {
    let runs: Vec<Run> = runs.iter().map(run).collect::<Result<_>>()?;
    let mut env = Environment::new();
    env.set_auto_escape_callback(|_| AutoEscape::Html);
    env.add_filter("fixed", |x: f64, digits: usize| format!("{x:.digits$}"));
    env.add_filter("count", |n: f64| count(n));
    env.add_template("page.html", TEMPLATE)?;
    let runs = Value::from(Serde(&runs));
    Ok(env.get_template("page.html")?.render(context! { runs, version => env!("CARGO_PKG_VERSION") })?)
}

/// A number of things in few digits: 870, 3.1k, 12M.
fn count(n: f64) -> String {
    let [unit, sign] = match n {
        n if n >= 1e9 => [1e9, 3.0],
        n if n >= 1e6 => [1e6, 2.0],
        n if n >= 1e3 => [1e3, 1.0],
        _ => [1.0, 0.0],
    };
    let scaled = n / unit;
    let digits = usize::from(unit > 1.0 && scaled < 9.95);
    format!("{scaled:.digits$}{}", ["", "k", "M", "G"][sign as usize])
}

fn run(results: &Results) -> Result<Run> {
    let (report, header) = (&Report::new(results), &results.header);
    let missing: Vec<String> = results.missing().iter().map(Key::to_string).collect();
    let mut names: Vec<&str> = report.builds().iter().map(|b| b.scene.as_str()).collect();
    names.dedup();
    let sets = report.sets();
    let scenes = names.iter().map(|name| scene(report, &sets, name)).collect::<Result<_>>()?;
    let titled = |title, table| Titled { title, table };
    Ok(Run {
        device: header.device.clone(),
        driver: header.driver.clone(),
        commit: header.commit.clone(),
        command: header.command.join(" "),
        plan: header.plan.clone(),
        costs: header.costs.to_array(),
        answers: answers(report),
        scenes,
        plots: if sets.is_empty() { vec![] } else { vec![predicted(report, &sets)?] },
        tables: [
            titled(
                "Builds: medians; ± is the range between the quartiles, in per cent of the median",
                report.build_table(),
            ),
            titled(
                "Boxes: shares and areas against the same tree with axis-aligned boxes; expected costs with (c_T, c_OBB, c_I) = (3, 4, 2)",
                report.volume_table(),
            ),
            titled("Rays, the views of each set together", report.ray_table()),
            titled(
                "Beside Table 6.1 of Veverkova24: each over the same scene's PLOC tree of axis-aligned boxes, and in brackets what is printed there, of another machine (CUDA, GTX 1070 Ti), other code, and, but for the dragon, other models of the same kinds and sizes",
                printed::beside(report, &sets),
            ),
            titled(
                "Errors of judged hits: wrong ones of a million, those among them that rounding doesn't excuse, and of t, relative; views together, the worst of their errors of t",
                report.error_table(),
            ),
            titled("Errors of pictures", report.image_table()),
            titled("Build time by kernel, of one run with a stamp a kernel", report.kernel_table()),
        ]
        .into_iter()
        .filter(|t| !t.table.rows.is_empty())
        .collect(),
        planned: results.count() + missing.len(),
        missing,
        faults: report.faults(),
        drivers_faults: report.drivers_faults(),
        checked: report.checked(),
    })
}

fn scene(report: &Report, sets: &[Views], name: &str) -> Result<SceneSection> {
    let builds: Vec<&BuildRow> = report.builds().iter().filter(|b| b.scene == name).copied().collect();
    let sets: Vec<&Views> = sets.iter().filter(|v| v.scene == name).collect();
    let mut plots = vec![build_time(&builds)?];
    if !sets.is_empty() {
        plots.extend([rates(&sets)?, tests(&sets)?]);
    }
    plots.push(levels(&builds)?);
    plots.extend(errors::of_scene(report, &builds, &sets, name)?);
    let explained = builds.iter().filter(|b| !b.explain.is_empty());
    Ok(SceneSection {
        name: name.to_owned(),
        pictures: report.pictures(name).into_iter().filter_map(shown).collect(),
        triangles: builds.first().map_or(0, |b| b.triangles),
        plots,
        explained: explained
            .map(|b| Explained { builder: b.builder.clone(), sentences: b.explain.clone() })
            .collect(),
    })
}

/// None where its file is gone.
fn shown(picture: &PictureRow) -> Option<Shown> {
    let title = match picture.builder.as_str() {
        "" => "The scene".to_owned(),
        builder => format!("{builder}: {:.0} ns a ray in the mean", picture.mean_ns),
    };
    (!picture.png.is_empty()).then(|| Shown { title, png: STANDARD.encode(&picture.png) })
}

/// Build time by stage, scaled to the median of whole builds.
fn build_time(builds: &[&BuildRow]) -> Result<Plot> {
    let stage = |name: &str| name.split('/').next().unwrap_or_default().to_owned();
    let mut stages: Vec<String> = vec![];
    for k in builds.iter().flat_map(|b| &b.kernels) {
        if !stages.contains(&stage(&k.name)) {
            stages.push(stage(&k.name));
        }
    }
    let bar = |b: &&BuildRow| {
        let stamped: f64 = b.kernels.iter().map(|k| k.ms).sum();
        let scale = if stamped > 0.0 { b.build_ms.median / stamped } else { 0.0 };
        let of = |s: &String| b.kernels.iter().filter(|k| stage(&k.name) == *s).map(|k| k.ms).sum::<f64>();
        let range = Some([b.build_ms.q1, b.build_ms.q3]);
        Bar { label: b.builder.clone(), parts: stages.iter().map(|s| scale * of(s)).collect(), range }
    };
    let rows: Vec<Bar> = builds.iter().map(bar).collect();
    bars("Build time by stage; whiskers: quartiles of whole builds", "ms", &stages, &rows)
}

fn label(v: &Views) -> String {
    format!("{}, {}", v.set, v.builder)
}

fn rates(sets: &[&Views]) -> Result<Plot> {
    let bar = |v: &&Views| {
        let rate = v.mrays_s();
        Bar { label: label(v), parts: vec![rate.median], range: Some([rate.q1, rate.q3]) }
    };
    let rows: Vec<Bar> = sets.iter().map(bar).collect();
    bars("Rays a second; whiskers: quartiles", "Mrays/s", &[], &rows)
}

fn tests(sets: &[&Views]) -> Result<Plot> {
    let bar = |v: &&Views| {
        let (n, tests) = (v.rays.max(1) as f64, v.tests?);
        let parts = [tests.boxes, tests.oriented, tests.triangles].map(|t| t as f64 / n);
        Some(Bar { label: label(v), parts: parts.into(), range: None })
    };
    let rows: Vec<Bar> = sets.iter().filter_map(bar).collect();
    let names = ["axis-aligned boxes", "oriented boxes", "triangles"].map(str::to_owned);
    bars("Tests of a ray that walks alone", "tests a ray", &names, &rows)
}

fn levels(builds: &[&BuildRow]) -> Result<Plot> {
    let of = |b: &&BuildRow| {
        let areas = &b.survey.as_ref()?.tree.area_by_level;
        let points = areas.iter().enumerate().map(|(i, a)| [i as f64, *a]).collect();
        Some(Series { name: b.builder.clone(), points })
    };
    let series: Vec<Series> = builds.iter().filter_map(of).collect();
    let units = ["level, the root's is 0", "area over the scene's"];
    curves("Area of nodes and leaves by level", units, &series)
}

/// What the surface area heuristic expects against what was measured, a point a scene, builder and set.
fn predicted(report: &Report, sets: &[Views]) -> Result<Plot> {
    let mut series: Vec<Series> = vec![];
    for v in sets {
        let Some(build) =
            report.builds().iter().find(|b| (b.scene.as_str(), b.builder.as_str()) == (v.scene, v.builder))
        else {
            continue;
        };
        let Some(survey) = &build.survey else { continue };
        let point = [survey.tight.cost, v.trace_ms.median * 1e6 / v.rays.max(1) as f64];
        match series.iter_mut().find(|s| s.name == v.builder) {
            Some(s) => s.points.push(point),
            None => series.push(Series { name: v.builder.to_owned(), points: vec![point] }),
        }
    }
    let units = ["expected cost of a ray that meets the scene's box, (3, 4, 2)", "ns a ray, measured"];
    points("Predicted against measured: a point a scene and set of rays", units, &series, Lines::None)
}

#[cfg(test)]
mod tests;
