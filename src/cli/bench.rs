//! `boxwood bench`: builders × scenes × ray sets, measured and checked.

use super::choices::{SortName, TransformArgs};
use super::files;
use super::report::{self, REPORT, ROWS};
use super::{Global, warn_of};
use crate::bench::{
    BenchError, Contender, Costs, Coverage, Header, Maker, Plan, Preset, Presets, RayFile, RayKind, RaySet,
    Report, Rows, Shard, Unmeasured, run as measure,
};
use crate::bvh::require_memory;
use crate::device::{Device, DeviceInfo};
use crate::ray_query::TriangleOrder;
use crate::scene::{self, Progress, Scene, Transform};
use crate::trace::rays::Aimed;
use crate::trace::{Precision, Query};
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Build, trace, check and time scenes; print tables, write rows.jsonl, bench.json, bench.csv and report.html.
///
/// Builders take turns, so that what else the machine does meets all of them alike. Medians; ± is the range between the
/// quartiles, in per cent of the median. Faults are hits that the f64 reference contradicts and rounding doesn't excuse,
/// unsure ones those that it may; of the device's own traversal (--against) they are told, and no failure. Every finished
/// row is in rows.jsonl at once: --resume goes on from there.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenes: files, names, or set:NAME: see `boxwood scenes list`. SCENE@D is moved by D along each axis. Default: the
    /// preset's.
    scenes: Vec<String>,
    #[command(flatten)]
    transform: TransformArgs,
    /// What to measure; `--preset list` tells which there are.
    #[arg(long, value_name = "NAME", default_value = "default")]
    preset: String,
    /// A file of presets and builders, like scenes/bench.toml in boxwood's sources.
    #[arg(long, value_name = "TOML")]
    presets: Option<PathBuf>,
    /// Builders: recipes of the presets' file.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    builders: Vec<String>,
    /// What else builds and traces in turn with them: `ray-query`, the device's own structure and its traversal, over the
    /// mesh's order of triangles and over Morton's, whose sorting is part of the build.
    #[arg(long, value_enum, value_name = "WHAT", value_delimiter = ',')]
    against: Vec<Against>,
    /// Rays: primary, ao, diffuse, shadow, file:PATH for nearest hits of a file's rays, any:PATH for whether they hit.
    #[arg(long, value_name = "SET", value_delimiter = ',')]
    rays: Vec<String>,
    /// Whether rays but primaries are sorted on the device; the sort's time counts.
    #[arg(long, value_enum, default_value_t = SortName::Auto)]
    sort: SortName,
    /// Views of each scene: 1–5.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=5))]
    views: Option<u32>,
    /// Measured runs at most, after a warm-up; fewer where times settle.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: Option<u32>,
    /// Folder for the results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    out: PathBuf,
    /// Measure the Ith of N parts of the plan, the same on every machine; `boxwood report merge` joins their folders.
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Go on with the rows in the folder instead of beginning anew.
    #[arg(long)]
    resume: bool,
    /// Don't check hits.
    #[arg(long)]
    no_check: bool,
    /// Trace all secondary rays of a picture, as GPUs do by default; software drivers trace a sample.
    #[arg(long)]
    all: bool,
}

/// What boxwood is held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Against {
    /// VK_KHR_acceleration_structure and VK_KHR_ray_query.
    RayQuery,
}

impl Args {
    /// What boxwood's `own` contenders are held against.
    fn rivals(&self, own: &[Contender]) -> Result<Vec<Contender>> {
        if !self.against.contains(&Against::RayQuery) {
            return Ok(vec![]);
        }
        let rival = |order: TriangleOrder| match own.iter().find(|c| c.name == order.name()) {
            None => Ok(Contender {
                name: order.name().to_owned(),
                maker: Maker::Driver(order),
                precision: Precision::default(),
            }),
            Some(taken) => {
                bail!("--against ray-query wants the name {}, which a builder has: rename it", taken.name)
            }
        };
        TriangleOrder::ALL.into_iter().map(rival).collect()
    }

