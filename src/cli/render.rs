//! `boxwood render`: pictures of a scene, and of what tracing it costs.

use super::choices::{PrecisionName, RecipeArgs, SceneArgs};
use super::files::Output;
use super::{Global, query};
use crate::abi::Tests;
use crate::bvh::{SceneBuffers, build};
use crate::device::Timing;
use crate::picture::{Picture, Studio, Subject, heat_map, scale_end};
use crate::scene::{Camera, Scene};
use crate::trace::rays::{MOST_SAMPLES, SAMPLES, Secondary, View};
use anyhow::{Context, Result, bail};
use glam::Vec3;
use std::fs;
use std::path::PathBuf;

/// Pixels a side at most.
const LARGEST: i64 = 16384;

/// Which picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Mode {
    /// Primary rays, shaded by a lamp and the sky.
    Primary,
    /// Ambient occlusion: how much of what is near leaves a point open.
    Ao,
    /// Light of the sky that reaches a point, past all that stands between.
    Diffuse,
    /// Box tests and triangle tests of each primary ray.
    Heat,
    /// All of these; `--out` is a folder.
    All,
}

impl Mode {
    const EACH: [Self; 4] = [Self::Primary, Self::Ao, Self::Diffuse, Self::Heat];

    fn file(self) -> &'static str {
        match self {
            Self::Primary => "primary.png",
            Self::Ao => "ao.png",
            Self::Diffuse => "diffuse.png",
            Self::Heat => "heat.png",
            Self::All => "",
        }
    }
}

/// Take pictures of a scene: shaded, ambient occlusion, diffuse light, or what each ray cost.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// A .png file, or a folder that gets primary.png, ao.png, diffuse.png, heat.png.
    #[arg(long, value_name = "PNG|DIR")]
    out: PathBuf,
    /// Which picture.
    #[arg(long, value_enum, default_value_t = Mode::Primary)]
    mode: Mode,
    #[command(flatten)]
    view: ViewArgs,
    /// Rays a hit, of `ao` and `diffuse`.
    #[arg(long, value_name = "N", default_value_t = SAMPLES, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SAMPLES)))]
    samples: u32,
    /// Length of ambient-occlusion rays, scene units. Default: 5 % of the diagonal of the scene's box.
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    ao_length: Option<f32>,
    /// Triangle test.
    #[arg(long, value_enum, default_value_t = PrecisionName::Robust)]
    precision: PrecisionName,
    #[command(flatten)]
    recipe: RecipeArgs,
}

/// What a picture is taken of, and how large it is.
#[derive(Debug, clap::Args)]
pub(super) struct ViewArgs {
    /// Which of the scene's five views.
    #[arg(long, value_name = "1-5", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=5))]
    view: u32,
    /// Five views of the whole scene from outside, instead of its own.
    #[arg(long)]
    around: bool,
    /// Pixels in a row.
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=LARGEST))]
    width: u32,
    /// Rows.
    #[arg(long, value_name = "N", default_value_t = 768, value_parser = clap::value_parser!(u32).range(1..=LARGEST))]
    height: u32,
}

impl ViewArgs {
    /// The same for the library.
    pub(super) fn of(&self, scene: &Scene) -> View {
        let Self { view, around, width, height } = *self;
        let views = if around { Camera::five_for(&scene.bounds()) } else { scene.views_or_default() };
        View { camera: views[view as usize - 1], width, height }
    }
}

/// A length above 0; may be `inf`.
fn length(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|x: &f32| *x > 0.0).ok_or_else(|| "write a number above 0, or inf".into())
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let single = args.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) && !args.out.is_dir();
    let modes = if args.mode == Mode::All { Mode::EACH.to_vec() } else { vec![args.mode] };
    if single && modes.len() > 1 {
        bail!("--mode all makes {} pictures; give --out a folder, not {}", modes.len(), args.out.display());
    }
    if !single {
        fs::create_dir_all(&args.out)
            .with_context(|| format!("can't make the folder {}", args.out.display()))?;
    }
    let path = |mode: Mode| if single { args.out.clone() } else { args.out.join(mode.file()) };
    let paths: Vec<PathBuf> = modes.iter().map(|m| path(*m)).collect();
    let outputs = paths.iter().map(|p| Output::new(p)).collect::<Result<Vec<_>>>()?;

    let device = global.open_device()?;
    let recipe = args.recipe.recipe(global, &device)?;
    let scene = global.open_scene_for(&args.scene, &device, recipe.builder)?;
    let buffers = SceneBuffers::upload(&device, &scene)?;
    let bvh = build(&device, &buffers, &recipe, Timing::Off)?.bvh;
    let view = args.view.of(&scene);
    let subject = Subject { device: &device, scene: &scene, buffers: &buffers, bvh: &bvh };
    let studio = Studio::new(subject, view, args.precision.into())?;
    for ((mode, output), path) in modes.into_iter().zip(outputs).zip(&paths) {
        output.finish(&taken(global, &studio, subject, view, mode, args)?.png()?)?;
        global.remark(path.display());
    }
    Ok(())
}

/// The picture of a mode.
fn taken(
    global: &Global,
    studio: &Studio,
    subject: Subject,
    view: View,
    mode: Mode,
    args: &Args,
) -> Result<Picture> {
    let bar = query::bar(global, view.pixels());
    let progress = |rays| bar.inc(rays as u64);
    let picture = match mode {
        Mode::Primary | Mode::All => studio.shaded(),
        Mode::Ao => {
            let ao = Secondary::ao(&subject.scene.bounds());
            let length = args.ao_length.unwrap_or(ao.length);
            studio.ambient(&Secondary { samples: args.samples, length, ..ao }, &progress)?
        }
        Mode::Diffuse => {
            studio.diffuse(&Secondary { samples: args.samples, ..Secondary::diffuse() }, &progress)?
        }
        Mode::Heat => heat(view.width as usize, &studio.tests(subject.bvh)?),
    };
    bar.finish_and_clear();
    Ok(picture)
}

/// Maps of boxes, at the left, and of triangles that each pixel's ray tests.
fn heat(width: usize, tests: &[Tests]) -> Picture {
    let map = |count: fn(&Tests) -> u32, unit: &str| {
        let counts: Vec<f32> = tests.iter().map(|t| count(t) as f32).collect();
        heat_map(width, &counts, unit, scale_end(&counts))
    };
    let boxes = map(|t| t.boxes + t.oriented, "box tests a ray");
    let triangles = map(|t| t.triangles, "triangle tests a ray");
    let gap = 4;
    let height = boxes.height.max(triangles.height);
    let mut both = Picture::new(2 * width + gap, height, Vec3::splat(0.008));
    both.put(0, 0, &boxes);
    both.put(width + gap, 0, &triangles);
    both
}
