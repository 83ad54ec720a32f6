//! Oriented nodes: the device against the twin bit for bit, the boxes against their triangles, hits against those of the
//! axis-aligned tree.

#![allow(clippy::unwrap_used)]

use crate::gpu::{quiet, quiet_on};
use crate::matrix::{assert_twin, each_shape};
use crate::soup::{Corners, grid, moved, named, random, random_rays, ray, scene};
use boxwood::abi::{Hit, Ray};
use boxwood::bvh::{self, Builder, Directions, Fit, Recipe, SceneBuffers};
use boxwood::device::{Device, Timing};
use boxwood::oracle::validate::{Claims, Stats, validate};
use boxwood::scene::Scene;
use boxwood::trace::{Batch, Options, Query, RayOrder, Walk, trace};
use std::sync::Arc;

/// Many nodes pay for little.
fn dito(points: u32) -> Recipe {
    Recipe { fit: Fit::Dito(points), oriented_cost: 5.5, ..Recipe::default() }
}

/// Thin triangles in all directions.
pub fn slivers(n: usize, seed: u64) -> Vec<Corners> {
    let long = random(n, 0.2, seed);
    long.iter().map(|[a, b, _]| [*a, *b, std::array::from_fn(|k| b[k] + 1e-3 * (k as f32 - 1.0))]).collect()
}

/// What the device's tree is like, sound as it must be.
pub fn stats(scene: &Scene, recipe: &Recipe) -> Stats {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, scene).unwrap();
    let bvh = bvh::build(&device, &buffers, recipe, Timing::Off).unwrap().bvh;
    let stats = validate(scene, &bvh.read().unwrap(), &Claims::of(&bvh, recipe.collapse)).unwrap();
    assert_eq!(stats.oriented, bvh.oriented as usize);
    stats
}

#[test]
fn trees_equal_the_twins() {
    for device in each_shape() {
        let device = quiet_on(device);
        for n in [0, 1, 2, 3, 7, 63, 64, 65, 600, 4100] {
            for builder in [Builder::Ploc, Builder::Lbvh] {
                let recipe = Recipe { builder, ..dito(14) };
                for soup in [slivers(n, 5), random(n, 0.3, n as u64), grid(n)] {
                    let (built, twin) = assert_twin("oriented", &device, &scene(&soup), &recipe);
                    assert_eq!(built.bvh.oriented, twin.oriented, "{n}");
                }
            }
        }
    }
}

#[test]
fn every_fit_equals_the_twin() {
    let device = quiet();
    let soup = scene(&slivers(3000, 7));
    // Bases: see odopfit.
    for fit in Fit::ALL.into_iter().filter(|fit| fit.bases().is_none()) {
        let (built, _) = assert_twin("fits", &device, &soup, &Recipe { fit, ..dito(14) });
        assert_eq!(built.bvh.oriented > 0, fit != Fit::Aabb);
    }
}

#[test]
fn generated_directions_equal_the_twins() {
    for device in each_shape() {
        let device = quiet_on(device);
        for directions in Directions::ALL {
            for (points, n) in [(12, 65), (14, 600), (20, 300), (26, 300)] {
                let recipe = Recipe { directions, ..dito(points) };
                let soup = scene(&random(n, 0.3, n as u64));
                let (built, _) = assert_twin("directions", &device, &soup, &recipe);
                assert!(built.bvh.oriented > 0, "{directions:?}, {points} points");
            }
        }
    }
}

#[test]
fn directions_matter_and_want_dito() {
    let soup = scene(&random(2000, 0.1, 3));
    let areas = Directions::ALL.map(|directions| {
        let stats = stats(&soup, &Recipe { directions, ..dito(14) });
        (stats.box_area / stats.aabb_area).to_bits()
    });
    assert!((1..5).all(|i| !areas[..i].contains(&areas[i])), "{areas:?}");
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &soup).unwrap();
    let bad = Recipe { directions: Directions::Zone, ..Recipe::default() };
    let error = bvh::build(&device, &buffers, &bad, Timing::Off).unwrap_err().to_string();
    assert!(error.contains("zone") && error.contains("dito14"), "{error}");
}

#[test]
fn local_search_equals_the_twins() {
    for device in each_shape() {
        let device = quiet_on(device);
        for points in [12, 14, 20, 26] {
            for (n, local_search) in [(1, 24), (65, 1), (300, 24), (100, 100)] {
                let recipe = Recipe { local_search, ..dito(points) };
                for soup in [slivers(n, 6), random(n, 0.3, n as u64), grid(n)] {
                    let what = format!("{points} points, {local_search} evaluations");
                    assert_twin(&what, &device, &scene(&soup), &recipe);
                }
            }
        }
    }
}

