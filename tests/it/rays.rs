//! Rays made on the device against their twin, and what must hold of any of them.

#![allow(clippy::unwrap_used)]

use crate::gpu::{gpu, quiet, quiet_on};
use crate::matrix::{each_width, gpu_shaped};
use boxwood::abi::{Hit, Ray};
use boxwood::bvh::{Bvh, Recipe, SceneBuffers, build};
use boxwood::device::{Device, Timing};
use boxwood::oracle::rays as twin;
use boxwood::oracle::reference::Reference;
use boxwood::scene::{self, Camera, Progress, Scene};
use boxwood::trace::rays::{Aimed, Light, Sampler, Secondary, View, pixel_order, primary, secondary};
use boxwood::trace::{Batch, Options, Query, trace};
use glam::{DVec3, Vec3};
use std::sync::Arc;

fn generated(spec: &str) -> Scene {
    scene::open(spec, &scene::Options { progress: Progress::Quiet, cache: None }).unwrap()
}

/// A scene, its tree, and rays that look at it.
pub struct Stage {
    pub scene: Scene,
    buffers: SceneBuffers,
    pub bvh: Bvh,
}

impl Stage {
    pub fn new(device: &Arc<Device>, scene: Scene) -> Self {
        Self::by(device, scene, &Recipe::default())
    }

    pub fn by(device: &Arc<Device>, scene: Scene, recipe: &Recipe) -> Self {
        let buffers = SceneBuffers::upload(device, &scene).unwrap();
        let bvh = build(device, &buffers, recipe, Timing::Off).unwrap().bvh;
        Self { scene, buffers, bvh }
    }

    /// Primary rays, traced.
    pub fn look(&self, device: &Arc<Device>, view: &View) -> Batch {
        let mut batch = Batch::new(device, view.pixels(), false).unwrap();
        primary(device, view, &mut batch, Timing::Off).unwrap();
        trace(device, &self.bvh, &batch, Options::default(), Timing::Off).unwrap();
        batch
    }

    /// All secondary rays, in batches of `capacity`; each batch must take at least a primary.
    pub fn spawn(
        &self,
        device: &Arc<Device>,
        primaries: &Batch,
        kind: &Secondary,
        capacity: usize,
    ) -> Vec<Ray> {
        let mut out = Batch::new(device, capacity, false).unwrap();
        let (mut start, mut rays) = (0, vec![]);
        while start < primaries.count {
            let (taken, _) =
                secondary(device, &self.buffers, primaries, kind, start, &mut out, Timing::Off).unwrap();
            assert!(taken > 0, "primary {start} was not taken");
            assert!(out.count <= capacity);
            start += taken;
            rays.extend(out.rays.read_first(out.count).unwrap());
        }
        assert_eq!(start, primaries.count);
        rays
    }

    pub fn hits(&self, device: &Arc<Device>, rays: &[Ray]) -> Vec<Hit> {
        let mut batch = Batch::new(device, rays.len(), false).unwrap();
        batch.set(rays).unwrap();
        trace(device, &self.bvh, &batch, Options { query: Query::Any, ..Options::default() }, Timing::Off)
            .unwrap();
        batch.hits.read().unwrap()
    }
}

fn bits(rays: &[Ray]) -> &[[u32; 8]] {
    bytemuck::cast_slice(rays)
}

#[test]
fn pixel_order_is_its_twin() {
    for (width, height) in [(0, 0), (1, 1), (8, 8), (16, 8), (31, 17), (3, 40), (40, 3), (136, 72)] {
        assert_eq!(pixel_order(width, height), twin::pixel_order(width, height), "{width} × {height}");
    }
}

