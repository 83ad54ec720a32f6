#![allow(clippy::unwrap_used)]

use super::*;
use crate::bvh::{Collapse, Recipe};
use crate::oracle;
use crate::scene::{Generator, Progress};

/// What the twin's build hands on, and the cost of its binary tree.
fn stages(scene: &Scene, recipe: &Recipe) -> (Stages, f64) {
    let built = oracle::build(scene, recipe);
    let Some((tree, kept)) = built.raw else { return (Stages::default(), 0.0) };
    let stages = Stages {
        order: built.order,
        root: Some(tree.root),
        nodes: tree.nodes,
        cuts: tree.cuts,
        ..Stages::default()
    };
    (stages, kept.sah)
}

fn made(generator: Generator) -> Scene {
    generator.generate("mixed", 2_000, Progress::Quiet).unwrap()
}

fn near(got: f64, wanted: f64) {
    assert!((got - wanted).abs() <= 1e-4 * wanted, "{got}, not {wanted}");
}

#[test]
fn axis_aligned_it_is_the_sah_cost() {
    for generator in [Generator::Hairball, Generator::City, Generator::Sphere] {
        let scene = made(generator);
        for max_leaf in [1, 8] {
            let collapse = Collapse { max_leaf, ..Recipe::default().collapse };
            let (stages, sah) = stages(&scene, &Recipe { collapse, ..Recipe::default() });
            let mixed = measure(&scene, &stages);
            near(mixed.aabb_cost, sah);
            assert!(mixed.cost > 0.0 && mixed.cost <= mixed.aabb_cost);
        }
    }
}

/// What climbs from the children is what a look at all triangles below finds.
#[test]
fn every_place_is_measured_by_all_below() {
    for generator in [Generator::Hairball, Generator::CityRotated, Generator::Sphere] {
        let scene = made(generator);
        let (stages, _) = stages(&scene, &Recipe::default());
        let (places, order) = places(stages.root.unwrap().node, &stages.nodes, &stages.cuts);
        let points = unit_corners(&scene, order.iter().map(|r| stages.order[*r as usize] as usize));
        let mut cost = 0.0;
        for p in &places {
            let below = &points[3 * p.first..3 * (p.first + p.count)];
            let aabb = least_area(AXES, 1.0, below);
            let oriented = frame_of(below).map_or(aabb, |f| least_area(f.rows, f.stretch(), below));
            cost += match p.right {
                Some(_) => (3.0 * aabb).min(4.0 * oriented),
                None => 2.0 * p.count as f64 * aabb.min(oriented),
            };
        }
        let wanted = cost / least_area(AXES, 1.0, &points);
        let got = measure(&scene, &stages).cost;
        assert!((got - wanted).abs() <= 1e-12 * wanted, "{generator:?}: {got}, not {wanted}");
    }
}

#[test]
fn boxes_off_the_axes_cost_less() {
    let ratio = |generator| {
        let scene = made(generator);
        let mixed = measure(&scene, &stages(&scene, &Recipe::default()).0);
        mixed.cost / mixed.aabb_cost
    };
    let [upright, turned, strands] =
        [Generator::City, Generator::CityRotated, Generator::Hairball].map(ratio);
    assert!(upright > 0.98 && turned < 0.88 && strands < 0.96, "{upright}, {turned}, {strands}");
}

#[test]
fn a_leaf_costs_by_its_own_box() {
    // A quad that leans by 45°: half area 2 · √8 in its own frame, 12 along the axes.
    let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 2.0], [0.0, 2.0, 2.0]];
    let scene =
        Scene { positions: corners.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]], ..Scene::default() };
    let (stages, _) = stages(&scene, &Recipe::default());
    let Mixed { cost, aabb_cost } = measure(&scene, &stages);
    let oriented = 2.0 * 8f64.sqrt();
    near(aabb_cost, 2.0 * 2.0);
    near(cost, 2.0 * 2.0 * oriented / 12.0);
    assert_eq!(measure(&Scene::default(), &Stages::default()), Mixed::default());
}
