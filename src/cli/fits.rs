//! `boxwood fits`: how near each way to fit a box comes to the least one.

use super::Global;
use crate::oracle::fits::{Excess, KINDS, Method, Row, Settings, measure};
use anyhow::Result;
use comfy_table::{ContentArrangement, Table, presets};
use std::io::Write;

/// Fit boxes to random point sets, and compare their half areas with those of near-optimal boxes. On the CPU.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Sets of each kind: 1–100000.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    sets: u32,
    /// Evaluations of local search: 0–1024.
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(0..=1024))]
    local_search: u32,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// The table, for machines.
#[derive(serde::Serialize)]
struct Report {
    sets: u32,
    local_search: u32,
    rows: Vec<Cell>,
}

/// How a method does on a kind of sets, half areas above the least, per cent.
#[derive(serde::Serialize)]
struct Cell {
    set: &'static str,
    method: String,
    #[serde(flatten)]
    excess: Excess,
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let rows = measure(Settings { sets: args.sets, evaluations: args.local_search });
    let mut out = std::io::stdout().lock();
    if args.json {
        let cells = rows.iter().flat_map(|row| {
            let cell = |(method, excess): (Method, &Excess)| Cell {
                set: row.kind.name,
                method: method.name(),
                excess: *excess,
            };
            Method::ALL.into_iter().zip(&row.excess).map(cell)
        });
        let report = Report { sets: args.sets, local_search: args.local_search, rows: cells.collect() };
        writeln!(out, "{}", serde_json::to_string_pretty(&report)?)?;
        return Ok(());
    }
    writeln!(out, "{}", table(&rows))?;
    for kind in KINDS {
        global.remark(format_args!("{}: {}", kind.name, kind.what));
    }
    Ok(())
}

/// Mean and greatest excess, per cent; a row a kind, and the means over all.
fn table(rows: &[Row]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(std::iter::once("set".to_owned()).chain(Method::ALL.iter().map(|m| m.name())));
    for row in rows {
        let cell = |e: &Excess| format!("{}/{:.0}", short(e.mean), e.max);
        table.add_row(std::iter::once(row.kind.name.to_owned()).chain(row.excess.iter().map(cell)));
    }
    let mean = |m: usize| rows.iter().map(|r| r.excess[m].mean).sum::<f64>() / rows.len() as f64;
    let means = (0..Method::ALL.len()).map(|m| format!("{:.2}", mean(m)));
    table.add_row(std::iter::once("all".to_owned()).chain(means));
    table
}

/// Of a small number a digit after the point.
fn short(x: f64) -> String {
    if x < 9.95 { format!("{x:.1}") } else { format!("{x:.0}") }
}
