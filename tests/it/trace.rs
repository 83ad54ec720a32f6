//! Hits: device == twin, device == f64 reference, and what must hold whatever the tree.

#![allow(clippy::unwrap_used)]

use crate::gpu::{Quiet, gpu, quiet, quiet_on};
use crate::matrix::{gpu_shaped, max_leaf, narrow, radius};
use crate::soup::{Random, aimed, grid, moved, named, random, random_rays, ray, scene, sphere};
use boxwood::abi::{Hit, Ray, Tests};
use boxwood::bvh::{self, Builder, Bvh, Fit, HostTree, Recipe, SceneBuffers};
use boxwood::device::{Device, Timing};
use boxwood::oracle::compare::{self, Arithmetic, compare};
use boxwood::oracle::morton::Space;
use boxwood::oracle::reference::Reference;
use boxwood::oracle::trace::Tree;
use boxwood::scene::Scene;
use boxwood::trace::{Batch, Boxes, Options, Precision, Query, RayOrder, Walk, trace};
use std::sync::Arc;

pub const CLOSEST: Options = Options {
    query: Query::Closest,
    precision: Precision::Robust,
    walk: Walk::Single,
    order: RayOrder::AsGiven,
    boxes: Boxes::Mixed,
};
const ANY: Options = Options { query: Query::Any, ..CLOSEST };
const REFILL: Options = Options { walk: Walk::Refill, ..CLOSEST };

/// A tree on the device and read back.
pub struct Traced<'a> {
    device: &'a Arc<Device>,
    bvh: Bvh,
    tree: HostTree,
    space: Space,
}

impl<'a> Traced<'a> {
    pub fn new(device: &'a Arc<Device>, scene: &Scene, recipe: &Recipe) -> Self {
        let buffers = SceneBuffers::upload(device, scene).unwrap();
        let bvh = bvh::build(device, &buffers, recipe, Timing::Off).unwrap().bvh;
        let Bvh { exponent, anchor, reach, .. } = bvh;
        let space = Space { exponent, scale: 2f32.powi(exponent), anchor, reach };
        Self { device, tree: bvh.read().unwrap(), bvh, space }
    }

    fn twin(&self) -> Tree<'_> {
        Tree { tree: &self.tree, space: &self.space, wide: self.device.is_wide() }
    }

    pub fn hits(&self, rays: &[Ray], options: Options) -> Vec<Hit> {
        let mut batch = Batch::new(self.device, rays.len(), false).unwrap();
        batch.set(rays).unwrap();
        trace(self.device, &self.bvh, &batch, options, Timing::Off).unwrap();
        batch.hits.read().unwrap()
    }

    fn counted(&self, rays: &[Ray], options: Options) -> (Vec<Hit>, Vec<Tests>) {
        let mut batch = Batch::new(self.device, rays.len(), true).unwrap();
        batch.set(rays).unwrap();
        trace(self.device, &self.bvh, &batch, options, Timing::Off).unwrap();
        (batch.hits.read().unwrap(), batch.tests.unwrap().read().unwrap())
    }

    /// All kernels agree with each other and, in t, triangle, u and v, with the twin. Returns the nearest hits.
    pub fn assert_twin(&self, what: &str, rays: &[Ray]) -> Vec<Hit> {
        let hits = self.hits(rays, CLOSEST);
        let twin: Vec<Hit> = rays.iter().map(|r| self.twin().closest(r).0).collect();
        assert_same_hits(&format!("{what}: device and twin"), rays, &hits, &twin);
        for walk in Walk::ALL {
            let (kernel, options) = (walk.kernel_name(), Options { walk, ..ANY });
            let others = self.hits(rays, Options { walk, ..CLOSEST });
            assert_same_hits(&format!("{what}: {kernel}"), rays, &hits, &others);
            for (i, any) in self.hits(rays, options).iter().enumerate() {
                let expected = if hits[i].is_hit() { Hit { t: 0.0, ..Hit::MISS } } else { Hit::MISS };
                assert_eq!(bits(any), bits(&expected), "{what}: any hit, {kernel}, ray {i}: {:?}", rays[i]);
            }
        }
        hits
    }
}

pub fn bits(hit: &Hit) -> [u32; 4] {
    [hit.t.to_bits(), hit.triangle, hit.u.to_bits(), hit.v.to_bits()]
}

