//! `boxwood render`: pictures of a scene, and of what tracing it costs.

use super::choices::{PrecisionName, RecipeArgs, SceneArgs};
use super::files::Output;
use super::image::{Picture, heat_map};
use super::{Global, query};
use crate::abi::{Hit, Ray, Tests};
use crate::bvh::{Bvh, SceneBuffers, build};
use crate::device::{Device, Timing};
use crate::oracle::rays::surface_of;
use crate::scene::{Camera, Scene};
use crate::trace::rays::{
    MOST_SAMPLES, SAMPLES, SECONDARY_BATCH, Secondary, View, pixel_order, primary, secondary,
};
use crate::trace::{Batch, Options, Query, Walk, trace};
use anyhow::{Context, Result, bail};
use glam::{DVec3, Vec3};
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

/// What surfaces of no colour send back of the light that they get.
const ALBEDO: Vec3 = Vec3::splat(0.8);
/// The sky straight above, at the horizon, and what lies below it; linear light.
const ZENITH: Vec3 = Vec3::new(0.55, 0.72, 1.0);
const HORIZON: Vec3 = Vec3::new(0.95, 0.97, 1.0);
const GROUND: Vec3 = Vec3::new(0.30, 0.27, 0.24);
/// The lamp of `primary`, beside the sky's light.
const LAMP: Vec3 = Vec3::new(0.80, 0.75, 0.66);
/// Light on an open surface that faces the zenith is about 1: what `diffuse` is exposed for.
const EXPOSURE: f32 = 1.2;
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
    let scene = global.open_scene(&args.scene)?;
    let buffers = SceneBuffers::upload(&device, &scene)?;
    let recipe = args.recipe.recipe(global, &device)?;
    let bvh = build(&device, &buffers, &recipe, Timing::Off)?.bvh;
    let view = args.view.of(&scene);
    let studio = Studio::new(global, device, &scene, buffers, bvh, view, args)?;
    for ((mode, output), path) in modes.into_iter().zip(outputs).zip(&paths) {
        studio.take(mode, args)?.save(output)?;
        global.remark(path.display());
    }
    Ok(())
}

/// A scene with its primary rays traced.
struct Studio<'a> {
    global: &'a Global,
    device: Arc<Device>,
    scene: &'a Scene,
    buffers: SceneBuffers,
    bvh: Bvh,
    view: View,
    options: Options,
    primaries: Batch,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    /// The pixel of each ray.
    order: Vec<u32>,
    /// Upward on the picture's horizon.
    up: Vec3,
}

impl<'a> Studio<'a> {
    fn new(
        global: &'a Global,
        device: Arc<Device>,
        scene: &'a Scene,
        buffers: SceneBuffers,
        bvh: Bvh,
        view: View,
        args: &Args,
    ) -> Result<Self> {
        let options = Options { precision: args.precision.into(), ..Options::default() };
        let mut primaries = Batch::new(&device, view.pixels(), false)?;
        primary(&device, &view, &mut primaries, Timing::Off)?;
        trace(
            &device,
            &bvh,
            &primaries,
            Options { walk: Walk::untried(&device, true), ..options },
            Timing::Off,
        )?;
        let (rays, hits) = (primaries.rays.read()?, primaries.hits.read()?);
        let order = pixel_order(view.width, view.height);
        let up = Vec3::from(view.camera.up).normalize_or(Vec3::Y);
        Ok(Self { global, device, scene, buffers, bvh, view, options, primaries, rays, hits, order, up })
    }

    fn take(&self, mode: Mode, args: &Args) -> Result<Picture> {
        let ao = Secondary::ao(&self.scene.bounds());
        let light = match mode {
            Mode::Primary | Mode::All => self.shaded(),
            Mode::Ao => {
                let length = args.ao_length.unwrap_or(ao.length);
                // The share of open rays is the pixel's value as it stands, not light: the eye tells more shades apart.
                let shares =
                    self.gathered(&Secondary { samples: args.samples, length, ..ao }, |_| Vec3::ONE)?;
                self.over_background(&shares, |open, _| Vec3::powf(open, 2.2))
            }
            Mode::Diffuse => {
                let kind = Secondary { samples: args.samples, ..Secondary::diffuse() };
                let means = self.gathered(&kind, |d| self.sky(d) * EXPOSURE)?;
                self.over_background(&means, |light, hit| light * self.albedo(hit))
            }
            Mode::Heat => return self.heat(),
        };
        Ok(Picture::of(self.view.width as usize, &self.on_pixels(&light)))
    }

    /// What is told a ray, a pixel.
    fn on_pixels<T: Copy + Default>(&self, of_rays: &[T]) -> Vec<T> {
        let mut pixels = vec![T::default(); of_rays.len()];
        for (pixel, value) in self.order.iter().zip(of_rays) {
            pixels[*pixel as usize] = *value;
        }
        pixels
    }

    /// Light from direction `d`.
    fn sky(&self, d: Vec3) -> Vec3 {
        let height = d.dot(self.up);
        if height >= 0.0 {
            HORIZON.lerp(ZENITH, height.sqrt())
        } else {
            HORIZON.lerp(GROUND, (-height * 6.0).min(1.0).sqrt())
        }
    }

