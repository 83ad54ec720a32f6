//! Twin of `glsl/lbvh/*.comp`, from the other end: the device climbs from the leaves, this halves from the root, as the
//! radix tree is defined \[KARRAS12\].

use super::morton::Space;
use super::ploc::leaves;
use crate::bvh::Collapse;
use crate::bvh::raw::{HostRawTree, Room, Subtree};
use crate::scene::Scene;

/// Rank of the first triangle of the right half of ranks `first..=last`: the first of those with a 1 in the highest bit
/// in which their codes differ, or, where all are equal, their ranks.
pub fn split(keys: &[u64], first: usize, last: usize) -> usize {
    let word = |rank: usize| if keys[first] == keys[last] { rank as u64 } else { keys[rank] };
    let bit = (word(first) ^ word(last)).ilog2();
    (first..=last).find(|rank| word(*rank) >> bit & 1 != word(first) >> bit & 1).unwrap_or(last)
}

fn subtree(
    room: &mut Room<'_>,
    keys: &[u64],
    leaves: &[Subtree],
    range: [usize; 2],
    c: &Collapse,
) -> Subtree {
    let [first, last] = range;
    if first == last {
        return leaves[first];
    }
    let right = split(keys, first, last);
    let a = subtree(room, keys, leaves, [first, right - 1], c);
    let b = subtree(room, keys, leaves, [right, last], c);
    room.merge(&a, &b, c)
}

/// The radix tree over the triangles of `order`, whose codes are `keys`; none where there is no triangle.
pub fn climb(
    scene: &Scene,
    order: &[u32],
    keys: &[u64],
    space: &Space,
    collapse: &Collapse,
) -> Option<HostRawTree> {
    let leaves = leaves(scene, order, space, collapse);
    let build = |mut room: Room<'_>| subtree(&mut room, keys, &leaves, [0, order.len() - 1], collapse);
    (!order.is_empty()).then(|| HostRawTree::build(order.len(), build))
}
