//! How tight a tree's boxes are: the measures of Table 6.1 of \[VEVERKOVA24\], of a packed tree against the same tree
//! with axis-aligned boxes.
//!
//! **Boxes**: one of every packed node and leaf but the root, the least around its triangles: in the frame of the node
//! above, or along the axes where that has none. Areas are those from before boxes go to a node's grid.
//!
//! **Cost**, expected of a ray that meets the scene's box, with (c_T, c_OBB, c_I) = (3, 4, 2): c_T is what the two boxes
//! of a binary node cost, so that a packed node costs 3/2 a child, and 4/2 where its children's boxes are oriented:
//! `[Σ_nodes c(n) A(n) + 2 Σ_leaves A n] / A_scene`, A(n) the half area of the box that n is tested by. Of axis-aligned
//! boxes alone it is the wide SAH cost with (3, 2).
//!
//! The study behind the mixed tree's aims keeps the cheaper box of every node of the *binary* tree, without frames that
//! children share: see [`super::mixed`].

use super::dito::{corners, extent};
use crate::abi::{Aabb, INVALID, TRIANGLE_WORDS};
use crate::bvh::frame::{Frame, is_oriented};
use crate::bvh::raw::half_area;
use crate::bvh::{Child, HostTree};
use glam::Vec3;
use rayon::prelude::*;

/// Costs of the literature: of one of a binary node's two boxes, of one that is oriented, of a triangle.
pub const BOOK: [f64; 3] = [1.5, 2.0, 2.0];
/// The axes of the scene.
pub(super) const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

/// How tight the boxes of a tree are. Shares are of 1, and 0 where there is nothing to share.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Tightness {
    /// Boxes.
    pub boxes: usize,
    /// Share of them that is axis-aligned.
    pub aabb_share: f64,
    /// Their share of all boxes' area.
    pub aabb_area_share: f64,
    /// Area of the boxes of inner nodes over that of their axis-aligned boxes.
    pub inner_area: f64,
    /// Likewise of leaves.
    pub leaf_area: f64,
    /// Likewise of both.
    pub total_area: f64,
    /// Expected cost with (3, 4, 2).
    pub cost: f64,
    /// The same were all boxes axis-aligned: with (3, 2).
    pub aabb_cost: f64,
}

/// Sums over boxes, areas not divided by the scene's.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    boxes: usize,
    /// Of them those along the axes.
    aligned: usize,
    /// Area of those.
    aligned_area: f64,
    /// Areas of nodes' and of leaves' boxes.
    areas: [f64; 2],
    /// Of their axis-aligned boxes.
    aabb_areas: [f64; 2],
    cost: f64,
    aabb_cost: f64,
}

impl Sums {
    fn and(self, o: Self) -> Self {
        let both = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            boxes: self.boxes + o.boxes,
            aligned: self.aligned + o.aligned,
            aligned_area: self.aligned_area + o.aligned_area,
            areas: both(self.areas, o.areas),
            aabb_areas: both(self.aabb_areas, o.aabb_areas),
            cost: self.cost + o.cost,
            aabb_cost: self.aabb_cost + o.aabb_cost,
        }
    }
}

fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// Half area of the least box around `points`: of a frame with `rows` that lengthen by `stretch`.
pub(super) fn least_area(rows: [Vec3; 3], stretch: f32, points: &[Vec3]) -> f64 {
    f64::from(half_area(&extent(rows, points))) / f64::from(stretch).powi(2)
}

/// Measures `tree`, which must be sound (see [`super::validate`]): unit space less `anchor`, the scene's box `bounds`.
pub fn measure(tree: &HostTree, anchor: [f32; 3], bounds: &Aabb) -> Tightness {
    if tree.root == INVALID {
        return Tightness::default();
    }
    let count = tree.triangles.len() as u32 / TRIANGLE_WORDS;
    let points: Vec<Vec3> = (0..count).into_par_iter().flat_map_iter(|t| corners(tree, anchor, t)).collect();
    let ranges = ranges(tree);
    let sums: Vec<Sums> =
        (0..tree.nodes.len()).into_par_iter().map(|i| of_node(tree, i, &ranges, &points)).collect();
    // One after the other, so that the sum is the same everywhere.
    let mut sums = sums.into_iter().fold(Sums::default(), Sums::and);
    let scene = f64::from(half_area(bounds));
    let [root, aligned] = visit(tree, tree.root as usize);
    sums.cost += root * scene;
    sums.aabb_cost += aligned * scene;
    let total = |areas: [f64; 2]| areas[0] + areas[1];
    Tightness {
        boxes: sums.boxes,
        aabb_share: share(sums.aligned as f64, sums.boxes as f64),
        aabb_area_share: share(sums.aligned_area, total(sums.areas)),
        inner_area: share(sums.areas[0], sums.aabb_areas[0]),
        leaf_area: share(sums.areas[1], sums.aabb_areas[1]),
        total_area: share(total(sums.areas), total(sums.aabb_areas)),
        cost: share(sums.cost, scene),
        aabb_cost: share(sums.aabb_cost, scene),
    }
}