pub fn assert_same_hits(what: &str, rays: &[Ray], a: &[Hit], b: &[Hit]) {
    assert_eq!(a.len(), b.len(), "{what}");
    let different: Vec<usize> = (0..a.len()).filter(|&i| bits(&a[i]) != bits(&b[i])).collect();
    if let Some(&i) = different.first() {
        panic!(
            "{what}: {} of {} rays differ, ray {i} {:?}: {:?} and {:?}",
            different.len(),
            a.len(),
            rays[i],
            a[i],
            b[i]
        );
    }
}

fn assert_clean(what: &str, reference: &Reference, rays: &[Ray], hits: &[Hit]) {
    let verdict = compare(reference, rays, hits, compare::Query::Closest, Arithmetic::Exact);
    assert!(verdict.is_clean(), "{what}: {verdict}");
}

/// Tree, twin and reference over one scene.
fn check(device: &Quiet<'_>, what: &str, scene: &Scene, rays: &[Ray]) -> Vec<Hit> {
    let traced = Traced::new(device, scene, &Recipe::default());
    let hits = traced.assert_twin(what, rays);
    assert_clean(what, &Reference::new(scene), rays, &hits);
    hits
}

/// Rays along each axis, both ways, with either zero, through and beside grid lines.
fn axis_rays() -> Vec<Ray> {
    let mut rays = vec![];
    for axis in 0..3 {
        for (sign, zero) in [(1.0, 0.0f32), (-1.0, 0.0), (1.0, -0.0), (-1.0, -0.0)] {
            for i in 0..17 * 17 {
                let mut origin = [(i % 17) as f32 / 8.0 - 1.0; 3];
                origin[(axis + 1) % 3] = (i / 17) as f32 / 8.0 - 1.0;
                origin[axis] = -9.0 * sign;
                let mut direction = [zero; 3];
                direction[axis] = sign;
                rays.push(ray(origin, direction));
            }
        }
    }
    rays
}

#[test]
fn random_rays_hit_as_the_twin_and_the_reference_say() {
    let device = quiet();
    for (what, corners) in [
        ("sparse", random(3000, 0.02, 1)),
        ("dense", random(1500, 0.5, 2)),
        ("slivers", moved(&random(1500, 0.3, 3), |p| [p[0], p[1], p[2] * 1e-4])),
        ("grid", grid(3000)),
        ("one", random(1, 1.0, 4)),
        ("two", random(2, 1.0, 4)),
    ] {
        let hits = check(&device, what, &scene(&corners), &random_rays(6000, 7));
        assert!(hits.iter().any(Hit::is_hit), "{what}");
    }
}

#[test]
fn axis_rays_hit_as_the_twin_and_the_reference_say() {
    let device = quiet();
    let city = named("city:2000");
    for (what, scene) in [("grid", scene(&grid(3000))), ("sphere", sphere(12, [0.0; 3], 0.9)), ("city", city)]
    {
        let (lo, hi) = (scene.bounds().lo, scene.bounds().hi);
        // The rays' cube onto the scene's box.
        let place = |p: [f32; 3]| std::array::from_fn(|k| (p[k] + 1.0) * 0.5 * (hi[k] - lo[k]) + lo[k]);
        let rays: Vec<Ray> = axis_rays().into_iter().map(|r| Ray { origin: place(r.origin), ..r }).collect();
        let hits = check(&device, what, &scene, &rays);
        assert!(hits.iter().filter(|h| h.is_hit()).count() > 300, "{what}");
    }
}

#[test]
fn no_ray_leaks_through_vertices_and_edges() {
    let device = quiet();
    let far = [1e4, -2e5, 1e6];
    for (centre, radius) in
        [([0.0; 3], 1.0), (far, 1e3), ([0.0; 3], 1e-30), ([0.0; 3], 1e30), ([3.0; 3], 1e-3)]
    {
        let scene = sphere(16, centre, radius);
        let traced = Traced::new(&device, &scene, &Recipe::default());
        for off in [0.0, 0.3] {
            let origin =
                std::array::from_fn(|k| (f64::from(centre[k]) + off * radius * (k as f64 - 1.0)) as f32);
            let rays = aimed(&scene, origin);
            let what = format!("sphere of radius {radius:e} at {centre:?} from {origin:?}");
            let hits = traced.assert_twin(&what, &rays);
            let missed = hits.iter().filter(|h| !h.is_hit()).count();
            assert_eq!(missed, 0, "{what}: of {} rays", rays.len());
            assert_clean(&what, &Reference::new(&scene), &rays, &hits);
        }
    }
}

