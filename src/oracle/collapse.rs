//! Twin of `glsl/collapse/*.comp`: which nodes the packed tree keeps, and where they and their leaves' triangles go.

use super::ploc::RawTree;
use crate::abi::{COLLAPSED_BIT, INVALID, LEAF_BIT};

/// What `collapse/number` writes, and the sums.
#[derive(Debug, Clone)]
pub struct Kept {
    /// The kept raw nodes, in order.
    pub nodes: Vec<u32>,
    /// Packed index of each raw node, or [`INVALID`].
    pub packed: Vec<u32>,
    /// First triangle of the leaves directly below each.
    pub leaf_triangles: Vec<u32>,
    /// Nodes kept; 0 where the whole scene is one leaf.
    pub count: u32,
    /// Packed index of the root; 0 where there is none.
    pub root: u32,
}

/// Triangles of `child` where it is a leaf of the packed tree, else 0.
fn leaf_count(tree: &RawTree, child: u32) -> u32 {
    if child >= LEAF_BIT {
        return 1;
    }
    let count = tree.nodes[child as usize].count;
    if count & COLLAPSED_BIT != 0 { count & !COLLAPSED_BIT } else { 0 }
}

/// Keeps what a walk from the root reaches without entering a collapsed node; numbers it in order.
pub fn number(tree: &RawTree) -> Kept {
    let mut kept = vec![false; tree.nodes.len()];
    let mut stack = vec![tree.root.node];
    while let Some(node) = stack.pop() {
        if node >= LEAF_BIT || tree.nodes[node as usize].count & COLLAPSED_BIT != 0 {
            continue;
        }
        kept[node as usize] = true;
        stack.extend([tree.nodes[node as usize].left, tree.nodes[node as usize].right]);
    }
    let mut result = Kept { nodes: vec![], packed: vec![], leaf_triangles: vec![], count: 0, root: 0 };
    let mut triangle = 0;
    for (i, (node, kept)) in (0..).zip(tree.nodes.iter().zip(&kept)) {
        result.packed.push(if *kept { result.count } else { INVALID });
        result.leaf_triangles.push(triangle);
        if *kept {
            result.nodes.push(i);
            result.count += 1;
            triangle += leaf_count(tree, node.left) + leaf_count(tree, node.right);
        }
    }
    if result.count > 0 {
        result.root = result.packed[tree.root.node as usize];
    }
    result
}