#[test]
fn primary_rays_are_their_twins() {
    let device = quiet();
    let camera = Camera { eye: [3.0, 2.0, 5.0], target: [0.1, -0.2, 0.3], up: [0.1, 1.0, 0.0], fov_y: 55.0 };
    for (width, height) in [(1, 1), (5, 3), (8, 8), (37, 21), (100, 75)] {
        let view = View { camera, width, height };
        let mut batch = Batch::new(&device, view.pixels() + 3, false).unwrap();
        primary(&device, &view, &mut batch, Timing::Off).unwrap();
        assert_eq!(batch.count, view.pixels());
        let rays = batch.rays.read_first(batch.count).unwrap();
        for (i, (ray, truth)) in rays.iter().zip(&twin::primary(&view)).enumerate() {
            let direction = Vec3::from(ray.direction);
            assert_eq!((ray.origin, ray.t_min, ray.t_max), (truth.origin, 0.0, f32::INFINITY));
            let gap = direction.distance(Vec3::from(truth.direction));
            assert!(gap < 1e-6, "{width} × {height}, ray {i}: {gap:e} off {:?}", truth.direction);
            assert!((direction.length() - 1.0).abs() < 1e-6, "ray {i} is not a unit vector: {direction}");
        }
    }
}

#[test]
fn a_view_must_fit_its_batch() {
    let device = quiet();
    let view = View { camera: generated("sphere:20").view(), width: 10, height: 10 };
    let mut batch = Batch::new(&device, 99, false).unwrap();
    let error = primary(&device, &view, &mut batch, Timing::Off).unwrap_err();
    assert!(error.to_string().contains("100"), "{error}");
}

#[test]
fn secondary_rays_are_their_twins() {
    let device = quiet();
    let stage = Stage::new(&device, generated("sphere:2k"));
    let view = View { camera: stage.scene.view(), width: 61, height: 45 };
    let primaries = stage.look(&device, &view);
    let rays = primaries.rays.read_first(primaries.count).unwrap();
    let hits = primaries.hits.read_first(primaries.count).unwrap();
    let met = hits.iter().filter(|h| h.is_hit()).count();
    assert!(met > 500 && met < hits.len() - 500, "{met} of {} primaries hit", hits.len());
    let ao = Secondary::ao(&stage.scene.bounds());
    let random = Secondary { samples: 9, sampler: Sampler::Random(3), ..ao };
    let later = Secondary { samples: 5, sampler: Sampler::Halton(8192), ..ao };
    let few = [1, 7].map(|samples| Secondary { samples, ..ao });
    for kind in [ao, Secondary::diffuse(), few[0], few[1], random, later] {
        let samples = kind.samples as usize;
        for capacity in [met * samples + 5, met * samples, 3000, samples] {
            if capacity == samples && samples != 32 {
                continue; // a batch a hit: once will do
            }
            let made = stage.spawn(&device, &primaries, &kind, capacity);
            let (taken, truth) = twin::secondary(&stage.scene, &rays, &hits, &kind, 0, usize::MAX);
            assert_eq!((taken, made.len()), (hits.len(), met * samples), "{kind:?}, capacity {capacity}");
            for (i, (m, t)) in bits(&made).iter().zip(bits(&truth)).enumerate() {
                assert_eq!(m, t, "{kind:?}, capacity {capacity}, ray {i}: {:?}, not {:?}", made[i], truth[i]);
            }
        }
    }
    // A batch stops where the twin's stops.
    let mut out = Batch::new(&device, 320, false).unwrap();
    let (taken, _) = secondary(&device, &stage.buffers, &primaries, &ao, 700, &mut out, Timing::Off).unwrap();
    let (truth, made) = twin::secondary(&stage.scene, &rays, &hits, &ao, 700, 320);
    assert_eq!((taken, out.count), (truth, made.len()));
}

