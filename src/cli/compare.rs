//! `boxwood compare`: two runs of the benchmark, for gates.

use super::files;
use super::report::ROWS;
use crate::bench::{Comparison, Quantity, Ratio, Results, compare};
use crate::scene::printable;
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Compare two runs of `boxwood bench`: ratios, second over first, and where those of times lie, about 95 % sure.
///
/// Exits with 1 where the second is worse by more than the threshold and noise is not the reason: times by their interval,
/// counts (tests, SAH cost, bytes, faults) as they are. Also where the second lacks rows that the first has.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The first run: its folder, its bench.json or its rows.jsonl.
    first: PathBuf,
    /// The second one.
    second: PathBuf,
    /// How much worse is too much, per cent.
    #[arg(long, value_name = "PERCENT", default_value_t = 5.0, value_parser = super::values::percent)]
    threshold: f64,
    /// What counts: times drift, counts don't.
    #[arg(long, value_enum, default_value_t = Of::All)]
    of: Of,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Of {
    /// Times and counts.
    All,
    /// Times alone.
    Times,
    /// Counts alone: the same on every machine.
    Counts,
}

impl Of {
    fn takes(self, quantity: Quantity) -> bool {
        match self {
            Self::All => true,
            Self::Times => !quantity.is_count(),
            Self::Counts => quantity.is_count(),
        }
    }
}

/// Runs the command.
pub(super) fn run(args: &Args) -> Result<()> {
    let [first, second] = [&args.first, &args.second].map(|path| results(path));
    let Comparison { mut ratios, only_first, only_second } = compare(&first?, &second?);
    ratios.retain(|r| args.of.takes(r.quantity));
    let threshold = 1.0 + args.threshold / 100.0;
    let past = ratios.iter().filter(|r| r.is_past(threshold)).count();
    let lacking = only_first.len();
    let mut out = std::io::stdout().lock();
    if args.json {
        writeln!(out, "{}", files::json(&Comparison { ratios, only_first, only_second })?)?;
    } else {
        writeln!(out, "{}", printable(&table(&ratios, threshold).to_string()))?;
        for (keys, which) in [(&only_first, "first"), (&only_second, "second")] {
            for key in keys {
                writeln!(out, "only the {which} has {}", printable(&key.to_string()))?;
            }
        }
    }
    match (past, lacking) {
        (0, 0) => Ok(()),
        (0, _) => bail!("the second run lacks {lacking} rows that the first has"),
        _ => bail!("{past} of the second run's figures are worse by more than {} %", args.threshold),
    }
}

/// Results at `path`: a folder, a file of rows, or the JSON that a finished run writes.
fn results(path: &Path) -> Result<Results> {
    if path.is_dir() {
        return Ok(Results::read(&path.join(ROWS))?);
    }
    if path.extension().is_some_and(|e| e == "json") {
        let text = std::fs::read(path).with_context(|| format!("can't read {}", path.display()))?;
        let what = "is no bench.json of this version of boxwood; measure again, or give the folder";
        return serde_json::from_slice(&text).with_context(|| format!("{} {what}", path.display()));
    }
    Ok(Results::read(path)?)
}

fn table(ratios: &[Ratio], threshold: f64) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(["what", "figure", "first", "second", "ratio", "95 %", ""]);
    for r in ratios {
        table.add_row([
            r.key.to_string(),
            r.quantity.name().to_owned(),
            number(r.first),
            number(r.second),
            format!("{:.3}", r.ratio),
            r.interval.map_or("–".into(), |[low, high]| format!("{low:.3} to {high:.3}")),
            if r.is_past(threshold) { "worse" } else { "" }.to_owned(),
        ]);
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Whole where it is large.
fn number(x: f64) -> String {
    if x.abs() >= 1e4 || x.fract() == 0.0 { format!("{x:.0}") } else { format!("{x:.2}") }
}