    fn presets(&self) -> Result<Presets> {
        let Some(path) = &self.presets else { return Ok(Presets::own()?) };
        let text = std::fs::read_to_string(path).with_context(|| format!("can't read {}", path.display()))?;
        Presets::parse(&text).with_context(|| path.display().to_string())
    }

    /// The preset, changed by what else was typed.
    fn plan(&self, presets: &Presets, device: &DeviceInfo) -> Result<Plan> {
        let preset = presets.preset(&self.preset)?;
        let or =
            |typed: &Vec<String>, preset: Vec<String>| if typed.is_empty() { preset } else { typed.clone() };
        let Preset {
            scenes,
            builders,
            rays,
            views,
            size,
            warm_ups,
            runs,
            sample,
            check,
            aimed,
            boxes,
            images,
            pictures,
        } = preset;
        let contender = |name: &String| -> Result<Contender> {
            let (recipe, precision) = (presets.recipe(name)?, presets.precision(name)?);
            Ok(Contender { name: name.clone(), maker: Maker::Boxwood(recipe), precision })
        };
        let own = once_each(or(&self.builders, builders));
        let mut contenders = own.iter().map(contender).collect::<Result<Vec<_>>>()?;
        contenders.extend(self.rivals(&contenders)?);
        Ok(Plan {
            scenes: once_each(each_of_sets(or(&self.scenes, scenes))?),
            transform: self.transform.transform(),
            contenders,
            shard: self.shard.unwrap_or(Shard::WHOLE),
            rays: once_each(or(&self.rays, rays)).iter().map(|set| ray_set(set)).collect::<Result<_>>()?,
            orders: self.sort.orders(false),
            views: self.views.map_or(views, |n| n as usize),
            size,
            warm_ups,
            runs: self.runs.map_or(runs, |n| n as usize),
            coverage: if self.all || !device.is_cpu() { Coverage::All } else { Coverage::sample(sample) },
            check: if self.no_check { 0 } else { check },
            aimed,
            boxes,
            images,
            pictures,
        })
    }
}

/// Scenes, those of a set in its place.
fn each_of_sets(specs: Vec<String>) -> Result<Vec<String>> {
    let mut scenes = vec![];
    for spec in specs {
        match spec.strip_prefix("set:") {
            None => scenes.push(spec),
            Some(name) => match scene::set(name) {
                Some(set) => scenes.extend_from_slice(set),
                None => {
                    let known: Vec<_> = scene::manifest().sets.keys().map(String::as_str).collect();
                    bail!("no set is called {name:?}; there are {}", known.join(", "))
                }
            },
        }
    }
    Ok(scenes)
}

/// What is named, the second naming of anything left out.
fn once_each(names: Vec<String>) -> Vec<String> {
    let mut seen = vec![];
    for name in names {
        if !seen.contains(&name) {
            seen.push(name);
        }
    }
    seen
}