/// What a visit of node `i` costs, and what it would with axis-aligned boxes. Nothing above a scene of one leaf.
fn visit(tree: &HostTree, i: usize) -> [f64; 2] {
    let node = &tree.nodes[i];
    let children = node.children.iter().filter(|c| **c != INVALID).count() as f64;
    let test = if is_oriented(node.frame) { BOOK[1] } else { BOOK[0] };
    if children > 1.0 { [test * children, BOOK[0] * children] } else { [0.0; 2] }
}

/// Of the children of node `i`, their boxes and visits.
fn of_node(tree: &HostTree, i: usize, ranges: &[[u32; 2]], points: &[Vec3]) -> Sums {
    let node = &tree.nodes[i];
    let frame = is_oriented(node.frame).then(|| Frame::of(node.frame));
    let children = node.children.iter().filter(|c| **c != INVALID).map(|c| tree.child(*c));
    children.fold(Sums::default(), |sums, child| {
        let (kind, [first, count], [visit, aabb_visit]) = match child {
            Child::Node(n) => (0, ranges[n as usize], visit(tree, n as usize)),
            Child::Leaf { first, count } => (1, [first, count], [BOOK[2] * f64::from(count); 2]),
        };
        let below = &points[3 * first as usize..3 * (first + count) as usize];
        let aabb = least_area(AXES, 1.0, below);
        let area = frame.map_or(aabb, |f| least_area(f.rows, f.stretch(), below));
        let of_kind = |area| std::array::from_fn(|k| if k == kind { area } else { 0.0 });
        sums.and(Sums {
            boxes: 1,
            aligned: usize::from(frame.is_none()),
            aligned_area: if frame.is_none() { area } else { 0.0 },
            areas: of_kind(area),
            aabb_areas: of_kind(aabb),
            cost: visit * area,
            aabb_cost: aabb_visit * aabb,
        })
    })
}

/// A child's box: the frame of the node above, its first triangle and how many there are.
pub(super) struct ChildBox {
    /// None: along the axes.
    pub frame: Option<[u32; 2]>,
    pub first: u32,
    pub count: u32,
}

/// Of all children, node by node.
pub(super) fn boxes_of(tree: &HostTree) -> Vec<ChildBox> {
    let ranges = ranges(tree);
    let of_node = |node: &crate::abi::Node| {
        let frame = is_oriented(node.frame).then_some(node.frame);
        let box_of = |c: u32| {
            let [first, count] = match tree.child(c) {
                Child::Node(n) => ranges[n as usize],
                Child::Leaf { first, count } => [first, count],
            };
            ChildBox { frame, first, count }
        };
        node.children.into_iter().filter(|c| *c != INVALID).map(box_of).collect::<Vec<_>>()
    };
    tree.nodes.iter().flat_map(of_node).collect()
}

/// First triangle and number of triangles below each node.
fn ranges(tree: &HostTree) -> Vec<[u32; 2]> {
    let below =
        |i: u32| tree.nodes[i as usize].children.into_iter().filter(|c| *c != INVALID).map(|c| tree.child(c));
    // Parents before their children.
    let mut order = vec![tree.root];
    let mut next = 0;
    while let Some(node) = order.get(next) {
        order.extend(below(*node).filter_map(|c| if let Child::Node(n) = c { Some(n) } else { None }));
        next += 1;
    }
    let mut ranges = vec![[0; 2]; tree.nodes.len()];
    for node in order.into_iter().rev() {
        let range = |child| match child {
            Child::Node(n) => ranges[n as usize],
            Child::Leaf { first, count } => [first, count],
        };
        // From left to right one after the other.
        let all = below(node).map(range).reduce(|a, b| [a[0].min(b[0]), a[1] + b[1]]);
        ranges[node as usize] = all.unwrap_or_default();
    }
    ranges
}

#[cfg(test)]
mod tests;
