//! `boxwood devices`: what there is, what each offers, which one would be used, and why others can't be.

use super::Global;
use crate::device::{self, DeviceInfo};
use anyhow::Result;
use comfy_table::{ContentArrangement, Table, presets};
use std::io::Write;

/// List every Vulkan device with what it offers, and which one boxwood would use.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// A device and whether it is the one.
#[derive(serde::Serialize)]
struct Row<'a> {
    #[serde(flatten)]
    info: &'a DeviceInfo,
    usable: bool,
    chosen: bool,
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let all = device::list()?;
    let chosen = device::choose(&all, global.device.as_deref());
    let rows: Vec<Row> = all
        .iter()
        .enumerate()
        .map(|(i, info)| Row { info, usable: info.usable(), chosen: chosen.as_ref().is_ok_and(|c| *c == i) })
        .collect();
    let mut out = std::io::stdout().lock();
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&rows)?)?;
    } else {
        for row in &rows {
            print(&mut out, row)?;
        }
    }
    chosen?;
    Ok(())
}

fn print(out: &mut impl Write, row: &Row) -> Result<()> {
    let d = row.info;
    writeln!(out, "{} {} ({}){}", d.index, d.name, d.kind, if row.chosen { " ← used" } else { "" })?;
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic);
    let mut fact = |name: &str, value: String| {
        table.add_row([format!("   {name}"), value]);
    };
    fact("driver", d.driver.clone());
    fact("Vulkan", d.vulkan.clone());
    fact("subgroup", format!("{} invocations", d.subgroup_size));
    fact("workgroup", format!("up to {} invocations", d.max_workgroup));
    fact("memory", memory(d));
    fact(
        "binding",
        format!("up to {} MiB of a buffer; larger ones by address", d.max_storage_buffer_range >> 20),
    );
    fact("timestamps", timestamps(d));
    for f in &d.features {
        let need = if f.required { "required" } else { "optional" };
        fact(if f.present { "yes" } else { "no" }, format!("{} ({need}: {})", f.name, f.purpose));
    }
    if let Some(warning) = &d.warning {
        fact("warning", warning.clone());
    }
    if !d.usable() {
        fact("can't be used", d.refused.join(", "));
    }
    writeln!(out, "{}", table.trim_fmt())?;
    Ok(())
}

fn memory(d: &DeviceInfo) -> String {
    let free = d.memory_free.map_or("what is free is not told".into(), |f| format!("{} MiB free", f >> 20));
    format!("{} MiB, {free}", d.memory >> 20)
}

fn timestamps(d: &DeviceInfo) -> String {
    if d.timestamp_period > 0.0 && d.timestamp_bits > 0 {
        format!("{} ns a tick, {} bits", d.timestamp_period, d.timestamp_bits)
    } else {
        "none: wall time instead".into()
    }
}
