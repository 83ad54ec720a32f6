//! Scenes that break builders: degenerate, damaged, lopsided. Each against the twin and the f64 reference.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::assert_twin;
use crate::soup::{Corners, Random, moved, random, random_rays, ray, scene, sphere};
use boxwood::abi::{Hit, Ray};
use boxwood::bvh::{Builder, Morton, Recipe};
use boxwood::device::{Device, Timing};
use boxwood::oracle::compare::{self, Arithmetic, compare};
use boxwood::oracle::reference::Reference;
use boxwood::oracle::validate::{Claims, validate};
use boxwood::scene::Scene;
use boxwood::trace::{Batch, Options, trace};
use bytemuck::bytes_of;
use proptest::prelude::*;
use std::sync::Arc;

/// Each builder's tree against its twin and what must hold of any tree, hits against the reference. Returns PLOC's hits.
fn check(what: &str, device: &Arc<Device>, scene: &Scene, rays: &[Ray]) -> Vec<Hit> {
    let reference = Reference::new(scene);
    let [ploc, lbvh, odop, binned] = Builder::ALL.map(|builder| {
        let recipe = Recipe { builder, ..Recipe::default() };
        let (built, _) = assert_twin(what, device, scene, &recipe);
        let claims = Claims::of(&built.bvh, recipe.collapse);
        if let Err(invalid) = validate(scene, &built.bvh.read().unwrap(), &claims) {
            panic!("{what}, {builder:?}: {invalid}");
        }
        let mut batch = Batch::new(device, rays.len(), false).unwrap();
        batch.set(rays).unwrap();
        trace(device, &built.bvh, &batch, Options::default(), Timing::Off).unwrap();
        let hits = batch.hits.read().unwrap();
        let verdict = compare(&reference, rays, &hits, compare::Query::Closest, Arithmetic::Exact);
        assert!(verdict.is_clean(), "{what}, {builder:?}: {verdict}");
        hits
    });
    for (builder, hits) in [("lbvh", lbvh), ("odop2", odop), ("sah", binned)] {
        let differ = ploc.iter().zip(&hits).position(|(a, b)| bytes_of(a) != bytes_of(b));
        assert_eq!(differ, None, "{what}: a ray's hit differs between ploc and {builder}");
    }
    ploc
}

#[test]
fn five_thousand_alike() {
    let device = quiet();
    let one = random(1, 1.0, 1)[0];
    let hits = check("alike", &device, &scene(&vec![one; 5000]), &random_rays(300, 1));
    assert!(hits.iter().filter(|h| h.is_hit()).all(|h| h.triangle == 0));
}

#[test]
fn flat_and_thin_scenes() {
    let device = quiet();
    let soup = random(3000, 0.1, 2);
    let onto = |keep: [f32; 3]| moved(&soup, |p| std::array::from_fn(|k| p[k] * keep[k]));
    for (what, keep) in [
        ("flat in x", [0.0, 1.0, 1.0]),
        ("flat in z", [1.0, 1.0, 0.0]),
        ("a line", [0.0, 1.0, 0.0]),
        ("nearly flat", [1.0, 1e-6, 1.0]),
    ] {
        check(what, &device, &scene(&onto(keep)), &random_rays(500, 3));
    }
    let collinear: Vec<Corners> = soup.iter().map(|c| c.map(|p| [p[0], 2.0 * p[0], -p[0]])).collect();
    check("collinear", &device, &scene(&collinear), &random_rays(500, 4));
}

#[test]
fn damaged_triangles_are_left_out_and_numbers_stay() {
    let device = quiet();
    let good = random(2500, 0.2, 5);
    let mut corners = good.clone();
    let mut random = Random(6);
    for i in 0..corners.len() {
        match i % 5 {
            0 => corners[i][i % 3][i / 3 % 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][random.below(3)],
            1 => corners[i][1] = corners[i][0],
            2 => corners[i] = [corners[i][2]; 3],
            _ => {}
        }
    }
    let soup = scene(&corners);
    let hits = check("damaged", &device, &soup, &random_rays(1500, 7));
    assert!(hits.iter().filter(|h| h.is_hit()).all(|h| h.triangle % 5 > 2));
    let (built, _) = assert_twin("damaged", &device, &soup, &Recipe::default());
    assert_eq!((built.bvh.left_out, built.bvh.triangle_count), (1500, 1000));
    // Two of opposite zero are one place: the corners coincide.
    let zeros = scene(&[[[0.0, -0.0, 0.0], [0.0, 0.0, -0.0], [1.0, 1.0, 1.0]], good[0]]);
    for builder in Builder::ALL {
        let (built, _) = assert_twin("zeros", &device, &zeros, &Recipe { builder, ..Recipe::default() });
        assert_eq!(built.bvh.left_out, 1);
    }
}

#[test]
fn none_that_can_be_hit() {
    let device = quiet();
    for n in [0, 1, 2, 3000] {
        let hits = check("points", &device, &scene(&vec![[[1.0; 3]; 3]; n]), &random_rays(50, 8));
        assert!(hits.iter().all(|h| !h.is_hit()));
    }
}

