//! The packed tree: what every tree must be, whatever the twin says.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::{build, max_leaf};
use crate::soup::{grid, random, scene, sphere};
use boxwood::abi::{Aabb, TRIANGLE_WORDS};
use boxwood::bvh::{Bvh, Child, HostTree};
use boxwood::scene::Scene;

/// Triangles below `child` in order; each within `bounds`, as is each box.
fn walk(
    tree: &HostTree,
    anchor: [f32; 3],
    child: u32,
    bounds: &Aabb,
    triangles: &mut Vec<u32>,
    depth: &mut u32,
) {
    match tree.child(child) {
        Child::Leaf { first, count } => {
            for place in first..first + count {
                triangles.push(place);
                let at = (place * TRIANGLE_WORDS) as usize;
                for k in 0..9 {
                    let x = f32::from_bits(tree.triangles[at + k]) - anchor[k % 3];
                    let (lo, hi) = (bounds.lo[k % 3], bounds.hi[k % 3]);
                    assert!(lo <= x && x <= hi, "triangle {place} sticks out: {lo} <= {x} <= {hi}");
                }
            }
        }
        Child::Node(i) => {
            *depth += 1;
            let node = &tree.nodes[i as usize];
            let mut deepest = 0;
            for (b, child) in [(&node.left_bounds, node.left), (&node.right_bounds, node.right)] {
                for k in 0..3 {
                    let (lo, hi) = (bounds.lo[k], bounds.hi[k]);
                    assert!(
                        lo <= b.lo[k] && b.hi[k] <= hi,
                        "node {i}: child {child:#x} sticks out: {b:?} of {bounds:?}"
                    );
                }
                let mut below = *depth;
                walk(tree, anchor, child, b, triangles, &mut below);
                deepest = deepest.max(below);
            }
            *depth = deepest;
        }
    }
}

fn assert_valid(what: &str, scene: &Scene, bvh: &Bvh) {
    let tree = bvh.read().unwrap();
    let (mut places, mut depth) = (vec![], 0);
    walk(&tree, bvh.anchor, bvh.root, &bvh.bounds, &mut places, &mut depth);
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
    let reach = tree.nodes.iter().flat_map(|n| [n.left_bounds.lo, n.left_bounds.hi]).flatten();
    assert!(reach.fold(0.0, |a, x| f32::max(a, x.abs())) <= bvh.reach, "{what}: reach {}", bvh.reach);
    assert!(tree.nodes.iter().all(|n| n.pad == [0; 2]), "{what}: padding is 0");
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
