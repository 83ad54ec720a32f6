//! What \[VEVERKOVA24\] prints of the same scenes, beside what was measured: Table 6.1, from another machine (CUDA on a
//! GTX 1070 Ti) and other code, of scenes that boxwood makes anew but for the dragon. So only what a builder is over the
//! axis-aligned one of the same scene is compared.

use crate::bench::{BuildRow, Report, Table, Views};
use serde::Deserialize;
use std::sync::OnceLock;

/// Figures as printed: scene, metric, builder, value.
const TABLE: &str = include_str!("../../scenes/table-6-1.csv");
/// Scenes by their names there and here, where `rungholt` is a city of the same size.
const SCENES: [[&str; 2]; 8] = [
    ["Tree", "tree"],
    ["Dragon", "dragon"],
    ["Hairball", "hairball"],
    ["Crown", "crown"],
    ["Conference", "conference"],
    ["Rungholt", "city"],
    ["RotatedRungholt", "city-rotated"],
    ["Powerplant", "power-plant"],
];
/// Builders likewise.
const BUILDERS: [[&str; 2]; 5] =
    [["AABB", "ploc"], ["DiTO", "dito"], ["2-ODOP", "odop2"], ["3-ODOP", "odop3"], ["4-ODOP", "odop4"]];
/// How far the numbers of triangles may lie apart, as a share of the printed one: the archive's dragon has 9 % more.
const ALIKE: f64 = 0.1;

/// A line of the table.
#[derive(Debug, Deserialize)]
struct Figure {
    scene: String,
    metric: String,
    builder: String,
    value: f64,
}

fn figures() -> &'static [Figure] {
    static FIGURES: OnceLock<Vec<Figure>> = OnceLock::new();
    FIGURES.get_or_init(|| csv::Reader::from_reader(TABLE.as_bytes()).deserialize().flatten().collect())
}

fn printed(scene: &str, metric: &str, builder: &str) -> Option<f64> {
    let is_it =
        |f: &&Figure| (f.scene.as_str(), f.metric.as_str(), f.builder.as_str()) == (scene, metric, builder);
    figures().iter().find(is_it).map(|f| f.value)
}

/// The name there of what `names` calls `here`.
fn there<'a>(names: &[[&'a str; 2]], here: &str) -> Option<&'a str> {
    names.iter().find(|n| n[1] == here).map(|n| n[0])
}

/// The thesis' scene that `build` is of: the same kind, and about as many triangles.
fn scene_of(build: &BuildRow) -> Option<&'static str> {
    let name = there(&SCENES, build.scene.split([':', '@']).next()?)?;
    let triangles = printed(name, "triangles", "")?;
    ((build.triangles as f64 / triangles - 1.0).abs() <= ALIKE).then_some(name)
}

/// A measure of Table 6.1.
struct Measure {
    title: &'static str,
    metric: &'static str,
    over: Over,
    ours: fn(&Row) -> Option<f64>,
}

/// What the printed figure is over the axis-aligned builder's.
#[derive(PartialEq)]
enum Over {
    /// Printed as a share of it, per cent.
    Share,
    /// Printed as such.
    Aligned,
}

/// A builder's row and what it is held against.
struct Row<'a> {
    report: &'a Report<'a>,
    sets: &'a [Views<'a>],
    build: &'a BuildRow,
    aligned: &'a BuildRow,
}

impl Row<'_> {
    /// Rays a second over the axis-aligned builder's.
    fn rate(&self, set: &str) -> Option<f64> {
        let rate = |builder: &str| {
            let is_it = |v: &&Views| (v.scene, v.builder, v.set) == (self.build.scene.as_str(), builder, set);
            self.sets.iter().find(is_it).map(|v| v.mrays_s().median).filter(|r| *r > 0.0)
        };
        Some(rate(&self.build.builder)? / rate(&self.aligned.builder)?)
    }

    fn cost(build: &BuildRow) -> Option<f64> {
        build.survey.as_ref().map(|s| s.tight.cost).filter(|c| *c > 0.0)
    }
}

