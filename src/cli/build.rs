//! `boxwood build`: builds a scene's tree and says what it took.

use super::check::{self, Checks};
use super::choices::{RecipeArgs, ReportArgs, SceneArgs};
use super::files::{Output, emit};
use super::{Global, explain};
use crate::bench::{Builds, KernelTime, measure_builds};
use crate::bvh::{Bvh, Fit, Recipe, SceneBuffers, stages};
use crate::device::Device;
use crate::oracle::mixed::{self, Mixed};
use crate::oracle::quality::{Quality, measure};
use crate::oracle::tight::{self, Tightness};
use crate::oracle::validate::Claims;
use crate::scene::Scene;
use anyhow::Result;

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
}

/// What `build` and `query` report of a build.
#[derive(Debug, serde::Serialize)]
pub(super) struct BuildReport {
    device: String,
    driver: String,
    commit: &'static str,
    scene: String,
    triangles: usize,
    left_out: u32,
    builder: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    morton: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radius: Option<u32>,
    max_leaf: u32,
    collapse: &'static str,
    fit: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    bases: Option<&'static str>,
    node_cost: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    oriented_cost: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    threshold: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    directions: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    local_search: Option<u32>,
    /// Of a binary node and of a triangle.
    sah_costs: [f32; 2],
    runs: usize,
    build_ms: f64,
    /// Of the last build, the share of its time that the CPU took.
    build_host_ms: f64,
    build_ms_min: f64,
    build_wall_ms: f64,
    bvh_bytes: u64,
    scratch_bytes: u64,
    sah: f64,
    depth: u32,
    nodes: usize,
    /// Those whose boxes are oriented.
    oriented: u32,
    tree_hash: String,
}

/// The whole report of `build`.
#[derive(serde::Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    build: &'a BuildReport,
    kernels: &'a [KernelTime],
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

impl BuildReport {
    /// Of `builds`; reads the tree back for its hash.
    pub(super) fn new(device: &Device, scene: &Scene, recipe: &Recipe, builds: &Builds) -> Result<Self> {
        let bvh = &builds.built.bvh;
        Ok(Self {
            device: device.info().name.clone(),
            driver: device.info().driver.clone(),
            commit: env!("BOXWOOD_COMMIT"),
            scene: scene.name.clone(),
            triangles: scene.triangles.len(),
            left_out: bvh.left_out,
            builder: recipe.builder.name(),
            morton: recipe.builder.wants_codes().then_some(recipe.morton.name()),
            radius: recipe.builder.has_radius().then_some(recipe.radius),
            max_leaf: recipe.collapse.max_leaf,
            collapse: recipe.collapsed.name(),
            fit: recipe.fit.name(),
            bases: recipe.builder.bases().or(recipe.fit.bases()).map(|b| b.generator.name()),
            node_cost: recipe.collapse.node_cost,
            oriented_cost: (recipe.fit != Fit::Aabb).then_some(recipe.oriented_cost),
            threshold: recipe.threshold,
            directions: recipe.fit.has_points().then_some(recipe.directions.name()),
            local_search: (recipe.local_search > 0).then_some(recipe.local_search),
            sah_costs: [recipe.collapse.traversal_cost, recipe.collapse.triangle_cost],
            runs: builds.device.runs,
            build_ms: builds.device.median,
            build_host_ms: builds.built.times.host_ms,
            build_ms_min: builds.device.min,
            build_wall_ms: builds.wall.median,
            bvh_bytes: bvh.bytes(),
            scratch_bytes: builds.built.scratch_bytes,
            sah: bvh.sah,
            depth: bvh.depth,
            nodes: bvh.nodes.len(),
            oriented: bvh.oriented,
            tree_hash: bvh.read()?.hash(),
        })
    }

    /// For people.
    pub(super) fn remark(&self, global: &Global) {
        let per_triangle = self.triangles.max(1) as f64;
        global.remark(format_args!(
            "{}: {} triangles built in {:.2} ms (least {:.2}, wall {:.2}) on {}",
            self.scene, self.triangles, self.build_ms, self.build_ms_min, self.build_wall_ms, self.device
        ));
        global.remark(format_args!(
            "tree: {} nodes, {:.1} MB, SAH cost {:.2}; scratch {:.0} bytes a triangle",
            self.nodes,
            self.bvh_bytes as f64 * 1e-6,
            self.sah,
            self.scratch_bytes as f64 / per_triangle
        ));
    }
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let json = args.report.json.as_deref().map(Output::new).transpose()?;
    let device = global.open_device()?;
    let recipe = args.recipe.recipe(global, &device)?;
    let scene = global.open_scene_for(&args.scene, &device, recipe.builder)?;
    let buffers = SceneBuffers::upload(&device, &scene)?;
    let builds = measure_builds(&device, &buffers, &recipe, args.report.runs as usize)?;
    let build = BuildReport::new(&device, &scene, &recipe, &builds)?;
    build.remark(global);
    if args.report.explain {
        explain::build(&builds.built);
    }
    // A tree that is not sound has no quality.
    let check = if args.report.check || args.quality {
        Some(Checks::of_tree(global, &scene, &builds.built.bvh, &recipe)?)
    } else {
        None
    };
    let faults = check.as_ref().and_then(Checks::faults);
    let mut report =
        Report { build: &build, kernels: &builds.kernels, check, quality: None, tight: None, mixed: None };
    if args.quality {
        let bvh = &builds.built.bvh;
        let tight = tight::measure(&bvh.read()?, bvh.anchor, &bvh.bounds);
        let mixed = mixed::measure(&scene, &stages(&device, &buffers, &recipe)?.1);
        report.quality = Some(measured(global, bvh, &recipe)?);
        remark_boxes(global, &tight, &mixed);
        (report.tight, report.mixed) = (Some(tight), Some(mixed));
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
