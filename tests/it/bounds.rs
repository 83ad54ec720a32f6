//! Errors of hits measured against the bounds that `oracle::bounds` derives, and origins of secondary rays against theirs.

#![allow(clippy::unwrap_used)]

use crate::gpu::{gpu, quiet_on};
use crate::matrix::{each_width, max_leaf};
use crate::soup::{Corners, Random, aimed, moved, named, random, random_rays, ray, scene, sphere};
use boxwood::abi::{Hit, Ray};
use boxwood::bvh::{Recipe, SceneBuffers, build};
use boxwood::device::{Device, Timing};
use boxwood::oracle::bounds::{Bound, bound, crossing};
use boxwood::oracle::brute::{self, Ray64};
use boxwood::oracle::exact::{Difference, exact};
use boxwood::oracle::rays as twin;
use boxwood::scene::Scene;
use boxwood::trace::rays::{Secondary, View, primary, secondary};
use boxwood::trace::{Batch, Options, Precision, Query, trace};
use std::sync::Arc;

fn traced(device: &Arc<Device>, scene: &Scene, recipe: &Recipe, rays: &[Ray], options: Options) -> Vec<Hit> {
    let buffers = SceneBuffers::upload(device, scene).unwrap();
    let bvh = build(device, &buffers, recipe, Timing::Off).unwrap().bvh;
    let mut batch = Batch::new(device, rays.len(), false).unwrap();
    batch.set(rays).unwrap();
    trace(device, &bvh, &batch, options, Timing::Off).unwrap();
    batch.hits.read().unwrap()
}

/// Long thin triangles, each a thousandth or less of its length wide.
fn needles(n: usize, seed: u64) -> Vec<Corners> {
    let mut random = Random(seed);
    let mut needle = || {
        let (at, along, width) = (random.point(), random.point(), 1e-3 / (1 << random.below(12)) as f32);
        let step = random.point();
        let end: [f32; 3] = std::array::from_fn(|k| at[k] + along[k]);
        [at, end, std::array::from_fn(|k| 0.5 * (at[k] + end[k]) + width * step[k])]
    };
    (0..n).map(|_| needle()).collect()
}