const MEASURES: [Measure; 9] = [
    Measure {
        title: "SAH cost",
        metric: "bvh_cost",
        over: Over::Aligned,
        ours: |r| Some(Row::cost(r.build)? / Row::cost(r.aligned)?),
    },
    Measure {
        title: "total area %",
        metric: "bvh_area_pct",
        over: Over::Share,
        ours: |r| r.build.survey.as_ref().map(|s| 100.0 * s.tight.total_area),
    },
    Measure {
        title: "AABB boxes %",
        metric: "aabb_node_pct",
        over: Over::Share,
        ours: |r| r.build.survey.as_ref().map(|s| 100.0 * s.tight.aabb_share),
    },
    Measure {
        title: "by area %",
        metric: "aabb_area_pct",
        over: Over::Share,
        ours: |r| r.build.survey.as_ref().map(|s| 100.0 * s.tight.aabb_area_share),
    },
    Measure {
        title: "memory %",
        metric: "memory_pct",
        over: Over::Share,
        ours: |r| r.report.memory_share(r.build).map(|share| 100.0 * share),
    },
    Measure {
        title: "build time",
        metric: "build_s",
        over: Over::Aligned,
        ours: |r| {
            (r.aligned.build_ms.median > 0.0).then(|| r.build.build_ms.median / r.aligned.build_ms.median)
        },
    },
    Measure {
        title: "primary rays a second",
        metric: "primary_mrays",
        over: Over::Aligned,
        ours: |r| r.rate("primary"),
    },
    Measure { title: "AO", metric: "ao_mrays", over: Over::Aligned, ours: |r| r.rate("ao") },
    Measure { title: "diffuse", metric: "diffuse_mrays", over: Over::Aligned, ours: |r| r.rate("diffuse") },
];

impl Measure {
    fn printed(&self, scene: &str, builder: &str) -> Option<f64> {
        let value = printed(scene, self.metric, builder)?;
        match self.over {
            Over::Share => Some(value),
            Over::Aligned => Some(value / printed(scene, self.metric, BUILDERS[0][0])?),
        }
    }

    /// Ours, and theirs in brackets.
    fn cell(&self, row: &Row, scene: &str) -> String {
        let digits = if self.over == Over::Share { 1 } else { 2 };
        let text = |x: Option<f64>| x.map_or("–".into(), |x| format!("{x:.digits$}"));
        let builder = there(&BUILDERS, &row.build.builder);
        let theirs = builder.and_then(|builder| self.printed(scene, builder));
        format!("{} ({})", text((self.ours)(row)), text(theirs))
    }
}

/// A row a scene and builder of both: without rows where none of the thesis' scenes was measured at its size, or not by
/// the axis-aligned builder.
pub(super) fn beside<'a>(report: &'a Report<'a>, sets: &'a [Views<'a>]) -> Table {
    let titles = MEASURES.iter().map(|m| m.title);
    let mut table = Table::new(2, ["scene", "builder"].into_iter().chain(titles));
    let builds = report.builds();
    for build in builds {
        let is_aligned = |b: &&&BuildRow| b.scene == build.scene && b.builder == BUILDERS[0][1];
        let (Some(scene), Some(aligned)) = (scene_of(build), builds.iter().find(is_aligned)) else {
            continue;
        };
        if build.builder == aligned.builder {
            continue;
        }
        let row = Row { report, sets, build, aligned };
        let cells = MEASURES.iter().map(|m| m.cell(&row, scene));
        table.push([build.scene.clone(), build.builder.clone()].into_iter().chain(cells));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_is_read() {
        assert_eq!(figures().len(), TABLE.lines().count() - 1);
        for [there, _] in SCENES {
            assert!(printed(there, "bvh_cost", "AABB").is_some(), "{there}");
        }
        // The thesis left these blank, for want of memory.
        assert_eq!(printed("Powerplant", "bvh_cost", "3-ODOP"), None);
        assert_eq!(MEASURES[0].printed("Rungholt", "DiTO").map(|x| (x * 100.0).round()), Some(131.0));
    }

    #[test]
    fn ours_stands_before_theirs() {
        use crate::bench::{Results, Spread};
        let build = |builder: &str, ms: f64| BuildRow {
            scene: "dragon".into(),
            builder: builder.into(),
            triangles: 871_414,
            build_ms: Spread::of(&[ms]),
            ..BuildRow::default()
        };
        let builds = vec![build("ploc", 4.0), build("dito", 10.0), build("auto", 12.0)];
        let results = Results { builds, ..Results::default() };
        let table = beside(&Report::new(&results), &[]);
        let build_time: Vec<&str> = table.rows.iter().map(|row| row[7].as_str()).collect();
        assert_eq!(table.header[7], "build time");
        assert_eq!(build_time, ["2.50 (2.50)", "3.00 (–)"], "0.05 s over 0.02 s are printed");
    }

    #[test]
    fn scenes_of_another_size_are_not_held_against_it() {
        let build =
            |scene: &str, triangles| BuildRow { scene: scene.into(), triangles, ..BuildRow::default() };
        assert_eq!(scene_of(&build("dragon", 871_414)), Some("Dragon"));
        assert_eq!(scene_of(&build("city-rotated:6820096", 6_814_712)), Some("RotatedRungholt"));
        for (scene, triangles) in [("dragon-res2", 871_414), ("city:1M", 1_000_000), ("dragon", 202_520)] {
            assert_eq!(scene_of(&build(scene, triangles)), None, "{scene}");
        }
    }
}
