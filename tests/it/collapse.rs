//! Leaves of several triangles. Every build of `matrix` compares what is kept and how it is numbered.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::{assert_twin, build, max_leaf};
use crate::soup::{grid, random, scene};
use boxwood::abi::COLLAPSED_BIT;
use boxwood::bvh::{self, Child, Collapse, Recipe, SceneBuffers};
use boxwood::device::Timing;

#[test]
fn no_leaf_is_larger_than_asked() {
    let device = quiet();
    let one = random(1, 1.0, 1)[0];
    for (what, soup) in [
        ("random", scene(&random(2500, 0.5, 1))),
        ("grid", scene(&grid(2500))),
        ("alike", scene(&vec![one; 2500])),
    ] {
        for limit in [1, 2, 3, 8, 63, 64] {
            // A costly box test makes leaves as large as may be.
            let collapse = Collapse { traversal_cost: 1e6, triangle_cost: 1.0, max_leaf: limit };
            let tree = build(&device, &soup, &Recipe { collapse, ..Recipe::default() }).0.bvh.read().unwrap();
            let mut largest = 0;
            let mut triangles = 0;
            for node in &tree.nodes {
                for child in [node.left, node.right] {
                    if let Child::Leaf { count, .. } = tree.child(child) {
                        largest = largest.max(count);
                        triangles += count;
                    }
                }
            }
            assert!(largest <= limit, "{what}: a leaf of {largest}, at most {limit} asked");
            assert!(largest > limit / 2, "{what}: leaves of at most {largest} where {limit} are cheapest");
            assert_eq!(triangles, 2500, "{what}");
        }
    }
}

#[test]
fn one_leaf_is_a_tree() {
    let device = quiet();
    for n in [1, 2, 8] {
        let collapse = Collapse { traversal_cost: 1e6, triangle_cost: 1.0, max_leaf: 8 };
        let recipe = Recipe { collapse, ..Recipe::default() };
        let (built, _) = assert_twin("one leaf", &device, &scene(&random(n, 0.5, 3)), &recipe);
        let tree = built.bvh.read().unwrap();
        assert_eq!((tree.nodes.len(), tree.root), (1, 0));
        assert_eq!(tree.child(tree.nodes[0].left), Child::Leaf { first: 0, count: n as u32 });
    }
}

#[test]
fn the_heuristic_is_the_cheapest_cut() {
    // A node's cost as the twin sums it, from below, equals the cost counted over the kept tree.
    let soup = scene(&random(1500, 0.4, 4));
    let recipe = Recipe::default();
    let twin = boxwood::oracle::build(&soup, &recipe);
    let (tree, kept) = twin.raw.unwrap();
    let area = |b: &boxwood::abi::Aabb| f64::from(boxwood::oracle::ploc::half_area(b));
    let c = recipe.collapse;
    let mut cost = 0.0;
    let mut leaf = |child: u32, b| {
        let count = if child >= boxwood::abi::LEAF_BIT {
            1
        } else {
            let count = tree.nodes[child as usize].count;
            if count & COLLAPSED_BIT == 0 {
                return;
            }
            count & !COLLAPSED_BIT
        };
        cost += f64::from(c.triangle_cost) * area(b) * f64::from(count);
    };
    let mut inner = 0.0;
    for (node, packed) in tree.nodes.iter().zip(&kept.packed) {
        if *packed != boxwood::abi::INVALID {
            inner += f64::from(c.traversal_cost)
                * area(&boxwood::oracle::ploc::merged(&node.left_bounds, &node.right_bounds));
            leaf(node.left, &node.left_bounds);
            leaf(node.right, &node.right_bounds);
        }
    }
    let all = cost + inner;
    assert!((all / f64::from(tree.root.cost) - 1.0).abs() < 1e-5, "{all} counted, {} summed", tree.root.cost);
}

#[test]
fn recipes_out_of_range_are_refused() {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &scene(&random(3, 0.5, 5))).unwrap();
    let error = |recipe: &Recipe| bvh::build(&device, &buffers, recipe, Timing::Off).unwrap_err().to_string();
    for limit in [0, 65, u32::MAX] {
        let message = error(&max_leaf(limit));
        assert!(message.contains("largest leaf") && message.contains("1 to 64"), "{message}");
    }
    for radius in [0, 129] {
        let message = error(&Recipe { radius, ..Recipe::default() });
        assert!(message.contains("radius") && message.contains("1 to 128"), "{message}");
    }
    let collapse = Collapse { traversal_cost: f32::NAN, ..Recipe::default().collapse };
    assert!(error(&Recipe { collapse, ..Recipe::default() }).contains("cost"));
}
