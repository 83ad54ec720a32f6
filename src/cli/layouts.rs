//! `boxwood layouts`: node layouts of the literature against the packed tree's.

use super::Global;
use super::choices::{RecipeArgs, SceneArgs};
use super::render::ViewArgs;
use crate::bench::{LayoutPlan, LayoutRow, LayoutSize, Layouts, RayKind, measure_layouts};
use anyhow::{Result, bail};
use clap::ValueEnum;
use clap::builder::PossibleValue;
use comfy_table::{ContentArrangement, Table, presets};
use std::io::Write;

/// Secondary rays of a kind at most, by default.
const SAMPLE: u32 = 1 << 18;

/// Trace rays through a scene's tree in several node layouts, in turn.
///
/// packed: the node that all else of boxwood traces, four children that share a frame; packed-aabb: the same where no node
/// has one. Of the same binary tree, with the same leaves: aabb64, nodes of two axis-aligned boxes; obb112, of two oriented
/// ones as matrices; mixed, of either, the cheaper by --oriented-cost.
///
/// Layouts take turns, each ray alone in an invocation; medians, ± the range between the quartiles in per cent. The binary
/// trees are made on the host, with DiTO's boxes from 14 extremal points; their build isn't timed. Exits with 1 where a
/// layout's hits are not those of the first, bit for bit, or a corner of a triangle lies outside a box above it.
#[derive(Debug, clap::Args)]
#[command(mut_arg("builder", |builder| builder.default_value("dito")))]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Rays.
    #[arg(
        long,
        value_enum,
        value_name = "KIND",
        value_delimiter = ',',
        default_value = "primary,ao,diffuse"
    )]
    rays: Vec<RayKind>,
    /// Secondary rays of a kind at most, from eight places of the picture; 0: all.
    #[arg(long, value_name = "N", default_value_t = SAMPLE)]
    sample: u32,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Timed runs of each layout, after a warm-up: 1–1000.
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl ValueEnum for RayKind {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()))
    }
}

/// What `layouts` reports.
#[derive(serde::Serialize)]
struct Report<'a> {
    scene: &'a str,
    device: &'a str,
    driver: &'a str,
    #[serde(flatten)]
    layouts: &'a Layouts,
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let device = global.open_device()?;
    let recipe = args.recipe.recipe(global, &device)?;
    let scene = global.open_scene_for(&args.scene, &device, recipe.builder)?;
    let plan = LayoutPlan {
        recipe,
        view: args.view.of(&scene),
        kinds: args.rays.clone(),
        sample: args.sample as usize,
        runs: args.runs as usize,
    };
    let layouts = measure_layouts(&device, &scene, &plan, &|step| global.remark(step))?;
    let mut out = std::io::stdout().lock();
    if args.json {
        let info = device.info();
        let (device, driver) = (info.name.as_str(), info.driver.as_str());
        let report = Report { scene: &scene.name, device, driver, layouts: &layouts };
        writeln!(out, "{}", serde_json::to_string_pretty(&report)?)?;
    } else {
        writeln!(out, "{}\n\n{}", sizes(&layouts), rows(&layouts))?;
    }
    fail_on_faults(&layouts)
}

/// The command's failure, where a layout is not sound.
fn fail_on_faults(layouts: &Layouts) -> Result<()> {
    for LayoutSize { layout, outside, .. } in &layouts.sizes {
        if let Some(outside @ 1..) = outside {
            bail!("{layout}: {outside} times a corner of a triangle lies outside a box above it");
        }
    }
    match layouts.rows.iter().find(|row| row.differing > 0) {
        Some(row) => bail!(
            "{}: {} of {} {} rays hit something else than in {}",
            row.layout,
            row.differing,
            row.count,
            row.rays,
            layouts.sizes[0].layout
        ),
        None => Ok(()),
    }
}

fn table(head: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(head);
    table
}

/// What nodes take.
fn sizes(layouts: &Layouts) -> Table {
    let mut table = table(&["layout", "nodes", "bytes a node", "MiB"]);
    for LayoutSize { layout, nodes, bytes, .. } in &layouts.sizes {
        let mean = *bytes as f64 / (*nodes).max(1) as f64;
        let mib = *bytes as f64 / f64::from(1 << 20);
        table.add_row([(*layout).to_owned(), nodes.to_string(), format!("{mean:.1}"), format!("{mib:.2}")]);
    }
    table
}

/// What rays take, a row a kind and layout.
fn rows(layouts: &Layouts) -> Table {
    let head =
        ["rays", "layout", "boxes", "oriented", "triangles", "ms", "±%", "Mrays/s", "speed", "differing"];
    let mut table = table(&head);
    for LayoutRow { layout, rays, count, tests, trace_ms, speed, differing } in &layouts.rows {
        let each = |n: u64| format!("{:.2}", n as f64 / (*count).max(1) as f64);
        table.add_row([
            (*rays).to_owned(),
            (*layout).to_owned(),
            each(tests.boxes),
            each(tests.oriented),
            each(tests.triangles),
            format!("{:.1}", trace_ms.median),
            format!("{:.0}", trace_ms.percent()),
            format!("{:.2}", trace_ms.rate(*count).median),
            format!("{speed:.2}"),
            differing.to_string(),
        ]);
    }
    table
}
