//! Pictures of a scene through a tree: shaded, ambient occlusion, light of the sky, what rays cost.

use super::{Picture, PictureError, Result};
use crate::abi::{Hit, Ray, Tests};
use crate::bvh::{Bvh, SceneBuffers};
use crate::device::{Device, Timing};
use crate::oracle::rays::surface_of;
use crate::scene::Scene;
use crate::trace::rays::{SECONDARY_BATCH, Secondary, View, pixel_order, primary, secondary};
use crate::trace::{Batch, Options, Precision, Walk, trace};
use glam::{DVec3, Vec3};
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
/// Is told how many primaries of all are done with.
pub(crate) type Progress<'a> = &'a dyn Fn(usize);

/// What is looked at, and through what.
#[derive(Clone, Copy)]
pub(crate) struct Subject<'a> {
    pub(crate) device: &'a Arc<Device>,
    pub(crate) scene: &'a Scene,
    pub(crate) buffers: &'a SceneBuffers,
    pub(crate) bvh: &'a Bvh,
}

/// A scene with its primary rays traced.
pub(crate) struct Studio<'a> {
    subject: Subject<'a>,
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

/// What secondary rays bring.
pub(crate) struct Gathered {
    /// Of each primary the mean over its secondary rays; none where it met no surface.
    pub(crate) means: Vec<Option<Vec3>>,
    /// Device time of tracing them, ms.
    pub(crate) trace_ms: f64,
}

impl<'a> Studio<'a> {
    pub(crate) fn new(subject: Subject<'a>, view: View, precision: Precision) -> Result<Self> {
        let Subject { device, bvh, .. } = subject;
        let options = Options { precision, ..Options::default() };
        let mut primaries = Batch::new(device, view.pixels(), false)?;
        primary(device, &view, &mut primaries, Timing::Off)?;
        let together = Options { walk: Walk::untried(device, true), ..options };
        trace(device, bvh, &primaries, together, Timing::Off)?;
        let (rays, hits) = (primaries.rays.read()?, primaries.hits.read()?);
        let order = pixel_order(view.width, view.height);
        let up = Vec3::from(view.camera.up).normalize_or(Vec3::Y);
        Ok(Self { subject, view, options, primaries, rays, hits, order, up })
    }

    /// Primary rays, shaded by a lamp and the sky.
    pub(crate) fn shaded(&self) -> Picture {
        self.picture(&self.shading())
    }

    /// How much of what is within the rays' length leaves a point open.
    pub(crate) fn ambient(&self, kind: &Secondary, progress: Progress) -> Result<Picture> {
        let shares = self.gathered(kind, |_| Vec3::ONE, progress)?.means;
        // The share of open rays is the pixel's value as it stands, not light: the eye tells more shades apart.
        Ok(self.picture(&self.over_background(&shares, |open, _| Vec3::powf(open, 2.2))))
    }

    /// Light of the sky that reaches a point.
    pub(crate) fn diffuse(&self, kind: &Secondary, progress: Progress) -> Result<Picture> {
        let means = self.gathered(kind, |d| self.sky(d) * EXPOSURE, progress)?.means;
        Ok(self.picture(&self.over_background(&means, |light, hit| light * self.albedo(hit))))
    }

    /// Tests of each pixel's primary ray by itself, not by packets, through `bvh`, a tree of the same scene.
    pub(crate) fn tests(&self, bvh: &Bvh) -> Result<Vec<Tests>> {
        let device = self.subject.device;
        let mut counted = Batch::new(device, self.rays.len(), true)?;
        counted.set(&self.rays)?;
        trace(device, bvh, &counted, self.options, Timing::Off)?;
        let tests = counted.tests.as_ref().map_or(Ok(vec![]), |tests| tests.read())?;
        Ok(self.on_pixels(&tests))
    }

    fn picture(&self, of_rays: &[Vec3]) -> Picture {
        Picture::of(self.view.width as usize, &self.on_pixels(of_rays))
    }

