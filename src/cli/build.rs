//! `boxwood build`: builds a scene's tree and says what it took.

use super::check::{self, Checks};
use super::choices::{RecipeArgs, ReportArgs, SceneArgs};
use super::files::{Output, emit};
use super::{Global, explain};
use crate::bench::{Builds, KernelTime, measure_builds};
use crate::bvh::{Bvh, Fit, Recipe, SceneBuffers};
use crate::device::Device;
use crate::oracle::quality::{Quality, measure};
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
    /// level.
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
    #[serde(skip_serializing_if = "Option::is_none")]
    bases: Option<&'static str>,
    max_leaf: u32,
    fit: &'static str,
    node_cost: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    oriented_cost: Option<f32>,
    costs: [f32; 2],
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
            bases: recipe.builder.bases().map(|bases| bases.generator.name()),
            max_leaf: recipe.collapse.max_leaf,
            fit: recipe.fit.name(),
            node_cost: recipe.collapse.node_cost,
            oriented_cost: (recipe.fit != Fit::Aabb).then_some(recipe.oriented_cost),
            costs: [recipe.collapse.traversal_cost, recipe.collapse.triangle_cost],
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
    let recipe = args.recipe.recipe();
    let json = args.report.json.as_deref().map(Output::new).transpose()?;
    let device = global.open_device()?;
    let scene = global.open_scene(&args.scene)?;
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
    let quality = if args.quality { Some(measured(global, &builds.built.bvh, &recipe)?) } else { None };
    let faults = check.as_ref().and_then(Checks::faults);
    emit(&Report { build: &build, kernels: &builds.kernels, check, quality }, json)?;
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