#[test]
fn secondary_rays_follow_the_cosine() {
    let device = quiet();
    let stage = Stage::new(&device, generated("sphere:2k"));
    let view = View { camera: stage.scene.view(), width: 96, height: 96 };
    let primaries = stage.look(&device, &view);
    let seen = primaries.rays.read().unwrap();
    let hits = primaries.hits.read().unwrap();
    let rays = stage.spawn(&device, &primaries, &Secondary::diffuse(), 1 << 20);
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let normals: Vec<DVec3> = (0..hits.len())
        .filter(|&i| hits[i].is_hit())
        .map(|i| {
            let [a, b, c] = stage.scene.corners(hits[i].triangle as usize).map(wide);
            let n = (b - a).cross(c - a).normalize();
            -n * n.dot(wide(seen[i].direction)).signum()
        })
        .collect();
    let mut squares = vec![];
    let mut sum = 0.0;
    for (i, ray) in rays.iter().enumerate() {
        let d = wide(ray.direction);
        assert!((d.length() - 1.0).abs() < 2e-6, "ray {i}: length {}", d.length());
        let z = d.dot(normals[i / 32]);
        assert!(z > 0.0, "ray {i} leaves below its triangle: {z:e}");
        sum += z;
        squares.push(1.0 - z * z);
    }
    let mean = sum / rays.len() as f64;
    assert!((mean * 1.5 - 1.0).abs() < 0.01, "mean z {mean}");
    squares.sort_by(f64::total_cmp);
    for share in [0.25, 0.5, 0.75] {
        let square = squares[(share * squares.len() as f64) as usize];
        assert!((square - share).abs() < 0.01, "quantile {share} of r²: {square}");
    }
    // Azimuths: no side is favoured.
    let mean: DVec3 = rays.iter().enumerate().map(|(i, r)| wide(r.direction) - normals[i / 32] / 1.5).sum();
    assert!(mean.length() / (rays.len() as f64) < 0.01, "{mean}");
}

/// Lights around `scene`: a small one, one within it, one far off, a large one.
fn lights(scene: &Scene) -> [Light; 4] {
    let [mut within, mut far, small, mut large] = Light::above(&scene.bounds());
    within.position = [0.1, 0.0, -0.1];
    far.position = far.position.map(|x| x * 1e4);
    large.radius = 0.7;
    [Light { radius: 1e-3, ..small }, within, far, large]
}

#[test]
fn shadow_rays_are_their_twins() {
    for device in [gpu, gpu_shaped] {
        let device = quiet_on(device);
        let stage = Stage::new(&device, generated("city:2k"));
        let primaries = stage.look(&device, &View { camera: stage.scene.view(), width: 61, height: 45 });
        let rays = primaries.rays.read_first(primaries.count).unwrap();
        let hits = primaries.hits.read_first(primaries.count).unwrap();
        let met = hits.iter().filter(|h| h.is_hit()).count();
        let all = Secondary::shadow(lights(&stage.scene));
        for kind in [all, Secondary { samples: 1, ..all }, Secondary { samples: 9, length: 0.5, ..all }] {
            let most = met * kind.samples as usize;
            let (_, truth) = twin::secondary(&stage.scene, &rays, &hits, &kind, 0, usize::MAX);
            assert!(truth.len() > most / 9 && truth.len() < most, "{} of {most}", truth.len());
            for capacity in [most + 5, most, 700] {
                let made = stage.spawn(&device, &primaries, &kind, capacity);
                assert_eq!(bits(&made), bits(&truth), "{kind:?}, capacity {capacity}");
            }
        }
        let mut out = Batch::new(&device, 402, false).unwrap();
        let (taken, _) =
            secondary(&device, &stage.buffers, &primaries, &all, 700, &mut out, Timing::Off).unwrap();
        let (truth, made) = twin::secondary(&stage.scene, &rays, &hits, &all, 700, 402);
        assert_eq!((taken, out.count), (truth, made.len()), "a batch stops where the twin's stops");
    }
}

