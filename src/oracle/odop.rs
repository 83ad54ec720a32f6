//! Twin of `glsl/odop/*.comp`: rounds as PLOC's, by the area of the least box in any basis. All boxes in all bases are
//! kept; that the device projects triangles anew where memory is short is of no concern here: the tree is the same.

use super::morton::Space;
use super::ploc::{colour_mask, pair_key, partner_of};
use crate::abi::{Aabb, Basis, INVALID};
use crate::bvh::frame::along;
use crate::bvh::raw::{
    Corners, HostRawTree, Room, Subtree, half_area, leaf_bounds, merged, settled, unit_point,
};
use crate::bvh::{Bases, Collapse};
use crate::scene::Scene;
use glam::Vec3;

/// A cluster and its boxes, one a basis.
#[derive(Debug, Clone)]
struct Polytope {
    subtree: Subtree,
    boxes: Vec<Aabb>,
}

/// `odop/project`: the box of triangles in a basis.
pub fn project(triangles: &[Corners], basis: &Basis, scale: f32, anchor: [f32; 3]) -> Aabb {
    let mut bounds = Aabb { lo: [f32::MAX; 3], hi: [f32::MIN; 3] };
    for corner in triangles.as_flattened() {
        let p = Vec3::from_array(unit_point(*corner, scale, anchor));
        let at = [basis.x, basis.y, basis.z].map(|axis| along(Vec3::from_array(axis), p));
        bounds = merged(&bounds, &Aabb { lo: at, hi: at });
    }
    Aabb { lo: bounds.lo.map(settled), hi: bounds.hi.map(settled) }
}

/// Each triangle a cluster of its own, by the least of its areas.
fn leaves(scene: &Scene, order: &[u32], space: &Space, axes: &[Basis], collapse: &Collapse) -> Vec<Polytope> {
    let leaf = |(rank, triangle): (u32, &u32)| {
        let corners = scene.corners(*triangle as usize);
        let bounds = leaf_bounds(corners, space.scale, space.anchor);
        let boxes: Vec<Aabb> =
            axes.iter().map(|basis| project(&[corners], basis, space.scale, space.anchor)).collect();
        let area = boxes.iter().map(half_area).fold(f32::MAX, f32::min);
        Polytope { subtree: Subtree::leaf_of_area(rank, bounds, area, collapse), boxes }
    };
    (0..).zip(order).map(leaf).collect()
}

/// `odop/search`: the least key of each cluster's pairs in any basis.
fn search(clusters: &[Polytope], radius: u32) -> Vec<u32> {
    let mut nearest = vec![INVALID; clusters.len()];
    for i in 0..clusters.len() {
        for j in i + 1..clusters.len().min(i + 1 + radius as usize) {
            for (a, b) in clusters[i].boxes.iter().zip(&clusters[j].boxes) {
                let key = pair_key(a, b, i as u32, (j - i) as u32, radius);
                for cluster in [i, j] {
                    nearest[cluster] = nearest[cluster].min(key);
                }
            }
        }
    }
    nearest
}

/// The half area of a pair's cluster: that of its axis-aligned box where it is the key's as far as the colour leaves it.
fn area_of(a: &Polytope, b: &Polytope, key: u32, radius: u32) -> f32 {
    let aligned = half_area(&merged(&a.subtree.bounds, &b.subtree.bounds));
    let area = key & !colour_mask(radius);
    if aligned.to_bits() & !colour_mask(radius) == area { aligned } else { f32::from_bits(area) }
}

/// `odop/merge` and `odop/unite`: pairs that name each other become one, the rest go on, in order.
fn round(room: &mut Room<'_>, clusters: &[Polytope], radius: u32, collapse: &Collapse) -> Vec<Polytope> {
    let nearest = search(clusters, radius);
    let mut next = vec![];
    for (i, a) in clusters.iter().enumerate() {
        let key = nearest[i];
        let j = partner_of(i as u32, key, radius) as usize;
        let mutual = nearest.get(j) == Some(&key);
        if mutual && j < i {
            continue;
        }
        next.push(if mutual {
            let b = &clusters[j];
            let area = area_of(a, b, key, radius);
            Polytope {
                subtree: room.merge_to_area(&a.subtree, &b.subtree, area, collapse),
                boxes: a.boxes.iter().zip(&b.boxes).map(|(a, b)| merged(a, b)).collect(),
            }
        } else {
            a.clone()
        });
    }
    next
}

/// Clusters the triangles of `order` into a binary tree; none where there is no triangle.
pub fn cluster(
    scene: &Scene,
    order: &[u32],
    space: &Space,
    bases: Bases,
    radius: u32,
    collapse: &Collapse,
) -> Option<HostRawTree> {
    let mut clusters = leaves(scene, order, space, &bases.axes(), collapse);
    let build = |mut room: Room<'_>| {
        let mut rounds = 0;
        while clusters.len() > 1 {
            let count = clusters.len();
            clusters = round(&mut room, &clusters, radius, collapse);
            assert!(clusters.len() < count, "round {rounds} merged none of {count} clusters");
            rounds += 1;
        }
        // What the device says: no round adds two levels.
        Subtree { levels: rounds, ..clusters[0].subtree }
    };
    (!order.is_empty()).then(|| HostRawTree::build(order.len(), build))
}
