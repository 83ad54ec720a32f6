//! ODOP: its trees against the twin's, with boxes kept and projected anew, and what must hold of its boxes.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::{ODOP, assert_same_tree, assert_twin, build, radius};
use crate::soup::{Corners, Random, grid, moved, random, scene, sphere};
use boxwood::abi::Aabb;
use boxwood::bvh::raw::{half_area, leaf_bounds, merged};
use boxwood::bvh::{self, Bases, BuildError, Builder, Generator, Recipe, SceneBuffers};
use boxwood::device::{Device, Timing};
use boxwood::oracle::odop::project;
use boxwood::scene::Scene;
use bytemuck::bytes_of;
use std::sync::Arc;

fn odop(generator: Generator, degree: u32) -> Recipe {
    Recipe { builder: Builder::Odop(Bases { generator, degree }), ..Recipe::default() }
}

/// The least [`Recipe::memory`] with which `recipe` builds over `scene`, bytes: one basis a group at first.
fn least_memory(device: &Arc<Device>, scene: &Scene, recipe: &Recipe) -> u64 {
    let buffers = SceneBuffers::upload(device, scene).unwrap();
    match bvh::build(device, &buffers, &Recipe { memory: 0, ..*recipe }, Timing::Off) {
        Err(BuildError::Bases { needed, .. }) => needed,
        // No more boxes than a single cluster has.
        other => {
            other.unwrap();
            0
        }
    }
}

#[test]
fn every_degree_and_generator_equals_the_twin() {
    let device = quiet();
    let soup = scene(&random(130, 0.3, 1));
    for generator in Generator::ALL {
        for degree in 1..=generator.most_degree() {
            let recipe = odop(generator, degree);
            assert_twin("bases", &device, &soup, &recipe);
            let streamed = Recipe { memory: least_memory(&device, &soup, &recipe), ..recipe };
            assert_twin("bases, in groups", &device, &soup, &streamed);
        }
    }
}

#[test]
fn soups_equal_the_twin() {
    let device = quiet();
    let thin = moved(&random(2100, 0.2, 2), |[x, y, z]| [x + 0.7 * y, y - 0.6 * x, 1e-3 * z + 0.2 * x]);
    for (what, soup) in [
        ("random", scene(&random(2500, 0.05, 3))),
        ("grid", scene(&grid(2500))),
        ("thin", scene(&thin)),
        ("sphere", sphere(20, [3.0, -2.0, 1e3], 0.5)),
    ] {
        for degree in [2, 3] {
            assert_twin(what, &device, &soup, &odop(Generator::Grid, degree));
        }
        assert_twin(what, &device, &soup, &Recipe { builder: ODOP, ..radius(40) });
        assert_twin(what, &device, &soup, &Recipe { builder: ODOP, ..radius(3) });
    }
}

#[test]
fn nasty_scenes_equal_the_twin() {
    let device = quiet();
    let one = random(1, 1.0, 4)[0];
    let few = random(300, 0.2, 5);
    let mut damaged = few.clone();
    for (i, corners) in damaged.iter_mut().enumerate().filter(|(i, _)| i % 3 == 0) {
        corners[i % 2][i / 3 % 3] = [f32::NAN, f32::INFINITY, -0.0][i % 3];
    }
    let scaled = |s: f32| moved(&few, |p| p.map(|x| x * s));
    let far = moved(&few, |p| p.map(|x| 1e6 + x * 10.0));
    let soups: [(&str, Vec<Corners>); 12] = [
        ("none", vec![]),
        ("one", few[..1].to_vec()),
        ("two", few[..2].to_vec()),
        ("three", few[..3].to_vec()),
        ("all alike", vec![one; 600]),
        ("damaged", damaged),
        ("none to hit", vec![[[1.0; 3]; 3]; 9]),
        ("tiny", scaled(1e-30)),
        ("denormal", scaled(1e-41)),
        ("huge", scaled(1e37)),
        ("far out", far),
        ("flat", moved(&few, |[x, y, _]| [x, y, 0.0])),
    ];
    for (what, corners) in soups {
        for degree in [1, 2, 4] {
            let recipe = odop(Generator::Grid, degree);
            let soup = scene(&corners);
            assert_twin(what, &device, &soup, &recipe);
            let memory = least_memory(&device, &soup, &recipe);
            assert_twin(what, &device, &soup, &Recipe { memory, ..recipe });
        }
    }
}

#[test]
fn coincident_triangles_pair_up_at_once() {
    let device = quiet();
    let one = random(1, 1.0, 6)[0];
    let (all, recipe) = (scene(&vec![one; 5000]), Recipe { builder: ODOP, ..Recipe::default() });
    for memory in [4 << 30, least_memory(&device, &all, &recipe)] {
        let built = build(&device, &all, &Recipe { memory, ..recipe });
        assert!(built.0.bvh.depth <= 13 + 4, "{} rounds", built.0.bvh.depth);
    }
}