#[test]
fn triangles_are_closed() {
    let device = quiet_on(narrow);
    // A closed fan around the origin, in a plane and as a cone, seen from above: all triangles share the apex.
    for (spokes, slope) in [(3, 0.0), (4, 0.0), (7, 0.5), (16, -0.25), (5, 1e-6)] {
        let rim = |i: usize| {
            let a = i as f32 / spokes as f32 * std::f32::consts::TAU;
            if i == spokes { [1.0, 0.0, slope] } else { [a.cos(), a.sin(), slope] }
        };
        let corners: Vec<_> = (0..spokes).map(|i| [[0.0; 3], rim(i), rim(i + 1)]).collect();
        let scene = scene(&corners);
        let traced = Traced::new(&device, &scene, &Recipe::default());
        let mut rays = vec![];
        for origin in [[0.0, 0.0, 4.0], [0.1, -0.2, 3.0], [0.0, -0.0, -5.0], [0.25, 0.125, 2.0]] {
            let toward = |p: [f32; 3]| ray(origin, std::array::from_fn(|k| p[k] - origin[k]));
            rays.push(toward([0.0; 3]));
            for i in 0..spokes {
                rays.extend([0.25, 0.5, 0.75].map(|s| toward(rim(i).map(|x| x * s))));
            }
        }
        for (i, r) in rays.iter().enumerate() {
            let what = format!("{spokes} spokes, slope {slope}: {r:?}");
            // By integers as by doubles: the apex is every triangle's, and what brute force says of spokes is so.
            let mut met = traced.twin().crossed(r);
            let mut by_doubles = Tree { wide: true, ..traced.twin() }.crossed(r);
            met.sort_unstable();
            by_doubles.sort_unstable();
            assert_eq!(met, by_doubles, "{what}");
            if i % (3 * spokes + 1) == 0 {
                assert_eq!(met.len(), spokes, "{what}");
            }
        }
        let hits = traced.assert_twin("fan", &rays);
        assert!(hits.iter().all(Hit::is_hit), "{spokes} spokes, slope {slope}");
        assert_clean("fan", &Reference::new(&scene), &rays, &hits);
    }
}

#[test]
fn counts_are_those_of_the_twin() {
    let device = quiet_on(narrow);
    for recipe in [max_leaf(1), Recipe::default()] {
        let soup = scene(&random(2000, 0.15, 8));
        let traced = Traced::new(&device, &soup, &recipe);
        let rays = random_rays(2000, 9);
        for options in [CLOSEST, ANY, REFILL, Options { walk: Walk::Refill, ..ANY }] {
            let (hits, tests) = traced.counted(&rays, options);
            assert_same_hits("counting changes nothing", &rays, &hits, &traced.hits(&rays, options));
            for (i, r) in rays.iter().enumerate() {
                let twin = if options.query == Query::Any {
                    traced.twin().any(r).1
                } else {
                    traced.twin().closest(r).1
                };
                let counts = |t: &Tests| (t.boxes, t.oriented, t.triangles);
                assert_eq!(counts(&tests[i]), counts(&twin), "boxes, triangles: {options:?}, ray {i}: {r:?}");
            }
        }
        // In a packet a ray also meets what its neighbours want, speculation what a nearer hit would have hidden: each
        // ray alone tests less or as much.
        let (uncounted, alone) = (traced.hits(&rays, CLOSEST), traced.counted(&rays, CLOSEST).1);
        for walk in [Walk::Packet, Walk::Persistent] {
            let (hits, tests) = traced.counted(&rays, Options { walk, ..CLOSEST });
            assert_same_hits(&format!("{walk:?} counted"), &rays, &hits, &uncounted);
            let boxes = |t: &[Tests]| t.iter().map(|t| u64::from(t.boxes)).sum::<u64>();
            assert!(boxes(&tests) >= boxes(&alone), "{walk:?}");
        }
    }
}

