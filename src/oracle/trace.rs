//! Twin of `glsl/trace/single.comp`, and of `glsl/trace/binary.comp`, with the robust test; the other kernels
//! give the same hits.

mod approach;
mod binary;
mod by_doubles;
mod by_integers;
mod by_pairs;
mod digits;
mod distant;
mod double_single;
mod packed;
mod ray;

pub use binary::BinaryNodes;
pub use ray::{Setup, prepare};

use self::by_doubles::meet_by_doubles;
use self::by_integers::meet_by_integers;
use self::by_pairs::meet_by_pairs;
use self::ray::rescaled;
use super::morton::Space;
use crate::abi::{Hit, INVALID, LEAF_BIT, Ray, TRIANGLE_WORDS, Tests};
use crate::bvh::{Child, HostTree};

type V3 = [f32; 3];

/// At least this sorts a child that the ray passes by.
const MISSED: i32 = 0x7f80_0000;

/// t where a child is entered, or a little less.
fn entered(key: i32) -> f32 {
    f32::from_bits((if key < 0 { key | 3 } else { key & !3 }) as u32)
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Meeting {
    /// In lengths of the scaled direction.
    pub t: f32,
    /// Weights of the second and third corner.
    pub uv: [f32; 2],
}

/// The robust test \[WOOP13\], of a device with 64-bit floats (`wide`) or without. `corners` in unit scale, not moved. What
/// is not surely missed is met again, in doubles, or in double-single precision and by integers; there what is surely beyond
/// `limit` or before t_min is not.
pub fn meet(s: &Setup, corners: [V3; 3], limit: f32, wide: bool) -> Option<Meeting> {
    let [a, b, c] = corners.map(|p| std::array::from_fn::<f32, 3, _>(|k| p[s.axes[k]] - s.origin[k]));
    let [p, q, r] = [a, b, c].map(|x| [x[0] - s.shear[0] * x[2], x[1] - s.shear[1] * x[2]]);
    let u = r[0] * q[1] - r[1] * q[0];
    let v = p[0] * r[1] - p[1] * r[0];
    let w = q[0] * p[1] - q[1] * p[0];
    let far = |k: usize| p[k].abs().max(q[k].abs()).max(r[k].abs());
    let doubt = ((32.0 / 16_777_216.0) * s.reach) * (far(0) + far(1));
    let (lo, hi) = (u.min(v).min(w), u.max(v).max(w));
    if !s.is_distant() && lo < -doubt && hi > doubt {
        return None;
    }
    let corners = corners.map(|p| s.axes.map(|k| p[k]));
    let known = match wide {
        true if !s.is_distant() => meet_by_doubles(s, corners, limit),
        // Beyond, products might overflow.
        false if s.reach < 1_048_576.0 => meet_by_pairs(s, corners, limit),
        _ => Known::Unknown,
    };
    match known {
        Known::Met(m) => Some(m),
        Known::PassedBy => None,
        Known::Unknown => meet_by_integers(s, corners),
    }
}

/// What is known of a meeting.
enum Known {
    Met(Meeting),
    PassedBy,
    Unknown,
}

/// The nearest hit so far.
#[derive(Debug, Clone, Copy)]
struct Nearest {
    t: f32,
    triangle: u32,
    uv: [f32; 2],
    /// What is beyond, as the walk counts t, is passed by.
    limit: f32,
}

impl Nearest {
    fn none_yet(s: &Setup) -> Self {
        Self { t: s.t_max, triangle: INVALID, uv: [0.0; 2], limit: s.limit_at(s.t_max) }
    }
}

/// Nodes that rays walk.
pub trait Nodes {
    /// Node or leaf, or [`INVALID`].
    fn root(&self) -> u32;
    /// The children of a node that a ray meets before `limit`, as its walk counts t, farthest first, each with the key that sorts it; counts
    /// what was tested.
    fn met(&self, s: &Setup, node: u32, limit: f32, tests: &mut Tests) -> Vec<(i32, u32)>;
}

/// A tree and its unit space.
#[derive(Debug, Clone, Copy)]
pub struct Tree<'a> {
    /// The packed tree.
    pub tree: &'a HostTree,
    /// Its unit space.
    pub space: &'a Space,
    /// Whether the device has 64-bit floats.
    pub wide: bool,
}

