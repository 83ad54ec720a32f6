//! Twin of `glsl/dito/*.comp`: extremal points of every child of a packed node, and the frame of its least box.

mod improve;

pub use improve::improved;

use super::morton::reciprocal;
use super::rays::{outer, unit};
use crate::abi::{INVALID, Node, Range};
use crate::bvh::frame::{STEPS, along, words};
use crate::bvh::raw::half_area;
use crate::bvh::{Child, HostTree, Recipe};
use glam::Vec3;

/// Squared, of the longest distance: points this near to a line or a plane lie in it.
const FLAT: f32 = 1e-12;
/// What is known of a child of a packed node, or of the root.
#[derive(Debug, Clone)]
pub struct Slot {
    /// Its triangles; none where there is no child.
    pub range: Range,
    /// Those of its points that are least and greatest along each direction; of a leaf of few triangles all corners, again
    /// and again.
    pub points: Vec<Vec3>,
    /// Words of the frame of its least box.
    pub frame: [u32; 2],
}

impl Default for Slot {
    fn default() -> Self {
        Self { range: Range { first: 0, count: 0 }, points: vec![], frame: [0; 2] }
    }
}

/// Of `all` the points that are least and greatest along each direction, the first where several are.
pub(super) fn extremes(all: &[Vec3], directions: &[Vec3]) -> Vec<Vec3> {
    let first = |better: fn(f32, f32) -> bool, d: &Vec3| {
        all.iter().copied().reduce(|best, p| if better(along(*d, p), along(*d, best)) { p } else { best })
    };
    let of = |d| [first(|a, b| a < b, d), first(|a, b| a > b, d)];
    directions.iter().flat_map(of).flatten().collect()
}

/// What a leaf's slot holds of its corners: as many points as there are ends of `directions`. All of them, again and
/// again, where there is room: some may be extremal in no direction.
pub fn kept(all: &[Vec3], directions: &[Vec3]) -> Vec<Vec3> {
    let wanted = 2 * directions.len();
    if all.len() <= wanted {
        all.iter().copied().cycle().take(wanted).collect()
    } else {
        extremes(all, directions)
    }
}

/// Corners of the triangle at `place`, unit space.
pub fn corners(tree: &HostTree, anchor: [f32; 3], place: u32) -> [Vec3; 3] {
    tree.corners(place as usize).map(|p| Vec3::from_array(p) - Vec3::from_array(anchor))
}

/// Every slot: 4 i + k is child k of node i, and the root's comes last.
/// `points` extremal points each, as `recipe` has them; beyond its threshold none, and no frame.
pub fn fit(tree: &HostTree, anchor: [f32; 3], points: u32, recipe: &Recipe) -> Vec<Slot> {
    let mut slots = vec![Slot::default(); 4 * tree.nodes.len() + 1];
    climb(tree, anchor, &recipe.directions.of(points), tree.root, 4 * tree.nodes.len(), &mut slots);
    let most = recipe.most_of_points();
    for slot in slots.iter_mut().filter(|s| (1..=most).contains(&s.range.count)) {
        slot.frame = improved(fitted(&slot.points), &slot.points, recipe.local_search);
    }
    slots
}

/// Fills the slots below `node`, and its own.
fn climb(tree: &HostTree, anchor: [f32; 3], directions: &[Vec3], node: u32, own: usize, slots: &mut [Slot]) {
    let Node { children, .. } = tree.nodes[node as usize];
    let mut all = vec![];
    let (mut first, mut count) = (u32::MAX, 0);
    for (k, reference) in children.iter().enumerate().filter(|(_, c)| **c != INVALID) {
        let slot = 4 * node as usize + k;
        match tree.child(*reference) {
            Child::Node(child) => {
                climb(tree, anchor, directions, child, slot, slots);
                all.push(slots[slot].points.clone());
            }
            Child::Leaf { first, count } => {
                let below: Vec<Vec3> =
                    (first..first + count).flat_map(|t| corners(tree, anchor, t)).collect();
                all.push(extremes(&below, directions));
                slots[slot].range = Range { first, count };
                slots[slot].points = kept(&below, directions);
            }
        }
        let below = &slots[slot];
        first = first.min(below.range.first);
        count += below.range.count;
    }
    // Of each direction only the points that children name for it.
    let of = |j: usize| {
        let pick = |k: usize| all.iter().map(|points| points[2 * j + k]).collect::<Vec<_>>();
        let direction = [directions[j]];
        [extremes(&pick(0), &direction)[0], extremes(&pick(1), &direction)[1]]
    };
    slots[own].points = (0..directions.len()).flat_map(of).collect();
    slots[own].range = Range { first, count };
}

