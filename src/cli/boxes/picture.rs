//! A picture of boxes: translucent faces with lines for edges, layer upon layer, before a grey mesh. Both are traced as
//! any scene is; a layer is what a ray meets beyond the one before.

use super::shown::{Kind, Shown};
use crate::abi::{Hit, Ray};
use crate::bvh::{Bvh, FACES, PlacedBox, Recipe, SceneBuffers, build};
use crate::device::{Device, Timing};
use crate::picture::{LETTER, Picture, text_width};
use crate::scene::Scene;
use crate::trace::rays::{View, pixel_order, primary};
use crate::trace::{Batch, Options, Walk, trace};
use anyhow::Result;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Faces that a ray goes through at most.
const LAYERS: usize = 24;
/// Behind everything, and the mesh at its darkest and lightest; linear light.
const BACKGROUND: Vec3 = Vec3::splat(0.94);
const MESH: [Vec3; 2] = [Vec3::splat(0.16), Vec3::splat(0.78)];
/// How much a face hides: that is looked at from outside, and from within.
const FACE: [f32; 2] = [0.30, 0.10];
/// Likewise an edge.
const EDGE: [f32; 2] = [0.95, 0.40];
/// Half of an edge's width on a face, pixels; of a small face this share of its width.
const LINE: f64 = 0.8;
const LINE_SHARE: f64 = 0.12;
/// What is nearer than this share of the scene's diagonal is at the same place: tight boxes touch the mesh and each other.
const TOUCHING: f64 = 4e-6;

/// Rays a pixel, a side, of pictures of as many rays at most; larger ones have one a pixel.
const FINE: u32 = 2;
const FINE_RAYS: usize = 1 << 23;

/// What has gathered along a ray.
#[derive(Clone, Copy)]
struct Layers {
    light: Vec3,
    /// Share of what lies behind that is seen.
    open: f32,
}

/// Draws what `shown` has before `scene`, whose tree is `bvh`; a legend below.
pub(super) fn draw(
    device: &Arc<Device>,
    scene: &Scene,
    bvh: &Bvh,
    shown: &Shown,
    view: View,
) -> Result<Picture> {
    let fine = if view.pixels() * (FINE * FINE) as usize <= FINE_RAYS { FINE } else { 1 };
    let (width, height) = (view.width as usize, view.height as usize);
    let view = View { width: view.width * fine, height: view.height * fine, ..view };
    let mut batch = Batch::new(device, view.pixels(), false)?;
    primary(device, &view, &mut batch, Timing::Off)?;
    let options = Options { walk: Walk::untried(device, true), ..Options::default() };
    trace(device, bvh, &batch, options, Timing::Off)?;
    let (rays, hits) = (batch.rays.read()?, batch.hits.read()?);

    let surfaces = shown.scene();
    let touching = TOUCHING * diagonal(&surfaces);
    let pixel = view.axes()[1].length() * f64::from(fine);
    let painter = Painter { shown, surfaces, pixel, touching };
    let gathered = painter.layers(device, batch, &rays, &hits)?;

    let mut light = vec![Vec3::ZERO; width * height];
    let of_rays = rays.iter().zip(&hits).zip(&gathered);
    for (at, ((ray, hit), layers)) in pixel_order(view.width, view.height).into_iter().zip(of_rays) {
        let (x, y) = (at % view.width / fine, at / view.width / fine);
        let seen = layers.light + layers.open * behind(scene, ray, hit);
        light[y as usize * width + x as usize] += seen / (fine * fine) as f32;
    }
    Ok(with_legend(&Picture::of(width, &light), shown))
}

/// Of the box of a scene's vertices.
fn diagonal(scene: &Scene) -> f64 {
    let bounds = scene.bounds();
    let square: f64 = (0..3).map(|k| (f64::from(bounds.hi[k]) - f64::from(bounds.lo[k])).powi(2)).sum();
    if square.is_finite() { square.sqrt() } else { 0.0 }
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// The mesh as a lamp at the eye lights it, or nothing.
fn behind(scene: &Scene, ray: &Ray, hit: &Hit) -> Vec3 {
    if !hit.is_hit() {
        return BACKGROUND;
    }
    let [a, b, c] = scene.corners(hit.triangle as usize).map(wide);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    MESH[0].lerp(MESH[1], normal.dot(wide(ray.direction)).abs() as f32)
}

/// Knows the boxes and their colours.
struct Painter<'a> {
    shown: &'a Shown,
    /// The boxes, to be traced.
    surfaces: Scene,
    /// Width of a pixel at distance 1.
    pixel: f64,
    /// What is nearer is at the same place, scene units.
    touching: f64,
}