impl Tree<'_> {
    fn meet(&self, s: &Setup, corners: [V3; 3], limit: f32) -> Option<Meeting> {
        meet(s, corners, limit, self.wide)
    }

    /// Corners of the triangle at `place` of the packed tree, unit scale, and its input index.
    fn triangle(&self, place: u32) -> ([V3; 3], u32) {
        let at = (place * TRIANGLE_WORDS) as usize;
        let word = |k: usize| f32::from_bits(self.tree.triangles[at + k]);
        (std::array::from_fn(|c| std::array::from_fn(|k| word(3 * c + k))), self.tree.triangles[at + 9])
    }

    /// Walks `nodes`, nearer child first. `leaf` tests triangle `place` and returns whether the walk ends.
    fn walk(
        &self,
        nodes: &impl Nodes,
        s: &Setup,
        nearest: &mut Nearest,
        mut leaf: impl FnMut(u32, &mut Nearest) -> bool,
    ) -> Tests {
        let mut tests = Tests { boxes: 0, oriented: 0, triangles: 0, pad: 0 };
        let mut stack =
            if s.valid { vec![(f32::NEG_INFINITY.to_bits() as i32, nodes.root())] } else { vec![] };
        while let Some((key, node)) = stack.pop() {
            if node == INVALID || entered(key) > nearest.limit {
                continue;
            }
            if node >= LEAF_BIT {
                let Child::Leaf { first, count } = self.tree.child(node) else { continue };
                for place in first..first + count {
                    tests.triangles += 1;
                    if leaf(place, nearest) {
                        return tests;
                    }
                }
                continue;
            }
            stack.extend(nodes.met(s, node, nearest.limit, &mut tests));
        }
        tests
    }

    /// The nearest hit of `ray`, of equal t that of the lowest index, and what was tested.
    pub fn closest(&self, ray: &Ray) -> (Hit, Tests) {
        self.closest_by(self.tree, ray)
    }

    /// Likewise, by other nodes over the same leaves.
    pub fn closest_by(&self, nodes: &impl Nodes, ray: &Ray) -> (Hit, Tests) {
        let s = prepare(ray, self.space);
        let mut nearest = Nearest::none_yet(&s);
        let tests = self.walk(nodes, &s, &mut nearest, |place, nearest| {
            let (corners, index) = self.triangle(place);
            let Some(m) = self.meet(&s, corners, nearest.t) else { return false };
            let t = m.t;
            if t >= s.t_min && t <= nearest.t.min(f32::MAX) && (t != nearest.t || index < nearest.triangle) {
                *nearest = Nearest { t, triangle: index, uv: m.uv, limit: s.limit_at(t) };
            }
            false
        });
        if nearest.triangle == INVALID {
            return (Hit::MISS, tests);
        }
        let [u, v] = nearest.uv;
        (Hit { t: rescaled(nearest.t, s.t_exponent).min(f32::MAX), triangle: nearest.triangle, u, v }, tests)
    }

    /// Whether `ray` hits anything: t is 0 where it does; and what was tested.
    pub fn any(&self, ray: &Ray) -> (Hit, Tests) {
        self.any_by(self.tree, ray)
    }

    /// Likewise, by other nodes over the same leaves.
    pub fn any_by(&self, nodes: &impl Nodes, ray: &Ray) -> (Hit, Tests) {
        let s = prepare(ray, self.space);
        let mut occluded = false;
        let mut nearest = Nearest::none_yet(&s);
        let tests = self.walk(nodes, &s, &mut nearest, |place, _| {
            occluded |= self
                .meet(&s, self.triangle(place).0, s.t_max)
                .is_some_and(|m| m.t >= s.t_min && m.t <= s.t_max.min(f32::MAX));
            occluded
        });
        (if occluded { Hit { t: 0.0, ..Hit::MISS } } else { Hit::MISS }, tests)
    }

    /// Input indices of all triangles of the tree that the line of `ray` meets: no boxes, no order.
    pub fn crossed(&self, ray: &Ray) -> Vec<u32> {
        let s = prepare(&Ray { t_min: f32::NEG_INFINITY, t_max: f32::INFINITY, ..*ray }, self.space);
        let count = self.tree.triangles.len() as u32 / TRIANGLE_WORDS;
        let index_if_met = |place: u32| {
            let (corners, index) = self.triangle(place);
            self.meet(&s, corners, f32::INFINITY).map(|_| index)
        };
        if s.valid { (0..count).filter_map(index_if_met).collect() } else { vec![] }
    }
}
