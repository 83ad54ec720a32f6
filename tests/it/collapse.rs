//! The packed tree's nodes and leaves, against every cut there is. Every build of `matrix` compares what is kept and how it
//! is numbered.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::{assert_twin, build, max_leaf};
use crate::soup::{Corners, grid, random, scene};
use boxwood::abi::{Aabb, KEPT_BIT, LEAF_BIT, RAW_MASK, WIDTH};
use boxwood::bvh::raw::{HostRawTree, half_area};
use boxwood::bvh::{self, Builder, Child, Collapse, Recipe, SceneBuffers};
use boxwood::device::Timing;
use boxwood::oracle::collapse::{Kept, children, is_leaf};

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
            // A costly node makes leaves as large as may be.
            let collapse = Collapse {
                node_cost: 1e6,
                triangle_cost: 1.0,
                max_leaf: limit,
                ..Recipe::default().collapse
            };
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
        let collapse = Collapse { node_cost: 1e6, triangle_cost: 1.0, ..Recipe::default().collapse };
        let recipe = Recipe { collapse, ..Recipe::default() };
        let (built, _) = assert_twin("one leaf", &device, &scene(&random(n, 0.5, 3)), &recipe);
        let tree = built.bvh.read().unwrap();
        assert_eq!((tree.nodes.len(), tree.root), (1, 0));
        assert_eq!(tree.children(&tree.nodes[0])[0].0, Child::Leaf { first: 0, count: n as u32 });
    }
}

/// The twin's tree of `corners`, what is kept of it, and the cost that the merges say.
fn cut(corners: &[Corners], recipe: &Recipe) -> (HostRawTree, Kept, f64) {
    let (tree, kept) = boxwood::oracle::build(&scene(corners), recipe).raw.unwrap();
    let cost = f64::from(tree.root.cost);
    (tree, kept, cost)
}

/// Triangles below a reference.
fn count(tree: &HostRawTree, child: u32) -> u32 {
    if child >= LEAF_BIT { 1 } else { tree.cuts[(child & RAW_MASK) as usize].count }
}

/// What the leaf `child` costs.
fn leaf_cost(tree: &HostRawTree, (child, bounds): (u32, Aabb), c: &Collapse) -> f64 {
    f64::from(c.triangle_cost) * f64::from(half_area(&bounds)) * f64::from(count(tree, child))
}

/// What the packed tree costs, its nodes and leaves one by one.
fn cost_of_kept(tree: &HostRawTree, c: &Collapse) -> f64 {
    let (mut cost, mut stack) = (0.0, vec![(tree.root.node, tree.root.bounds)]);
    while let Some((child, bounds)) = stack.pop() {
        if is_leaf(child) {
            cost += leaf_cost(tree, (child, bounds), c);
        } else {
            cost += f64::from(c.node_cost) * f64::from(half_area(&bounds));
            stack.extend(children(tree, child));
        }
    }
    cost
}

/// Every set of at most `most` subtrees that together are `child`.
fn covers(tree: &HostRawTree, child: (u32, Aabb), most: usize) -> Vec<Vec<(u32, Aabb)>> {
    let mut found = vec![vec![child]];
    if child.0 >= LEAF_BIT || most < 2 {
        return found;
    }
    let node = &tree.nodes[(child.0 & RAW_MASK) as usize];
    for left in covers(tree, (node.left, node.left_bounds), most - 1) {
        for right in covers(tree, (node.right, node.right_bounds), most - left.len()) {
            found.push([&left[..], &right].concat());
        }
    }
    found
}

