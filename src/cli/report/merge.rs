//! `boxwood report merge`: folders of results as one.

use super::{Global, Output, REPORT, ROWS, read, write, write_run};
use crate::bench::Results;
use anyhow::{Context, Result, bail};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Join folders that `boxwood bench` wrote, shards of a run and runs of any devices, into one.
///
/// A run's rows, tables and report come as if it had been measured in one go: `compare`, `report` and `bench --resume`
/// take them. Of several runs each has a folder in it, and one report is over all. Of rows that are there twice the first
/// folder's stay.
#[derive(Debug, clap::Args)]
pub(in super::super) struct Args {
    /// Folders that `boxwood bench --out` wrote.
    #[arg(value_name = "DIR", required = true)]
    folders: Vec<PathBuf>,
    /// The folder to write.
    #[arg(long, value_name = "DIR", default_value = "merged")]
    out: PathBuf,
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let runs = read(global, &args.folders)?;
    let folders: Vec<PathBuf> = match runs.as_slice() {
        [_] => vec![args.out.clone()],
        several => several.iter().enumerate().map(|(i, run)| args.out.join(name(i, run))).collect(),
    };
    for (folder, run) in folders.iter().zip(&runs) {
        refuse_another(&folder.join(ROWS), run)?;
    }
    for (folder, run) in folders.iter().zip(&runs) {
        fs::create_dir_all(folder).with_context(|| format!("can't make the folder {}", folder.display()))?;
        let rows = folder.join(ROWS);
        for (file, bytes) in run.files_beside(&rows) {
            let beside = file.parent().unwrap_or(folder);
            fs::create_dir_all(beside)
                .with_context(|| format!("can't make the folder {}", beside.display()))?;
            Output::new(&file)?.finish(bytes)?;
        }
        Output::new(&rows)?.finish(&run.to_lines()?)?;
        write_run(global, folder, run)?;
    }
    let page = args.out.join(REPORT);
    if runs.len() > 1 {
        write(&page, &runs)?;
    }
    writeln!(std::io::stdout(), "Report: {}", std::path::absolute(&page).unwrap_or(page).display())?;
    Ok(())
}

/// A folder's name: the run's number and device, as file systems like them.
fn name(index: usize, run: &Results) -> String {
    let words = run.header.device.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let mut name = (index + 1).to_string();
    for word in words {
        name = name + "-" + &word.to_ascii_lowercase();
    }
    name.truncate(64);
    name
}

/// Fails where the rows at `path` are not all in `run`, for they would be lost.
fn refuse_another(path: &Path, run: &Results) -> Result<()> {
    if !path.exists() {
        return Ok(());
    }
    let there = Results::read(path)?;
    let joined = Results::joined(vec![run.clone(), there]);
    if joined.len() > 1 || joined.iter().any(|both| both.count() > run.count()) {
        bail!(
            "{} holds rows that none of the folders has; name its folder too, or give another --out",
            path.display()
        );
    }
    Ok(())
}
