//! What a binary tree costs whose nodes each keep the cheaper of two boxes of their own, the axis-aligned one and
//! DiTO's: the study that the mixed tree's aims come from. No packed tree reaches it, for its children share a frame.
//!
//! `[Σ_inner min(3 A_AABB, 4 A_OBB) + 2 Σ_leaves min(A_AABB, A_OBB) n] / A_scene`: half areas, n triangles; of the tree as
//! it was collapsed, the leaves being those of the packed tree. A_OBB is the area of the least box around all triangles
//! below in the frame that DiTO finds from 14 extremal points.

use super::collapse::is_leaf;
use super::dito::{extent, extremes, fitted, kept};
use super::tight::{AXES, BOOK, least_area};
use crate::abi::{Aabb, LEAF_BIT, RAW_MASK, RawCut, RawNode};
use crate::bvh::frame::{Frame, along, is_oriented};
use crate::bvh::raw::{half_area, merged};
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
    /// Edges from the root.
    depth: usize,
    /// The place to the right below; the one to the left is the next. None of a leaf.
    right: Option<usize>,
}

/// What is known of all points below a place.
#[derive(Debug, Clone)]
struct Below {
    aabb: Aabb,
    /// Those that are least and greatest along each direction.
    extremes: Vec<Vec3>,
    /// With the cheaper box, and with the axis-aligned one.
    costs: [f64; 2],
}

/// Costs of the binary tree that `stages` of a build of `scene` tell of; zeros where there is none.
pub fn measure(scene: &Scene, stages: &Stages) -> Mixed {
    let Some(root) = stages.root else { return Mixed::default() };
    let (places, order) = places(root.node, &stages.nodes, &stages.cuts);
    let points = unit_corners(scene, order.iter().map(|rank| stages.order[*rank as usize] as usize));
    let directions = Directions::Book.of(POINTS);
    let depths = places.iter().map(|p| p.depth + 1).max().unwrap_or(0);
    let mut levels = vec![vec![]; depths];
    // In its level, from left to right.
    let slots: Vec<usize> = places
        .iter()
        .enumerate()
        .map(|(i, p)| {
            levels[p.depth].push(i);
            levels[p.depth].len() - 1
        })
        .collect();
    let (mut costs, mut deeper) = (vec![[0.0; 2]; places.len()], vec![]);
    for level in levels.iter().rev() {
        let here: Vec<Below> = level
            .par_iter()
            .map(|&i| {
                let children = places[i].right.map(|right| [i + 1, right].map(|c| &deeper[slots[c]]));
                places[i].below(&points, &directions, children)
            })
            .collect();
        level.iter().zip(&here).for_each(|(i, below)| costs[*i] = below.costs);
        deeper = here;
    }
    let area = deeper.first().map_or(0.0, |root| f64::from(half_area(&root.aabb)));
    let sum = |k: usize| costs.iter().map(|c| c[k]).sum::<f64>();
    if area > 0.0 { Mixed { cost: sum(0) / area, aabb_cost: sum(1) / area } } else { Mixed::default() }
}

/// Nodes and leaves below `root`, each before those below it, and the ranks of all triangles, left to right.
fn places(root: u32, nodes: &[RawNode], cuts: &[RawCut]) -> (Vec<Place>, Vec<u32>) {
    let (mut places, mut order) = (vec![], vec![]);
    // Of what is below a leaf, which is no place, no depth; of a right child, whose.
    let mut stack = vec![(root, Some(0), None::<usize>)];
    while let Some((child, depth, right_of)) = stack.pop() {
        let node = (child & RAW_MASK) as usize;
        let single = child & LEAF_BIT != 0;
        let own = places.len();
        if let Some(depth) = depth {
            let count = if single { 1 } else { cuts[node].count as usize };
            places.push(Place { first: order.len(), count, depth, right: None });
        }
        if let Some(parent) = right_of {
            places[parent].right = Some(own);
        }
        if single {
            order.push(child & !LEAF_BIT);
        } else {
            let below = depth.filter(|_| !is_leaf(child)).map(|depth| depth + 1);
            stack.push((nodes[node].right, below, below.map(|_| own)));
            stack.push((nodes[node].left, below, None));
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
    /// From what is below its children, where it has some, without a look at more than the box of all `points` in a frame.
    fn below(&self, points: &[Vec3], directions: &[Vec3], children: Option<[&Below; 2]>) -> Below {
        let points = &points[3 * self.first..3 * (self.first + self.count)];
        let (aabb, extremes) = match children {
            None => (extent(AXES, points), extremes(points, directions)),
            Some([a, b]) => (merged(&a.aabb, &b.aabb), farther(&a.extremes, &b.extremes, directions)),
        };
        let area = f64::from(half_area(&aabb));
        let [cost, oriented_cost] = if children.is_some() {
            [2.0 * BOOK[0], 2.0 * BOOK[1]]
        } else {
            [BOOK[2] * self.count as f64; 2]
        };
        let oriented = (area > 0.0).then(|| frame_of_extremes(points, &extremes)).flatten();
        // Around the extremal points alone it is no larger.
        let least = |f: &Frame, points| oriented_cost * least_area(f.rows, f.stretch(), points);
        let kept = oriented.filter(|f| least(f, &extremes) < cost * area);
        let cheaper = kept.map_or(cost * area, |f| least(&f, points).min(cost * area));
        Below { aabb, extremes, costs: [cheaper, cost * area] }
    }
}

/// Of the extremal points of two sets, left and right, those of both.
fn farther(a: &[Vec3], b: &[Vec3], directions: &[Vec3]) -> Vec<Vec3> {
    let ends = directions.iter().flat_map(|d| [-*d, *d]);
    ends.zip(a.iter().zip(b)).map(|(d, (a, b))| if along(d, *b) > along(d, *a) { *b } else { *a }).collect()
}

/// Frame of DiTO's box around `points`, of which `extremes` are extremal; none where that is axis-aligned.
fn frame_of_extremes(points: &[Vec3], extremes: &[Vec3]) -> Option<Frame> {
    if points.len() <= POINTS as usize {
        return frame_of(points);
    }
    let found = fitted(extremes);
    is_oriented(found).then(|| Frame::of(found))
}

/// Frame of DiTO's box; none where that is axis-aligned.
pub(super) fn frame_of(points: &[Vec3]) -> Option<Frame> {
    let found = fitted(&kept(points, &Directions::Book.of(POINTS)));
    is_oriented(found).then(|| Frame::of(found))
}

#[cfg(test)]
mod tests;