#[test]
fn t_min_and_t_max_belong_to_the_range() {
    let device = quiet();
    // A stack of squares at z = 1, 2, 4, …: t is a power of two, which no rounding moves.
    let corners: Vec<_> = (0..12)
        .flat_map(|k| {
            let z = (1 << k) as f32;
            let at = |x: f32, y: f32| [x * z, y * z, z];
            [[at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0)], [at(-1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]]
        })
        .collect();
    let scene = scene(&corners);
    let mut rays = vec![];
    let mut expected = vec![];
    for k in 0..12 {
        let t = (1 << k) as f32;
        for (t_min, t_max, hit) in [
            (t, f32::INFINITY, Some(t)),
            (t, t, Some(t)),
            (0.0, t, Some(1.0)),
            (t.next_up(), 4096.0, (k < 11).then_some(2.0 * t)),
            (t.next_down(), t, Some(t)),
            (t.next_up(), (2.0 * t).next_down(), None),
            (-3.0, -1.0, None),
            (t, t.next_down(), None),
            (f32::NEG_INFINITY, f32::INFINITY, Some(1.0)),
        ] {
            rays.push(Ray { t_min, t_max, ..ray([0.0; 3], [0.125, 0.25, 1.0]) });
            expected.push(hit.unwrap_or(f32::INFINITY));
        }
    }
    // From a surface: t = 0 is in no range that begins above 0 or ends below it, by however little.
    let least = f32::from_bits(1);
    for (t_min, t_max, hit) in [
        (0.0, f32::INFINITY, Some(0.0)),
        (-0.0, 0.0, Some(0.0)),
        (-least, least, Some(0.0)),
        (f32::MIN_POSITIVE, f32::INFINITY, Some(1.0)),
        (least, f32::INFINITY, Some(1.0)),
        (least, least, None),
        (least, -least, None),
        (f32::NEG_INFINITY, -least, None),
    ] {
        rays.push(Ray { t_min, t_max, ..ray([0.125, 0.25, 1.0], [0.125, 0.25, 1.0]) });
        expected.push(hit.unwrap_or(f32::INFINITY));
    }
    let hits = check(&device, "ranges", &scene, &rays);
    for i in 0..rays.len() {
        assert_eq!(hits[i].t, expected[i], "{:?}", rays[i]);
    }
}

#[test]
fn directions_of_any_length() {
    let device = quiet();
    let soup = scene(&random(1500, 0.3, 10));
    let traced = Traced::new(&device, &soup, &Recipe::default());
    let reference = Reference::new(&soup);
    let plain = random_rays(500, 11);
    let at_unit = traced.assert_twin("unit", &plain);
    for exponent in [-100, -60, 1, 60, 100] {
        let factor = 2f32.powi(exponent);
        let rays: Vec<Ray> =
            plain.iter().map(|r| Ray { direction: r.direction.map(|x| x * factor), ..*r }).collect();
        let hits = traced.assert_twin(&format!("directions · 2^{exponent}"), &rays);
        for i in 0..rays.len() {
            // A power of two changes t by its inverse and nothing else.
            let same = (hits[i].triangle, hits[i].u.to_bits(), hits[i].t * factor);
            assert_eq!(same, (at_unit[i].triangle, at_unit[i].u.to_bits(), at_unit[i].t), "{:?}", rays[i]);
        }
    }
    for factor in [1e-30, 1e30, 1e-37, 3e37] {
        let rays: Vec<Ray> =
            plain.iter().map(|r| Ray { direction: r.direction.map(|x| x * factor), ..*r }).collect();
        assert_clean(
            &format!("directions · {factor:e}"),
            &reference,
            &rays,
            &traced.assert_twin("long", &rays),
        );
    }
    // Denormal ones: t may be beyond the floats, and is cut to the largest of them, for +inf means a miss.
    let denormal: Vec<Ray> =
        plain.iter().map(|r| Ray { direction: r.direction.map(|x| x * 1e-41), ..*r }).collect();
    let hits = traced.assert_twin("denormal", &denormal);
    assert!(hits.iter().any(|h| h.t == f32::MAX) && hits.iter().all(|h| h.is_hit() == (h.triangle < 1500)));
}

/// From `distance` at points in the middle of a sphere.
fn from_afar(distance: f32, radius: f32) -> (Scene, Vec<Ray>) {
    let mut random = Random(12);
    let mut aim = || {
        let from = random.point().map(|x| x * distance);
        let to = random.point().map(|x| x * 0.7 * radius);
        ray(from, std::array::from_fn(|k| to[k] - from[k]))
    };
    let rays = (0..1500).map(|_| aim()).collect();
    (sphere(16, [0.0; 3], radius.into()), rays)
}

#[test]
fn rays_from_afar() {
    let device = quiet();
    for (distance, radius) in [(1e7, 1e4), (1e4, 1.0), (1e7, 1.0)] {
        let (scene, rays) = from_afar(distance, radius);
        check(&device, &format!("from {distance:e} at a sphere of radius {radius:e}"), &scene, &rays);
    }
}

