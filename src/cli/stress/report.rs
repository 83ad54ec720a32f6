//! What `boxwood stress` prints and writes.

use crate::device::Device;
use crate::stress::smallest::{Saved, name_of};
use crate::stress::{Case, Effort, Failure, Kind, Outcome, Plan, Row, SETS, Summary, Total};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

/// What `stress` reports.
#[derive(serde::Serialize)]
pub(super) struct Report<'a> {
    device: &'a str,
    driver: &'a str,
    commit: &'static str,
    effort: Effort,
    seed: u64,
    rays_per_set: usize,
    builders: Vec<&'static str>,
    /// Scenes that are not tried yet: what is here is kept while a run goes on.
    left: usize,
    summary: Summary,
    scenes: Vec<SceneReport<'a>>,
}

/// A scene's row.
#[derive(serde::Serialize)]
struct SceneReport<'a> {
    family: &'static str,
    scene: &'static str,
    why: &'static str,
    outcome: Outcome,
    triangles: usize,
    depth: u32,
    cases: usize,
    rays: usize,
    robust: &'a Total,
    fast: &'a Total,
    refusals: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<&'a str>,
    failures: Vec<FailureReport<'a>>,
    seconds: f64,
}

/// A failure.
#[derive(serde::Serialize)]
struct FailureReport<'a> {
    kind: Kind,
    setting: String,
    query: &'static str,
    precision: &'static str,
    walk: &'static str,
    cases: usize,
    what: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    smallest: Option<&'a Saved>,
}

/// All of a run of `scenes` scenes, or what there is of it so far, for machines.
pub(super) fn report<'a>(
    device: &'a Device,
    plan: &Plan,
    scenes: usize,
    rows: &'a [Row],
    saved: &'a [(usize, usize, Saved)],
) -> Report<'a> {
    let failures = |at: usize, row: &'a Row| {
        let of = |(which, f): (usize, &'a Failure)| FailureReport {
            kind: f.kind,
            setting: f.setting.name(),
            query: name_of(f.options.query),
            precision: f.options.precision.name(),
            walk: f.options.walk.kernel_name(),
            cases: f.cases,
            what: &f.what,
            smallest: saved.iter().find(|s| (s.0, s.1) == (at, which)).map(|s| &s.2),
        };
        row.failures.iter().enumerate().map(of).collect()
    };
    let scene = |(at, row): (usize, &'a Row)| SceneReport {
        family: row.case.family.name(),
        scene: row.case.name,
        why: row.case.why,
        outcome: row.outcome(),
        triangles: row.triangles,
        depth: row.depth,
        cases: row.cases,
        rays: row.rays,
        robust: &row.robust,
        fast: &row.fast,
        refusals: row.refusals,
        refused: row.refused.as_deref(),
        failures: failures(at, row),
        seconds: row.seconds,
    };
    Report {
        device: &device.info().name,
        driver: &device.info().driver,
        commit: env!("BOXWOOD_COMMIT"),
        effort: plan.effort,
        seed: plan.seed,
        rays_per_set: plan.rays,
        builders: plan.methods.iter().map(|m| m.name).collect(),
        left: scenes - rows.len(),
        summary: Summary::of(rows),
        scenes: rows.iter().enumerate().map(scene).collect(),
    }
}

fn empty_table<T: Into<String>>(words: usize, header: impl IntoIterator<Item = T>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.into_iter().map(Into::into));
    for column in table.column_iter_mut().skip(words) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// A row a scene.
pub(super) fn table(rows: &[Row]) -> Table {
    let head = [
        "family",
        "scene",
        "verdict",
        "triangles",
        "levels",
        "cases",
        "rays",
        "missed",
        "false",
        "leaked",
        "wrong",
        "malformed",
        "differing",
        "unsure",
        "fast's faults",
        "refused",
        "s",
    ];
    let mut table = empty_table(3, head);
    for row in rows {
        let words = [row.case.family.name(), row.case.name, row.outcome().name()].map(str::to_owned);
        let r = &row.robust;
        let numbers = [
            row.triangles,
            row.depth as usize,
            row.cases,
            row.rays,
            r.missed,
            r.false_hits,
            r.leaked,
            r.wrong_triangle,
            r.malformed + row.fast.malformed,
            r.differing,
            r.unsure,
            row.fast.faults() - row.fast.malformed,
            row.refusals,
        ]
        .map(|n| n.to_string());
        table.add_row(words.into_iter().chain(numbers).chain([format!("{:.1}", row.seconds)]));
    }
    table
}

/// In a line.
pub(super) fn said(s: &Summary) -> String {
    format!(
        "{}: {} passed, {} refused, {} failed; {} cases, {} answers, robust: {} faults, {} differing, {} unsure; fast: {} \
         faults; {:.0} s",
        counted(s.scenes, "scene"),
        s.passed,
        s.refused,
        s.failed,
        s.cases,
        s.rays,
        s.robust.faults(),
        s.robust.differing,
        s.robust.unsure,
        s.fast.faults(),
        s.seconds
    )
}

/// Scenes and sets of rays, and why they are there.
pub(super) fn list(cases: &[&Case]) -> String {
    let mut scenes = empty_table(2, ["scene", "why"]);
    for case in cases {
        scenes.add_row([case.title(), case.why.to_owned()]);
    }
    let mut sets = empty_table(2, ["rays", "why"]);
    for set in SETS {
        sets.add_row([set.name, set.why]);
    }
    format!("{}\n\n{}", scenes.trim_fmt(), sets.trim_fmt())
}

/// As in 2 rays.
pub(super) fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}