/// At points inside of triangles, from `distance` away.
fn at_triangles(corners: &[Corners], n: usize, distance: f32, seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    let mut toward = || {
        let [a, b, c] = corners[random.below(corners.len())];
        let (u, v) = (0.2 + 0.15 * random.unit(), 0.3 + 0.25 * random.unit());
        let to: [f32; 3] = std::array::from_fn(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
        let from = random.point().map(|x| distance * x);
        ray(from, std::array::from_fn(|k| to[k] - from[k]))
    };
    (0..n).map(|_| toward()).collect()
}

/// Rays that meet a tilted plane of large triangles at ever smaller angles.
fn grazing() -> (Vec<Corners>, Vec<Ray>) {
    let plane = |x: f32, y: f32| [x, y, 0.37 * x - 0.61 * y];
    let corners = vec![
        [plane(-9.0, -9.0), plane(9.0, -9.0), plane(9.0, 9.0)],
        [plane(-9.0, -9.0), plane(9.0, 9.0), plane(-9.0, 9.0)],
    ];
    let mut random = Random(5);
    let mut graze = |i: usize| {
        let [x, y, _] = random.point();
        let (to, from) = (plane(3.0 * x, 3.0 * y), plane(random.unit(), random.unit()));
        let height = 2f32.powi(-(i as i32 % 20));
        let from = [from[0], from[1], from[2] + height];
        ray(from, std::array::from_fn(|k| to[k] - from[k]))
    };
    let rays = (0..1500).map(&mut graze).collect();
    (corners, rays)
}

/// Primary rays of a view of `scene` and diffuse ones from what they met.
fn looks(device: &Arc<Device>, scene: &Scene) -> Vec<Ray> {
    let buffers = SceneBuffers::upload(device, scene).unwrap();
    let bvh = build(device, &buffers, &Recipe::default(), Timing::Off).unwrap().bvh;
    let view = View { camera: scene.view(), width: 40, height: 30 };
    let mut batch = Batch::new(device, view.pixels(), false).unwrap();
    primary(device, &view, &mut batch, Timing::Off).unwrap();
    trace(device, &bvh, &batch, Options::default(), Timing::Off).unwrap();
    let mut out = Batch::new(device, 4 * view.pixels(), false).unwrap();
    let kind = Secondary { samples: 4, ..Secondary::diffuse() };
    secondary(device, &buffers, &batch, &kind, 0, &mut out, Timing::Off).unwrap();
    let mut rays = batch.rays.read().unwrap();
    rays.extend(out.rays.read_first(out.count).unwrap());
    rays
}

/// From easy to nasty.
fn sets(device: &Arc<Device>) -> Vec<(&'static str, Scene, Vec<Ray>)> {
    let soup = random(1000, 0.3, 1);
    let thin = needles(400, 2);
    let ball = sphere(12, [0.0; 3], 1.0);
    let at = |corners: &[Corners], distance| at_triangles(corners, 1500, distance, 3);
    let scaled = |scale: f32| {
        let rays = random_rays(1500, 4).into_iter();
        let rays = rays.map(|r| Ray { origin: r.origin.map(|x| x * scale), ..r }).collect();
        (scene(&moved(&soup, |p| p.map(|x| x * scale))), rays)
    };
    let ((tiny, tiny_rays), (huge, huge_rays), (plane, graze)) = (scaled(1e-12), scaled(1e25), grazing());
    let away = moved(&soup, |p| p.map(|x| x + 500.0));
    let away_rays = random_rays(1500, 4).into_iter();
    let away_rays = away_rays.map(|r| Ray { origin: r.origin.map(|x| x + 500.0), ..r }).collect();
    let (views, city) = (named("sphere:2k"), named("city-rotated:2k"));
    let (seen, streets) = (looks(device, &views), looks(device, &city));
    vec![
        ("random", scene(&soup), random_rays(1500, 4)),
        ("vertices, edges", ball.clone(), aimed(&ball, [0.1, 0.2, -0.1])),
        ("primary, diffuse", views, seen),
        ("city", city, streets),
        ("grazing", scene(&plane), graze),
        ("needles", scene(&thin), at(&thin, 2.0)),
        ("needles, far", scene(&thin), at(&thin, 3e4)),
        ("far", scene(&soup), at(&soup, 1e5)),
        ("tiny", tiny, tiny_rays),
        ("huge", huge, huge_rays),
        ("off the origin", scene(&away), away_rays),
    ]
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Largest share of the bounds of t, u and v that the hits of a set use, and of how many hits there is none.
fn judge(
    what: &str,
    scene: &Scene,
    rays: &[Ray],
    hits: &[Hit],
    precision: Precision,
    wide: bool,
) -> [f64; 3] {
    let mut shares: [Vec<f64>; 3] = [vec![], vec![], vec![]];
    let (mut count, mut unknown) = (0, 0);
    for (ray, hit) in rays.iter().zip(hits).filter(|(_, hit)| hit.is_hit()) {
        let corners = scene.corners(hit.triangle as usize);
        let Bound { t, u, v } = bound(ray, corners, precision, wide);
        count += 1;
        if !(t.is_finite() && u.is_finite() && v.is_finite()) {
            unknown += 1;
            continue;
        }
        let truth = crossing(ray, corners).unwrap();
        let errors = [(hit.t, truth.t), (hit.u, truth.u), (hit.v, truth.v)];
        for (k, ((is, should), most)) in errors.into_iter().zip([t, u, v]).enumerate() {
            let error = (f64::from(is) - should).abs();
            assert!(error <= most, "{what}: {error:e} > {most:e}, {truth:?}: {hit:?}, {ray:?}, {corners:?}");
            shares[k].push(error / most);
        }
    }
    assert!(count > 100, "{what}: {count} hits");
    assert!(unknown * 4 < count, "{what}: {unknown} of {count} hits have no bound");
    let medians = shares.each_mut().map(|s| median(s));
    let most = shares.map(|s| *s.last().unwrap());
    println!(
        "{what}: {count} hits, {unknown} without a bound; error / bound of t, u, v: median {medians:.3?}, greatest {most:.3?}"
    );
    most
}

#[test]
fn errors_stay_within_their_bounds() {
    for device in each_width() {
        let device = quiet_on(device);
        let wide = device.is_wide();
        let sets = sets(&device);
        for precision in Precision::ALL {
            let mut most = [0.0f64; 3];
            for (what, scene, rays) in &sets {
                let options = Options { precision, ..Options::default() };
                let hits = traced(&device, scene, &Recipe::default(), rays, options);
                let what = format!("{}, doubles: {wide}, {what}", precision.name());
                let shares = judge(&what, scene, rays, &hits, precision, wide);
                (0..3).for_each(|k| most[k] = most[k].max(shares[k]));
            }
            // A bound that nothing comes near would say nothing.
            let least = match (precision, wide) {
                (Precision::Robust, true) => 0.9,
                (Precision::Robust, false) => 0.8,
                _ => 0.05,
            };
            assert!(most.iter().all(|m| *m > least), "{precision:?}, doubles: {wide}: at most {most:?}");
        }
    }
}

/// Rays from `distance` away at the ends of needles, and past them by the least that a direction can say.
fn at_ends(corners: &[Corners], distance: f32) -> Vec<Ray> {
    let mut random = Random(7);
    let mut rays = vec![];
    for to in corners.as_flattened() {
        let from = random.point().map(|x| distance * x);
        let direction: [f32; 3] = std::array::from_fn(|k| to[k] - from[k]);
        rays.extend(
            [direction, direction.map(f32::next_up), direction.map(f32::next_down)].map(|d| ray(from, d)),
        );
    }
    rays
}

/// Triangles of small whole numbers and rays that pass exactly through corners and middles of edges, 2¹⁸ away.
fn lattice() -> (Vec<Corners>, Vec<Ray>) {
    let mut random = Random(11);
    let mut whole = |most: usize| [(); 3].map(|()| random.below(2 * most + 1) as f32 - most as f32);
    let corners: Vec<Corners> = (0..300).map(|_| [whole(8), whole(8), whole(8)]).collect();
    let mut rays = vec![];
    for [a, b, _] in &corners {
        let direction = whole(3);
        let middle = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        rays.extend(
            [*a, middle].map(|p| ray(std::array::from_fn(|k| p[k] - 262_144.0 * direction[k]), direction)),
        );
    }
    (corners, rays)
}

#[test]
fn hits_are_those_of_exact_arithmetic() {
    let thin = needles(300, 6);
    let mut sets: Vec<_> = [2.0, 1e3, 1e5]
        .map(|distance| (format!("from {distance:e}"), thin.clone(), at_ends(&thin, distance)))
        .into();
    let (corners, rays) = lattice();
    sets.push(("lattice".into(), corners, rays));
    for (what, corners, rays) in sets {
        let soup = scene(&corners);
        let truth: Vec<bool> = rays.iter().map(|r| brute::any(&soup, r)).collect();
        let hit = truth.iter().filter(|t| **t).count();
        println!("{what}: {hit} of {} hit", rays.len());
        assert!(hit > 10 && hit < rays.len(), "{what}: {hit} of {} hit", rays.len());
        for device in each_width() {
            let device = quiet_on(device);
            for recipe in [Recipe::default(), max_leaf(1), max_leaf(64)] {
                for query in [Query::Closest, Query::Any] {
                    let options = Options { query, ..Options::default() };
                    let hits = traced(&device, &soup, &recipe, &rays, options);
                    let wrong = (0..rays.len()).find(|i| hits[*i].is_hit() != truth[*i]);
                    assert_eq!(wrong, None, "{what}, {query:?}: {:?}", wrong.map(|i| (rays[i], hits[i])));
                }
            }
        }
    }
}

/// Height over the plane of `corners`, to the side that `direction` comes from.
fn height(p: [f32; 3], [a, b, c]: Corners, direction: [f32; 3]) -> f64 {
    let wide = |v: [f32; 3]| v.map(f64::from);
    let to = |q| Difference::new(wide(a), wide(q));
    let (ab, ac) = (to(b), to(c));
    let [x, y] = [ab.rounded(), ac.rounded()];
    let n = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    let area = n.map(|x| x * x).iter().sum::<f64>().sqrt();
    -exact(&Difference::vector(wide(direction)), &ab, &ac).signum() * exact(&to(p), &ab, &ac) / area
}

#[test]
fn origins_are_off_by_what_rounding_does() {
    for device in each_width() {
        let device = quiet_on(device);
        for (what, most) in [("sphere:2k", 200.0), ("sphere:20k", 80.0), ("city-rotated:2k", 1000.0)] {
            let scene = named(what);
            let diagonal = {
                let b = scene.bounds();
                (0..3).map(|k| f64::from(b.hi[k] - b.lo[k]).powi(2)).sum::<f64>().sqrt()
            };
            let view = View { camera: scene.view(), width: 120, height: 90 };
            let mut batch = Batch::new(&device, view.pixels(), false).unwrap();
            primary(&device, &view, &mut batch, Timing::Off).unwrap();
            let rays = batch.rays.read().unwrap();
            let hits = traced(&device, &scene, &Recipe::default(), &rays, Options::default());
            let (mut lifts, mut offs, mut own) = (vec![], vec![], vec![]);
            for (i, (r, hit)) in rays.iter().zip(&hits).enumerate() {
                let Some(surface) = twin::surface_of(&scene, r, hit, i) else { continue };
                let corners = scene.corners(hit.triangle as usize);
                let [a, b, c] = corners;
                let point: [f32; 3] =
                    std::array::from_fn(|k| a[k] + (hit.u * (b[k] - a[k]) + hit.v * (c[k] - a[k])));
                let (lift, off) =
                    (height(surface.origin, corners, r.direction), height(point, corners, r.direction));
                assert!(lift > 0.0, "{what}, ray {i}: starts {lift:e} over its triangle");
                assert!(lift >= off.abs(), "{what}, ray {i}: lifted by {lift:e}, the point is {off:e} off");
                lifts.push(lift);
                offs.push(off.abs());
                own.push((surface, hit.triangle));
            }
            assert!(own.len() > 2000, "{what}: {} surfaces", own.len());
            let (lift, off) = (median(&mut lifts), median(&mut offs));
            println!(
                "{what}: lifted by {:.2e} of the diagonal, the point {:.2e} off",
                lift / diagonal,
                off / diagonal
            );
            assert!(lift <= most * off, "{what}: lifted by {lift:e}, the points are {off:e} off");
            // Along the surface, as nearly as cosine-distributed rays go, and away from it: never its own triangle.
            for grazing in [1.0 / 4096.0f32, 0.3, 1.0] {
                let leave = |(s, _): &(boxwood::abi::Surface, u32)| {
                    let n = s.normal;
                    let across =
                        if n[0].abs() > n[2].abs() { [-n[1], n[0], 0.0] } else { [0.0, -n[2], n[1]] };
                    ray(s.origin, std::array::from_fn(|k| across[k] + grazing * n[k]))
                };
                let from: Vec<Ray> = own.iter().map(leave).collect();
                for precision in Precision::ALL {
                    let options = Options { precision, ..Options::default() };
                    let hits = traced(&device, &scene, &Recipe::default(), &from, options);
                    let wrong = (0..hits.len()).find(|i| hits[*i].triangle == own[*i].1);
                    assert_eq!(wrong, None, "{what}, {precision:?}: {:?}", wrong.map(|i| (from[i], hits[i])));
                }
            }
        }
    }
}

#[test]
fn brute_force_and_the_twin_agree_on_each_triangle() {
    // Whatever boxes a tree has: the test itself is exact.
    let thin = needles(200, 8);
    let soup = scene(&thin);
    let device = quiet_on(gpu);
    let buffers = SceneBuffers::upload(&device, &soup).unwrap();
    let bvh = build(&device, &buffers, &Recipe::default(), Timing::Off).unwrap().bvh;
    let space = boxwood::oracle::morton::Space {
        exponent: bvh.exponent,
        scale: 2f32.powi(bvh.exponent),
        anchor: bvh.anchor,
        reach: bvh.reach,
    };
    let tree = bvh.read().unwrap();
    let twins = [true, false].map(|wide| boxwood::oracle::trace::Tree { tree: &tree, space: &space, wide });
    for distance in [1.0, 1e5] {
        for r in at_triangles(&thin, 300, distance, 9) {
            let through = Ray { t_min: f32::NEG_INFINITY, ..r };
            let line = Ray64::new(&through).unwrap();
            let truth: Vec<u32> = (0..thin.len() as u32)
                .filter(|i| {
                    let corners = brute::finite_corners(soup.corners(*i as usize)).unwrap();
                    brute::intersect(&line, corners, *i).is_some()
                })
                .collect();
            for twin in &twins {
                let mut crossed = twin.crossed(&through);
                crossed.sort_unstable();
                assert_eq!(crossed, truth, "doubles: {}, from {distance:e}: {r:?}", twin.wide);
            }
        }
    }
}