/// Rays at a sphere about 0, within and beside it, from `distance` along each axis: what their small components do, counts.
fn from_distant(distance: f32, radius: f32) -> Vec<Ray> {
    let mut random = Random(14);
    let mut aim = |i: usize| {
        let [to, from] = [(); 2].map(|()| random.point().map(|x| x * 1.5 * radius));
        let away = if i.is_multiple_of(2) { distance } else { -distance };
        let k = i / 2 % 3;
        // One in four straight on, another through 0.
        let mut r = match i % 4 {
            0 => ray(from, [0.0; 3]),
            1 => ray(from, from.map(|x| -x)),
            _ => ray(from, std::array::from_fn(|k| to[k] - from[k])),
        };
        (r.origin[k], r.direction[k]) = (away, -away);
        r
    };
    (0..1200).map(&mut aim).collect()
}

/// As in exact arithmetic, from as far as floats go: also where the origin overflows what the scene is measured in.
#[test]
fn distant_rays_hit_what_they_are_aimed_at() {
    for device in [gpu, narrow] {
        let device = quiet_on(device);
        for (distance, radius) in [
            (1e9, 1.0),
            (1e12, 1.0),
            (1e20, 1e3),
            (1e30, 1e-4),
            (3.4e38, 1.0),
            (1e7, 1e-37),
            (3e38, 1e-30),
            (3.4e38, 1e-37),
            (1e-10, 1e-37),
        ] {
            let what = format!("from {distance:e} at a sphere of radius {radius:e}");
            let (scene, rays) = (sphere(12, [0.0; 3], radius.into()), from_distant(distance, radius));
            let hits = check(&device, &what, &scene, &rays);
            let hit = hits.iter().filter(|h| h.is_hit()).count();
            assert!((300..900).contains(&hit), "{what}: {hit} of {} hit", rays.len());
            // The sphere is at t = 1 and nowhere else.
            for (t_min, t_max, within) in
                [(0.0, 1.0, true), (1.0, 9.0, true), (0.0, 0.999, false), (1.001, 9.0, false)]
            {
                let ranged: Vec<Ray> = rays.iter().map(|r| Ray { t_min, t_max, ..*r }).collect();
                let again = check(&device, &what, &scene, &ranged);
                assert!(again.iter().zip(&hits).all(|(a, b)| a.is_hit() == (b.is_hit() && within)), "{what}");
            }
        }
    }
}

/// Of a plane as far away as floats go, and so small that no unit holds both, no tree is made.
#[test]
fn scenes_too_far_for_their_size_are_refused() {
    let device = quiet();
    for (k, axis) in ['x', 'y', 'z'].into_iter().enumerate() {
        for (at, size, fits) in
            [(1e30, 1e-30, false), (1e30, 1e-7, true), (-1e38, 1e2, true), (-3e38, 1e-20, false)]
        {
            let mut corners = [[0.0; 3]; 3];
            (corners[1][(k + 1) % 3], corners[2][(k + 2) % 3]) = (size, size);
            corners.iter_mut().for_each(|c| c[k] = at);
            let scene = scene(&[corners]);
            let buffers = SceneBuffers::upload(&device, &scene).unwrap();
            let built = bvh::build(&device, &buffers, &Recipe::default(), Timing::Off);
            assert_eq!(built.is_ok(), fits, "{axis} = {at:e}, {size:e} long");
            let Err(error) = built else {
                let rays = [0.25, 0.75].map(|share| {
                    let mut r = ray([share * size; 3], [0.0; 3]);
                    (r.origin[k], r.direction[k]) = (0.0, at);
                    r
                });
                let hits = check(&device, &format!("{axis} = {at:e}"), &scene, &rays);
                assert_eq!([hits[0].is_hit(), hits[1].is_hit()], [true, false], "{axis} = {at:e}");
                continue;
            };
            let told = error.to_string();
            assert!(
                told.contains(&format!("the plane {axis} = {at:e}")) && told.contains("--translate"),
                "{told}"
            );
        }
    }
}

