//! Leaves of several triangles. Every build of `matrix` compares what is kept and how it is numbered.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::{assert_twin, build, max_leaf};
use crate::soup::{grid, random, scene};
use boxwood::abi::{INVALID, LEAF_BIT, RAW_MASK, WIDTH};
use boxwood::bvh::raw::half_area;
use boxwood::bvh::{self, Builder, Child, Collapse, Recipe, SceneBuffers};
use boxwood::device::Timing;
use boxwood::oracle::collapse::{children, is_leaf};
use boxwood::scene::Scene;

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
                for (child, _) in tree.children(node) {
                    if let Child::Leaf { count, .. } = child {
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
        assert_eq!(tree.children(&tree.nodes[0])[0].0, Child::Leaf { first: 0, count: n as u32 });
    }
}

#[test]
fn the_cost_is_that_of_the_kept_tree() {
    // A node's cost as the twin sums it, from below, equals the cost counted over the tree from its root.
    let soup = scene(&random(1500, 0.4, 4));
    for builder in Builder::ALL {
        cost_is_that_of_the_kept_tree(&soup, &Recipe { builder, ..Recipe::default() });
    }
}

fn cost_is_that_of_the_kept_tree(soup: &Scene, recipe: &Recipe) {
    let (tree, _) = boxwood::oracle::build(soup, recipe).raw.unwrap();
    let c = recipe.collapse;
    let (mut cost, mut stack) = (0.0, vec![(tree.root.node, tree.root.bounds)]);
    while let Some((child, bounds)) = stack.pop() {
        let area = f64::from(half_area(&bounds));
        let at = (child & RAW_MASK) as usize;
        if is_leaf(child) {
            let count = if child >= LEAF_BIT { 1 } else { tree.links[at].count & RAW_MASK };
            cost += f64::from(c.triangle_cost) * area * f64::from(count);
            continue;
        }
        cost += f64::from(c.traversal_cost) * area;
        let node = &tree.nodes[at];
        stack.extend([(node.left, node.left_bounds), (node.right, node.right_bounds)]);
    }
    assert!(
        (cost / f64::from(tree.root.cost) - 1.0).abs() < 1e-5,
        "{cost} counted, {} summed",
        tree.root.cost
    );
}

#[test]
fn a_packed_node_takes_in_what_it_has_room_for() {
    for (what, soup) in [("random", scene(&random(3000, 0.05, 6))), ("grid", scene(&grid(3000)))] {
        let (tree, kept) = boxwood::oracle::build(&soup, &max_leaf(1)).raw.unwrap();
        let slots = |node: u32| children(&tree, node).len();
        let mut sum = 0;
        for node in &kept.nodes {
            let here = slots(*node);
            assert!((2..=WIDTH as usize).contains(&here), "{what}: {here} children");
            sum += here;
            // A node that stands though it would fit: its parent then prefers another child of it, or is absorbed.
            let above = tree.links[*node as usize].parent;
            let room = |above: u32| slots(above) + here - 1 <= WIDTH as usize;
            assert!(above == INVALID || !room(above), "{what}: node {node} would fit in {above}");
        }
        let mean = sum as f64 / kept.nodes.len() as f64;
        assert!(mean > 3.3, "{what}: {mean} children a node");
        assert_eq!(sum, kept.nodes.len() - 1 + 3000, "{what}: every node and triangle is some node's child");
    }
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
