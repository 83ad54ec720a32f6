//! Twin of `glsl/ploc/*.comp`: rounds of search, merge and compaction until one cluster is left. Where the device
//! does its last rounds in one dispatch, or searches with registers, is of no concern here: the tree is the same.

use super::morton::Space;
use crate::abi::{Aabb, INVALID};
use crate::bvh::Collapse;
use crate::bvh::raw::{HostRawTree, Room, Subtree, half_area, leaf_bounds, merged};
use crate::scene::Scene;

/// Low bits of a key that hold the colour of a pair.
pub(super) fn colour_mask(radius: u32) -> u32 {
    2 * radius.next_power_of_two() - 1
}

/// The bit of `i` that tells the pair (i, i + distance) from (i − distance, i).
fn side(i: u32, distance: u32) -> u32 {
    i >> distance.trailing_zeros() & 1
}

/// Key of the pair (i, i + distance).
pub fn pair_key(a: &Aabb, b: &Aabb, i: u32, distance: u32, radius: u32) -> u32 {
    let colour = ((distance - 1) * 2) | side(i, distance);
    half_area(&merged(a, b)).to_bits() & !colour_mask(radius) | colour
}

/// The other cluster of the pair that cluster `i` holds least.
pub fn partner_of(i: u32, key: u32, radius: u32) -> u32 {
    let colour = key & colour_mask(radius);
    let distance = (colour >> 1) + 1;
    if side(i, distance) == colour & 1 { i + distance } else { i.wrapping_sub(distance) }
}

/// `ploc/leaves`: each triangle in unit space, a cluster of its own.
pub fn leaves(scene: &Scene, order: &[u32], space: &Space, collapse: &Collapse) -> Vec<Subtree> {
    let bounds = |t: &u32| leaf_bounds(scene.corners(*t as usize), space.scale, space.anchor);
    (0..).zip(order).map(|(rank, t)| Subtree::leaf(rank, bounds(t), collapse)).collect()
}

/// `ploc/search`: the least key of each cluster's pairs.
pub fn search(bounds: &[Aabb], radius: u32) -> Vec<u32> {
    let count = bounds.len() as u32;
    let mut nearest = vec![INVALID; bounds.len()];
    for i in 0..count {
        for distance in 1..=radius.min(count - 1 - i) {
            let j = i + distance;
            let key = pair_key(&bounds[i as usize], &bounds[j as usize], i, distance, radius);
            for cluster in [i, j] {
                nearest[cluster as usize] = nearest[cluster as usize].min(key);
            }
        }
    }
    nearest
}

/// `ploc/count`, `ploc/scan` and `ploc/merge`: pairs that name each other become one, the rest go on, in order.
fn round(room: &mut Room<'_>, clusters: &[Subtree], radius: u32, collapse: &Collapse) -> Vec<Subtree> {
    let bounds: Vec<Aabb> = clusters.iter().map(|c| c.bounds).collect();
    let nearest = search(&bounds, radius);
    let mut next = vec![];
    for i in 0..clusters.len() {
        let key = nearest[i];
        let j = partner_of(i as u32, key, radius) as usize;
        let mutual = nearest.get(j) == Some(&key);
        if mutual && j < i {
            continue;
        }
        next.push(if mutual { room.merge(&clusters[i], &clusters[j], collapse) } else { clusters[i] });
    }
    next
}

/// Clusters the triangles of `order` into a binary tree; none where there is no triangle.
pub fn cluster(
    scene: &Scene,
    order: &[u32],
    space: &Space,
    radius: u32,
    collapse: &Collapse,
) -> Option<HostRawTree> {
    let mut clusters = leaves(scene, order, space, collapse);
    let build = |mut room: Room<'_>| {
        let mut rounds = 0;
        while clusters.len() > 1 {
            let count = clusters.len();
            clusters = round(&mut room, &clusters, radius, collapse);
            assert!(clusters.len() < count, "round {rounds} merged none of {count} clusters");
            rounds += 1;
        }
        // What the device says: no round adds two levels.
        Subtree { levels: rounds, ..clusters[0] }
    };
    (!order.is_empty()).then(|| HostRawTree::build(order.len(), build))
}
