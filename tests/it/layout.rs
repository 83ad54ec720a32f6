//! The packed tree: what every tree must be, whatever the twin says.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::{build, max_leaf};
use crate::soup::{grid, random, scene, sphere};
use boxwood::abi::TRIANGLE_WORDS;
use boxwood::bvh::{Bvh, Child, HostTree};
use boxwood::scene::Scene;

/// Places of the triangles below `child`, which must lie within `bounds` but for rounding, and the levels of nodes.
fn walk(tree: &HostTree, bvh: &Bvh, child: Child, bounds: &[[f64; 3]; 2], places: &mut Vec<u32>) -> u32 {
    let from = places.len();
    let levels = match child {
        Child::Leaf { first, count } => {
            places.extend(first..first + count);
            0
        }
        Child::Node(i) => {
            let children = tree.children(&tree.nodes[i as usize]);
            let below = children.iter().map(|(child, b)| walk(tree, bvh, *child, &b.corners, places));
            1 + below.max().unwrap()
        }
    };
    let slack = f64::from(bvh.reach) * f64::from(f32::EPSILON);
    for place in &places[from..] {
        let at = (place * TRIANGLE_WORDS) as usize;
        for k in 0..9 {
            let x = f64::from(f32::from_bits(tree.triangles[at + k])) - f64::from(bvh.anchor[k % 3]);
            let (lo, hi) = (bounds[0][k % 3] - slack, bounds[1][k % 3] + slack);
            assert!(lo <= x && x <= hi, "triangle {place} sticks out of {child:?}: {lo} <= {x} <= {hi}");
        }
    }
    levels
}

fn assert_valid(what: &str, scene: &Scene, bvh: &Bvh) {
    let tree = bvh.read().unwrap();
    let mut places = vec![];
    let bounds = [bvh.bounds.lo, bvh.bounds.hi].map(|p| p.map(f64::from));
    let depth = walk(&tree, bvh, Child::Node(bvh.root), &bounds, &mut places);
    let count = bvh.triangle_count as usize;
    assert!(depth <= bvh.depth, "{what}: {depth} levels, {} said", bvh.depth);
    let mut inputs: Vec<u32> = places.iter().map(|p| tree.input_index(*p as usize)).collect();
    places.sort_unstable();
    assert_eq!(places, (0..count as u32).collect::<Vec<_>>(), "{what}: each place once");
    inputs.sort_unstable();
    inputs.dedup();
    assert_eq!(inputs.len(), count, "{what}: each triangle once");
    for place in 0..count {
        let at = place * TRIANGLE_WORDS as usize;
        let corners = scene.corners(tree.input_index(place) as usize);
        let scale = 2f32.powi(bvh.exponent);
        for (k, x) in corners.iter().flatten().enumerate() {
            assert_eq!(tree.triangles[at + k], (x * scale).to_bits(), "{what}: triangle {place}, word {k}");
        }
    }
    let reach = tree.nodes.iter().flat_map(|n| n.origin);
    assert!(reach.fold(0.0, |a, x| f32::max(a, x.abs())) <= bvh.reach, "{what}: reach {}", bvh.reach);
    assert!(tree.nodes.iter().all(|n| n.frame == [0; 2]), "{what}: along the axes");
}

#[test]
fn packed_trees_are_valid() {
    let device = quiet();
    for (what, soup) in [
        ("random", scene(&random(5000, 0.1, 1))),
        ("grid", scene(&grid(5000))),
        ("sphere", sphere(20, [1e3, -5.0, 0.0], 2.0)),
        ("two", scene(&random(2, 0.1, 2))),
    ] {
        for leaf in [1, 8, 64] {
            assert_valid(what, &soup, &build(&device, &soup, &max_leaf(leaf)).0.bvh);
        }
    }
}