/// A ray set as typed.
fn ray_set(text: &str) -> Result<RaySet> {
    let file = |path: &str, query| -> Result<RaySet> {
        let rays = files::rays(Path::new(path))?.into();
        Ok(RaySet::File(RayFile { path: path.into(), rays, query }))
    };
    match text.split_once(':') {
        Some(("file", path)) => file(path, Query::Closest),
        Some(("any", path)) => file(path, Query::Any),
        _ => match RayKind::ALL.into_iter().find(|kind| kind.name() == text) {
            Some(kind) => Ok(RaySet::Made(kind)),
            None => match Aimed::ALL.into_iter().find(|aimed| aimed.name() == text) {
                Some(aimed) => Ok(RaySet::Aimed(aimed)),
                None => {
                    let made = RayKind::ALL.map(RayKind::name);
                    let known = [&made[..], &Aimed::ALL.map(Aimed::name)].concat().join(", ");
                    bail!("no rays are called {text:?}; there are {known}, file:PATH and any:PATH")
                }
            },
        },
    }
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let presets = args.presets()?;
    if args.preset == "list" {
        return list(&presets);
    }
    // What can't be is found out before anything is opened.
    presets.preset(&args.preset)?;
    let device = global.open_device()?;
    if args.against.contains(&Against::RayQuery) {
        device.require_ray_query().context("--against ray-query")?;
    }
    let plan = args.plan(&presets, device.info())?;
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("can't make the folder {}", args.out.display()))?;
    let path = |name: &str| args.out.join(name);
    let costs = Costs::measured(&device, global.cache().as_deref())?;
    let header = Header::new(device.info(), &plan, costs);
    let open = if args.resume { Rows::resume } else { Rows::create };
    let mut rows = open(&path(ROWS), &header)?;
    if args.resume {
        global.remark(format_args!("resuming: {} of {} rows are there", rows.count(), plan.keys().len()));
    }

    let bar = bar(global, plan.keys().len());
    let open = |spec: &str| open_scene(global, args, &device, &plan, spec);
    let done = measure(&device, &plan, &open, &mut rows, &|step, rows| {
        bar.set_message(step.to_owned());
        bar.set_position(rows.count() as u64);
        if bar.is_hidden() {
            // No terminal: a line a step, for a log that stands still for minutes worries people.
            global.remark(step);
        }
    });
    bar.finish_and_clear();
    if done.is_err() && rows.count() > 0 {
        global.remark(format_args!("{} finished rows are kept: --resume goes on with them", rows.count()));
    }
    let unmeasured = done?;
    if rows.count() == 0
        && let [first, ..] = &unmeasured[..]
    {
        bail!("{}", said(first, unmeasured.len()));
    }

    let found = Report::new(rows.results());
    print(&found, &plan)?;
    report::write_run(global, &args.out, rows.results())?;
    let page = path(REPORT);
    writeln!(std::io::stdout(), "Report: {}", std::path::absolute(&page).unwrap_or(page).display())?;
    let drivers = found.drivers_faults();
    if !drivers.is_empty() {
        global.remark(format_args!(
            "the device's own traversal is wrong about some hits:\n{}",
            drivers.join("\n")
        ));
    }
    if let faults @ [_, ..] = &found.faults()[..] {
        bail!("the hits are wrong\n{}", faults.join("\n"));
    }
    for scene in unmeasured.iter().skip(1) {
        tracing::warn!("{}: {}", scene.scene, scene.why);
    }
    match &unmeasured[..] {
        [] => Ok(()),
        [first, ..] => {
            bail!("{}; what could be measured is kept: --resume goes on", said(first, unmeasured.len()))
        }
    }
}

/// The first of the scenes that could not be measured, and how many there are.
fn said(first: &Unmeasured, count: usize) -> String {
    let Unmeasured { scene, why } = first;
    match count {
        1 => format!("{scene} could not be measured: {why}"),
        _ => format!("{count} scenes could not be measured, first {scene}: {why}"),
    }
}

/// Presets and builders there are.
fn list(presets: &Presets) -> Result<()> {
    let mut out = std::io::stdout().lock();
    for (name, what) in presets.list() {
        writeln!(out, "{name:12} {what}")?;
    }
    writeln!(out, "builders: {}", presets.recipes().collect::<Vec<_>>().join(", "))?;
    Ok(())
}

/// What is before the last `@` of `spec` and by how much the scene is moved along each axis: 0 where there is no number
/// behind one, or a file of the whole name.
fn moved(spec: &str) -> (&str, f64) {
    let at = spec.rsplit_once('@').filter(|_| !Path::new(spec).exists());
    let number = at.and_then(|(scene, by)| Some((scene, by.parse().ok().filter(|by: &f64| by.is_finite())?)));
    number.unwrap_or((spec, 0.0))
}

