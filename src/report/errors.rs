//! Run time against error: a point a configuration, and the front of those that nothing beats.

use super::Result;
use super::plots::{Lines, Plot, Series, points};
use crate::bench::{BuildRow, ImageRow, Report, Views};

/// Adds a point to the series of a name.
fn add(series: &mut Vec<Series>, name: &str, point: [f64; 2]) {
    match series.iter_mut().find(|s| s.name == name) {
        Some(s) => s.points.push(point),
        None => series.push(Series { name: name.to_owned(), points: vec![point] }),
    }
}

/// Those of a scene that there is something for.
pub(super) fn of_scene(
    report: &Report,
    builds: &[&BuildRow],
    sets: &[&Views],
    scene: &str,
) -> Result<Vec<Plot>> {
    let mut plots = vec![];
    plots.extend(excess(builds)?);
    plots.extend(hits(sets)?);
    let images: Vec<&ImageRow> = report.images().iter().filter(|i| i.scene == scene).copied().collect();
    let mut shown: Vec<&str> = images.iter().map(|i| i.shows.as_str()).collect();
    shown.dedup();
    for shows in shown {
        let of: Vec<&ImageRow> = images.iter().filter(|i| i.shows == shows).copied().collect();
        plots.push(pictures(shows, &of)?);
    }
    Ok(plots)
}

/// Build time against how much larger boxes are than they need be.
fn excess(builds: &[&BuildRow]) -> Result<Option<Plot>> {
    let mut series = vec![];
    for b in builds {
        if let Some(excess) = b.excess() {
            add(&mut series, &b.builder, [b.build_ms.median, excess.total]);
        }
    }
    if series.is_empty() {
        return Ok(None);
    }
    let units = ["build time, ms", "area of boxes above near-optimal ones, %"];
    points("Build time against area of boxes; grey: nothing beats these", units, &series, Lines::Front)
        .map(Some)
}

/// Time of a ray against wrong hits, a point a builder and set; and against the error of t.
fn hits(sets: &[&Views]) -> Result<Vec<Plot>> {
    let (mut wrong, mut off) = (vec![], vec![]);
    for v in sets {
        let Some(per_million) = v.wrong_per_million() else { continue };
        add(&mut wrong, v.builder, [v.ns_a_ray(), per_million]);
        if v.check.t_error.max > 0.0 {
            add(&mut off, v.builder, [v.ns_a_ray(), v.check.t_error.p99]);
        }
    }
    let mut plots = vec![];
    // Where nobody is wrong there is nothing to weigh.
    if wrong.iter().flat_map(|s| &s.points).any(|p| p[1] > 0.0) {
        let units = ["device time, ns a ray", "wrong hits in a million"];
        let title = "Time against wrong hits: a point a set of rays; crosses at the foot: none; grey: nothing beats these";
        plots.push(points(title, units, &wrong, Lines::Front)?);
    }
    if !off.is_empty() {
        let units = ["device time, ns a ray", "relative error of t, 99 % of hits within"];
        let title = "Time against the error of t: a point a set of rays; grey: nothing beats these";
        plots.push(points(title, units, &off, Lines::Front)?);
    }
    Ok(plots)
}

/// Tracing time against the error of pictures, by how samples are spread.
fn pictures(shows: &str, images: &[&ImageRow]) -> Result<Plot> {
    let mut series = vec![];
    for i in images {
        add(&mut series, &i.sampler, [i.trace_ms.median, i.rmse]);
    }
    let what = if shows == "ao" { "ambient occlusion" } else { "light of the sky" };
    let [few, many] = [images.iter().map(|i| i.samples).min(), images.iter().map(|i| i.samples).max()];
    let title = format!(
        "Error of a picture of {what}, {} to {} samples a hit; grey: nothing beats these",
        few.unwrap_or(0),
        many.unwrap_or(0)
    );
    points(&title, ["tracing time, ms", "RMSE of pixels from 0 to 1"], &series, Lines::FrontAndSeries)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bench::{Check, RayRow, Results, Spread, Survey};
    use crate::oracle::excess::Excess;

    fn results() -> Results {
        let excess = Excess { boxes: 3, total: 7.0, ..Excess::default() };
        let build = BuildRow {
            scene: "s".into(),
            builder: "b".into(),
            build_ms: Spread::of(&[2.0]),
            survey: Some(Survey { excess: Some(excess), ..Survey::default() }),
            ..BuildRow::default()
        };
        let check = Check { rays: 1000, missed: 2, ..Check::default() };
        let ray = RayRow {
            scene: "s".into(),
            builder: "b".into(),
            set: "edges".into(),
            rays: 1000,
            trace_ms: Spread::of(&[1.0]),
            check: Some(check),
            ..RayRow::default()
        };
        let image = |sampler: &str, samples| ImageRow {
            scene: "s".into(),
            shows: "ao".into(),
            sampler: sampler.into(),
            samples,
            trace_ms: Spread::of(&[f64::from(samples)]),
            rmse: 1.0 / f64::from(samples),
            ..ImageRow::default()
        };
        Results {
            builds: vec![build],
            rays: vec![ray],
            images: vec![image("halton", 1), image("halton", 4), image("random", 2)],
            ..Results::default()
        }
    }

    fn plots(results: &Results) -> Vec<Plot> {
        let report = Report::new(results);
        let sets = report.sets();
        of_scene(&report, report.builds(), &sets.iter().collect::<Vec<_>>(), "s").unwrap()
    }

    #[test]
    fn what_was_measured_is_drawn_with_units() {
        let all = plots(&results());
        let titles: Vec<&str> = all.iter().map(|p| &p.title[..10]).collect();
        assert_eq!(titles, ["Build time", "Time again", "Error of a"]);
        for (plot, units) in all.iter().zip([["ms", "%"], ["ns a ray", "in a million"], ["ms", "RMSE"]]) {
            for unit in units {
                assert!(plot.svg.contains(unit), "{}: {unit}", plot.title);
            }
        }
        assert_eq!(all[2].legend.len(), 2);
    }

    #[test]
    fn nothing_is_drawn_of_what_was_not_measured() {
        let mut few = results();
        few.images.clear();
        few.builds[0].survey = None;
        few.rays[0].check = None;
        assert!(plots(&few).is_empty());
        // Nobody is wrong, and no t is known.
        few.rays[0].check = Some(Check { rays: 10, ..Check::default() });
        assert!(plots(&few).is_empty());
    }
}
