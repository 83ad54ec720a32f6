//! `boxwood stress`: what tries to break builders and traversals, judged by the f64 reference.

mod closed;
mod report;
mod watch;

use self::report::{counted, list, report, said, table};
use self::watch::Watch;
use super::choices::PrecisionName;
use super::files::{self, Output};
use super::{Global, query::bar};
use crate::bvh::Method;
use crate::device::Device;
use crate::stress::smallest::{self, Budget, Saved};
use crate::stress::{self, Case, Effort, Plan, Row, Setting, Step, Summary, traced};
use crate::trace::{Options, Precision};
use anyhow::{Context, Result, bail};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Builders that are tried where none are named.
const BUILDERS: [&str; 7] = ["ploc", "lbvh", "sah", "dito14", "odop2", "hybrid", "auto"];
/// Failures of which the least case is looked for, at most, and for how long in all.
const LOOKED_INTO: usize = 12;
const LOOKING: Duration = Duration::from_secs(60);

/// Try to break builders and traversals: scenes and rays made for it, on the device, against the f64 reference.
///
/// Scenes × builders × codes × precisions × queries × walks. A scene fails where a tree is not sound; where a robust hit is
/// wrong that rounding doesn't excuse, or differs between two trees or walks in any bit; where a record could be no answer,
/// or a ray of NaN hits, in any precision. The fast test leaks by nature: its faults are counted. A tree deeper than any
/// stack is refused, which is no failure. Of failures the least case is looked for and written as files that
/// `boxwood query` takes. --json is written anew with every scene, so that a run cut off keeps those that it finished. Exit
/// code 1 with any failure.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Instead of all this: trace N rays in all from within closed meshes (round ones, tiny, huge and far ones, with needles,
    /// slivers and seams, on the axes and turned, winding) at vertices, at points of edges and along axes, by every walk.
    /// None may get out. Where builders turn boxes, they do at any gain in area.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..),
          conflicts_with_all = ["quick", "only", "list", "precision", "rays", "limit"])]
    closed: Option<u64>,
    /// Small scenes and fewer walks: a minute's worth.
    #[arg(long)]
    quick: bool,
    /// Only scenes whose family/name holds PATTERN; may be given several times: see --list.
    #[arg(long, value_name = "PATTERN")]
    only: Vec<String>,
    /// Tell what there is, and why.
    #[arg(long)]
    list: bool,
    /// Builders.
    #[arg(long, value_enum, value_name = "BUILDER", value_delimiter = ',')]
    builders: Vec<Method>,
    /// Triangle tests.
    #[arg(long, value_enum, value_name = "TEST", value_delimiter = ',')]
    precision: Vec<PrecisionName>,
    /// Rays of each set, fewer where a ray meets very many triangles. Default: 252, or 60 with --quick.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    rays: Option<u32>,
    /// Seed of what is by chance.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Seconds that a build or a trace may take: what takes longer hangs, is named, and ends the run.
    #[arg(long, value_name = "S", default_value_t = 300, value_parser = clap::value_parser!(u64).range(20..))]
    limit: u64,
    /// Folder for the least cases of failures, or, with --closed, for the first faulty rays and their meshes.
    #[arg(long, value_name = "DIR", default_value = "stress")]
    out: PathBuf,
    /// Write all as JSON to this file, again with every scene or mesh that is done.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Args {
    fn methods(&self) -> Vec<Method> {
        match self.builders.as_slice() {
            [] => BUILDERS.iter().filter_map(|name| Method::named(name)).collect(),
            named => named.to_vec(),
        }
    }

    fn plan(&self) -> Plan {
        let effort = if self.quick { Effort::Quick } else { Effort::Whole };
        let methods = self.methods();
        let precisions = match self.precision.as_slice() {
            [] => Precision::ALL.to_vec(),
            named => named.iter().map(|p| (*p).into()).collect(),
        };
        let rays = self.rays.map_or(effort.rays(), |n| n as usize);
        Plan { effort, methods, precisions, rays, seed: self.seed }
    }
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    if let Some(rays) = args.closed {
        return closed::run(global, args, rays);
    }
    let cases = stress::chosen(&args.only);
    if cases.is_empty() {
        bail!("no scene's family/name holds {}: see `boxwood stress --list`", args.only.join(" or "));
    }
    if args.list {
        return Ok(writeln!(std::io::stdout().lock(), "{}", list(&cases))?);
    }
    let json = args.json.as_deref().map(Output::new).transpose()?;
    let plan = args.plan();
    let device = global.open_device()?;
    let progress = bar(global, cases.len()).with_message("stress");
    let watch = Watch::new(Duration::from_secs(args.limit));
    let rows = stress::run(&device, &cases, &plan, &traced, &|step| match step {
        Step::Begun(case) => progress.set_message(case.title()),
        Step::Trying(case, setting, options) => watch.expect(tried(case, setting, options)),
        Step::Done(rows) => {
            progress.inc(1);
            progress.suspend(|| {
                if let Some(row) = rows.last() {
                    global.remark(fared(row));
                }
                keep(global, json, || report(&device, &plan, cases.len(), rows, &[]));
            });
        }
    });
    progress.finish_and_clear();
    watch.expect("looking for the least cases of what failed".into());
    let saved = save_smallest(global, args, &device, &plan, &rows)?;
    let summary = Summary::of(&rows);
    writeln!(std::io::stdout().lock(), "{}\n\n{}", table(&rows), said(&summary))?;
    for row in &rows {
        if let Some(refused) = &row.refused {
            global.remark(format_args!("{}: refused: {refused}", row.case.title()));
        }
    }
    if let Some(json) = json {
        let report = report(&device, &plan, cases.len(), &rows, &saved);
        json.finish(files::json(&report)?.as_bytes())?;
    }
    fail_on(&summary, args)
}

