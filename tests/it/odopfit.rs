//! Nodes fitted to bases: the device against the twin bit for bit, the boxes against their triangles, hits against those
//! of the axis-aligned tree.

#![allow(clippy::unwrap_used)]

use crate::gpu::{gpu, quiet, quiet_on};
use crate::matrix::{assert_same_tree, assert_twin, build, each_shape};
use crate::orient::{found, rays, slivers, stats};
use crate::soup::{Corners, grid, moved, named, random, scene};
use boxwood::bvh::{self, Bases, Builder, Fit, Generator, HostTree, Recipe, SceneBuffers};
use boxwood::device::{Device, Shape, Timing};
use boxwood::trace::{Batch, Options, Query};
use std::sync::{Arc, OnceLock};

/// Many nodes pay for little.
fn recipe(fit: Fit) -> Recipe {
    Recipe { fit, oriented_cost: 5.5, ..Recipe::default() }
}

fn odop(generator: Generator, degree: u32) -> Recipe {
    recipe(Fit::Odop(Bases { generator, degree }))
}

/// A device that takes `bases` up the tree together.
fn grouped(bases: u32) -> Arc<Device> {
    let options = crate::gpu::options();
    let shape = Shape { bases, ..Shape::of(gpu().info()) };
    Device::open(&boxwood::device::Options { shape: Some(shape), ..options }).unwrap()
}

#[test]
fn trees_equal_the_twins() {
    for device in each_shape() {
        let device = quiet_on(device);
        for n in [0, 1, 2, 3, 7, 63, 65, 600, 2100] {
            for builder in [Builder::Ploc, Builder::Lbvh] {
                for soup in [slivers(n, 5), random(n, 0.3, n as u64), grid(n)] {
                    let recipe = Recipe { builder, ..odop(Generator::Grid, 2) };
                    let (built, twin) = assert_twin("fitted", &device, &scene(&soup), &recipe);
                    assert_eq!(built.bvh.oriented, twin.oriented, "{n}");
                }
            }
        }
    }
}

#[test]
fn every_degree_and_generator_equals_the_twin() {
    let device = quiet();
    let soup = scene(&slivers(400, 7));
    for degree in 1..=8 {
        let (built, _) = assert_twin("degrees", &device, &soup, &odop(Generator::Grid, degree));
        // The first of the grid is no rotation.
        assert_eq!(built.bvh.oriented > 0, degree > 1, "{degree}");
    }
    for generator in Generator::ALL {
        for degree in [1, generator.most_degree().min(4)] {
            assert_twin("generators", &device, &soup, &odop(generator, degree));
        }
    }
}

#[test]
fn own_bases_and_hybrids_equal_the_twin() {
    let device = quiet();
    for (name, soup) in [("slivers", scene(&slivers(2000, 7))), ("city", named("city-rotated:3k"))] {
        for fit in [Fit::Own(16), Fit::Own(3), Fit::Hybrid] {
            let (built, twin) = assert_twin(name, &device, &soup, &recipe(fit));
            assert!(built.bvh.oriented == twin.oriented && twin.oriented > 0, "{fit:?}");
        }
    }
}

#[test]
fn thresholds_equal_the_twin() {
    for device in each_shape() {
        let device = quiet_on(device);
        for (name, soup) in [("slivers", scene(&slivers(1500, 7))), ("city", named("city-rotated:3k"))] {
            for threshold in [0, 1, 8, 60, 1500, 100_000] {
                for local_search in [0, 6] {
                    let recipe = Recipe { threshold: Some(threshold), local_search, ..recipe(Fit::Hybrid) };
                    let (built, twin) = assert_twin(name, &device, &soup, &recipe);
                    assert_eq!(built.bvh.oriented, twin.oriented, "{threshold}");
                }
            }
        }
    }
}

#[test]
fn thresholds_part_bases_from_points() {
    let device = quiet();
    let soup = named("city-rotated:3k");
    let tree = |recipe: Recipe| build(&device, &soup, &recipe).0.bvh.read().unwrap();
    let hybrid = |threshold| tree(Recipe { threshold: Some(threshold), ..recipe(Fit::Hybrid) });
    // All nodes are above, or none is.
    assert_same_tree("bases", &hybrid(0), &tree(recipe(Fit::Own(16))));
    assert_same_tree("points", &hybrid(1 << 20), &tree(recipe(Fit::Dito(14))));
    let oriented = |tree: &HostTree| tree.nodes.iter().map(|n| n.frame).collect::<Vec<_>>();
    let [bases, points] = [0, 1 << 20].map(|threshold| oriented(&hybrid(threshold)));
    let mixed = oriented(&hybrid(50));
    assert!(mixed != bases && mixed != points);
    // Each node has a frame of one or the other.
    assert!((0..mixed.len()).all(|i| mixed[i] == bases[i] || mixed[i] == points[i]));
    let buffers = SceneBuffers::upload(&device, &soup).unwrap();
    let bad = Recipe { threshold: Some(9), ..recipe(Fit::Dito(14)) };
    let error = bvh::build(&device, &buffers, &bad, Timing::Off).unwrap_err().to_string();
    assert!(error.contains("threshold") && error.contains("hybrid"), "{error}");
}