#[test]
fn shadow_rays_reach_their_lights() {
    let device = quiet();
    let stage = Stage::new(&device, octahedron(Vec3::ZERO, Vec3::ONE));
    let primaries = stage.look(&device, &View { camera: stage.scene.view(), width: 60, height: 45 });
    for radius in [0.0, 0.25] {
        let lights = Light::above(&stage.scene.bounds()).map(|l| Light { radius, ..l });
        let kind = Secondary { samples: 64, ..Secondary::shadow(lights) };
        let rays = stage.spawn(&device, &primaries, &kind, 1 << 20);
        assert!(rays.len() > 1000, "{}", rays.len());
        let mut met = [0; 4];
        for ray in &rays {
            assert_eq!((ray.t_min, ray.t_max), (0.0, 1.0));
            let end = Vec3::from(ray.origin) + Vec3::from(ray.direction);
            let off = lights.map(|l| (end.distance(Vec3::from(l.position)) - radius).abs());
            let light = (0..4).find(|i| off[*i] < 1e-5);
            met[light.unwrap_or_else(|| panic!("{ray:?} ends {off:?} off the lights"))] += 1;
        }
        assert!(met.iter().filter(|n| **n > 0).count() >= 3, "one may see the back only: {met:?}");
        // A convex body shades no side that faces the light.
        let shaded = stage.hits(&device, &rays).iter().filter(|h| h.is_hit()).count();
        assert_eq!(shaded, 0, "of {}, radius {radius}", rays.len());
    }
}

#[test]
fn no_shadow_rays_to_lights_behind() {
    let device = quiet();
    let stage = Stage::new(&device, octahedron(Vec3::ZERO, Vec3::ONE));
    let view = View { camera: stage.scene.view(), width: 60, height: 45 };
    let primaries = stage.look(&device, &view);
    let away: [f32; 3] = std::array::from_fn(|k| -20.0 * view.camera.eye[k]);
    let kind = Secondary::shadow([Light { position: away, radius: 0.0 }; 4]);
    let mut out = Batch::new(&device, 4 * view.pixels(), false).unwrap();
    let (taken, _) = secondary(&device, &stage.buffers, &primaries, &kind, 0, &mut out, Timing::Off).unwrap();
    let rays = primaries.rays.read().unwrap();
    let hits = primaries.hits.read().unwrap();
    let met = hits.iter().filter(|h| h.is_hit()).count();
    assert_eq!(taken, view.pixels());
    // Sides at a slant may be seen by both.
    assert!(out.count < met, "{} rays from {met} hits", out.count);
    let (_, truth) = twin::secondary(&stage.scene, &rays, &hits, &kind, 0, usize::MAX);
    assert_eq!(bits(&out.rays.read_first(out.count).unwrap()), bits(&truth));
}

#[test]
fn no_ray_escapes_a_closed_sphere() {
    let device = quiet();
    let stage = Stage::new(&device, generated("sphere:20k"));
    let b = stage.scene.bounds();
    let eye: [f32; 3] = std::array::from_fn(|k| (b.lo[k] + b.hi[k]) / 2.0);
    for target in [[1.0, 0.2, 0.1], [-0.3, -1.0, 0.4]] {
        let camera = Camera {
            eye,
            target: std::array::from_fn(|k| eye[k] + target[k]),
            up: [0.0, 1.0, 0.0],
            fov_y: 120.0,
        };
        let primaries = stage.look(&device, &View { camera, width: 80, height: 60 });
        let kind = Secondary { length: f32::INFINITY, ..Secondary::ao(&b) };
        let rays = stage.spawn(&device, &primaries, &kind, 1 << 20);
        assert_eq!(rays.len(), 32 * 80 * 60, "a primary missed from within");
        let out = stage.hits(&device, &rays).iter().filter(|h| !h.is_hit()).count();
        assert_eq!(out, 0, "{out} of {} rays left the sphere", rays.len());
    }
}

/// An octahedron: convex, every corner within `size` of `centre`.
fn octahedron(centre: Vec3, size: Vec3) -> Scene {
    let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.7);
    let corner = |v: Vec3| (centre + turn * (v * size)).to_array();
    let positions = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].map(corner).to_vec();
    let mut triangles = vec![];
    for x in 0..2 {
        for y in 2..4 {
            triangles.extend([[x, y, 4], [x, y, 5]]);
        }
    }
    Scene { positions, triangles, ..Scene::default() }
}

