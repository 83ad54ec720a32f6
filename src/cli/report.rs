//! `boxwood report`: results of `boxwood bench` as one HTML file.

use super::Global;
use super::files::Output;
use crate::bench::Results;
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
/// finished is reported as far as it came.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folders that `boxwood bench --out` wrote.
    #[arg(value_name = "DIR", default_value = "results")]
    folders: Vec<PathBuf>,
    /// The file. Default: report.html in the first folder.
    #[arg(long, value_name = "HTML")]
    out: Option<PathBuf>,
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let read = |folder: &PathBuf| Results::read(&folder.join(ROWS)).map_err(anyhow::Error::from);
    let results = Results::joined(args.folders.iter().map(read).collect::<Result<_>>()?);
    let first = args.folders.first().map_or(Path::new("."), PathBuf::as_path);
    let path = args.out.clone().unwrap_or_else(|| first.join(REPORT));
    write(&path, &results)?;
    global.remark(format_args!("written: {}", path.display()));
    Ok(())
}

/// Writes the report of `results`.
pub(super) fn write(path: &Path, results: &[Results]) -> Result<()> {
    let page = html(results).context("can't make the report")?;
    Output::new(path)?.finish(page.as_bytes())
}