/// A scene; a generated one instead of one of a preset's that can't be fetched.
fn open_scene(
    global: &Global,
    args: &Args,
    device: &Device,
    plan: &Plan,
    spec: &str,
) -> std::result::Result<Scene, BenchError> {
    let recipes = plan.contenders_of(spec).iter().filter_map(|c| match &c.maker {
        Maker::Boxwood(recipe) => Some(recipe),
        Maker::Driver(_) => None,
    });
    let (spec, by) = moved(spec);
    if let Some(triangles) = scene::triangles_of(spec) {
        for recipe in recipes {
            require_memory(device, recipe.builder, triangles)?;
        }
    }
    let options = global.scene_options();
    let scene = match scene::open(spec, &options) {
        Ok(scene) => scene,
        Err(e) => {
            // Who names a scene wants that one.
            let Some(instead) = e.instead().filter(|_| args.scenes.is_empty()) else { return Err(e.into()) };
            tracing::warn!("{e}");
            eprintln!("note: measuring {instead} instead of {spec}, which could not be fetched");
            scene::open(instead, &options)?
        }
    };
    let scene = args.transform.transform().apply(scene)?;
    let scene = Transform { translate: [by; 3], ..Transform::default() }.apply(scene)?;
    warn_of(&scene);
    Ok(scene)
}

/// The tables, and what they mean.
fn print(report: &Report, plan: &Plan) -> Result<()> {
    let header = report.header();
    let mut out = std::io::stdout().lock();
    let [width, height] = plan.size;
    writeln!(
        out,
        "{}, {}; boxwood {}; medians of at most {} runs, fewer where times settled",
        header.device, header.driver, header.commit, plan.runs
    )?;
    writeln!(
        out,
        "\nBuilds: bounds, Morton codes, sort, tree, leaves by cost, layout\n{}",
        report.build_table()
    )?;
    writeln!(
        out,
        "\nBoxes: shares and areas against the same tree with axis-aligned boxes; expected costs with (3, 4, 2) against (3, 2), of the tree and of its binary tree with the boxes of its nodes chosen one by one\n{}",
        report.volume_table()
    )?;
    if !plan.rays.is_empty() {
        let which = match plan.coverage {
            Coverage::All => "all of them".to_owned(),
            Coverage::Spans { count, rays } => {
                format!("a sample of at most {} from {count} parts of each picture", count * rays)
            }
        };
        writeln!(
            out,
            "\nRays: {} views of {width} × {height} primaries; 32 secondaries a hit, {which}\n{}",
            plan.views,
            report.ray_table()
        )?;
        let Costs { boxes, oriented, triangles } = header.costs;
        writeln!(
            out,
            "Cost: tests times what one takes here: a box {boxes:.2} ns, an oriented one {oriented:.2}, a triangle {triangles:.2}."
        )?;
        match plan.check {
            0 => writeln!(out, "Hits were not checked.")?,
            rays => writeln!(
                out,
                "Faults: hits of up to {rays} rays a set and view that the f64 reference contradicts; unsure: where rounding may be the reason."
            )?,
        }
    }
    if report.builds().iter().any(|b| b.excess().is_some()) || !report.images().is_empty() {
        writeln!(out, "\nErrors of hits, of a million, and of t, relative\n{}", report.error_table())?;
    }
    if !report.images().is_empty() {
        writeln!(
            out,
            "\nErrors of pictures against one of many more samples; pixels from 0 to 1\n{}",
            report.image_table()
        )?;
    }
    writeln!(
        out,
        "\nBuild time by kernel (one run with a stamp a kernel, which costs some)\n{}",
        report.kernel_table()
    )?;
    Ok(())
}

/// Shows the step, on a terminal.
fn bar(global: &Global, rows: usize) -> ProgressBar {
    let target = match global.progress() {
        Progress::Bars => ProgressDrawTarget::stderr(),
        Progress::Quiet => ProgressDrawTarget::hidden(),
    };
    let bar = ProgressBar::with_draw_target(Some(rows as u64), target);
    bar.enable_steady_tick(std::time::Duration::from_millis(250));
    match ProgressStyle::with_template("{spinner} {pos}/{len} rows {wide_msg} {elapsed}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
