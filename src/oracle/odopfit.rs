//! Twin of `glsl/odopfit/climb.comp`: which nodes of a packed tree are packed again in one of a set of frames.

use super::dito::{corners, extent};
use super::orient::{Costs, NOWHERE, present, unstretched};
use crate::abi::{Aabb, INVALID};
use crate::bvh::frame::{Frame, is_oriented};
use crate::bvh::raw::{half_area, merged};
use crate::bvh::{Child, HostTree, Recipe};
use glam::Vec3;

/// Orients the nodes of `tree` where one of `frames` pays; returns how many.
pub fn fit(tree: &mut HostTree, anchor: [f32; 3], frames: &[[u32; 2]], recipe: &Recipe) -> u32 {
    if tree.root == INVALID {
        return 0;
    }
    let costs = Costs::of(recipe);
    let mut oriented = 0;
    for i in 0..tree.nodes.len() {
        let below: Vec<Vec<Vec3>> = present(&tree.nodes[i])
            .map(|k| {
                let mut all = vec![];
                gather(tree, anchor, tree.nodes[i].children[k], &mut all);
                all
            })
            .collect();
        // Three corners a triangle.
        let count: usize = below.iter().map(|all| all.len() / 3).sum();
        if count as u32 <= recipe.least_of_bases() {
            continue;
        }
        if let Some((words, boxes)) = choose(tree, &costs, i, &below, frames) {
            oriented += costs.pack(tree, i, words, &boxes);
        }
    }
    oriented
}

/// Corners of all triangles below a child, left to right.
fn gather(tree: &HostTree, anchor: [f32; 3], child: u32, all: &mut Vec<Vec3>) {
    match tree.child(child) {
        Child::Node(i) => {
            let node = &tree.nodes[i as usize];
            present(node).for_each(|k| gather(tree, anchor, node.children[k], all));
        }
        Child::Leaf { first, count } => {
            all.extend((first..first + count).flat_map(|t| corners(tree, anchor, t)));
        }
    }
}

/// Of `frames` the first in which node `i` costs least, if that is less than along the axes, and its children's boxes.
fn choose(
    tree: &HostTree,
    costs: &Costs,
    i: usize,
    below: &[Vec<Vec3>],
    frames: &[[u32; 2]],
) -> Option<([u32; 2], Vec<Aabb>)> {
    let node = &tree.nodes[i];
    let in_frame = |words: [u32; 2]| {
        let frame = Frame::of(words);
        let boxes: Vec<Aabb> = below.iter().map(|all| extent(frame.rows, all)).collect();
        let mut cost = 0.0;
        for (k, bounds) in present(node).zip(&boxes) {
            cost += costs.of_visit(tree.child(node.children[k])) * half_area(bounds);
        }
        (frame, cost, boxes)
    };
    let (_, along_axes, boxes) = in_frame([0; 2]);
    let own = boxes.iter().fold(NOWHERE, |all, b| merged(&all, b));
    let mut least = along_axes - (costs.oriented - costs.node) * half_area(&own);
    let mut best = None;
    for words in frames.iter().filter(|words| is_oriented(**words)) {
        let (frame, cost, boxes) = in_frame(*words);
        let cost = unstretched(cost, &frame);
        if cost < least {
            (least, best) = (cost, Some((*words, boxes)));
        }
    }
    best
}
