//! Binary trees in the layouts of the literature, made on the host: of the binary tree that a build hands on, above its
//! leaves, so that they bound the same triangles as the packed tree. Oriented boxes are DiTO's, from 14 extremal points,
//! around all triangles below.

use super::collapse::is_leaf;
use super::layout::leaf_reference;
use super::mixed::frame_of;
use crate::abi::{Aabb, AabbNode, INVALID, LEAF_BIT, OBB_BIT, Obb, ObbNode, RAW_MASK, TRIANGLE_WORDS};
use crate::bvh::{HostTree, Recipe, Stages};
use crate::trace::layouts::{HostBinary, Layout, PAD_OBB, PADDED_REACHES};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// What half an edge's rounding takes, of an oriented box's extents.
const SLACK: f64 = 1.0 + 1.0 / 1_048_576.0;

/// A binary tree above leaves of several triangles, and the boxes that its nodes may have.
#[derive(Debug)]
pub struct BinaryTree {
    /// Corners of the packed tree's triangles, unit space less the anchor.
    points: Vec<DVec3>,
    /// Parents first, left before right.
    inner: Vec<Inner>,
    /// Place in `inner`, or leaf.
    root: u32,
    levels: u32,
    /// The largest coordinate difference between a ray's origin and the scene that oriented boxes are padded for.
    padded_reach: f64,
}

/// A node: its children as [`BinaryTree::root`], and their boxes.
#[derive(Debug, Clone, Copy, Default)]
struct Inner {
    children: [u32; 2],
    boxes: [Boxes; 2],
}

/// What a child may be bounded by.
#[derive(Debug, Clone, Copy, Default)]
struct Boxes {
    /// Its triangles: the first, and how many.
    range: [usize; 2],
    /// Least corner and greatest.
    aabb: [DVec3; 2],
    /// Half area of that.
    area: f64,
    /// Axes of the oriented box and its half area, where there is one.
    oriented: Option<([DVec3; 3], f64)>,
}

/// Least and greatest of what `along` says of `points`.
fn extent(points: &[DVec3], along: impl Fn(DVec3) -> DVec3) -> [DVec3; 2] {
    let [nowhere, everywhere] = [f64::INFINITY, f64::NEG_INFINITY].map(DVec3::splat);
    points.iter().fold([nowhere, everywhere], |[lo, hi], p| [lo.min(along(*p)), hi.max(along(*p))])
}

/// Coordinates along three axes.
fn along(axes: [DVec3; 3]) -> impl Fn(DVec3) -> DVec3 {
    move |p| DVec3::from_array(axes.map(|a| a.dot(p)))
}

fn half_area([lo, hi]: [DVec3; 2]) -> f64 {
    let e = hi - lo;
    e.x * (e.y + e.z) + e.y * e.z
}

impl Boxes {
    fn of(range: [usize; 2], all: &[DVec3]) -> Self {
        let points = below(range, all);
        let aabb = extent(points, |p| p);
        let near: Vec<Vec3> = points.iter().map(|p| p.as_vec3()).collect();
        let oriented = frame_of(&near).map(|frame| {
            let axes = frame.rows.map(|row| row.as_dvec3().normalize());
            (axes, half_area(extent(points, along(axes))))
        });
        Self { range, aabb, area: half_area(aabb), oriented }
    }

