//! Twin of `glsl/recut/*.comp`: the cuts of a binary tree by the areas of DiTO's boxes.

use super::collapse::{expand, number};
use super::dito::{Slot, extent, fit};
use super::layout;
use super::morton::Space;
use super::orient::unstretched;
use crate::abi::{Aabb, COLLAPSED_BIT, Cluster, LEAF_BIT, RAW_MASK, RawCut, RawNode};
use crate::bvh::Recipe;
use crate::bvh::frame::{Frame, is_oriented};
use crate::bvh::raw::{HostRawTree, cheapest, half_area, least_of, merged};
use crate::scene::Scene;

/// Chooses the cuts of `tree`, over the triangles of `order`, by boxes from `points` extremal points each.
pub fn choose(
    scene: &Scene,
    order: &[u32],
    space: &Space,
    tree: &mut HostRawTree,
    points: u32,
    recipe: &Recipe,
) {
    if tree.nodes.is_empty() {
        return;
    }
    // `recut/whole`.
    tree.cuts.iter_mut().for_each(|cut| cut.choices = 2);
    tree.root.node &= !COLLAPSED_BIT;
    expand(tree);
    let kept = number(tree, &recipe.collapse);
    let binary = layout::pack(scene, order, space, recipe.collapse.max_leaf, Some((tree, &kept)));
    let slots = fit(&binary, space.anchor, points, recipe);
    let root = tree.root.node;
    let cluster = Climb { tree: &mut *tree, slots: &slots, recipe }.climb(root, slots.len() - 1);
    let collapsed = tree.cuts[root as usize].choices & 3 == 0;
    tree.root.node = if collapsed { root | COLLAPSED_BIT } else { root };
    tree.root.cost = cluster.cost[0];
}

struct Climb<'a> {
    tree: &'a mut HostRawTree,
    slots: &'a [Slot],
    recipe: &'a Recipe,
}

impl Climb<'_> {
    fn fitted_area(&self, slot: usize, bounds: &Aabb) -> f32 {
        let Slot { points, frame, .. } = &self.slots[slot];
        let area = half_area(bounds);
        if !is_oriented(*frame) {
            return area;
        }
        let frame = Frame::of(*frame);
        let oriented = unstretched(half_area(&extent(frame.rows, points)), &frame) * self.recipe.dearer();
        least_of(oriented, area)
    }

    /// The cluster of a child of node `node`.
    fn below(&mut self, node: u32, side: usize, child: u32, bounds: &Aabb) -> Cluster {
        let slot = 4 * node as usize + side;
        if child >= LEAF_BIT {
            let cost = self.recipe.collapse.triangle_cost * self.fitted_area(slot, bounds);
            return Cluster { node: child, rank: child & RAW_MASK, count: 1, cost: [cost; 3] };
        }
        self.climb(child, slot)
    }

    /// The cluster of `node`, below slot `up`; writes how it is cut.
    fn climb(&mut self, node: u32, up: usize) -> Cluster {
        let RawNode { left_bounds, right_bounds, left, right } = self.tree.nodes[node as usize];
        let a = self.below(node, 0, left, &left_bounds);
        let b = self.below(node, 1, right, &right_bounds);
        let area = self.fitted_area(up, &merged(&left_bounds, &right_bounds));
        let count = a.count + b.count;
        let (cost, choices) = cheapest(a.cost, b.cost, area, count, &self.recipe.collapse);
        self.tree.cuts[node as usize] = RawCut { count, choices };
        Cluster { node, rank: a.rank, count, cost }
    }
}
