//! `boxwood report`: results of `boxwood bench` as one HTML file; `report merge`: folders of results as one.

mod merge;

use super::Global;
use super::files::{self, Output};
use crate::bench::{Key, Report, Results};
use crate::report::html;
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};

/// File of a results folder that holds its rows.
pub(super) const ROWS: &str = "rows.jsonl";
/// Name of a report.
pub(super) const REPORT: &str = "report.html";

/// Write results of `boxwood bench` as one HTML file, which needs no network.
///
/// Folders of several runs, of any devices, make one report. Shards of one run are joined in it; a run that is not
/// finished is reported as far as it came, with the rows that it lacks.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(super) struct Args {
    #[command(subcommand)]
    what: Option<What>,
    /// Folders that `boxwood bench --out` wrote.
    #[arg(value_name = "DIR", default_value = "results")]
    folders: Vec<PathBuf>,
    /// The file. Default: report.html in the first folder.
    #[arg(long, value_name = "HTML")]
    out: Option<PathBuf>,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    Merge(merge::Args),
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    if let Some(What::Merge(args)) = &args.what {
        return merge::run(global, args);
    }
    let results = read(global, &args.folders)?;
    let first = args.folders.first().map_or(Path::new("."), PathBuf::as_path);
    let path = args.out.clone().unwrap_or_else(|| first.join(REPORT));
    write(&path, &results)?;
    global.remark(format_args!("written: {}", path.display()));
    Ok(())
}

/// The runs that are in `folders`, of which some may hold parts of one; says what they lack and what they have twice.
fn read(global: &Global, folders: &[PathBuf]) -> Result<Vec<Results>> {
    let read = |folder: &PathBuf| Results::read(&folder.join(ROWS)).map_err(anyhow::Error::from);
    let parts: Vec<Results> = folders.iter().map(read).collect::<Result<_>>()?;
    let twice = Results::measured_twice(&parts);
    if !twice.is_empty() {
        tracing::warn!("{} measured twice; the first folder's stay: {}", rows(twice.len()), some(&twice));
    }
    let runs = Results::joined(parts);
    for run in &runs {
        let missing = run.missing();
        if !missing.is_empty() {
            let device = &run.header.device;
            global.remark(format_args!("{device}: {} missing: {}", rows(missing.len()), some(&missing)));
        }
    }
    Ok(runs)
}

fn rows(count: usize) -> String {
    if count == 1 { "a row is".into() } else { format!("{count} rows are") }
}

/// The first few of `keys`.
fn some(keys: &[Key]) -> String {
    let named: Vec<String> = keys.iter().take(3).map(Key::to_string).collect();
    named.join("; ") + if keys.len() > named.len() { "; …" } else { "" }
}

/// Writes what was made of a run into `folder`: its tables as JSON and CSV, and its report.
pub(super) fn write_run(global: &Global, folder: &Path, results: &Results) -> Result<()> {
    let found = Report::new(results);
    let [json, csv] = ["bench.json", "bench.csv"].map(|name| folder.join(name));
    Output::new(&json)?.finish(files::json(&found)?.as_bytes())?;
    Output::new(&csv)?.finish(&found.csv().context("can't write the CSV")?)?;
    write(&folder.join(REPORT), std::slice::from_ref(results))?;
    global.remark(format_args!("written: {}, {}", json.display(), csv.display()));
    Ok(())
}

/// Writes the report of `results`.
pub(super) fn write(path: &Path, results: &[Results]) -> Result<()> {
    let page = html(results).context("can't make the report")?;
    Output::new(path)?.finish(page.as_bytes())
}