#[test]
fn groups_do_not_show() {
    static DEVICES: OnceLock<[Arc<Device>; 4]> = OnceLock::new();
    let soup = scene(&slivers(3000, 11));
    let mut first = None;
    for i in 0..4 {
        let device = quiet_on(|| &DEVICES.get_or_init(|| [1, 2, 5, 8].map(grouped))[i]);
        let tree = build(&device, &soup, &odop(Generator::Grid, 3)).0.bvh.read().unwrap();
        let first = first.get_or_insert(tree.clone());
        assert_same_tree("groups", first, &tree);
    }
}

#[test]
fn boxes_hold_their_triangles_and_are_smaller() {
    let far = |soup: &[Corners]| moved(soup, |p| p.map(|x| x + 1e4));
    let scenes = [
        ("slivers", scene(&slivers(5000, 1)), 1.0),
        ("random", scene(&random(5000, 0.1, 2)), 1.0),
        ("hairball:20k", named("hairball:20k"), 1.0),
        ("city-rotated:20k", named("city-rotated:20k"), 0.95),
        ("far", scene(&far(&slivers(2000, 3))), 1.0),
        ("tiny", scene(&moved(&slivers(2000, 4), |p| p.map(|x| x * 1e-3))), 1.0),
    ];
    for (name, scene, most) in scenes {
        let area = |fit| {
            let stats = stats(&scene, &recipe(fit));
            assert_eq!(stats.oriented > 0, fit != Fit::Aabb, "{name}, {fit:?}");
            stats.box_area / stats.aabb_area
        };
        // The grid of degree 4 holds that of degree 2.
        let [none, two, four] =
            [Fit::Aabb, odop(Generator::Grid, 2).fit, odop(Generator::Grid, 4).fit].map(area);
        assert!(two < none * most && four < two, "{name}: {four}, {two} and {none} of the axis-aligned area");
    }
}

#[test]
fn own_bases_find_a_citys_rotation() {
    let area = |fit| {
        let stats = stats(&named("city-rotated:20k"), &recipe(fit));
        stats.box_area / stats.aabb_area
    };
    let [own, dito, hybrid] = [Fit::Own(16), Fit::Dito(14), Fit::Hybrid].map(area);
    assert!(own < 0.72 && hybrid < own && hybrid < dito, "{own}, dito {dito}, hybrid {hybrid}");
}

#[test]
fn what_lies_along_the_axes_stays() {
    let device = quiet();
    for soup in [named("city:5k"), scene(&grid(2000))] {
        let buffers = SceneBuffers::upload(&device, &soup).unwrap();
        let built = bvh::build(&device, &buffers, &recipe(Fit::Own(16)), Timing::Kernels).unwrap();
        assert_eq!(built.bvh.oriented, 0);
        assert!(built.explain.iter().any(|s| s.starts_with("odopfit: skipped")), "{:?}", built.explain);
        let ran = |stage: &str| built.times.passes.iter().any(|p| p.name.starts_with(stage));
        assert!(ran("orientation") && !ran("odopfit/"));
    }
}

#[test]
fn hits_are_those_of_the_axis_aligned_tree() {
    let device = quiet();
    for (soup, at) in [(slivers(3000, 8), 0.0), (moved(&slivers(1000, 10), |p| p.map(|x| x + 1e4)), 1e4)] {
        let buffers = SceneBuffers::upload(&device, &scene(&soup)).unwrap();
        let build = |recipe| bvh::build(&device, &buffers, &recipe, Timing::Off).unwrap().bvh;
        let rays = rays(&soup, at);
        let mut batch = Batch::new(&device, rays.len(), false).unwrap();
        batch.set(&rays).unwrap();
        let plain = build(recipe(Fit::Aabb));
        for recipe in [odop(Generator::Grid, 3), odop(Generator::Sphere, 2), recipe(Fit::Hybrid)] {
            let oriented = build(recipe);
            assert!(oriented.oriented > 0);
            for query in [Query::Closest, Query::Any] {
                let options = Options { query, ..Options::default() };
                let given = found(&device, &plain, &batch, options);
                let hits = found(&device, &oriented, &batch, options);
                assert!(given.iter().filter(|h| h.is_hit()).count() > 300);
                assert_eq!(bytemuck::cast_slice::<_, u32>(&given), bytemuck::cast_slice::<_, u32>(&hits));
            }
        }
    }
}
