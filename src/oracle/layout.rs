//! Twin of `glsl/layout/*.comp`: the packed tree.

use super::collapse::{Kept, children, is_leaf, triangles_below};
use super::morton::Space;
use crate::abi::{Aabb, INVALID, LEAF_BIT, Node, RAW_MASK, TRIANGLE_WORDS};
use crate::bvh::raw::{HostRawTree, merged};
use crate::bvh::{HostTree, leaf_bits};
use crate::scene::Scene;

struct Packer<'a> {
    scene: &'a Scene,
    order: &'a [u32],
    scale: f32,
    tree: &'a HostRawTree,
    kept: &'a Kept,
    triangles: Vec<u32>,
    leaf_bits: u32,
}

pub(super) fn leaf_reference(leaf_bits: u32, first: u32, count: u32) -> u32 {
    LEAF_BIT | (count - 1) << (31 - leaf_bits) | first
}

impl Packer<'_> {
    /// The triangle of a Morton rank to place `to`.
    fn pack_triangle(&mut self, rank: u32, to: u32) {
        let t = self.order[rank as usize];
        let at = (TRIANGLE_WORDS * to) as usize;
        let corners = self.scene.corners(t as usize);
        for (k, x) in corners.iter().flatten().enumerate() {
            let y = x * self.scale;
            let y = if y.abs() < f32::MIN_POSITIVE { 0f32.copysign(y) } else { y };
            self.triangles[at + k] = y.to_bits();
        }
        self.triangles[at + 9] = t;
    }

    /// All triangles below `child`, from place `to` on, left to right. Returns how many.
    fn pack_leaf(&mut self, child: u32, to: u32) -> u32 {
        if child >= LEAF_BIT {
            self.pack_triangle(child & !LEAF_BIT, to);
            return 1;
        }
        let node = self.tree.nodes[(child & RAW_MASK) as usize];
        let left = self.pack_leaf(node.left, to);
        left + self.pack_leaf(node.right, to + left)
    }

    /// The packed node of `children`, left to right, the triangles of whose leaves go from place `to` on.
    fn pack_node(&mut self, children: &[(u32, Aabb)], mut to: u32) -> Node {
        let bounds = children.iter().skip(1).fold(children[0].1, |all, (_, b)| merged(&all, b));
        let exponents: [u32; 3] = std::array::from_fn(|k| step_exponent(bounds.lo[k], bounds.hi[k]));
        let mut node = Node {
            origin: bounds.lo,
            exponents: exponents[0] | exponents[1] << 8 | exponents[2] << 16,
            lo: [u32::MAX; 3],
            hi: [0; 3],
            children: [INVALID; 4],
            frame: [0; 2],
        };
        for (slot, (child, bounds)) in children.iter().enumerate() {
            planes(&mut node, slot, bounds, exponents);
            node.children[slot] = if is_leaf(*child) {
                let count = self.pack_leaf(*child, to);
                to += count;
                leaf_reference(self.leaf_bits, to - count, count)
            } else {
                to += triangles_below(self.tree, *child);
                self.kept.packed[*child as usize]
            };
        }
        node
    }
}

/// Puts the planes of a child's box on the grid of `node`, whose slot is empty.
pub(super) fn planes(node: &mut Node, slot: usize, bounds: &Aabb, exponents: [u32; 3]) {
    // Steps a unit.
    for (k, step) in exponents.map(|e| f32::from_bits((254 - e) << 23)).into_iter().enumerate() {
        let lo = (bounds.lo[k] - node.origin[k]) * step;
        let hi = (bounds.hi[k] - node.origin[k]) * step;
        node.lo[k] ^= (255 ^ lo.floor() as u32) << (8 * slot);
        node.hi[k] |= (hi.ceil() as u32) << (8 * slot);
    }
}

/// Biased exponent of the least power of two of which 255 steps reach from `lo` to `hi`; at least 27.
pub(super) fn step_exponent(lo: f32, hi: f32) -> u32 {
    let extent = hi - lo;
    let exponent = (extent.to_bits() >> 23).max(34) - 7;
    let steps = extent * f32::from_bits((254 - exponent) << 23);
    exponent + u32::from(steps.ceil() > 255.0)
}

/// Packs what is kept of `tree`, over the triangles of `order`.
pub fn pack(
    scene: &Scene,
    order: &[u32],
    space: &Space,
    max_leaf: u32,
    parts: Option<(&HostRawTree, &Kept)>,
) -> HostTree {
    let leaf_bits = leaf_bits(max_leaf);
    let Some((tree, kept)) = parts else {
        return HostTree { nodes: vec![], triangles: vec![], root: INVALID, leaf_bits };
    };
    let triangles = vec![0; order.len() * TRIANGLE_WORDS as usize];
    let mut packer = Packer { scene, order, scale: space.scale, tree, kept, triangles, leaf_bits };
    let mut nodes = vec![];
    if kept.count == 0 {
        nodes.push(packer.pack_node(&[(tree.root.node, tree.root.bounds)], 0));
    }
    for i in &kept.nodes {
        nodes.push(packer.pack_node(&children(tree, *i), kept.firsts[*i as usize]));
    }
    HostTree { nodes, triangles: packer.triangles, root: kept.root, leaf_bits }
}
