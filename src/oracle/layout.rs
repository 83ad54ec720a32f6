//! Twin of `glsl/layout/*.comp`: the packed tree.

use super::collapse::Kept;
use super::morton::Space;
use super::ploc::RawTree;
use crate::abi::{Aabb, COLLAPSED_BIT, INVALID, LEAF_BIT, Node, TRIANGLE_WORDS};
use crate::bvh::{HostTree, leaf_bits};
use crate::scene::Scene;

const EMPTY: Aabb = Aabb { lo: [3.4e38; 3], hi: [-3.4e38; 3] };

struct Packer<'a> {
    scene: &'a Scene,
    order: &'a [u32],
    scale: f32,
    tree: &'a RawTree,
    kept: &'a Kept,
    triangles: Vec<u32>,
    leaf_bits: u32,
}

impl Packer<'_> {
    fn leaf_reference(&self, first: u32, count: u32) -> u32 {
        LEAF_BIT | (count - 1) << (31 - self.leaf_bits) | first
    }

    /// The triangle of a Morton rank to place `to`.
    fn pack_triangle(&mut self, rank: u32, to: u32) {
        let t = self.order[rank as usize];
        let at = (TRIANGLE_WORDS * to) as usize;
        let corners = self.scene.corners(t as usize);
        for (k, x) in corners.iter().flatten().enumerate() {
            self.triangles[at + k] = (x * self.scale).to_bits();
        }
        self.triangles[at + 9] = t;
    }

    /// All triangles below `child`, from place `to` on, left to right. Returns how many.
    fn pack_leaf(&mut self, child: u32, to: u32) -> u32 {
        if child >= LEAF_BIT {
            self.pack_triangle(child & !LEAF_BIT, to);
            return 1;
        }
        let node = self.tree.nodes[child as usize];
        let left = self.pack_leaf(node.left, to);
        left + self.pack_leaf(node.right, to + left)
    }

    fn pack_child(&mut self, child: u32, to: &mut u32) -> u32 {
        if child < LEAF_BIT && self.tree.nodes[child as usize].count & COLLAPSED_BIT == 0 {
            return self.kept.packed[child as usize];
        }
        let count = self.pack_leaf(child, *to);
        *to += count;
        self.leaf_reference(*to - count, count)
    }
}

/// Packs what is kept of `tree`, over the triangles of `order`.
pub fn pack(
    scene: &Scene,
    order: &[u32],
    space: &Space,
    max_leaf: u32,
    parts: Option<(&RawTree, &Kept)>,
) -> HostTree {
    let leaf_bits = leaf_bits(max_leaf);
    let Some((tree, kept)) = parts else {
        return HostTree { nodes: vec![], triangles: vec![], root: INVALID, leaf_bits };
    };
    let triangles = vec![0; order.len() * TRIANGLE_WORDS as usize];
    let mut packer = Packer { scene, order, scale: space.scale, tree, kept, triangles, leaf_bits };
    let mut nodes = vec![];
    if kept.count == 0 {
        let count = packer.pack_leaf(tree.root.node, 0);
        let (left, right) = (packer.leaf_reference(0, count), packer.leaf_reference(0, 1));
        nodes.push(Node { left_bounds: tree.root.bounds, right_bounds: EMPTY, left, right, pad: [0; 2] });
    }
    for (i, node) in tree.nodes.iter().enumerate() {
        if kept.packed[i] == INVALID {
            continue;
        }
        let mut to = kept.leaf_triangles[i];
        let left = packer.pack_child(node.left, &mut to);
        let right = packer.pack_child(node.right, &mut to);
        nodes.push(Node {
            left_bounds: node.left_bounds,
            right_bounds: node.right_bounds,
            left,
            right,
            pad: [0; 2],
        });
    }
    HostTree { nodes, triangles: packer.triangles, root: kept.root, leaf_bits }
}