/// Writes what there is so far. Where that can't be done the run goes on: at its end there may be room.
fn keep<R: serde::Serialize>(global: &Global, json: Option<Output>, so_far: impl FnOnce() -> R) {
    let written = json.map(|json| json.keep(files::json(&so_far())?.as_bytes()));
    if let Some(Err(e)) = written {
        global.remark(format_args!("{e:#}: what is done is not kept"));
    }
}

/// The command's failure, where a scene failed.
fn fail_on(summary: &Summary, args: &Args) -> Result<()> {
    match summary.failed {
        0 => Ok(()),
        n => bail!("{n} of {} scenes failed; what was saved is in {}", summary.scenes, args.out.display()),
    }
}

/// How a scene fared, in a line or two.
fn fared(row: &Row) -> String {
    let (scene, outcome) = (row.case.title(), row.outcome().name());
    let mut said = format!("{scene}: {outcome}, {}, {:.1} s", counted(row.cases, "case"), row.seconds);
    for failure in &row.failures {
        let what = failure.what.lines().next().unwrap_or_default();
        said += &format!("\n  {}, {}: {what}", failure.setting.name(), failure.options.precision.name());
    }
    said
}

/// What goes on, in words.
fn tried(case: &Case, setting: &Setting, options: Option<&Options>) -> String {
    let (scene, tree) = (case.title(), setting.name());
    match options {
        None => format!("{scene}: building {tree}"),
        Some(o) => {
            let (query, precision) = (smallest::name_of(o.query), o.precision.name());
            format!("{scene}: {tree}, {}, {query}, {precision}", o.walk.kernel_name())
        }
    }
}

/// The least cases of failures, by row and failure.
fn save_smallest(
    global: &Global,
    args: &Args,
    device: &Arc<Device>,
    plan: &Plan,
    rows: &[Row],
) -> Result<Vec<(usize, usize, Saved)>> {
    let until = Instant::now() + LOOKING;
    let (mut left, mut all) = (LOOKED_INTO, vec![]);
    for (at, row) in rows.iter().enumerate() {
        for (which, failure) in row.failures.iter().enumerate() {
            let time = until.saturating_duration_since(Instant::now());
            if left == 0 || time.is_zero() {
                global.remark(format_args!("{}: not looked into, enough was", row.case.title()));
                continue;
            }
            left -= 1;
            let budget = Budget { time: Budget::default().time.min(time), ..Budget::default() };
            let smallest = smallest::smallest(device, &traced, plan, row, failure, budget);
            let saved = smallest::save(&args.out, device, plan, row, failure, &smallest)
                .with_context(|| format!("can't write to {}", args.out.display()))?;
            global.remark(format_args!(
                "{}, {} and {}: {}\n  {}\n  cd {} && {}",
                row.case.title(),
                counted(saved.triangles, "triangle"),
                counted(saved.rays, "ray"),
                smallest.what,
                saved.files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>().join(" "),
                args.out.display(),
                saved.replay.join("; ")
            ));
            all.push((at, which, saved));
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stress::CASES;

    #[test]
    fn names_are_distinct_and_builders_known() {
        for (i, case) in CASES.iter().enumerate() {
            assert_eq!(CASES.iter().position(|c| c.name == case.name), Some(i), "{}", case.name);
            assert!(!case.why.is_empty());
        }
        assert!(BUILDERS.iter().all(|name| Method::named(name).is_some()));
    }

    #[test]
    fn a_failure_is_the_commands() {
        use clap::Parser;
        #[derive(Parser)]
        struct Only {
            #[command(flatten)]
            args: Args,
        }
        let Only { args } = Only::parse_from(["x", "--out", "there"]);
        let mut summary = Summary::of(&[]);
        assert!(fail_on(&summary, &args).is_ok());
        (summary.scenes, summary.failed) = (9, 1);
        let said = fail_on(&summary, &args).map_err(|e| e.to_string());
        assert_eq!(said, Err("1 of 9 scenes failed; what was saved is in there".into()));
        assert_eq!(args.plan().methods.len(), BUILDERS.len());
        assert_eq!((args.plan().effort, args.plan().precisions.len()), (Effort::Whole, 2));
    }
}