#[test]
fn far_rays_test_as_little_as_near_ones() {
    let device = quiet_on(narrow);
    let soup = scene(&random(2000, 0.05, 8));
    let plain = Recipe::default();
    for recipe in [plain, Recipe { fit: Fit::Dito(14), oriented_cost: plain.collapse.node_cost, ..plain }] {
        let traced = Traced::new(&device, &soup, &recipe);
        let counts = |t: &Tests| [t.boxes, t.oriented, t.triangles];
        let tested = |distance: f32| {
            let mut random = Random(13);
            let mut aim = || {
                let (to, away) = (random.point(), random.point());
                ray(std::array::from_fn(|k| to[k] + distance * away[k]), away.map(|x| -x))
            };
            let rays: Vec<Ray> = (0..1000).map(|_| aim()).collect();
            let (_, tests) = traced.counted(&rays, CLOSEST);
            for (tests, ray) in tests.iter().zip(&rays) {
                assert_eq!(
                    counts(tests),
                    counts(&traced.twin().closest(ray).1),
                    "from {distance:e}: {ray:?}"
                );
            }
            tests.iter().flat_map(counts).map(u64::from).sum::<u64>()
        };
        let near = tested(4.0);
        for distance in [1e2, 1e3, 1e5, 1e7] {
            let far = tested(distance);
            assert!(far <= near + near / 4, "from {distance:e} {far} boxes and triangles, from near {near}");
        }
        // Straight on, for no other from so far away meets the scene.
        let straight = |distance: f32| {
            let mut random = Random(15);
            let mut aim = |i: usize| {
                let mut r = ray(random.point(), [0.0; 3]);
                (r.origin[i % 3], r.direction[i % 3]) = (distance, -distance);
                r
            };
            let rays: Vec<Ray> = (0..1000).map(&mut aim).collect();
            let (_, tests) = traced.counted(&rays, CLOSEST);
            for (tests, ray) in tests.iter().zip(&rays) {
                let twin = traced.twin().closest(ray).1;
                assert_eq!(counts(tests), counts(&twin), "from {distance:e}: {ray:?}");
            }
            tests.iter().flat_map(counts).map(u64::from).sum::<u64>()
        };
        let near = straight(4.0);
        for distance in [1e11, 1e20, 1e38] {
            // All of the scene is at one t: what is behind a hit is met too.
            let far = straight(distance);
            assert!(far <= 3 * near, "from {distance:e} {far} boxes and triangles, from near {near}");
        }
    }
}

#[test]
fn nonsense_rays_miss() {
    let device = quiet();
    let scene = scene(&random(500, 0.5, 13));
    let plain = random_rays(24, 14);
    let mut rays = vec![];
    for (i, r) in plain.iter().enumerate() {
        let mut words: [f32; 8] = bytemuck::cast(*r);
        words[i % 8] = f32::NAN;
        rays.push(bytemuck::cast(words));
    }
    rays.push(ray([0.0; 3], [0.0, -0.0, 0.0]));
    for bad in [f32::INFINITY, f32::NEG_INFINITY] {
        rays.push(ray([0.0, bad, 0.0], [1.0, 0.0, 0.0]));
        rays.push(ray([0.0; 3], [1.0, bad, 0.0]));
        rays.push(Ray { t_min: f32::INFINITY, ..plain[0] });
        rays.push(Ray { t_max: f32::NEG_INFINITY, ..plain[0] });
    }
    let hits = check(&device, "nonsense", &scene, &rays);
    assert!(hits.iter().all(|h| bits(h) == bits(&Hit::MISS)), "{hits:?}");
}

#[test]
fn scenes_of_any_size_anywhere() {
    let device = quiet();
    let soup = random(800, 0.3, 15);
    let rays = random_rays(1500, 16);
    for (scale, shift) in [(1e-30f32, 0.0f32), (1e30, 0.0), (1.0, 1e4), (1.0, 1e6), (1e3, -1e6), (1e-3, 10.0)]
    {
        let place = |p: [f32; 3]| p.map(|x| x * scale + shift);
        let scene = scene(&moved(&soup, place));
        let rays: Vec<Ray> = rays.iter().map(|r| Ray { origin: place(r.origin), ..*r }).collect();
        let hits = check(&device, &format!("· {scale:e} + {shift:e}"), &scene, &rays);
        assert!(hits.iter().filter(|h| h.is_hit()).count() > 100, "· {scale:e} + {shift:e}");
    }
}