/// The least that any packed tree of `child` costs: a leaf, or a node of any of its covers.
fn least_cost(tree: &HostRawTree, child: (u32, Aabb), c: &Collapse) -> f64 {
    let as_leaf = if count(tree, child.0) <= c.max_leaf { leaf_cost(tree, child, c) } else { f64::INFINITY };
    let node = f64::from(c.node_cost) * f64::from(half_area(&child.1));
    let of_cover = |cover: &Vec<_>| node + cover.iter().map(|one| least_cost(tree, *one, c)).sum::<f64>();
    let covers = covers(tree, child, WIDTH as usize);
    covers.iter().filter(|cover| cover.len() > 1).map(of_cover).fold(as_leaf, f64::min)
}

/// Builders whose costs are those of axis-aligned boxes.
const ALIGNED: [Builder; 3] = [Builder::Ploc, Builder::Lbvh, Builder::Binned];

#[test]
fn no_cut_costs_less() {
    let alike = vec![random(1, 1.0, 1)[0]; 7];
    let mut cases = vec![alike];
    for seed in 0..40 {
        cases.push(random(1 + seed as usize % 10, [0.05, 0.3, 1.0][seed as usize % 3], seed));
    }
    for corners in cases {
        for builder in ALIGNED {
            for (node_cost, max_leaf) in [(4.0, 8), (4.0, 1), (0.3, 3), (20.0, 4)] {
                let collapse = Collapse { node_cost, max_leaf, ..Recipe::default().collapse };
                let recipe = Recipe { builder, collapse, ..Recipe::default() };
                let (tree, _, cost) = cut(&corners, &recipe);
                let what = format!("{} triangles, {recipe:?}", corners.len());
                let least =
                    least_cost(&tree, (tree.root.node & (LEAF_BIT | RAW_MASK), tree.root.bounds), &collapse);
                let kept = cost_of_kept(&tree, &collapse);
                assert!((cost / least - 1.0).abs() < 1e-5, "{what}: {cost}, and {least} is possible");
                assert!((kept / least - 1.0).abs() < 1e-5, "{what}: the tree costs {kept}, not {least}");
            }
        }
    }
}

#[test]
fn the_cost_is_that_of_the_kept_tree() {
    for builder in ALIGNED {
        let recipe = Recipe { builder, ..Recipe::default() };
        let (tree, kept, cost) = cut(&random(1500, 0.4, 4), &recipe);
        let counted = cost_of_kept(&tree, &recipe.collapse);
        assert!((counted / cost - 1.0).abs() < 1e-5, "{builder:?}: {counted} counted, {cost} summed");
        assert!(kept.count > 100);
        for (i, cut) in (0..).zip(&tree.cuts) {
            assert_eq!(cut.choices & KEPT_BIT != 0, kept.nodes.contains(&i), "{builder:?}: mark of {i}");
        }
    }
}

/// Below each other in PLOC's tree: a level each.
fn chain(n: usize) -> Vec<Corners> {
    let growth = |i| 1.1f32.powi(i as i32);
    (0..n).map(growth).map(|s| [[-s, -s, 0.0], [s, -s, 0.0], [0.0, s, 0.1 * s]]).collect()
}

/// More levels of packed nodes than one submit has rounds: the rest follow.
#[test]
fn a_chain_is_followed_to_its_end() {
    let device = quiet();
    for n in [5, 64, 65, 200, 240] {
        for leaf in [1, 8] {
            let corners = chain(n);
            let (built, twin) = assert_twin("chain", &device, &scene(&corners), &max_leaf(leaf));
            let (_, kept) = twin.raw.unwrap();
            assert_eq!(built.bvh.depth as usize, n - 1, "a chain");
            if (n, leaf) == (240, 1) {
                assert!(kept.count > 64, "{} rounds are few", kept.count);
            }
        }
    }
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
            // One less would cost less.
            for (child, _) in children(&tree, *node).into_iter().filter(|(child, _)| !is_leaf(*child)) {
                let merged = here - 1 + slots(child);
                assert!(merged > WIDTH as usize, "{what}: node {child} would fit in {node}");
            }
        }
        let mean = sum as f64 / kept.nodes.len() as f64;
        assert!(mean > 3.0, "{what}: {mean} children a node");
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
