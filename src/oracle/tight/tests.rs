#![allow(clippy::unwrap_used)]

use super::*;
use crate::bvh::{Collapse, Fit, Recipe};
use crate::oracle::quality;
use crate::oracle::validate::Claims;
use crate::oracle::{self, Built};
use crate::scene::{Generator, Progress, Scene};

fn scene(generator: Generator) -> Scene {
    generator.generate("tight", 2_000, Progress::Quiet).unwrap()
}

fn built(scene: &Scene, fit: Fit) -> (Built, Aabb) {
    let built = oracle::build(scene, &Recipe { fit, ..Recipe::default() });
    let bounds = built.raw.as_ref().map_or(Aabb { lo: [0.0; 3], hi: [0.0; 3] }, |(raw, _)| raw.root.bounds);
    (built, bounds)
}

fn tightness((built, bounds): &(Built, Aabb)) -> Tightness {
    measure(&built.tree, built.space.anchor, bounds)
}

fn near(what: &str, got: f64, wanted: f64) {
    assert!((got - wanted).abs() <= 1e-4 * wanted.abs(), "{what}: {got}, not {wanted}");
}

/// By the definition, in f64, from the root down.
#[derive(Default)]
struct Definition {
    boxes: usize,
    aligned: usize,
    aligned_area: f64,
    /// Nodes, leaves.
    areas: [f64; 2],
    aabb_areas: [f64; 2],
    cost: f64,
    aabb_cost: f64,
}

impl Definition {
    fn triangles(tree: &HostTree, child: Child) -> Vec<u32> {
        match child {
            Child::Leaf { first, count } => (first..first + count).collect(),
            Child::Node(n) => {
                let children = tree.children(&tree.nodes[n as usize]);
                children.iter().flat_map(|(c, _)| Self::triangles(tree, *c)).collect()
            }
        }
    }

    fn add(&mut self, tree: &HostTree, anchor: [f32; 3], node: u32, area: f64, aabb_area: f64) {
        let children = tree.children(&tree.nodes[node as usize]);
        let half_area = |points: &[[f64; 3]]| {
            let edge = |k: usize| {
                let of = |start, pick: fn(f64, f64) -> f64| points.iter().map(|p| p[k]).fold(start, pick);
                of(f64::NEG_INFINITY, f64::max) - of(f64::INFINITY, f64::min)
            };
            edge(0) * edge(1) + edge(1) * edge(2) + edge(2) * edge(0)
        };
        for (child, volume) in &children {
            let corners = Self::triangles(tree, *child).into_iter().flat_map(|t| tree.corners(t as usize));
            let points: Vec<[f64; 3]> =
                corners.map(|p| std::array::from_fn(|k| f64::from(p[k] - anchor[k]))).collect();
            let stretch = volume.frame.map_or(1.0, |f| f64::from(f.stretch()));
            let within: Vec<_> = points.iter().map(|p| volume.within(*p)).collect();
            let (own, aabb) = (half_area(&within) / (stretch * stretch), half_area(&points));
            let test = if volume.frame.is_some() { 2.0 } else { 1.5 };
            self.cost += test * area;
            self.aabb_cost += 1.5 * aabb_area;
            self.boxes += 1;
            if volume.frame.is_none() {
                self.aligned += 1;
                self.aligned_area += own;
            }
            let kind = usize::from(matches!(child, Child::Leaf { .. }));
            self.areas[kind] += own;
            self.aabb_areas[kind] += aabb;
            match *child {
                Child::Node(node) => self.add(tree, anchor, node, own, aabb),
                Child::Leaf { count, .. } => {
                    self.cost += 2.0 * f64::from(count) * own;
                    self.aabb_cost += 2.0 * f64::from(count) * aabb;
                }
            }
        }
    }
}

#[test]
fn measures_are_their_definitions() {
    for generator in [Generator::Hairball, Generator::CityRotated, Generator::Soup] {
        let scene = scene(generator);
        let (built, bounds) = &built(&scene, Fit::Dito(14));
        assert!(built.oriented > 0);
        let got = measure(&built.tree, built.space.anchor, bounds);
        let mut d = Definition::default();
        let area = f64::from(half_area(bounds));
        d.add(&built.tree, built.space.anchor, built.tree.root, area, area);
        let total = |a: [f64; 2]| a[0] + a[1];
        assert_eq!(got.boxes, d.boxes);
        near("share", got.aabb_share, d.aligned as f64 / d.boxes as f64);
        near("share by area", got.aabb_area_share, d.aligned_area / total(d.areas));
        near("inner", got.inner_area, d.areas[0] / d.aabb_areas[0]);
        near("leaf", got.leaf_area, d.areas[1] / d.aabb_areas[1]);
        near("total", got.total_area, total(d.areas) / total(d.aabb_areas));
        near("cost", got.cost, d.cost / area);
        near("AABB's cost", got.aabb_cost, d.aabb_cost / area);
    }
}

#[test]
fn axis_aligned_trees_are_their_own_measure() {
    let (scene, recipe) = (scene(Generator::Hairball), Recipe::default());
    let aligned = built(&scene, Fit::Aabb);
    let t = tightness(&aligned);
    assert_eq!(
        (t.aabb_share, t.aabb_area_share, t.inner_area, t.leaf_area, t.total_area),
        (1.0, 1.0, 1.0, 1.0, 1.0)
    );
    assert_eq!(t.cost, t.aabb_cost);
    // The same tree, were its boxes not oriented.
    near("the tree before", tightness(&built(&scene, Fit::Dito(14))).aabb_cost, t.cost);
    let (built, bounds) = aligned;
    let claims = Claims {
        exponent: built.space.exponent,
        anchor: built.space.anchor,
        reach: built.space.reach,
        bounds,
        depth: 64,
        sah: 0.0,
        left_out: 0,
        collapse: Collapse { traversal_cost: 3.0, triangle_cost: 2.0, ..recipe.collapse },
    };
    near("wide SAH cost", t.cost, quality::measure(&built.tree, &claims).wide_sah);
}

#[test]
fn turned_boxes_cost_less_and_upright_ones_the_same() {
    let turned = tightness(&built(&scene(Generator::CityRotated), Fit::Dito(14)));
    assert!(turned.cost < 0.9 * turned.aabb_cost && turned.aabb_share < 0.5, "{turned:?}");
    let upright = tightness(&built(&scene(Generator::City), Fit::Dito(14)));
    assert!(upright.cost <= 1.0001 * upright.aabb_cost && upright.aabb_share > 0.99, "{upright:?}");
}

#[test]
fn next_to_nothing_is_measured() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let one = Scene { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Scene::default() };
    let t = tightness(&built(&one, Fit::Aabb));
    assert_eq!((t.boxes, t.cost, t.aabb_share), (1, 2.0, 1.0));
    assert_eq!(tightness(&built(&Scene::default(), Fit::Aabb)), Tightness::default());
}
