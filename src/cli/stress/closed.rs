//! `boxwood stress --closed`: a long run of rays from within closed meshes.

use super::{Args, keep};
use crate::cli::Global;
use crate::cli::files::{self, Output};
use crate::cli::query::bar;
use crate::device::Device;
use crate::scene::write::tri;
use crate::stress::closed::{self, Plan, Row, Solid, Step};
use crate::trace::Precision;
use anyhow::{Context, Result, bail};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use std::io::Write;
use std::path::Path;
use std::time::Instant;

/// Faulty rays that are saved.
const SAVED: usize = 8;

/// What is written as JSON.
#[derive(serde::Serialize)]
struct Report<'a> {
    version: &'static str,
    commit: &'static str,
    device: &'a str,
    driver: &'a str,
    /// Whether the device has 64-bit floats.
    doubles: bool,
    subgroup: u32,
    seed: u64,
    /// Rays that are not traced yet: what is here is kept while a run goes on.
    left: u64,
    #[serde(flatten)]
    total: Total,
    seconds: f64,
    rows: &'a [Row],
}

/// Sums over rows.
#[derive(serde::Serialize)]
struct Total {
    rays: u64,
    misses: u64,
    leaks: u64,
    others: u64,
    judged: u64,
    contradicted: u64,
    device_ms: f64,
}

impl Total {
    fn of(rows: &[Row]) -> Self {
        let sum = |f: fn(&Row) -> u64| rows.iter().map(f).sum();
        Self {
            rays: sum(|r| r.rays),
            misses: sum(|r| r.misses),
            leaks: sum(|r| r.leaks),
            others: sum(|r| r.others),
            judged: sum(|r| r.judged),
            contradicted: sum(|r| r.contradicted),
            device_ms: rows.iter().map(|r| r.device_ms).sum(),
        }
    }
}

/// Traces `rays` rays.
pub(super) fn run(global: &Global, args: &Args, rays: u64) -> Result<()> {
    let json = args.json.as_deref().map(Output::new).transpose()?;
    let device = global.open_device()?;
    let plan = Plan {
        rays,
        builders: args.methods(),
        seed: args.seed,
        solids: Solid::all(),
        precision: Precision::Robust,
    };
    let bar = bar(global, rays as usize);
    let start = Instant::now();
    let rows = closed::run(&device, &plan, &|step| match step {
        Step::Traced(n) => bar.inc(n),
        Step::Done(rows) => bar.suspend(|| keep(global, json, || report(&device, &plan, rows, start))),
    })?;
    bar.finish_and_clear();
    let (report, info) = (report(&device, &plan, &rows, start), device.info());
    let Report { total, seconds, .. } = &report;
    writeln!(std::io::stdout().lock(), "{}", table(&rows, total))?;
    global.remark(format_args!("{} rays in {seconds:.1} s on {}, {}", total.rays, info.name, info.driver));
    if let Some(json) = json {
        json.finish(files::json(&report)?.as_bytes())?;
    }
    fail_on_faults(&rows, &plan.solids, &args.out)
}

/// All of a run, or what there is of it so far.
fn report<'a>(device: &'a Device, plan: &Plan, rows: &'a [Row], start: Instant) -> Report<'a> {
    let (info, total) = (device.info(), Total::of(rows));
    Report {
        version: env!("CARGO_PKG_VERSION"),
        commit: env!("BOXWOOD_COMMIT"),
        device: &info.name,
        driver: &info.driver,
        doubles: device.is_wide(),
        subgroup: info.subgroup_size,
        seed: plan.seed,
        left: plan.rays - total.rays,
        total,
        seconds: start.elapsed().as_secs_f64(),
        rows,
    }
}

/// A row a mesh, builder and kind of rays, and their sum.
fn table(rows: &[Row], total: &Total) -> Table {
    let head =
        ["mesh", "builder", "rays", "triangles", "nodes", "oriented", "count", "misses", "leaks", "others"];
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(head.into_iter().chain(["judged", "contradicted", "Mrays/s"]));
    for r in rows {
        let words = [r.mesh.to_owned(), r.builder.to_owned(), r.kind.name().to_owned()];
        let sizes = [r.triangles as u64, r.nodes as u64, r.oriented.into()];
        let counts = [r.rays, r.misses, r.leaks, r.others, r.judged, r.contradicted];
        let numbers = sizes.into_iter().chain(counts).map(|n| n.to_string());
        table.add_row(words.into_iter().chain(numbers).chain([format!("{:.2}", r.mrays_s())]));
    }
    let Total { rays, misses, leaks, others, judged, contradicted, device_ms } = total;
    let words = ["all", "", "", "", "", ""].map(str::to_owned);
    let counts = [rays, misses, leaks, others, judged, contradicted].map(|n| n.to_string());
    let rate = format!("{:.2}", *rays as f64 / device_ms.max(1e-9) / 1e3);
    table.add_row(words.into_iter().chain(counts).chain([rate]));
    for column in table.column_iter_mut().skip(3) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// The command's failure, where rays got out: saves the first of them, each with its mesh.
fn fail_on_faults(rows: &[Row], solids: &[Solid], folder: &Path) -> Result<()> {
    let faults: u64 = rows.iter().map(Row::faults).sum();
    let Some(first) = rows.iter().find(|r| r.faults() > 0) else { return Ok(()) };
    let examples: Vec<_> =
        rows.iter().flat_map(|r| r.examples.iter().map(move |e| (r, e))).take(SAVED).collect();
    let mut saved = vec![];
    for (i, (row, example)) in examples.iter().enumerate() {
        std::fs::create_dir_all(folder).with_context(|| format!("can't make {}", folder.display()))?;
        let name = format!("{}-{}-{i}", row.mesh.replace(' ', "-"), row.builder);
        let path = |ending: &str| folder.join(format!("{name}.{ending}"));
        let write = |path: &Path, bytes: &[u8]| Output::new(path).and_then(|out| out.finish(bytes));
        let ray: Vec<u8> = example.ray.iter().flat_map(|x| x.to_le_bytes()).collect();
        write(&path("rays"), &ray)?;
        if let Some(solid) = solids.iter().find(|s| s.name == row.mesh) {
            write(&path("tri"), &tri(&solid.scene))?;
        }
        saved.push(format!(
            "{}: {:?} by {}: t {}, the surface is between {} and {}",
            path("rays").display(),
            example.fault,
            example.way,
            example.t,
            example.surface[0],
            example.surface[1]
        ));
    }
    bail!(
        "stress: {faults} faulty rays, the first of the {} by {}, {}\n{}",
        first.mesh,
        first.builder,
        first.kind.name(),
        saved.join("\n")
    )
}