impl Painter<'_> {
    /// What the boxes before `hits` add to each of `rays`; `batch` has room for all of these.
    fn layers(
        &self,
        device: &Arc<Device>,
        mut batch: Batch,
        rays: &[Ray],
        hits: &[Hit],
    ) -> Result<Vec<Layers>> {
        let buffers = SceneBuffers::upload(device, &self.surfaces)?;
        let boxes = build(device, &buffers, &Recipe::default(), Timing::Off)?.bvh;
        let mut gathered = vec![Layers { light: Vec3::ZERO, open: 1.0 }; rays.len()];
        // Rays that may meet more boxes, with their numbers.
        let ends = rays.iter().zip(hits).map(|(ray, hit)| Ray { t_max: self.beyond(hit.t), ..*ray });
        let mut left: Vec<(usize, Ray)> = ends.enumerate().collect();
        for _ in 0..LAYERS {
            batch.set(&left.iter().map(|(_, ray)| *ray).collect::<Vec<_>>())?;
            let options = Options { walk: Walk::untried(device, true), ..Options::default() };
            trace(device, &boxes, &batch, options, Timing::Off)?;
            let met = left.into_iter().zip(batch.hits.read_first(batch.count)?);
            let go_on = |((i, ray), hit): ((usize, Ray), Hit)| {
                self.add(&mut gathered[i], &ray, &hit);
                let ray = Ray { t_min: self.beyond(hit.t), ..ray };
                (ray.t_min < ray.t_max).then_some((i, ray))
            };
            left = met.filter(|(_, hit)| hit.is_hit()).filter_map(go_on).collect();
            if left.is_empty() {
                break;
            }
        }
        Ok(gathered)
    }

    /// Where what is no longer at the place `t` of a ray begins.
    fn beyond(&self, t: f32) -> f32 {
        (f64::from(t) + self.touching.max(f64::from(t) * TOUCHING)) as f32
    }

    /// Puts the face that `hit` says behind what has gathered.
    fn add(&self, layers: &mut Layers, ray: &Ray, hit: &Hit) {
        let face = hit.triangle as usize / 2;
        let (number, face) = (face / FACES.len(), face % FACES.len());
        let placed = &self.shown.placed[number];
        // Neighbours in the tree get colours far apart: steps of the golden ratio.
        let share = (number as f64 * 0.618_033_988_749_895).fract() as f32;
        let color = self.shown.kind(number).color(share);
        let direction = wide(ray.direction);
        let axis = face / 2;
        let cosine = placed.axes[axis].dot(direction);
        // A face of a greatest plane looks along its axis; of a flat box one face hides the other.
        let away = (face % 2 == 0) == (cosine < 0.0);
        let within = usize::from(away && placed.size[axis] > self.touching);
        let line = self.edge(placed, axis, wide(ray.origin) + direction * f64::from(hit.t), direction, hit.t);
        let shade = 0.65 + 0.35 * cosine.abs() as f32;
        let mut put = |color: Vec3, alpha: f32| {
            layers.light += layers.open * alpha * color;
            layers.open *= 1.0 - alpha;
        };
        put(color * 0.45, EDGE[within] * line);
        put(color * shade, FACE[within]);
    }

    /// How much of the pixel around `point`, on the face across `axis`, an edge's line takes: 0 to 1.
    fn edge(&self, placed: &PlacedBox, axis: usize, point: DVec3, direction: DVec3, t: f32) -> f32 {
        let offset = point - placed.origin;
        let pixel = self.pixel * f64::from(t);
        let share = |k: usize| {
            // As long as one sees it.
            let along = placed.axes[k];
            let seen = (along - direction * along.dot(direction)).length() / pixel;
            let (width, at) = (placed.size[k] * seen, along.dot(offset) * seen);
            let half = LINE.min(LINE_SHARE * width);
            // A pixel takes in half a pixel to either side; lines below one pixel are fainter instead.
            let distance = at.min(width - at).max(0.0);
            (half + 0.5 - distance).clamp(0.0, 1.0).min(half / LINE)
        };
        share((axis + 1) % 3).max(share((axis + 2) % 3)) as f32
    }
}

/// `picture` with what it shows below it.
fn with_legend(picture: &Picture, shown: &Shown) -> Picture {
    let size = (picture.width / 480).max(1);
    let (margin, letter) = (8 * size, LETTER * size);
    let ink = Vec3::splat(0.02);
    let mut all = Picture::new(picture.width, picture.height + 2 * letter + 3 * margin, Vec3::splat(0.95));
    all.put(0, 0, picture);
    let (mut x, y) = (margin, picture.height + margin);
    all.write(&shown.title(), x, y, size, ink);
    let y = y + letter + margin;
    for kind in Kind::ALL {
        let text = format!("{} {}", shown.count(kind), kind.name());
        // Its colours side by side.
        let length = 6 * letter;
        for i in 0..length * letter {
            all.set(x + i % length, y + i / length, kind.color((i % length) as f32 / length as f32));
        }
        all.write(&text, x + length + margin, y, size, ink);
        x += length + 4 * margin + text_width(&text, size);
    }
    all
}