#[test]
fn without_rotations_it_is_ploc() {
    let device = quiet();
    for soup in [scene(&random(6000, 0.05, 7)), scene(&grid(3000)), sphere(30, [5.0; 3], 1.0)] {
        for r in [8, 40] {
            let (ploc, by_ploc) = build(&device, &soup, &radius(r));
            let recipe = Recipe { builder: odop(Generator::Grid, 1).builder, ..radius(r) };
            for memory in [4 << 30, least_memory(&device, &soup, &recipe)] {
                let recipe = Recipe { memory, ..recipe };
                let (odop, by_odop) = build(&device, &soup, &recipe);
                assert_same_tree("degree 1", &odop.bvh.read().unwrap(), &ploc.bvh.read().unwrap());
                assert_eq!(bytes_of(&by_odop.root.unwrap()), bytes_of(&by_ploc.root.unwrap()));
            }
        }
    }
}

#[test]
fn memory_changes_no_tree() {
    let device = quiet();
    let soup = scene(&random(20_000, 0.02, 8));
    let slab = 24 * 20_000;
    for degree in [2, 3] {
        let recipe = odop(Generator::Zone, degree);
        let (kept, _) = build(&device, &soup, &recipe);
        let all = u64::from(degree.pow(3));
        let mut rounds = vec![];
        let least = least_memory(&device, &soup, &recipe);
        // One basis a group, two and a bit, all but one, all.
        for memory in [least, least + slab * 3 / 2, least + slab * (all - 2), least + slab * (all - 1)] {
            let (built, _) = build(&device, &soup, &Recipe { memory, ..recipe });
            let what = format!("{degree} with {memory} bytes");
            assert_same_tree(&what, &built.bvh.read().unwrap(), &kept.bvh.read().unwrap());
            assert_eq!(built.bvh.depth, kept.bvh.depth, "{what}");
            // Where boxes are few it's what follows that takes the most.
            let most = memory.max(least + slab * 3);
            assert!(built.scratch_bytes <= most, "{what}: {} bytes", built.scratch_bytes);
            rounds.push(built.explain.iter().any(|s| s.contains("projected anew")));
        }
        assert_eq!(rounds, [true, true, true, false]);
    }
}

#[test]
fn too_little_memory_is_told() {
    let device = quiet();
    let soup = scene(&random(3000, 0.1, 9));
    let buffers = SceneBuffers::upload(&device, &soup).unwrap();
    let recipe = Recipe { builder: ODOP, ..Recipe::default() };
    let least = least_memory(&device, &soup, &recipe);
    bvh::build(&device, &buffers, &Recipe { memory: least, ..recipe }, Timing::Off).unwrap();
    let recipe = Recipe { memory: least - 24, ..recipe };
    let error = bvh::build(&device, &buffers, &recipe, Timing::Off).unwrap_err();
    assert!(matches!(error, BuildError::Bases { .. }), "{error}");
    assert!(error.to_string().contains("--memory"), "{error}");
    let bad = odop(Generator::Grid, 9);
    let error = bvh::build(&device, &buffers, &bad, Timing::Off).unwrap_err();
    assert!(error.to_string().contains("1 to 8"), "{error}");
    let bad = odop(Generator::Dito(14), 4);
    let error = bvh::build(&device, &buffers, &bad, Timing::Off).unwrap_err();
    assert!(error.to_string().contains("1 to 3"), "{error}");
}

#[test]
fn boxes_of_parts_unite_to_the_box_of_all() {
    let mut random = Random(10);
    let all: Vec<Corners> = crate::soup::random(40, 0.3, 11);
    for generator in Generator::ALL {
        for basis in (Bases { generator, degree: 3 }).axes() {
            let anchor = random.point();
            let of = |part: &[Corners]| project(part, &basis, 0.5, anchor);
            let split = 1 + random.below(39);
            let parts = merged(&of(&all[..split]), &of(&all[split..]));
            assert_eq!(bytes_of(&parts), bytes_of(&of(&all)));
        }
    }
    // Of no rotation: the axis-aligned box, to the bit.
    let basis = (Bases { generator: Generator::Grid, degree: 1 }).axes()[0];
    for corners in all {
        let aligned = leaf_bounds(corners, 0.5, [0.1, -0.7, 0.3]);
        assert_eq!(bytes_of(&project(&[corners], &basis, 0.5, [0.1, -0.7, 0.3])), bytes_of(&aligned));
    }
}

/// Half area of all triangles' box, the least in any basis.
fn least_area(scene: &Scene, bases: Bases) -> f32 {
    let all: Vec<Corners> = (0..scene.triangles.len()).map(|i| scene.corners(i)).collect();
    let area = |basis| half_area(&project(&all, &basis, 1.0, [0.0; 3]));
    bases.axes().into_iter().map(area).fold(f32::MAX, f32::min)
}

#[test]
fn more_bases_hold_a_tilted_slab_tighter() {
    let tilted = moved(&random(50, 0.1, 12), |[x, y, z]| [x - 0.9 * y, y + 0.9 * x, 0.01 * z]);
    let soup = scene(&tilted);
    let area = |degree| least_area(&soup, Bases { generator: Generator::Grid, degree });
    let aligned: Aabb = tilted.iter().fold(Aabb { lo: [f32::MAX; 3], hi: [f32::MIN; 3] }, |all, c| {
        merged(&all, &leaf_bounds(*c, 1.0, [0.0; 3]))
    });
    assert!((area(1) - half_area(&aligned)).abs() <= 1e-6 * area(1));
    assert!(area(2) <= area(1) && area(4) < 0.8 * area(1), "{} {} {}", area(1), area(2), area(4));
}