/// Extent of points along three axes.
pub fn extent(rows: [Vec3; 3], points: &[Vec3]) -> crate::abi::Aabb {
    let mut bounds = crate::abi::Aabb { lo: [f32::MAX; 3], hi: [f32::MIN; 3] };
    for p in points {
        for (k, axis) in rows.iter().enumerate() {
            let x = along(*axis, *p);
            bounds.lo[k] = crate::bvh::raw::least_of(bounds.lo[k], x);
            bounds.hi[k] = crate::bvh::raw::greatest_of(bounds.hi[k], x);
        }
    }
    bounds
}

/// Words of the frame of the least box that DiTO finds around `points`.
pub fn fitted(points: &[Vec3]) -> [u32; 2] {
    let points = from_first(points);
    let (mut least_area, mut best) = (f32::MAX, [Vec3::ZERO; 3]);
    for rows in candidates(&points) {
        let area = half_area(&extent(rows, &points));
        if area < least_area {
            (least_area, best) = (area, rows);
        }
    }
    frame_words(best)
}

/// Points less the first of them.
fn from_first(points: &[Vec3]) -> Vec<Vec3> {
    points.iter().map(|p| *p - points[0]).collect()
}

/// The frames that DiTO tries, the axes of the scene first.
pub fn candidates(points: &[Vec3]) -> Vec<[Vec3; 3]> {
    let mut search = Search { points, frames: vec![[Vec3::X, Vec3::Y, Vec3::Z]] };
    // None where nothing is left to try.
    let _ = search.search_frames();
    search.frames
}

struct Search<'a> {
    points: &'a [Vec3],
    frames: Vec<[Vec3; 3]>,
}

impl Search<'_> {
    fn try_edge(&mut self, normal: Vec3, edge: Vec3) {
        if let Some(across) = unit(outer(normal, edge)) {
            self.frames.push([outer(edge, across), edge, across]);
        }
    }

    /// The first of the points for which `measure` is greatest, and beyond `floor`.
    fn farthest(&self, floor: f32, none: Vec3, measure: impl Fn(Vec3) -> f32) -> (Vec3, f32) {
        self.points.iter().fold((none, floor), |(far, most), p| {
            let here = measure(*p);
            if here > most { (*p, here) } else { (far, most) }
        })
    }

    fn farthest_from(&self, p: Vec3) -> (Vec3, f32) {
        self.farthest(-1.0, p, |q| {
            let v = q - p;
            along(v, v)
        })
    }

    fn search_frames(&mut self) -> Option<()> {
        // Farther apart than the extremal points of any direction, or hardly nearer.
        let (p0, _) = self.farthest_from(self.points[0]);
        let (p1, longest) = self.farthest_from(p0);
        let edge = unit(p0 - p1)?;
        let (p2, off_line) = self.farthest(-1.0, self.points[0], |p| {
            let v = p - p0;
            let off = v - edge * along(edge, v);
            along(off, off)
        });
        let across = unit(outer(p1 - p2, p2 - p0)).filter(|_| off_line > FLAT * longest);
        let Some(normal) = across else {
            let size = edge.abs();
            let other = if size.x <= size.y && size.x <= size.z {
                Vec3::X
            } else if size.y <= size.z {
                Vec3::Y
            } else {
                Vec3::Z
            };
            self.try_edge(unit(outer(edge, other))?, edge);
            return None;
        };
        let (above, highest) = self.farthest(0.0, p0, |p| along(normal, p - p0));
        let (below, lowest) = self.farthest(0.0, p0, |p| -along(normal, p - p0));
        let base = [p0, p1, p2];
        self.try_face(base);
        for (tip, height) in [(above, highest), (below, lowest)] {
            if height * height > FLAT * longest {
                for side in 0..3 {
                    self.try_face([tip, base[side], base[(side + 1) % 3]]);
                }
            }
        }
        Some(())
    }

    fn try_face(&mut self, [a, b, c]: [Vec3; 3]) {
        let edges = [b - a, c - b, a - c];
        let Some(normal) = unit(outer(edges[0], edges[1])) else { return };
        for edge in edges {
            if let Some(edge) = unit(edge) {
                self.try_edge(normal, edge);
            }
        }
    }
}

/// The rotation to axes like `rows`, in an order and of signs that make it least.
pub fn frame_words(rows: [Vec3; 3]) -> [u32; 2] {
    let mut best = (-1.0, rows);
    for order in 0..6 {
        let i = order >> 1;
        let j = (i + 1 + (order & 1)) % 3;
        let turned = [rows[i], rows[j], rows[3 - i - j]];
        let trace = turned[0].x.abs() + turned[1].y.abs() + turned[2].z.abs();
        if trace > best.0 {
            best = (trace, turned);
        }
    }
    let (trace, turned) = best;
    let [x, y, z]: [Vec3; 3] =
        std::array::from_fn(|k| if turned[k][k] < 0.0 { -turned[k] } else { turned[k] });
    let r = Vec3::new(z.y - y.z, x.z - z.x, y.x - x.y) * reciprocal(1.0 + trace);
    words(r.to_array().map(|x| (x * STEPS + 0.5).floor().clamp(-1_048_575.0, 1_048_575.0) as i32))
}