    /// What is told a ray, a pixel.
    fn on_pixels<T: Copy>(&self, of_rays: &[T]) -> Vec<T> {
        let mut ray = vec![0; self.order.len()];
        for (i, pixel) in self.order.iter().enumerate() {
            ray[*pixel as usize] = i;
        }
        ray.into_iter().map(|i| of_rays[i]).collect()
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
    fn shading(&self) -> Vec<Vec3> {
        let [corner, across, down] = self.view.axes();
        let forward =
            corner + (across * f64::from(self.view.width) + down * f64::from(self.view.height)) / 2.0;
        let (left, above) = (-across.normalize_or_zero(), -down.normalize_or_zero());
        let lamp = (left * 0.35 + above * 0.9 - forward.normalize_or_zero() * 0.45).normalize().as_vec3();
        let of_ray = |(ray, hit): (&Ray, &Hit)| {
            if !hit.is_hit() {
                return self.background(ray);
            }
            let [a, b, c] = self
                .subject
                .scene
                .corners(hit.triangle as usize)
                .map(|p| DVec3::from_array(p.map(f64::from)));
            let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
            let normal = if normal.dot(Vec3::from(ray.direction)) > 0.0 { -normal } else { normal };
            let open = 0.5 + 0.5 * normal.dot(self.up);
            (GROUND.lerp(ZENITH * 0.7, open) * 0.45 + LAMP * normal.dot(lamp).max(0.0)) * self.albedo(hit)
        };
        self.rays.iter().zip(&self.hits).map(of_ray).collect()
    }

    /// The base colour of what was hit, as albedo.
    fn albedo(&self, hit: &Hit) -> Vec3 {
        self.subject.scene.materials.color(hit.triangle as usize).map_or(ALBEDO, Vec3::from)
    }

    /// Means of secondary rays as light; the background where a primary met nothing.
    fn over_background(&self, means: &[Option<Vec3>], light: impl Fn(Vec3, &Hit) -> Vec3) -> Vec<Vec3> {
        let of_ray = |((ray, hit), mean): ((&Ray, &Hit), &Option<Vec3>)| {
            mean.map_or_else(|| self.background(ray), |mean| light(mean, hit))
        };
        self.rays.iter().zip(&self.hits).zip(means).map(of_ray).collect()
    }

    /// The mean of what `bring` says that secondary rays of `kind` bring from where they go, those that meet nothing.
    pub(crate) fn gathered(
        &self,
        kind: &Secondary,
        bring: impl Fn(Vec3) -> Vec3,
        progress: Progress,
    ) -> Result<Gathered> {
        let Subject { device, scene, buffers, bvh } = self.subject;
        let mut found = Gathered { means: vec![None; self.rays.len()], trace_ms: 0.0 };
        let has_surface = |i: &usize| surface_of(scene, &self.rays[*i], &self.hits[*i], *i).is_some();
        let mut open = (0..self.hits.len()).filter(has_surface);
        let samples = kind.samples as usize;
        let mut batch = Batch::new(device, SECONDARY_BATCH, false)?;
        let options = Options { query: kind.query(), ..self.options };
        let mut start = 0;
        while start < self.hits.len() {
            let (taken, _) =
                secondary(device, buffers, &self.primaries, kind, start, &mut batch, Timing::Off)?;
            if batch.count > 0 {
                found.trace_ms += trace(device, bvh, &batch, options, Timing::Outer)?.device_ms;
            }
            let rays = batch.rays.read_first(batch.count)?;
            let hits = batch.hits.read_first(batch.count)?;
            for (rays, hits) in rays.chunks_exact(samples).zip(hits.chunks_exact(samples)) {
                let Some(i) = open.next() else { return Err(PictureError::Surfaces("more")) };
                let free = rays.iter().zip(hits).filter(|(_, hit)| !hit.is_hit());
                let sum: Vec3 = free.map(|(ray, _)| bring(Vec3::from(ray.direction))).sum();
                found.means[i] = Some(sum / samples as f32);
            }
            start += taken;
            progress(taken);
        }
        match open.next() {
            Some(_) => Err(PictureError::Surfaces("fewer")),
            None => Ok(found),
        }
    }
}
