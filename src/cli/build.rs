//! `boxwood build`: builds a scene's tree and says what it took.

use super::check::{self, Checks};
use super::choices::{RecipeArgs, ReportArgs, SceneArgs};
use super::files::{Output, emit};
use super::tree::BuildReport;
use super::{Global, explain};
use crate::bench::{KernelTime, measure_builds};
use crate::bvh::{Bvh, Recipe, SceneBuffers, stages};
use crate::oracle::mixed::{self, Mixed};
use crate::oracle::quality::{Quality, measure};
use crate::oracle::tight::{self, Tightness};
use crate::oracle::validate::Claims;
use crate::saved::{self, Origin};
use anyhow::Result;
use std::path::PathBuf;
use std::time::Instant;

/// Build a scene's tree; print times, memory and quality as JSON.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    recipe: RecipeArgs,
    #[command(flatten)]
    report: ReportArgs,
    /// Check the tree, and measure what its SAH cost doesn't see: end-point overlap, leaf-count variability, area by
    /// level, how tight its boxes are.
    #[arg(long)]
    quality: bool,
    /// Write the tree to this file, from which `query --tree` traces without building; usually named .boxwood.
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
}

/// The whole report of `build`.
#[derive(serde::Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    build: &'a BuildReport,
    kernels: &'a [KernelTime],
    #[serde(skip_serializing_if = "Option::is_none")]
    saved: Option<SaveReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<Checks>,
    #[serde(skip_serializing_if = "Option::is_none")]
    quality: Option<Quality>,
    /// How tight its boxes are.
    #[serde(skip_serializing_if = "Option::is_none")]
    tight: Option<Tightness>,
    /// What its binary tree would cost, were the boxes of its nodes chosen one by one.
    #[serde(skip_serializing_if = "Option::is_none")]
    mixed: Option<Mixed>,
}

/// What saving took.
#[derive(serde::Serialize)]
struct SaveReport {
    file: PathBuf,
    bytes: u64,
    ms: f64,
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let json = args.report.json.as_deref().map(Output::new).transpose()?;
    let save = args.save.as_deref().map(Output::new).transpose()?;
    let device = global.open_device()?;
    let recipe = args.recipe.recipe(global, &device)?;
    let scene = global.open_scene_for(&args.scene, &device, recipe.builder)?;
    let buffers = SceneBuffers::upload(&device, &scene)?;
    let builds = measure_builds(&device, &buffers, &recipe, args.report.runs as usize)?;
    let build = BuildReport::new(&device, &scene, &recipe, &builds)?;
    build.remark(global);
    if args.report.explain {
        explain::build(&builds.built.explain);
    }
    // A tree that is not sound has no quality.
    let check = if args.report.check || args.quality {
        Some(Checks::of_tree(global, &scene, &builds.built.bvh, &recipe)?)
    } else {
        None
    };
    let faults = check.as_ref().and_then(Checks::faults);
    let mut report = Report {
        build: &build,
        kernels: &builds.kernels,
        saved: None,
        check,
        quality: None,
        tight: None,
        mixed: None,
    };
    if args.quality {
        let bvh = &builds.built.bvh;
        let tight = tight::measure(&bvh.read()?, bvh.anchor, &bvh.bounds);
        let mixed = mixed::measure(&scene, &stages(&device, &buffers, &recipe)?.1);
        report.quality = Some(measured(global, bvh, &recipe)?);
        remark_boxes(global, &tight, &mixed);
        (report.tight, report.mixed) = (Some(tight), Some(mixed));
    }
    if let (Some(output), Some(file)) = (save, &args.save) {
        let start = Instant::now();
        let origin = Origin::new(&scene, recipe);
        let bytes = output.finish_by(|out| Ok(saved::write(&builds.built.bvh, &origin, out)?))?;
        let ms = start.elapsed().as_secs_f64() * 1e3;
        global.remark(format_args!("saved: {}, {:.1} MB in {ms:.1} ms", file.display(), bytes as f64 * 1e-6));
        report.saved = Some(SaveReport { file: file.clone(), bytes, ms });
    }
    emit(&report, json)?;
    check::fail_on(faults)
}

/// The quality of a sound tree, and a line for people.
fn measured(global: &Global, bvh: &Bvh, recipe: &Recipe) -> Result<Quality> {
    let quality = measure(&bvh.read()?, &Claims::of(bvh, recipe.collapse));
    let error = match quality.epo_sampled {
        0 => String::new(),
        points => format!(" ± {:.4} (from {points} points)", quality.epo_error),
    };
    global.remark(format_args!(
        "quality: end-point overlap {:.4}{error}, wide SAH cost {:.2}; a ray meets {:.2} leaves, deviation {:.2}",
        quality.epo, quality.wide_sah, quality.leaves_per_ray, quality.lcv
    ));
    Ok(quality)
}

/// Lines for people on how tight the boxes are.
fn remark_boxes(global: &Global, tight: &Tightness, mixed: &Mixed) {
    global.remark(format_args!(
        "boxes: {:.2} % axis-aligned, {:.2} % by area; area of nodes {:.2} %, of leaves {:.2} %, of all {:.2} % of axis-aligned ones",
        100.0 * tight.aabb_share,
        100.0 * tight.aabb_area_share,
        100.0 * tight.inner_area,
        100.0 * tight.leaf_area,
        100.0 * tight.total_area
    ));
    global.remark(format_args!(
        "cost with (3, 4, 2): {:.2}, and {:.2} with axis-aligned boxes; of the binary tree, node by node, {:.2} and {:.2}",
        tight.cost, tight.aabb_cost, mixed.cost, mixed.aabb_cost
    ));
}
