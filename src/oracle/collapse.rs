//! Twin of `glsl/collapse/*.comp`: which nodes the packed tree keeps, and where they and their leaves' triangles go.

use crate::abi::{
    ABSORBED_BIT, Aabb, COLLAPSED_BIT, INVALID, KEPT_BIT, LEAF_BIT, RAW_MASK, RawNode, RawRoot, WIDTH,
};
use crate::bvh::Collapse;
use crate::bvh::raw::{HostRawTree, half_area, sah};

/// What `collapse/number` writes, and the sums.
#[derive(Debug, Clone)]
pub struct Kept {
    /// The kept raw nodes, in order.
    pub nodes: Vec<u32>,
    /// Packed index of each raw node, or [`INVALID`].
    pub packed: Vec<u32>,
    /// First triangle below each kept node, in the order of the tree read left to right.
    pub firsts: Vec<u32>,
    /// Nodes kept; 0 where the whole scene is one leaf.
    pub count: u32,
    /// Packed index of the root; 0 where there is none.
    pub root: u32,
    /// SAH cost of the binary tree with these leaves; the device's differs in the last digits.
    pub sah: f64,
}

/// Whether a raw node's child is a leaf of the packed tree.
pub fn is_leaf(child: u32) -> bool {
    child & (LEAF_BIT | COLLAPSED_BIT) != 0
}

/// Whether a raw node's child is absorbed by it.
pub fn is_absorbed(child: u32) -> bool {
    child & (LEAF_BIT | COLLAPSED_BIT | ABSORBED_BIT) == ABSORBED_BIT
}

/// Children of the packed node of a raw node, left to right, with their boxes: those of absorbed nodes in their place.
pub fn children(tree: &HostRawTree, node: u32) -> Vec<(u32, Aabb)> {
    let RawNode { left_bounds, right_bounds, left, right } = tree.nodes[node as usize];
    let expand = |(child, bounds)| {
        if is_absorbed(child) { children(tree, child & RAW_MASK) } else { vec![(child, bounds)] }
    };
    [(left, left_bounds), (right, right_bounds)].into_iter().flat_map(expand).collect()
}

/// Triangles below `child`.
pub(super) fn triangles_below(tree: &HostRawTree, child: u32) -> u32 {
    if child >= LEAF_BIT { 1 } else { tree.cuts[(child & RAW_MASK) as usize].count }
}

/// First triangle below each kept node, by raw node; 0 elsewhere.
fn firsts(tree: &HostRawTree) -> Vec<u32> {
    let mut firsts = vec![0; tree.nodes.len()];
    let mut stack: Vec<u32> = Some(tree.root.node).filter(|root| !is_leaf(*root)).into_iter().collect();
    while let Some(node) = stack.pop() {
        let mut triangle = firsts[node as usize];
        for (child, _) in children(tree, node) {
            if !is_leaf(child) {
                firsts[child as usize] = triangle;
                stack.push(child);
            }
            triangle += triangles_below(tree, child);
        }
    }
    firsts
}

/// How many of `share` children the first side of a raw node gets; of 1: of those of a packed node of its own. 0: one fewer
/// cost no more; of 1: a leaf.
fn first_of(tree: &HostRawTree, node: u32, share: u32) -> u32 {
    tree.cuts[node as usize].choices >> (2 * (share - 1)) & 3
}

/// Sets the bits of the references below `node`, which is dealt `share` children, `first` of them on its first side.
/// Those with packed nodes of their own go to `queue`.
fn deal(tree: &mut HostRawTree, node: u32, first: u32, share: u32, queue: &mut Vec<u32>) {
    let RawNode { left, right, .. } = tree.nodes[node as usize];
    let bits = [(left, first), (right, share - first)].map(|(child, share)| {
        if child >= LEAF_BIT {
            return child;
        }
        let dealt = (2..=share).rev().find(|share| first_of(tree, child, *share) > 0);
        if let Some(share) = dealt {
            deal(tree, child, first_of(tree, child, share), share, queue);
            child | ABSORBED_BIT
        } else if first_of(tree, child, 1) == 0 {
            child | COLLAPSED_BIT
        } else {
            queue.push(child);
            child
        }
    });
    [tree.nodes[node as usize].left, tree.nodes[node as usize].right] = bits;
}

/// `collapse/expand`: follows the cuts from the root.
pub fn expand(tree: &mut HostRawTree) {
    let mut queue: Vec<u32> = Some(tree.root.node).filter(|root| !is_leaf(*root)).into_iter().collect();
    while let Some(node) = queue.pop() {
        tree.cuts[node as usize].choices |= KEPT_BIT;
        deal(tree, node, first_of(tree, node, 1), WIDTH, &mut queue);
    }
}

/// Half areas of the binary nodes outside leaves, and of the leaves, times their triangles.
fn areas(tree: &HostRawTree) -> [f64; 2] {
    let mut areas = [0.0; 2];
    let mut stack = vec![(tree.root.node, tree.root.bounds)];
    while let Some((child, bounds)) = stack.pop() {
        let area = f64::from(half_area(&bounds));
        if is_leaf(child) {
            areas[1] += area * f64::from(triangles_below(tree, child));
            continue;
        }
        let RawNode { left_bounds, right_bounds, left, right } = tree.nodes[(child & RAW_MASK) as usize];
        areas[0] += area;
        stack.extend([(left, left_bounds), (right, right_bounds)]);
    }
    areas
}

/// `collapse/count` and `collapse/number`: keeps what is marked, in order.
pub fn number(tree: &HostRawTree, collapse: &Collapse) -> Kept {
    let RawRoot { node: root, bounds, .. } = tree.root;
    let sah = sah(areas(tree), &bounds, collapse);
    let mut result = Kept { nodes: vec![], packed: vec![], firsts: firsts(tree), count: 0, root: 0, sah };
    for (i, cut) in (0..).zip(&tree.cuts) {
        let kept = cut.choices & KEPT_BIT != 0;
        result.packed.push(if kept { result.count } else { INVALID });
        if kept {
            result.nodes.push(i);
            result.count += 1;
        }
    }
    if result.count > 0 {
        result.root = result.packed[root as usize];
    }
    result
}
