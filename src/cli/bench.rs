//! `boxwood bench`: scenes × ray kinds, measured and checked.

use super::files::{self, Output};
use super::{Global, warn_of};
use crate::bench::{Checking, Coverage, Plan, RayKind, Report, SCENES, run as measure, steps};
use crate::bvh::Recipe;
use crate::scene::{self, Progress, Scene};
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::Write;
use std::path::PathBuf;

/// Build, trace, check and time scenes; print tables, write bench.json and bench.csv.
///
/// Rounds visit every scene in turn. Medians of all rounds; ± is the range between the quartiles, in per cent of the
/// median. Faults are hits that the f64 reference contradicts and rounding doesn't excuse, unsure ones those that it may.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenes: files or names, as for `boxwood build`. Default: dragon, hairball:500k, city-rotated:1M.
    scenes: Vec<String>,
    /// Kinds of rays.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [KindName::Primary, KindName::Ao, KindName::Diffuse])]
    rays: Vec<KindName>,
    /// Rounds, after a warm-up.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Folder for bench.json and bench.csv.
    #[arg(long, value_name = "DIR", default_value = "results")]
    out: PathBuf,
    /// Check up to 200,000 rays of each set against the f64 reference (the default).
    #[arg(long, overrides_with = "no_check")]
    check: bool,
    /// Don't check hits.
    #[arg(long)]
    no_check: bool,
    /// Trace all secondary rays of a picture, as GPUs do by default; software drivers trace 2^20 of them.
    #[arg(long, conflicts_with = "quick")]
    all: bool,
    /// Smaller: a 512 × 384 picture, 2^16 secondary rays, scenes of 100,000 triangles unless named, 3 rounds at most.
    #[arg(long)]
    quick: bool,
}

/// A kind of rays, as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum KindName {
    /// From the camera.
    Primary,
    /// Ambient occlusion.
    Ao,
    /// Diffuse.
    Diffuse,
}

/// Scenes of `--quick`.
const QUICK: [&str; 3] = ["sphere:100k", "hairball:100k", "city-rotated:100k"];
/// Rays of a set that `--quick` checks.
const QUICK_CHECK: Checking = Checking::Sample { rays: 20_000 };

impl Args {
    fn plan(&self, software: bool) -> Plan {
        let mut kinds: Vec<RayKind> = vec![];
        for name in &self.rays {
            let kind = match name {
                KindName::Primary => RayKind::Primary,
                KindName::Ao => RayKind::Ao,
                KindName::Diffuse => RayKind::Diffuse,
            };
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        let coverage = match (self.quick, self.all || !software) {
            (true, _) => Coverage::QUICK,
            (false, true) => Coverage::All,
            (false, false) => Coverage::SAMPLE,
        };
        let checking = match (self.no_check, self.quick) {
            (true, _) => Checking::Off,
            (false, true) => QUICK_CHECK,
            (false, false) => Checking::DEFAULT,
        };
        let runs = if self.quick { self.runs.min(3) } else { self.runs } as usize;
        let size = if self.quick { [512, 384] } else { [1024, 768] };
        Plan { recipe: Recipe::default(), kinds, runs, size, coverage, checking }
    }
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("can't make the folder {}", args.out.display()))?;
    let (json, csv) = (args.out.join("bench.json"), args.out.join("bench.csv"));
    let (to_json, to_csv) = (Output::new(&json)?, Output::new(&csv)?);
    let device = global.open_device()?;
    let plan = args.plan(device.info().is_cpu());
    let scenes = open(global, args)?;

    let bar = bar(global, steps(scenes.len(), &plan));
    let report = measure(&device, &scenes, &plan, &|step| {
        bar.set_message(step.to_owned());
        bar.inc(1);
        if bar.is_hidden() {
            // No terminal: a line a step, for a log that stands still for minutes worries people.
            global.remark(step);
        }
    });
    bar.finish_and_clear();
    let report = report?;

    print(&report, &plan)?;
    to_json.finish(files::json(&report)?.as_bytes())?;
    to_csv.finish(&report.csv().context("can't write the CSV")?)?;
    global.remark(format_args!("written: {}, {}", json.display(), csv.display()));
    if report.is_clean() {
        return Ok(());
    }
    let faulty = report.verdicts().filter(|v| !v.2.is_clean());
    let list: Vec<String> = faulty.map(|(scene, kind, v)| format!("{scene}, {}: {v}", kind.name())).collect();
    bail!("the hits are wrong\n{}", list.join("\n").trim_end())
}

/// The scenes; a generated one instead of one that can't be fetched.
fn open(global: &Global, args: &Args) -> Result<Vec<Scene>> {
    let default: &[&str] = if args.quick { &QUICK } else { &SCENES };
    let named: Vec<&str> = args.scenes.iter().map(String::as_str).collect();
    let specs = if named.is_empty() { default } else { &named };
    let options = global.scene_options();
    let mut scenes = vec![];
    for spec in specs {
        let scene = match scene::open(spec, &options) {
            Ok(scene) => scene,
            Err(e) => {
                // Who names a scene wants that one.
                let Some(instead) = e.instead().filter(|_| named.is_empty()) else { return Err(e.into()) };
                tracing::warn!("{e}");
                eprintln!("note: measuring {instead} instead of {spec}, which could not be fetched");
                scene::open(instead, &options)?
            }
        };
        warn_of(&scene);
        scenes.push(scene);
    }
    Ok(scenes)
}

/// The tables, and what they mean.
fn print(report: &Report, plan: &Plan) -> Result<()> {
    let mut out = std::io::stdout().lock();
    let [width, height] = report.size;
    writeln!(
        out,
        "{}, {}; boxwood {}; medians of {} rounds",
        report.device, report.driver, report.commit, report.runs
    )?;
    writeln!(
        out,
        "\nBuilds: bounds, Morton codes, sort, PLOC, leaves by cost, layout\n{}",
        report.build_table()
    )?;
    let which = match report.coverage {
        Coverage::All => "all of them".to_owned(),
        Coverage::Spans { count, rays } => {
            format!("a sample of at most {} from {count} parts of the picture", count * rays)
        }
    };
    writeln!(
        out,
        "\nRays: {width} × {height} primaries; 32 secondaries a hit, {which}\n{}",
        report.ray_table()
    )?;
    match plan.checking {
        Checking::Off => writeln!(out, "Hits were not checked.")?,
        Checking::Sample { rays } => writeln!(
            out,
            "Faults: hits of up to {rays} rays a set that the f64 reference contradicts; unsure: where rounding may be the reason."
        )?,
    }
    writeln!(
        out,
        "\nBuild time by kernel (one run with a stamp a kernel, which costs some)\n{}",
        report.kernel_table()
    )?;
    Ok(())
}

/// Shows the step, on a terminal.
fn bar(global: &Global, steps: usize) -> ProgressBar {
    let target = match global.progress() {
        Progress::Bars => ProgressDrawTarget::stderr(),
        Progress::Quiet => ProgressDrawTarget::hidden(),
    };
    let bar = ProgressBar::with_draw_target(Some(steps as u64), target);
    bar.enable_steady_tick(std::time::Duration::from_millis(250));
    match ProgressStyle::with_template("{spinner} {pos}/{len} {wide_msg} {elapsed}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