#[test]
fn hits_depend_on_neither_tree_nor_order() {
    let device = quiet();
    let corners = random(1200, 0.3, 17);
    let soup = scene(&corners);
    let rays = random_rays(3000, 18);
    let hits = Traced::new(&device, &soup, &Recipe::default()).hits(&rays, CLOSEST);
    for recipe in [max_leaf(1), max_leaf(64), radius(1), radius(16)] {
        let other = Traced::new(&device, &soup, &recipe).hits(&rays, CLOSEST);
        assert_same_hits(&format!("{recipe:?}"), &rays, &hits, &other);
    }
    // Triangles in another order: the same hits under other numbers.
    let mut random = Random(19);
    let mut order: Vec<usize> = (0..corners.len()).collect();
    for i in (1..order.len()).rev() {
        order.swap(i, random.below(i + 1));
    }
    let shuffled = scene(&order.iter().map(|i| corners[*i]).collect::<Vec<_>>());
    let mut other = Traced::new(&device, &shuffled, &Recipe::default()).hits(&rays, CLOSEST);
    for hit in other.iter_mut().filter(|h| h.is_hit()) {
        hit.triangle = order[hit.triangle as usize] as u32;
    }
    assert_same_hits("shuffled", &rays, &hits, &other);
}

#[test]
fn ties_go_to_the_lower_index() {
    let device = quiet();
    let one = random(40, 0.5, 20);
    let copies: Vec<_> = (0..5).flat_map(|_| one.clone()).collect();
    let hits = check(&device, "five copies", &scene(&copies), &random_rays(3000, 21));
    assert!(hits.iter().filter(|h| h.is_hit()).all(|h| h.triangle < 40));
}

/// t that no float tells apart tie, whichever is met first: of the one triangle it is 0, of the other 10⁻⁵⁷.
#[test]
fn ties_within_the_least_float_go_to_the_lower_index() {
    let level = [[1e-10, 0.0, -1.0], [-1e-10, 0.0, -1.0], [0.0, 0.0, 1.0]];
    let tilted = [[1e-10, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1e-30, -1e-3]];
    let size = [[4.0, 4.0, 0.75], [4.0, 4.5, 0.75], [4.0, 4.0, 1.0]];
    for device in [gpu, narrow] {
        let device = quiet_on(device);
        // In leaves triangles lie in the order of space, not of indices: of one of the mirrored scenes the wrong way round.
        for (order, mirror) in
            [[level, tilted, size], [tilted, level, size]].iter().flat_map(|o| [(o, 1.0), (o, -1.0)])
        {
            let mirrored = |[x, y, z]: [f32; 3]| [x, y, z * mirror];
            let corners = order.map(|c| c.map(mirrored));
            let ray = Ray { t_min: -1.0, ..ray(mirrored([0.0, 0.0, -1e-30]), [0.0, -1.0, 0.0]) };
            for builder in Builder::ALL {
                let traced = Traced::new(&device, &scene(&corners), &Recipe { builder, ..Recipe::default() });
                let hits = traced.assert_twin(&format!("{builder:?}"), &[ray]);
                assert_eq!((hits[0].t, hits[0].triangle), (0.0, 0), "{builder:?}: {corners:?}");
            }
        }
    }
}

/// t that is 0 to the floats alone is on its side of 0: of a triangle 2⁻¹¹⁰ of the scene in size, −7.5e-41 is not in a range
/// that begins at 0, nor 7.5e-41 in one that ends there.
#[test]
fn what_is_nearly_0_is_on_its_side() {
    let (least, most) = (1.540_744e-33, 1.848_892_8e-33);
    let tiny = [[least; 3], [1.694_818_4e-33; 3], [1.694_818_4e-33, least, most]];
    let far = [[0.001_953_125; 3], [0.002_148_437_5; 3], [0.002_148_437_5, 0.001_953_125, 0.002_343_75]];
    let ray =
        ray([1.643_460_3e-33, 1.592_102e-33, 1.694_818_4e-33], [0.816_496_6, -0.408_248_3, -0.408_248_3]);
    let scene = scene(&[far, tiny]);
    let back = Ray { direction: ray.direction.map(|x| -x), ..ray };
    let ranges = |ray: Ray| {
        [(0.0, 1.0), (-1.0, 0.0), (-1.0, 1.0), (0.0, 0.0), (-1e-42, 1.0), (-1.0, 1e-42)]
            .map(|(t_min, t_max)| Ray { t_min, t_max, ..ray })
    };
    for device in [gpu, narrow] {
        let device = quiet_on(device);
        let traced = Traced::new(&device, &scene, &Recipe::default());
        let mut hit = Vec::new();
        for ray in [ray, back] {
            let hits = traced.assert_twin("before and behind", &ranges(ray));
            hit.push(hits.iter().map(|h| h.is_hit()).collect::<Vec<_>>());
        }
        // Limits below 2⁻¹²⁶ of the scene are that, so that what is as near is within them.
        assert_eq!(hit[0], [false, true, true, false, true, true], "behind");
        assert_eq!(hit[1], [true, false, true, false, true, true], "before");
    }
}