    /// Its corners as f32, rounded outward.
    fn aabb(&self) -> Aabb {
        let below = |x: f64| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 };
        let [lo, hi] = self.aabb;
        Aabb { lo: lo.to_array().map(below), hi: (-hi).to_array().map(|x| -below(x)) }
    }

    /// Its corners where a matrix may stand.
    fn untouched(&self) -> Obb {
        let Aabb { lo: [a, b, c], hi: [d, e, f] } = self.aabb();
        Obb { x: [a, b, c, d], y: [e, f, 0.0, 0.0], z: [0.0; 4] }
    }

    /// The matrix of its box along `axes`, padded.
    fn obb(&self, axes: [DVec3; 3], tree: &BinaryTree) -> Obb {
        let points = below(self.range, &tree.points);
        let [lo, hi] = extent(points, along(axes));
        let extents = (hi - lo + 2.0 * PAD_OBB * tree.padded_reach) * SLACK;
        let rows: [Vec3; 3] = std::array::from_fn(|k| (axes[k] / extents[k]).as_vec3());
        // Where rounded rows put it.
        let [lo, hi] = extent(points, along(rows.map(Vec3::as_dvec3)));
        let row = |k: usize| rows[k].extend((-0.5 * (lo[k] + hi[k])) as f32).to_array();
        Obb { x: row(0), y: row(1), z: row(2) }
    }

    /// The smaller box as a matrix.
    fn smaller(&self, tree: &BinaryTree) -> Obb {
        let axes = self.oriented.filter(|(_, area)| *area < self.area).map(|(axes, _)| axes);
        self.obb(axes.unwrap_or(DVec3::AXES), tree)
    }
}

/// Corners of a range of triangles.
fn below([first, count]: [usize; 2], points: &[DVec3]) -> &[DVec3] {
    &points[3 * first..3 * (first + count)]
}

/// Corners of all triangles of `tree`, unit space less `anchor`, in its order.
fn corners(tree: &HostTree, anchor: [f32; 3]) -> Vec<DVec3> {
    let anchor = Vec3::from_array(anchor).as_dvec3();
    let triangles = 0..tree.triangles.len() / TRIANGLE_WORDS as usize;
    let of = |t| tree.corners(t).map(|p| Vec3::from_array(p).as_dvec3() - anchor);
    triangles.into_par_iter().flat_map_iter(of).collect()
}

impl BinaryTree {
    /// The binary tree of a build, from its `stages`; `packed` is its tree, of the given anchor and largest coordinate.
    pub fn new(stages: &Stages, packed: &HostTree, anchor: [f32; 3], reach: f32) -> Self {
        let padded_reach = f64::from(PADDED_REACHES * reach);
        let points = corners(packed, anchor);
        let mut tree = Self { points, inner: vec![], root: INVALID, levels: 0, padded_reach };
        let mut first = 0;
        // With the place of the node above, and the side.
        let mut stack: Vec<(u32, Option<(usize, usize)>)> =
            stages.root.iter().map(|root| (root.node, None)).collect();
        while let Some((child, above)) = stack.pop() {
            let raw = (child & RAW_MASK) as usize;
            let reference = if is_leaf(child) {
                let count = if child >= LEAF_BIT { 1 } else { stages.cuts[raw].count };
                first += count;
                leaf_reference(packed.leaf_bits, first - count, count)
            } else {
                let place = tree.inner.len();
                tree.inner.push(Inner::default());
                let node = &stages.nodes[raw];
                stack.extend([(node.right, Some((place, 1))), (node.left, Some((place, 0)))]);
                place as u32
            };
            match above {
                Some((place, side)) => tree.inner[place].children[side] = reference,
                None => tree.root = reference,
            }
        }
        tree.bound(packed);
        tree
    }

    /// Bounds every child.
    fn bound(&mut self, packed: &HostTree) {
        let mut ranges = vec![[0; 2]; self.inner.len()];
        let mut levels = vec![1; self.inner.len()];
        for i in (0..self.inner.len()).rev() {
            let children = self.inner[i].children;
            let of = |child: u32| match packed.child(child) {
                crate::bvh::Child::Node(n) => (ranges[n as usize], levels[n as usize]),
                crate::bvh::Child::Leaf { first, count } => ([first as usize, count as usize], 0),
            };
            let [(left, above), (right, beside)] = children.map(of);
            for (boxes, range) in self.inner[i].boxes.iter_mut().zip([left, right]) {
                boxes.range = range;
            }
            ranges[i] = [left[0], left[1] + right[1]];
            levels[i] = 1 + u32::max(above, beside);
        }
        self.levels = levels.first().copied().unwrap_or(0);
        let points = &self.points;
        self.inner
            .par_iter_mut()
            .for_each(|node| node.boxes = node.boxes.map(|b| Boxes::of(b.range, points)));
    }

