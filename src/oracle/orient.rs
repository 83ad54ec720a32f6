//! Twin of `glsl/orient/*.comp`: which nodes of a packed tree are packed again in another frame.

use super::dito::{Slot, corners, extent, fit};
use super::layout::{planes, step_exponent};
use super::morton::reciprocal;
use crate::abi::{Aabb, INVALID, LEAF_BIT, Node, ORIENTED_BIT};
use crate::bvh::frame::{Frame, is_oriented};
use crate::bvh::raw::{half_area, merged};
use crate::bvh::{Child, HostTree, Recipe};

/// Costs of visits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Costs {
    pub(super) node: f32,
    pub(super) oriented: f32,
    pub(super) triangle: f32,
}

pub(super) const NOWHERE: Aabb = Aabb { lo: [f32::MAX; 3], hi: [f32::MIN; 3] };

/// Orients the nodes of `tree` where it pays; returns how many more are.
pub fn orient(tree: &mut HostTree, anchor: [f32; 3], points: u32, recipe: &Recipe) -> u32 {
    if tree.root == INVALID {
        return 0;
    }
    let slots = fit(tree, anchor, points, recipe);
    let costs = Costs::of(recipe);
    // Slot above each node.
    let mut above = vec![4 * tree.nodes.len(); tree.nodes.len()];
    for (i, node) in tree.nodes.iter().enumerate() {
        for (k, child) in node.children.iter().enumerate().filter(|(_, c)| **c < LEAF_BIT) {
            above[*child as usize] = 4 * i + k;
        }
    }
    let mut oriented = 0;
    let most = recipe.most_of_points();
    for i in (0..tree.nodes.len()).filter(|i| slots[above[*i]].range.count <= most) {
        let words = costs.choose(tree, &tree.nodes[i], &slots[4 * i..4 * i + 4], slots[above[i]].frame);
        if is_oriented(words) {
            let frame = Frame::of(words);
            let boxes: Vec<Aabb> = present(&tree.nodes[i])
                .map(|k| {
                    let range = slots[4 * i + k].range;
                    let all: Vec<_> = (range.first..range.first + range.count)
                        .flat_map(|t| corners(tree, anchor, t))
                        .collect();
                    extent(frame.rows, &all)
                })
                .collect();
            oriented += costs.pack(tree, i, words, &boxes);
        }
    }
    oriented
}

/// Which children a node has.
pub(super) fn present(node: &Node) -> impl Iterator<Item = usize> {
    (0..4).filter(|k| node.children[*k] != INVALID)
}

/// An area in a frame as it is in unit space.
pub(super) fn unstretched(area: f32, frame: &Frame) -> f32 {
    let over = reciprocal(frame.stretch());
    area * over * over
}

/// Half area of child k's box as packed, in the node's frame.
fn packed_area(node: &Node, k: usize) -> f32 {
    let [x, y, z]: [f32; 3] = std::array::from_fn(|axis| {
        let step = f32::from_bits((node.exponents >> (8 * axis) & 0xff) << 23);
        let plane = |planes: [u32; 3]| (planes[axis] >> (8 * k) & 0xff) as i32;
        (plane(node.hi) - plane(node.lo)) as f32 * step
    });
    x * (y + z) + y * z
}

impl Costs {
    pub(super) fn of(recipe: &Recipe) -> Self {
        Self {
            node: recipe.collapse.node_cost,
            oriented: recipe.oriented_cost,
            triangle: recipe.collapse.triangle_cost,
        }
    }

    /// What a ray that meets a child is expected to cost there.
    pub(super) fn of_visit(&self, child: Child) -> f32 {
        match child {
            Child::Node(_) => self.node,
            Child::Leaf { count, .. } => self.triangle * count as f32,
        }
    }

    /// Words of the frame of least expected cost.
    fn choose(&self, tree: &HostTree, node: &Node, slots: &[Slot], own: [u32; 2]) -> [u32; 2] {
        let mut candidates = vec![[0; 2], own];
        candidates.extend(present(node).map(|k| slots[k].frame));
        let mut costs = vec![0.0; candidates.len()];
        let mut all = NOWHERE;
        for k in present(node) {
            let visit = self.of_visit(tree.child(node.children[k]));
            for (c, words) in candidates.iter().enumerate() {
                if c == 0 || is_oriented(*words) {
                    let frame = Frame::of(*words);
                    let bounds = extent(frame.rows, &slots[k].points);
                    costs[c] += visit * unstretched(half_area(&bounds), &frame);
                    if c == 0 {
                        all = merged(&all, &bounds);
                    }
                }
            }
        }
        let dearer = (self.oriented - self.node) * half_area(&all);
        let mut least = (costs[0], [0; 2]);
        for (words, cost) in candidates.iter().zip(&costs).skip(1) {
            if is_oriented(*words) && cost + dearer < least.0 {
                least = (cost + dearer, *words);
            }
        }
        least.1
    }

    /// Packs node `i` again in the frame of `words`, in which its children's boxes are `boxes`, where that costs less than
    /// as it is; 1 where it wasn't oriented before.
    pub(super) fn pack(&self, tree: &mut HostTree, i: usize, words: [u32; 2], boxes: &[Aabb]) -> u32 {
        let node = tree.nodes[i];
        let bounds = boxes.iter().fold(NOWHERE, |all, b| merged(&all, b));
        let exponents: [u32; 3] = std::array::from_fn(|k| step_exponent(bounds.lo[k], bounds.hi[k]));
        let mut oriented = Node {
            origin: bounds.lo,
            exponents: exponents[0] | exponents[1] << 8 | exponents[2] << 16 | ORIENTED_BIT,
            lo: [u32::MAX; 3],
            hi: [0; 3],
            frame: words,
            ..node
        };
        for (slot, bounds) in boxes.iter().enumerate() {
            planes(&mut oriented, slot, bounds, exponents);
        }
        let area = |node: &Node, k| {
            let area = packed_area(node, k);
            if is_oriented(node.frame) { unstretched(area, &Frame::of(node.frame)) } else { area }
        };
        // The least planes and the greatest of all children: the node's own box.
        let planes_of = |planes: [u32; 3], pick: fn(u32, u32) -> u32| {
            planes.map(|p| present(&node).map(|k| p >> (8 * k) & 0xff).reduce(pick).unwrap_or(0))
        };
        let whole = Node { lo: planes_of(node.lo, u32::min), hi: planes_of(node.hi, u32::max), ..node };
        let (mut cost, mut cost_before) = (0.0, 0.0);
        if !is_oriented(node.frame) {
            cost = (self.oriented - self.node) * packed_area(&whole, 0);
        }
        for k in present(&node) {
            let visit = self.of_visit(tree.child(node.children[k]));
            cost += visit * area(&oriented, k);
            cost_before += visit * area(&node, k);
        }
        if cost < cost_before {
            tree.nodes[i] = oriented;
        }
        u32::from(cost < cost_before && !is_oriented(node.frame))
    }
}