/// To a device that reckons in twice the scene's extent and half the direction, t below 2⁻¹²⁵ may be 0, and that is no fault;
/// from there on it is told.
#[test]
fn t_below_the_least_float_of_a_device_may_be_0() {
    let least = f32::MIN_POSITIVE;
    let slope = 1.99;
    let level = |z: f32| scene(&[[[-0.5, -0.5, z], [0.5, -0.5, z], [0.0, 0.5, z]]]);
    let rays = [slope, -slope].map(|z| Ray { t_min: -1.0, ..ray([0.0; 3], [0.0, 0.0, z]) });
    for device in [gpu, narrow] {
        let device = quiet_on(device);
        for t in [0.9, 1.8, 1.99, 2.01, 3.0, 4.0, 100.0] {
            let hits = check(&device, &format!("t = {t} · 2⁻¹²⁶"), &level(t * least * slope), &rays);
            for (hit, sign) in hits.iter().zip([1.0, -1.0]) {
                let told = hit.t / least * sign;
                assert!((told - t).abs() < 1e-5 * t || t < 2.0 && told == 0.0, "{t}: {told}");
            }
        }
    }
}

#[test]
fn any_number_of_rays() {
    let device = quiet();
    let traced = Traced::new(&device, &scene(&random(300, 0.3, 27)), &Recipe::default());
    // None, one, a workgroup and one more or less, and enough that invocations take several rays each.
    let rays = random_rays(20_000, 28);
    for n in [0, 1, 3, 63, 64, 65, 127, 129, 1000, 20_000] {
        let hits = traced.hits(&rays[..n], CLOSEST);
        for walk in Walk::ALL {
            // Twice, for what a trace counts must start anew.
            for _ in 0..2 {
                let others = traced.hits(&rays[..n], Options { walk, ..CLOSEST });
                assert_same_hits(&format!("{n} rays, {walk:?}"), &rays[..n], &hits, &others);
            }
        }
    }
}

#[test]
fn empty_scenes_miss() {
    let device = quiet();
    let nan = [[[f32::NAN; 3]; 3]; 3];
    for (what, scene) in [("no triangle", scene(&[])), ("none that can be hit", scene(&nan))] {
        let hits = check(&device, what, &scene, &random_rays(100, 22));
        assert!(hits.iter().all(|h| !h.is_hit()), "{what}");
    }
}

#[test]
fn shapes_do_not_show_in_hits() {
    let soup = scene(&random(1500, 0.2, 23));
    let rays = random_rays(2000, 24);
    let hits = Traced::new(&quiet(), &soup, &Recipe::default()).hits(&rays, CLOSEST);
    let device = quiet_on(gpu_shaped);
    let traced = Traced::new(&device, &soup, &Recipe::default());
    assert_same_hits("GPU shapes", &rays, &hits, &traced.assert_twin("GPU shapes", &rays));
}

#[test]
fn devices_without_doubles_hit_as_their_twin_says() {
    let device = quiet_on(narrow);
    let soup = scene(&random(1500, 0.2, 23));
    let hits = check(&device, "no doubles", &soup, &random_rays(2000, 24));
    assert!(hits.iter().any(Hit::is_hit));
    let sphere = sphere(12, [0.0; 3], 1.0);
    let hits = check(&device, "no doubles, sphere", &sphere, &aimed(&sphere, [0.1, 0.2, -0.1]));
    assert!(hits.iter().all(Hit::is_hit));
}

#[test]
fn the_fast_test_is_nearly_right() {
    let device = quiet();
    let soup = scene(&random(1500, 0.3, 25));
    let traced = Traced::new(&device, &soup, &Recipe::default());
    let rays = random_rays(3000, 26);
    let robust = traced.hits(&rays, CLOSEST);
    let single = traced.hits(&rays, Options { precision: Precision::Fast, ..CLOSEST });
    for walk in Walk::ALL {
        let others = traced.hits(&rays, Options { precision: Precision::Fast, walk, ..CLOSEST });
        assert_same_hits(&format!("single rays and {walk:?}"), &rays, &single, &others);
    }
    let agree = |i: &usize| {
        let (a, b) = (robust[*i], single[*i]);
        a.triangle == b.triangle && (a.t == b.t || (a.t - b.t).abs() <= 1e-3 * a.t.abs())
    };
    let agreeing = (0..rays.len()).filter(agree).count();
    assert!(agreeing >= rays.len() - 3, "{agreeing} of {} rays agree", rays.len());
}