    /// The tree with nodes of `layout`; `recipe` says what visits cost.
    pub fn packed(&self, layout: Layout, recipe: &Recipe) -> HostBinary {
        let oriented = match layout {
            Layout::Aabb => vec![[false; 2]; self.inner.len()],
            Layout::Obb => vec![[true; 2]; self.inner.len()],
            Layout::Mixed => self.cheaper(recipe),
        };
        let (mut aabbs, mut obbs) = (0, 0);
        let place = |sides: &[bool; 2]| {
            let (place, next) = if sides.contains(&true) { (OBB_BIT, &mut obbs) } else { (0, &mut aabbs) };
            *next += 1;
            place | (*next - 1)
        };
        let places: Vec<u32> = oriented.iter().map(place).collect();
        let placed = |child: u32| places.get(child as usize).copied().unwrap_or(child);
        let mut made = HostBinary {
            layout,
            aabbs: Vec::with_capacity(aabbs as usize),
            obbs: Vec::with_capacity(obbs as usize),
            root: placed(self.root),
            levels: self.levels,
        };
        let plain = |(n, _): &(&Inner, &[bool; 2])| AabbNode {
            left: n.boxes[0].aabb(),
            right: n.boxes[1].aabb(),
            children: n.children.map(placed),
            pad: [0; 2],
        };
        let turned = |(n, sides): &(&Inner, &[bool; 2])| {
            let volume = |k: usize| match sides[k] {
                true => n.boxes[k].smaller(self),
                false => n.boxes[k].untouched(),
            };
            let aligned = u32::from(!sides[0]) | u32::from(!sides[1]) << 1;
            let children = n.children.map(placed);
            ObbNode { left: volume(0), right: volume(1), children, aligned, pad: 0 }
        };
        let (with, without): (Vec<_>, Vec<_>) =
            self.inner.iter().zip(&oriented).partition(|(_, sides)| sides.contains(&true));
        made.aabbs.par_extend(without.par_iter().map(plain));
        made.obbs.par_extend(with.par_iter().map(turned));
        made
    }

    /// Which children to bound by oriented boxes: where it saves more visits than what turning a ray costs, half of what
    /// turning it for a packed node does, as the node tests half as many.
    fn cheaper(&self, recipe: &Recipe) -> Vec<[bool; 2]> {
        let turn = 0.5 * f64::from(recipe.oriented_cost - recipe.collapse.node_cost);
        let mut areas = vec![half_area(extent(&self.points, |p| p)); self.inner.len()];
        let mut chosen = vec![[false; 2]; self.inner.len()];
        for (i, node) in self.inner.iter().enumerate() {
            for (k, (child, boxes)) in node.children.into_iter().zip(&node.boxes).enumerate() {
                let visit = if HostBinary::is_node(child) {
                    f64::from(recipe.collapse.traversal_cost)
                } else {
                    f64::from(recipe.collapse.triangle_cost) * boxes.range[1] as f64
                };
                let pays = |area: &f64| *area < boxes.area && visit * (boxes.area - area) > turn * areas[i];
                let smaller = boxes.oriented.map(|(_, area)| area).filter(pays);
                chosen[i][k] = smaller.is_some();
                if HostBinary::is_node(child) {
                    areas[child as usize] = smaller.unwrap_or(boxes.area);
                }
            }
        }
        chosen
    }

    /// How often a corner of a triangle lies outside a box above it in `made`, one of this tree: never, if that is sound.
    pub fn outside(&self, made: &HostBinary) -> usize {
        // This tree's node and the same one of `made`.
        let mut stack = vec![];
        if HostBinary::is_node(self.root) {
            stack.push((self.root, made.root));
        }
        let mut outside = 0;
        while let Some((own, same)) = stack.pop() {
            let node = &self.inner[own as usize];
            for (k, (child, volume)) in made.children(same).into_iter().enumerate() {
                let points = below(node.boxes[k].range, &self.points);
                outside += points.par_iter().filter(|p| !volume.holds(**p)).count();
                if HostBinary::is_node(child) {
                    stack.push((node.children[k], child));
                }
            }
        }
        outside
    }
}