#[test]
fn convex_bodies_do_not_shade_themselves() {
    let far = Vec3::new(1000.0, -300.0, 77.0);
    let cases = [
        (Vec3::ZERO, Vec3::ONE),
        (Vec3::ZERO, Vec3::splat(1e-6)),
        (far, Vec3::ONE),
        (far, Vec3::new(50.0, 2.0, 0.01)),
        (far * 1e4, Vec3::splat(1e6)),
    ];
    for (device, (centre, size)) in each_width().into_iter().flat_map(|d| cases.map(|case| (d, case))) {
        let device = quiet_on(device);
        let stage = Stage::new(&device, octahedron(centre, size));
        let primaries = stage.look(&device, &View { camera: stage.scene.view(), width: 120, height: 90 });
        let rays = stage.spawn(&device, &primaries, &Secondary::diffuse(), 1 << 20);
        assert!(rays.len() > 1000, "{centre} {size}: {} rays", rays.len());
        let own = stage.hits(&device, &rays).iter().filter(|h| h.is_hit()).count();
        assert_eq!(own, 0, "{centre} {size}: {own} of {} rays meet the body that they leave", rays.len());
    }
}

#[test]
fn no_rays_from_misses_or_triangles_without_a_normal() {
    let device = quiet();
    let (a, b, c) = ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let positions = vec![a, b, c, [2.0, 0.0, 0.0], [f32::MAX, f32::MAX, 0.0], [-f32::MAX; 3]];
    let triangles = vec![[0, 1, 3], [0, 1, 2], [1, 1, 1], [4, 5, 0]];
    let scene = Scene { positions, triangles, ..Scene::default() };
    let buffers = SceneBuffers::upload(&device, &scene).unwrap();
    let hit = |triangle| Hit { t: 1.0, triangle, u: 0.25, v: 0.5 };
    let hits = [hit(0), Hit::MISS, hit(1), hit(2), hit(3), hit(1), Hit::MISS];
    let ray = Ray { origin: [0.2, 0.2, 1.0], t_min: 0.0, direction: [0.0, 0.0, -1.0], t_max: f32::INFINITY };
    let mut primaries = Batch::new(&device, hits.len(), false).unwrap();
    primaries.set(&vec![ray; hits.len()]).unwrap();
    primaries.hits.write(&hits).unwrap();
    let kind = Secondary::diffuse();
    let mut out = Batch::new(&device, 1000, false).unwrap();
    let mut spawn = |start| {
        let (taken, _) =
            secondary(&device, &buffers, &primaries, &kind, start, &mut out, Timing::Off).unwrap();
        (taken, out.rays.read_first(out.count).unwrap())
    };
    let (taken, rays) = spawn(0);
    assert_eq!((taken, rays.len()), (7, 64));
    let truth = twin::secondary(&scene, &vec![ray; hits.len()], &hits, &kind, 0, 1000);
    assert_eq!(bits(&rays), bits(&truth.1));
    assert!(rays.iter().all(|r| r.direction[2] > 0.0 && r.origin[2] > 0.0));
    for (start, left) in [(6, 1), (7, 0), (8, 0)] {
        let (taken, rays) = spawn(start);
        assert_eq!((taken, rays.len()), (left, 0), "from primary {start} on");
    }
    let none = Secondary { samples: 0, ..kind };
    let taken = secondary(&device, &buffers, &primaries, &none, 0, &mut out, Timing::Off).unwrap().0;
    assert_eq!((taken, out.count), (7, 0), "no samples, no rays");
    let many = Secondary { samples: 1001, ..kind };
    assert!(secondary(&device, &buffers, &primaries, &many, 0, &mut out, Timing::Off).is_err());
}

#[test]
fn rays_aimed_from_within_a_closed_surface_hit() {
    let sphere = generated("sphere:500");
    let reference = Reference::new(&sphere);
    for aimed in Aimed::ALL {
        let rays = aimed.rays(&sphere, 400);
        // Those that begin outside of the sphere too: what they are aimed at is there.
        let met = |ray: &&Ray| reference.closest(ray).is_some_and(|hit| (0.0..1.000_01).contains(&hit.t));
        let count = rays.iter().filter(met).count();
        assert!(count > 300, "{}: {count}", aimed.name());
        assert_eq!(rays.len(), 400);
    }
    assert!(Aimed::Edges.rays(&Scene::default(), 9).is_empty());
}
