//! What a binary tree costs whose nodes each keep the cheaper of two boxes of their own, the axis-aligned one and
//! DiTO's: the study that the mixed tree's aims come from. No packed tree reaches it, for its children share a frame.
//!
//! `[Σ_inner min(3 A_AABB, 4 A_OBB) + 2 Σ_leaves min(A_AABB, A_OBB) n] / A_scene`: half areas, n triangles; of the tree as
//! it was collapsed, the leaves being those of the packed tree. A_OBB is the area of the least box around all triangles
//! below in the frame that DiTO finds from 14 extremal points.

use super::collapse::is_leaf;
use super::dito::{extremes, fitted};
use super::tight::{AXES, BOOK, least_area};
use crate::abi::{LEAF_BIT, RAW_MASK, RawCut, RawNode};
use crate::bvh::frame::{Frame, is_oriented};
use crate::bvh::{Directions, Stages};
use crate::scene::Scene;
use glam::Vec3;
use rayon::prelude::*;

/// Extremal points.
const POINTS: u32 = 14;

/// Expected cost of a ray that meets the scene's box.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Mixed {
    /// Each node with its cheaper box: (3, 4, 2).
    pub cost: f64,
    /// All boxes axis-aligned: (3, 2).
    pub aabb_cost: f64,
}

/// A node or leaf of the binary tree.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    /// Triangles below, in the order of the tree read left to right.
    first: usize,
    count: usize,
    leaf: bool,
}

/// Costs of the binary tree that `stages` of a build of `scene` tell of; zeros where there is none.
pub fn measure(scene: &Scene, stages: &Stages) -> Mixed {
    let Some(root) = stages.root else { return Mixed::default() };
    let (places, order) = places(root.node, &stages.nodes, &stages.cuts);
    let points = unit_corners(scene, order.iter().map(|rank| stages.order[*rank as usize] as usize));
    let costs: Vec<[f64; 2]> = places.par_iter().map(|p| p.costs(&points)).collect();
    let area = least_area(AXES, 1.0, &points);
    let sum = |k: usize| costs.iter().map(|c| c[k]).sum::<f64>();
    if area > 0.0 { Mixed { cost: sum(0) / area, aabb_cost: sum(1) / area } } else { Mixed::default() }
}

/// Nodes and leaves below `root`, and the ranks of all triangles, left to right.
fn places(root: u32, nodes: &[RawNode], cuts: &[RawCut]) -> (Vec<Place>, Vec<u32>) {
    let (mut places, mut order) = (vec![], vec![]);
    // What is below a leaf is no place.
    let mut stack = vec![(root, true)];
    while let Some((child, is_place)) = stack.pop() {
        let node = (child & RAW_MASK) as usize;
        let single = child & LEAF_BIT != 0;
        if is_place {
            let count = if single { 1 } else { cuts[node].count as usize };
            places.push(Place { first: order.len(), count, leaf: is_leaf(child) });
        }
        if single {
            order.push(child & !LEAF_BIT);
        } else {
            let within = is_place && !is_leaf(child);
            stack.extend([(nodes[node].right, within), (nodes[node].left, within)]);
        }
    }
    (places, order)
}

/// Corners of `triangles`, less the least corner of them all, over their longest edge.
fn unit_corners(scene: &Scene, triangles: impl Iterator<Item = usize>) -> Vec<Vec3> {
    let corners: Vec<[f32; 3]> = triangles.flat_map(|t| scene.corners(t)).collect();
    let least = |k: usize| corners.iter().map(|p| f64::from(p[k])).fold(f64::INFINITY, f64::min);
    let most = |k: usize| corners.iter().map(|p| f64::from(p[k])).fold(f64::NEG_INFINITY, f64::max);
    let lo: [f64; 3] = std::array::from_fn(least);
    let edge = (0..3).map(|k| most(k) - lo[k]).fold(0.0, f64::max);
    let over = if edge > 0.0 { 1.0 / edge } else { 0.0 };
    let unit =
        |p: &[f32; 3]| Vec3::from_array(std::array::from_fn(|k| ((f64::from(p[k]) - lo[k]) * over) as f32));
    corners.iter().map(unit).collect()
}

impl Place {
    /// With its cheaper box, and with its axis-aligned one.
    fn costs(&self, points: &[Vec3]) -> [f64; 2] {
        let below = &points[3 * self.first..3 * (self.first + self.count)];
        let aabb = least_area(AXES, 1.0, below);
        let oriented = oriented_area(below).unwrap_or(aabb);
        if self.leaf {
            let triangles = BOOK[2] * self.count as f64;
            [triangles * aabb.min(oriented), triangles * aabb]
        } else {
            [(2.0 * BOOK[0] * aabb).min(2.0 * BOOK[1] * oriented), 2.0 * BOOK[0] * aabb]
        }
    }
}

/// Area of DiTO's box; none where that is axis-aligned.
fn oriented_area(points: &[Vec3]) -> Option<f64> {
    let frame = frame_of(points)?;
    Some(least_area(frame.rows, frame.stretch(), points))
}

/// Frame of DiTO's box; none where that is axis-aligned.
pub(super) fn frame_of(points: &[Vec3]) -> Option<Frame> {
    let found = if points.len() <= POINTS as usize {
        fitted(&points.iter().copied().cycle().take(POINTS as usize).collect::<Vec<_>>())
    } else {
        fitted(&extremes(points, &Directions::Book.of(POINTS)))
    };
    is_oriented(found).then(|| Frame::of(found))
}

#[cfg(test)]
mod tests;
