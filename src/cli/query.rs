//! `boxwood query`: the door for other programs. Rays in, hits out, and what it took.

use super::check::{self, Checks};
use super::choices::{PrecisionName, RecipeArgs, ReportArgs, SortName, TransformArgs};
use super::files::{self, Output, emit};
use super::tree::{BuildReport, LoadReport, Source};
use super::{Global, explain};
use crate::abi::Ray;
use crate::bench::{
    Builds, Costs, Counting, KernelTime, Protocol, Traced, choose_walk, measure_builds, trace_all,
    try_recipes,
};
use crate::bvh::{Bvh, Fit, Recipe, SceneBuffers};
use crate::device::Device;
use crate::saved::{self, SavedError};
use crate::scene::{Progress, Scene};
use crate::trace::{Options, Query, RayOrder, Walk, is_coherent};
use anyhow::{Result, bail};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Trace the rays of a file through a scene and write their hits; print times as JSON.
///
/// Rays: little-endian f32, 8 a ray: origin, t_min, direction (of any length), t_max (may be +inf). Hits: f32 t (+inf
/// on a miss), u32 triangle in input order (0xffffffff on a miss), f32 u (weight of the second vertex), f32 v (of the
/// third).
#[derive(Debug, clap::Args)]
#[command(mut_group("TransformArgs", |group| group.requires("scene")))]
pub(super) struct Args {
    /// A mesh file or a name, such as dragon or hairball:500k: see `boxwood scenes list`. With --tree it may be left out, but
    /// for --check.
    #[arg(value_name = "SCENE", required_unless_present = "tree")]
    scene: Option<String>,
    #[command(flatten)]
    transform: TransformArgs,
    /// Trace through the tree of this file, which `build --save` has written, instead of building one. SCENE, where it is
    /// given, must be the one that it was built from.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["RecipeArgs", "sample"])]
    tree: Option<PathBuf>,
    /// Ray file.
    #[arg(long, value_name = "FILE")]
    rays: PathBuf,
    /// Hit file to write.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Only whether there is a hit: t is 0 where there is, and no triangle is told.
    #[arg(long)]
    any: bool,
    /// Count box and triangle tests, in a run of its own, and tell what they cost on this device: measured for a second,
    /// once.
    #[arg(long)]
    count: bool,
    /// Triangle test.
    #[arg(long, value_enum, default_value_t = PrecisionName::Robust)]
    precision: PrecisionName,
    /// Sort rays by origin and direction before they are traced; hits keep their places, and times include it.
    #[arg(long, value_enum, default_value_t = SortName::Auto)]
    sort: SortName,
    #[command(flatten)]
    recipe: RecipeArgs,
    /// With --builder auto: build other trees as well, top-down and by ODOP, and keep the one that N of the rays, spread
    /// evenly, cost least, by tests counted. Times of the build are of that one alone.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    sample: Option<u32>,
    #[command(flatten)]
    report: ReportArgs,
}

/// What `query` reports.
#[derive(serde::Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    source: &'a Source,
    query: &'static str,
    precision: &'static str,
    walk: &'static str,
    sorted: bool,
    /// Through which boxes, of a tree that keeps both.
    boxes: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    sort_ms: Option<f64>,
    rays: usize,
    hits: usize,
    trace_ms: f64,
    trace_ms_min: f64,
    trace_wall_ms: f64,
    mrays_s: f64,
    rays_per_submit: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    box_tests: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    oriented_tests: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    triangle_tests: Option<u64>,
    /// Of a box test, an oriented one and a triangle test, ns.
    #[serde(skip_serializing_if = "Option::is_none")]
    costs: Option<[f64; 3]>,
    /// Tests of a ray in the mean times their costs, ns.
    #[serde(skip_serializing_if = "Option::is_none")]
    cost_per_ray: Option<f64>,
    kernels: Vec<KernelTime>,
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<Checks>,
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let rays = files::rays(&args.rays)?;
    let out = Output::new(&args.out)?;
    let json = args.report.json.as_deref().map(Output::new).transpose()?;
    let device = global.open_device()?;
    let query = if args.any { Query::Any } else { Query::Closest };
    let runs = args.report.runs as usize;
    let tree = match &args.tree {
        Some(path) => loaded(global, args, &device, path)?,
        None => built(global, args, &device, &rays, query)?,
    };
    let bvh = &tree.bvh;

    let coherent = is_coherent(&rays, extent(bvh));
    let untried = Options {
        query,
        precision: args.precision.into(),
        walk: Walk::untried(&device, coherent),
        ..Options::default()
    };
    let choice = choose_walk(&device, bvh, &rays, untried, args.sort.orders(coherent))?;
    let options = choice.options;
    let costs = match args.count {
        true => Some(Costs::measured(&device, global.cache().as_deref())?),
        false => None,
    };
    let protocol = Protocol { runs, counting: if args.count { Counting::On } else { Counting::Off } };
    let bar = bar(global, rays.len());
    let traced = trace_all(&device, bvh, &rays, options, protocol, &|n| bar.inc(n as u64))?;
    bar.finish_and_clear();
    if args.report.explain {
        explain::build(&tree.explain);
        explain::trace(args.sort, &choice, protocol.counting, &traced);
    }
    out.finish(&files::hit_bytes(&traced.hits))?;

    let kernels = tree.kernels.iter().chain(&traced.kernels).cloned().collect();
    let Traced { device: device_ms, wall, .. } = &traced;
    let hits = traced.hits.iter().filter(|h| h.is_hit()).count();
    let mrays_s = device_ms.rate(rays.len()).median;
    global.remark(format_args!(
        "{} rays, {hits} hits in {:.2} ms (least {:.2}, wall {:.2}): {mrays_s:.2} Mrays/s",
        rays.len(),
        device_ms.median,
        device_ms.min,
        wall.median
    ));
    let check = match tree.scene.as_ref().filter(|_| args.report.check) {
        Some(scene) => {
            let checks = Checks::of_tree(global, scene, bvh, &tree.recipe)?;
            Some(checks.and_hits(global, scene, &rays, &traced.hits, options))
        }
        None => None,
    };
    let faults = check.as_ref().and_then(Checks::faults);
    let report = Report {
        source: &tree.source,
        query: match options.query {
            Query::Closest => "closest",
            Query::Any => "any",
        },
        precision: args.precision.name(),
        walk: options.walk.kernel_name(),
        sorted: options.order == RayOrder::Sorted,
        boxes: options.boxes.name(),
        sort_ms: (options.order == RayOrder::Sorted).then(|| traced.sort_ms()),
        rays: rays.len(),
        hits,
        trace_ms: device_ms.median,
        trace_ms_min: device_ms.min,
        trace_wall_ms: wall.median,
        mrays_s,
        rays_per_submit: traced.chunk.min(rays.len()),
        box_tests: traced.tests.map(|t| t.boxes),
        oriented_tests: traced.tests.map(|t| t.oriented),
        triangle_tests: traced.tests.map(|t| t.triangles),
        costs: costs.map(Costs::to_array),
        cost_per_ray: costs.zip(traced.tests).map(|(c, tests)| c.per_ray(&tests, rays.len())),
        kernels,
        check,
    };
    emit(&report, json)?;
    check::fail_on(faults)
}

