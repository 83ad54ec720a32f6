//! Twin of `glsl/collapse/*.comp`: which nodes the packed tree keeps, and where they and their leaves' triangles go.

use crate::abi::{ABSORBED_BIT, Aabb, COLLAPSED_BIT, INVALID, LEAF_BIT, RAW_MASK, RawNode};
use crate::bvh::raw::HostRawTree;

/// What `collapse/number` writes, and the sums.
#[derive(Debug, Clone)]
pub struct Kept {
    /// The kept raw nodes, in order.
    pub nodes: Vec<u32>,
    /// Packed index of each raw node, or [`INVALID`].
    pub packed: Vec<u32>,
    /// First triangle of the leaves among the children of each packed node.
    pub leaf_triangles: Vec<u32>,
    /// Nodes kept; 0 where the whole scene is one leaf.
    pub count: u32,
    /// Packed index of the root; 0 where there is none.
    pub root: u32,
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

/// Triangles of `child` where it is a leaf of the packed tree, else 0.
fn leaf_count(tree: &HostRawTree, child: u32) -> u32 {
    if child >= LEAF_BIT {
        return 1;
    }
    if is_leaf(child) { tree.links[(child & RAW_MASK) as usize].count & RAW_MASK } else { 0 }
}

/// Keeps what a walk from the root reaches without entering a collapsed node, and is not absorbed; numbers it in order.
pub fn number(tree: &HostRawTree) -> Kept {
    let mut kept = vec![false; tree.nodes.len()];
    let whole = tree.nodes.is_empty() || tree.links[tree.root.node as usize].count & COLLAPSED_BIT != 0;
    let mut stack = if whole { vec![] } else { vec![tree.root.node] };
    while let Some(node) = stack.pop() {
        kept[node as usize] = true;
        stack.extend(children(tree, node).iter().map(|(child, _)| *child).filter(|child| !is_leaf(*child)));
    }
    let mut result = Kept { nodes: vec![], packed: vec![], leaf_triangles: vec![], count: 0, root: 0 };
    let mut triangle = 0;
    for (i, kept) in (0..).zip(&kept) {
        result.packed.push(if *kept { result.count } else { INVALID });
        result.leaf_triangles.push(triangle);
        if *kept {
            result.nodes.push(i);
            result.count += 1;
            triangle += children(tree, i).iter().map(|(child, _)| leaf_count(tree, *child)).sum::<u32>();
        }
    }
    if result.count > 0 {
        result.root = result.packed[tree.root.node as usize];
    }
    result
}