#[test]
fn zeros_of_both_signs() {
    let device = quiet();
    let mut random = Random(9);
    let mut zero = || if random.bits() & 1 == 0 { 0.0f32 } else { -0.0 };
    // Boxes whose faces are ±0, in every order of corners; tiny spikes along z besides.
    let mut corners: Vec<Corners> = (0..2600)
        .map(|i| {
            let x = (i % 13) as f32 - 6.0;
            [[zero(), zero(), x], [x * zero(), zero(), x + 1.0], [zero(), x, zero()]]
        })
        .collect();
    for i in 0..400 {
        let z = 1e-12 * (i + 1) as f32;
        corners.push([[zero(), zero(), z], [zero(), zero(), 2.0 * z], [zero(), zero(), 3.0 * z]]);
    }
    corners.push([[zero(), zero(), 9.0], [1.0, 2.0, 9.0], [-1.0, -2.0, 3.0]]);
    check("±0", &device, &scene(&corners), &random_rays(500, 10));
    let flat = moved(&corners, |p| [p[0], p[1] * 0.0, p[2]]);
    check("±0 in a plane", &device, &scene(&flat), &random_rays(500, 10));
}

#[test]
fn a_teapot_in_a_stadium() {
    let device = quiet();
    // A stadium 1e6 across, and in its middle a ball of 1e-2, of half the triangles.
    let mut scene = sphere(24, [0.0; 3], 1e6);
    let teapot = sphere(24, [3.0, -7.0, 11.0], 1e-2);
    let shift = scene.positions.len() as u32;
    scene.positions.extend(&teapot.positions);
    scene.triangles.extend(teapot.triangles.iter().map(|t| t.map(|v| v + shift)));
    let mut random = Random(11);
    let mut rays: Vec<Ray> = (0..500).map(|_| ray([3.0, -7.0, 12.0], random.point())).collect();
    for _ in 0..500 {
        let target: [f32; 3] = std::array::from_fn(|k| [3.0, -7.0, 11.0][k] + 0.005 * random.unit());
        rays.push(ray([3.0, -7.0, 12.0], std::array::from_fn(|k| target[k] - [3.0, -7.0, 12.0][k])));
    }
    let hits = check("teapot", &device, &scene, &rays);
    assert!(hits.iter().all(Hit::is_hit), "the stadium is closed");
    assert!(hits[500..].iter().all(|h| h.triangle as usize >= scene.triangles.len() / 2));
}

#[test]
fn nested_and_growing_triangles() {
    let device = quiet();
    let one = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0f32]];
    let nested: Vec<Corners> = (0..2300)
        .map(|i| one.map(|c| c.map(|x| x * 2f32.powi(-(i % 40)) * (1.0 + i as f32 * 1e-4))))
        .collect();
    let down = |i: usize| ray([0.001 * i as f32, 0.3, 1.0], [0.0, 0.0, -1.0]);
    check("nested", &device, &scene(&nested), &(0..500).map(down).collect::<Vec<_>>());
    let concentric: Vec<Corners> = (1..=2300)
        .map(|i| {
            let s = i as f32;
            [[-s, -s, 0.0], [s, -s, 0.0], [0.0, s, 0.0]]
        })
        .collect();
    check("concentric", &device, &scene(&concentric), &(0..500).map(down).collect::<Vec<_>>());
    // One triangle across everything among many small ones.
    let mut huge = random(2300, 0.01, 12);
    huge[7] = [[-5.0, -5.0, 0.1], [5.0, -5.0, 0.1], [0.0, 9.0, 0.2]];
    check("one huge", &device, &scene(&huge), &random_rays(500, 13));
}

#[test]
fn geometric_progressions() {
    let device = quiet();
    // Each a share of the one before, towards one corner or along one axis: splits by area peel a few off at a time.
    for (what, ratio, axes) in [("halves", 0.5f32, 3), ("nearly alike", 0.99, 1), ("thirds", 1.0 / 3.0, 2)] {
        let corners: Vec<Corners> = (0..1200)
            .map(|i| {
                let s = ratio.powi(i % 120);
                let at: [f32; 3] = std::array::from_fn(|k| if k < axes { s } else { 0.0 });
                [at, at.map(|x| x + 0.1 * s), [at[0] + 0.1 * s, at[1], at[2] + 0.2 * s]]
            })
            .collect();
        check(what, &device, &scene(&corners), &random_rays(200, 14));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn lattices_equal_the_twin(
        corners in prop::collection::vec([[-3i8..=3, -3..=3, -3..=3], [-3..=3, -3..=3, -3..=3], [-3..=3, -3..=3, -3..=3]], 0..60),
        scale in prop::sample::select(vec![1.0f32, -0.0, 1e-30, 1e30]),
        radius in prop::sample::select(vec![8u32, 16]),
        builder in prop::sample::select(Builder::ALL.to_vec()),
        morton in prop::sample::select(Morton::ALL.to_vec()),
    ) {
        let device = quiet();
        let corners: Vec<Corners> = corners.iter().map(|c| c.map(|p| p.map(|x| f32::from(x) * scale))).collect();
        assert_twin("lattice", &device, &scene(&corners), &Recipe { builder, morton, radius, ..Recipe::default() });
    }

    #[test]
    fn any_floats_equal_the_twin(
        words in prop::collection::vec(any::<u32>(), 0..400),
        builder in prop::sample::select(Builder::ALL.to_vec()),
        morton in prop::sample::select(Morton::ALL.to_vec()),
    ) {
        let device = quiet();
        let corners: Vec<Corners> = words
            .chunks_exact(9)
            .map(|w| std::array::from_fn(|c| std::array::from_fn(|k| f32::from_bits(w[3 * c + k]))))
            .collect();
        assert_twin("any floats", &device, &scene(&corners), &Recipe { builder, morton, ..Recipe::default() });
    }
}