#[test]
fn local_search_makes_boxes_smaller() {
    for (name, scene) in [("hairball:5k", named("hairball:5k")), ("sphere:5k", named("sphere:5k"))] {
        for points in [14, 26] {
            let share = |local_search| {
                let stats = stats(&scene, &Recipe { local_search, ..dito(points) });
                stats.box_area / stats.aabb_area
            };
            let (before, after) = (share(0), share(24));
            assert!(after < before, "{name}, {points} points: {before} became {after}");
        }
    }
}

#[test]
fn boxes_hold_their_triangles_and_are_smaller() {
    let scenes = [
        ("slivers", scene(&slivers(5000, 1)), 0.97),
        ("random", scene(&random(5000, 0.1, 2)), 1.0),
        ("hairball:20k", named("hairball:20k"), 0.98),
        ("city-rotated:20k", named("city-rotated:20k"), 0.75),
        ("sphere:20k", named("sphere:20k"), 0.98),
        ("far", scene(&moved(&slivers(2000, 3), |p| p.map(|x| x + 1e4))), 0.98),
        ("tiny", scene(&moved(&slivers(2000, 4), |p| p.map(|x| x * 1e-3))), 0.98),
    ];
    for (name, scene, most) in scenes {
        for points in [12, 14, 20, 26] {
            let stats = stats(&scene, &dito(points));
            assert!(stats.oriented > 0, "{name}");
            let share = stats.box_area / stats.aabb_area;
            assert!(share < most, "{name}, {points} points: {share} of the axis-aligned area");
        }
    }
}

#[test]
fn what_lies_along_the_axes_stays() {
    for name in ["city:5k", "city:20k"] {
        let stats = stats(&named(name), &dito(14));
        // A row of boxes may run across the axes.
        assert!(stats.oriented * 1000 < stats.nodes, "{name}: {} of {} nodes", stats.oriented, stats.nodes);
    }
    assert_eq!(stats(&scene(&grid(2000)), &dito(26)).oriented, 0);
}

pub fn found(device: &Arc<Device>, bvh: &bvh::Bvh, batch: &Batch, options: Options) -> Vec<Hit> {
    trace(device, bvh, batch, options, Timing::Off).unwrap();
    batch.hits.read_first(batch.count).unwrap()
}

/// Rays at the corners and along the edges of triangles around (`at`, `at`, `at`), along the axes, and from everywhere.
pub fn rays(soup: &[Corners], at: f32) -> Vec<Ray> {
    let mut rays = random_rays(1500, 3);
    rays.iter_mut().for_each(|r| r.origin = r.origin.map(|x| x + at));
    for (i, [a, b, c]) in soup.iter().enumerate().step_by(soup.len().div_ceil(700)) {
        let from = [2.0 + at, -1.5 + i as f32 * 1e-3 + at, 1.0 + at];
        let towards = |p: &[f32; 3]| std::array::from_fn(|k| p[k] - from[k]);
        rays.extend([a, b, c].map(|p| ray(from, towards(p))));
        rays.push(ray(*a, std::array::from_fn(|k| b[k] - a[k])));
        let mut axis = [0.0, -0.0, 0.0];
        axis[i % 3] = if i % 2 == 0 { 1.0 } else { -1.0 };
        rays.push(ray(std::array::from_fn(|k| a[k] - 3.0 * axis[k]), axis));
    }
    rays
}

#[test]
fn hits_are_those_of_the_axis_aligned_tree() {
    let far = |soup: &[Corners]| moved(soup, |p| p.map(|x| x + 1e4));
    let soups = [(slivers(3000, 8), 0.0), (random(3000, 0.2, 9), 0.0), (far(&slivers(1000, 10)), 1e4)];
    for device in each_shape() {
        let device = quiet_on(device);
        for (soup, at) in &soups {
            let scene = scene(soup);
            let buffers = SceneBuffers::upload(&device, &scene).unwrap();
            let build =
                |fit| bvh::build(&device, &buffers, &Recipe { fit, ..dito(14) }, Timing::Off).unwrap().bvh;
            let (plain, oriented) = (build(Fit::Aabb), build(Fit::Dito(14)));
            assert!(oriented.oriented > 0 && plain.oriented == 0);
            let rays = rays(soup, *at);
            let mut batch = Batch::new(&device, rays.len(), false).unwrap();
            batch.set(&rays).unwrap();
            for query in [Query::Closest, Query::Any] {
                let given = found(&device, &plain, &batch, Options { query, ..Options::default() });
                let hits = given.iter().filter(|h| h.is_hit()).count();
                assert!(hits > 300, "{hits}");
                for walk in Walk::all(&device) {
                    let options =
                        Options { query, walk: *walk, order: RayOrder::AsGiven, ..Options::default() };
                    let hits = found(&device, &oriented, &batch, options);
                    for (i, (a, b)) in given.iter().zip(&hits).enumerate() {
                        let (a, b): ([u32; 4], [u32; 4]) = (bytemuck::cast(*a), bytemuck::cast(*b));
                        assert_eq!(a, b, "{walk:?}, {query:?}: ray {i}, {:?}", rays[i]);
                    }
                }
            }
        }
    }
}
