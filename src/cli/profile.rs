//! `boxwood profile`: where the time goes, by kernel and on a timeline.

use super::Global;
use super::choices::{RecipeArgs, SceneArgs};
use super::files::{Output, json};
use super::render::ViewArgs;
use crate::bench::RayKind;
use crate::profile::{Plan, profile, timeline};
use anyhow::Result;
use std::io::Write;
use std::path::PathBuf;

/// Build a scene's tree, trace its rays, and tell by kernel what took how long: tables, and a timeline for Perfetto.
///
/// MB are those of all buffers that a kernel's arguments point to, each once: what it must move where it goes through all
/// of them, more than it does where it looks at a part. Of a traversal they are counted instead: nodes visited, triangles
/// tested, rays and hits. "% of copy" is against a buffer's copy on this device. A stamp behind every pass costs time, so
/// runs without them are timed in turn with those that have them.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Rays to trace: primary, ao, diffuse, shadow, several with commas between. Of all but primaries as many as there are
    /// pixels, from the middle of the picture on.
    #[arg(long, value_name = "KINDS", value_delimiter = ',', default_value = "primary,ao", value_parser = kind)]
    rays: Vec<RayKind>,
    #[command(flatten)]
    view: ViewArgs,
    /// Runs without and with a stamp a pass, each, after a warm-up; medians are told.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    runs: u32,
    /// Write the timeline to this file: Trace Event JSON, for ui.perfetto.dev or chrome://tracing.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write the figures to this file as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// A kind of rays by its name.
fn kind(text: &str) -> Result<RayKind, String> {
    RayKind::ALL
        .into_iter()
        .find(|kind| kind.name() == text)
        .ok_or_else(|| format!("there are {}", RayKind::ALL.map(RayKind::name).join(", ")))
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let out = args.out.as_deref().map(Output::new).transpose()?;
    let figures = args.json.as_deref().map(Output::new).transpose()?;
    let device = global.open_device()?;
    let recipe = args.recipe.recipe(global, &device)?;
    let scene = global.open_scene_for(&args.scene, &device, recipe.builder)?;
    let plan = Plan { recipe, rays: args.rays.clone(), view: args.view.of(&scene), runs: args.runs as usize };
    let profile = profile(&device, &scene, &plan)?;
    if let Some(out) = out {
        out.finish((serde_json::to_string(&timeline(&profile))? + "\n").as_bytes())?;
    }
    if let Some(figures) = figures {
        figures.finish(json(&profile)?.as_bytes())?;
    }
    write!(std::io::stdout().lock(), "{profile}")?;
    if let Some(path) = &args.out {
        global.remark(format_args!("timeline: {}, for ui.perfetto.dev", path.display()));
    }
    Ok(())
}