    /// What a primary that misses shows: the sky, paler than it lights, so that things stand out.
    fn background(&self, ray: &Ray) -> Vec3 {
        let height = Vec3::from(ray.direction).dot(self.up);
        Vec3::splat(0.72).lerp(Vec3::new(0.30, 0.42, 0.62), (height * 0.5 + 0.5).clamp(0.0, 1.0))
    }

    /// A lamp over the viewer's left shoulder, and the sky: lighter where a surface faces up.
    fn shaded(&self) -> Vec<Vec3> {
        let [corner, across, down] = self.view.axes();
        let forward =
            corner + (across * f64::from(self.view.width) + down * f64::from(self.view.height)) / 2.0;
        let (left, above) = (-across.normalize_or_zero(), -down.normalize_or_zero());
        let lamp = (left * 0.35 + above * 0.9 - forward.normalize_or_zero() * 0.45).normalize().as_vec3();
        let of_ray = |(ray, hit): (&Ray, &Hit)| {
            if !hit.is_hit() {
                return self.background(ray);
            }
            let [a, b, c] =
                self.scene.corners(hit.triangle as usize).map(|p| DVec3::from_array(p.map(f64::from)));
            let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
            let normal = if normal.dot(Vec3::from(ray.direction)) > 0.0 { -normal } else { normal };
            let open = 0.5 + 0.5 * normal.dot(self.up);
            (GROUND.lerp(ZENITH * 0.7, open) * 0.45 + LAMP * normal.dot(lamp).max(0.0)) * self.albedo(hit)
        };
        self.rays.iter().zip(&self.hits).map(of_ray).collect()
    }

    /// The base colour of what was hit, as albedo.
    fn albedo(&self, hit: &Hit) -> Vec3 {
        self.scene.materials.color(hit.triangle as usize).map_or(ALBEDO, Vec3::from)
    }

    /// Means of secondary rays as light; the background where a primary met nothing.
    fn over_background(&self, means: &[Option<Vec3>], light: impl Fn(Vec3, &Hit) -> Vec3) -> Vec<Vec3> {
        let of_ray = |((ray, hit), mean): ((&Ray, &Hit), &Option<Vec3>)| {
            mean.map_or_else(|| self.background(ray), |mean| light(mean, hit))
        };
        self.rays.iter().zip(&self.hits).zip(means).map(of_ray).collect()
    }

    /// The mean of what secondary rays bring that meet nothing; none where a primary met no surface.
    fn gathered(&self, kind: &Secondary, bring: impl Fn(Vec3) -> Vec3) -> Result<Vec<Option<Vec3>>> {
        let mut means = vec![None; self.rays.len()];
        let has_surface = |i: &usize| surface_of(self.scene, &self.rays[*i], &self.hits[*i], *i).is_some();
        let mut open = (0..self.hits.len()).filter(has_surface);
        let samples = kind.samples as usize;
        let mut batch = Batch::new(&self.device, SECONDARY_BATCH, false)?;
        let options = Options { query: kind.query(), ..self.options };
        let bar = query::bar(self.global, self.hits.len());
        let mut start = 0;
        while start < self.hits.len() {
            let (taken, _) = secondary(
                &self.device,
                &self.buffers,
                &self.primaries,
                kind,
                start,
                &mut batch,
                Timing::Off,
            )?;
            trace(&self.device, &self.bvh, &batch, options, Timing::Off)?;
            let rays = batch.rays.read_first(batch.count)?;
            let hits = batch.hits.read_first(batch.count)?;
            for (rays, hits) in rays.chunks_exact(samples).zip(hits.chunks_exact(samples)) {
                let Some(i) = open.next() else {
                    bail!("rays/surface: the device finds more surfaces than its twin")
                };
                let free = rays.iter().zip(hits).filter(|(_, hit)| !hit.is_hit());
                let sum: Vec3 = free.map(|(ray, _)| bring(Vec3::from(ray.direction))).sum();
                means[i] = Some(sum / samples as f32);
            }
            start += taken;
            bar.inc(taken as u64);
        }
        bar.finish_and_clear();
        if open.next().is_some() {
            bail!("rays/surface: the device finds fewer surfaces than its twin");
        }
        Ok(means)
    }

    /// Tests of each primary ray by itself, not by packets: boxes at the left, triangles at the right.
    fn heat(&self) -> Result<Picture> {
        let mut counted = Batch::new(&self.device, self.rays.len(), true)?;
        counted.set(&self.rays)?;
        let options = Options { query: Query::Closest, ..self.options };
        trace(&self.device, &self.bvh, &counted, options, Timing::Off)?;
        let Some(tests) = &counted.tests else { bail!("the batch has no room for counts") };
        let tests = self.on_pixels(
            &tests.read()?.iter().map(|t: &Tests| [t.boxes + t.oriented, t.triangles]).collect::<Vec<_>>(),
        );
        let width = self.view.width as usize;
        let map = |which: usize, unit: &str| {
            heat_map(width, &tests.iter().map(|t| t[which]).collect::<Vec<_>>(), unit)
        };
        let (boxes, triangles) = (map(0, "box tests a ray"), map(1, "triangle tests a ray"));
        let gap = 4;
        let height = boxes.height.max(triangles.height);
        let mut both = Picture::new(2 * width + gap, height, Vec3::splat(0.008));
        both.put(0, 0, &boxes);
        both.put(width + gap, 0, &triangles);
        Ok(both)
    }
}
