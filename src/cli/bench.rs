//! `boxwood bench`: the default benchmark.

use super::Global;
use anyhow::{Result, bail};

/// Build and trace the default scenes; print a table, write JSON and CSV.
#[derive(Debug, clap::Args)]
pub(super) struct Args {}

/// Runs the command.
pub(super) fn run(_: &Global, _: &Args) -> Result<()> {
    bail!("not there yet")
}