/// What rays are traced through.
struct Tree {
    bvh: Bvh,
    recipe: Recipe,
    /// None: the tree was loaded without it.
    scene: Option<Scene>,
    source: Source,
    kernels: Vec<KernelTime>,
    explain: Vec<String>,
}

/// A tree that is built.
fn built(global: &Global, args: &Args, device: &Arc<Device>, rays: &[Ray], query: Query) -> Result<Tree> {
    let mut recipe = args.recipe.recipe(global, device)?;
    if args.sample.is_some() && recipe.fit != Fit::Auto {
        bail!("--sample chooses among trees, and the recipe names one: give --builder auto with it");
    }
    let Some(spec) = &args.scene else { bail!("no SCENE to build a tree of") };
    let scene = global.open_for(spec, &args.transform, device, recipe.builder)?;
    let buffers = SceneBuffers::upload(device, &scene)?;
    if let Some(most) = args.sample {
        let sample: Vec<Ray> =
            rays.iter().step_by(rays.len().div_ceil(most as usize).max(1)).copied().collect();
        let options = Options { query, precision: args.precision.into(), ..Options::default() };
        let costs = Costs::measured(device, global.cache().as_deref())?;
        let tried = try_recipes(device, &buffers, &recipe, &sample, options, costs)?;
        if args.report.explain {
            explain::sample(&tried, sample.len());
        }
        recipe = tried.first().map_or(recipe, |best| best.recipe);
    }
    let builds = measure_builds(device, &buffers, &recipe, args.report.runs as usize)?;
    let report = BuildReport::new(device, &scene, &recipe, &builds)?;
    report.remark(global);
    let Builds { built, kernels, .. } = builds;
    let (source, scene) = (Source::Built(report), Some(scene));
    Ok(Tree { bvh: built.bvh, recipe, scene, source, kernels, explain: built.explain })
}

/// The tree of the file `path`.
fn loaded(global: &Global, args: &Args, device: &Arc<Device>, path: &Path) -> Result<Tree> {
    if args.report.check && args.scene.is_none() {
        bail!("--check compares with the scene: give the SCENE of the tree {} as well", path.display());
    }
    let start = Instant::now();
    let loaded = saved::load(device, path)?;
    let ms = start.elapsed().as_secs_f64() * 1e3;
    let report = LoadReport::new(device, path.to_owned(), &loaded, ms, args.report.runs as usize)?;
    report.remark(global);
    let scene = args.scene.as_ref().map(|spec| global.open(spec, &args.transform)).transpose()?;
    if let Some(scene) = &scene {
        loaded.require_scene(scene).map_err(|fault| SavedError { path: path.to_owned(), fault })?;
    }
    let explain = vec![format!(
        "tree: {} bytes read in {ms:.2} ms, their checksum and every node and triangle checked; nothing built{}",
        loaded.bytes,
        if scene.is_some() { ", the scene only compared" } else { ", no scene read" }
    )];
    let saved::Loaded { bvh, origin, .. } = loaded;
    Ok(Tree { bvh, recipe: origin.recipe, scene, source: Source::Loaded(report), kernels: vec![], explain })
}

/// Longest edge of the tree's box, scene units.
fn extent(bvh: &Bvh) -> f32 {
    let longest = (0..3).map(|k| bvh.bounds.hi[k] - bvh.bounds.lo[k]).fold(0.0, f32::max);
    (f64::from(longest) * 2f64.powi(-bvh.exponent)) as f32
}

/// Shows how many rays are done, on a terminal.
pub(super) fn bar(global: &Global, rays: usize) -> ProgressBar {
    let target = match global.progress() {
        Progress::Bars => ProgressDrawTarget::stderr(),
        Progress::Quiet => ProgressDrawTarget::hidden(),
    };
    let bar = ProgressBar::with_draw_target(Some(rays as u64), target).with_message("tracing");
    match ProgressStyle::with_template("{msg} {wide_bar} {human_pos}/{human_len}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
