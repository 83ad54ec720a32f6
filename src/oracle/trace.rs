//! Twin of `glsl/trace/single.comp`, and of `glsl/trace/binary.comp`, with the robust test; the other kernels
//! give the same hits.

mod binary;
mod digits;
mod double_single;
mod packed;
mod triple;

pub use binary::BinaryNodes;

use self::digits::exact_triple;
use self::double_single::{Pair, cross, difference, dot, inner_size, outer_size, upper};
use self::triple::triple;
use super::morton::Space;
use crate::abi::{Hit, INVALID, LEAF_BIT, Ray, TRIANGLE_WORDS, Tests};
use crate::bvh::{Child, HostTree};

type V3 = [f32; 3];

/// Box padding, in units of the largest coordinate difference: see `glsl/lib/ray.glsl`.
const PAD: f32 = 32.0 / 16_777_216.0;
/// Likewise in a node's frame, times its stretch.
const PAD_ORIENTED: f32 = 64.0 / 16_777_216.0;
/// Direction components below this are raised to it.
const LEAST_DIRECTION: f32 = 1.0 / 1_099_511_627_776.0;

/// A ray made ready for boxes and triangles.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// Unit scale, not moved; in the order of `axes`.
    pub origin: V3,
    /// Of the triangle test.
    pub shear: V3,
    /// A permutation of 0 1 2; the last is the direction's largest component.
    pub axes: [usize; 3],
    /// Scaled direction; in the order of `axes`.
    pub direction: V3,
    /// R, the largest coordinate difference between the origin and the scene.
    pub reach: f32,
    /// Origin, moved; as given.
    pub moved: V3,
    /// Scaled direction, as given.
    pub unturned: V3,
    /// 1 / direction.
    pub inverse: V3,
    /// t of a near plane at p: p · inverse + near.
    pub near: V3,
    /// Likewise of a far plane.
    pub far: V3,
    /// Least t.
    pub t_min: f32,
    /// Greatest t.
    pub t_max: f32,
    /// t of the file = t here · 2 to this power.
    pub t_exponent: i32,
    /// Whether it can hit anything.
    pub valid: bool,
}

/// x · 2^exponent, exactly; what is denormal is rounded. In f64 every f32 is normal.
fn rescaled(x: f32, exponent: i32) -> f32 {
    (f64::from(x) * 2f64.powi(exponent)) as f32
}

/// Likewise; what is denormal becomes 0 of x's sign, as it is to some devices.
fn scaled(x: f32, exponent: i32) -> f32 {
    let exact = f64::from(x) * 2f64.powi(exponent);
    if exact.abs() < f64::from(f32::MIN_POSITIVE) { 0f32.copysign(x) } else { exact as f32 }
}

/// Likewise a limit of t, towards the inside of the range where it would become 0.
fn scaled_limit(t: f32, exponent: i32, outward_sign: f32) -> f32 {
    let scaled = scaled(t, exponent);
    let inward = t.is_sign_negative() != outward_sign.is_sign_negative() && t != 0.0;
    if scaled == 0.0 && inward { f32::MIN_POSITIVE.copysign(t) } else { scaled }
}

/// 1 / d, finite.
fn inverse_of(d: V3) -> V3 {
    d.map(|x| 1.0 / if x.abs() < LEAST_DIRECTION { LEAST_DIRECTION.copysign(x) } else { x })
}

/// Prepares `ray` for a tree of unit space `space`.
pub fn prepare(ray: &Ray, space: &Space) -> Setup {
    let (mut d, mut o) = (ray.direction, ray.origin);
    let finite = d.iter().chain(&o).all(|x| x.is_finite());
    let mut largest = d.iter().fold(0.0, |a, x| f32::max(a, x.abs()));
    let valid = finite && !ray.t_min.is_nan() && !ray.t_max.is_nan() && largest > 0.0;
    if !valid {
        d = [0.0, 0.0, 1.0];
        largest = 1.0;
    }
    // In f64 every f32 is normal.
    let exponent = (f64::from(largest).to_bits() >> 52) as i32 - 1023;
    d = d.map(|x| scaled(x, -exponent));
    let t_exponent = -exponent - space.exponent;

    o = o.map(|x| scaled(x, space.exponent));
    let moved: V3 = std::array::from_fn(|k| o[k] - space.anchor[k]);
    let reach = space.reach + moved.iter().fold(0.0, |a, x| f32::max(a, x.abs()));
    let inverse = inverse_of(d);
    let centre: V3 = std::array::from_fn(|k| -moved[k] * inverse[k]);
    let pad: V3 = std::array::from_fn(|k| (PAD * reach) * inverse[k].abs());

    let a = d.map(f32::abs);
    let axes = if a[2] >= a[0] && a[2] >= a[1] {
        [0, 1, 2]
    } else if a[1] >= a[0] {
        [2, 0, 1]
    } else {
        [1, 2, 0]
    };
    Setup {
        origin: axes.map(|k| o[k]),
        shear: [d[axes[0]] / d[axes[2]], d[axes[1]] / d[axes[2]], 1.0 / d[axes[2]]],
        axes,
        direction: axes.map(|k| d[k]),
        reach,
        moved,
        unturned: d,
        inverse,
        near: std::array::from_fn(|k| centre[k] - pad[k]),
        far: std::array::from_fn(|k| centre[k] + pad[k]),
        t_min: scaled_limit(ray.t_min, -t_exponent, -1.0),
        t_max: scaled_limit(ray.t_max, -t_exponent, 1.0),
        t_exponent,
        valid,
    }
}

/// At least this sorts a child that the ray passes by.
const MISSED: i32 = 0x7f80_0000;

/// t where a child is entered, or a little less.
fn entered(key: i32) -> f32 {
    f32::from_bits((if key < 0 { key | 3 } else { key & !3 }) as u32)
}

/// What a triangle test knows: the hit at t = depth / det, weights of the second and third corner = uv / det.
#[derive(Debug, Clone, Copy)]
pub struct Meeting {
    /// t · det.
    pub depth: f32,
    /// Sum of the weights.
    pub det: f32,
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
    if lo < -doubt && hi > doubt {
        return None;
    }
    let corners = corners.map(|p| s.axes.map(|k| p[k]));
    if wide {
        return meet_by_doubles(s, corners);
    }
    match meet_by_pairs(s, corners, limit) {
        Known::Met(m) => Some(m),
        Known::Missed => None,
        Known::Nothing => meet_by_integers(s, corners),
    }
}

/// What double-single precision can tell.
enum Known {
    Met(Meeting),
    Missed,
    Nothing,
}

/// 2⁻⁴²: see `glsl/lib/hit.glsl`.
const PAIR_DOUBT: f32 = 1.0 / 4_398_046_511_104.0;
/// 2⁻¹⁵.
const PAIR_RIGHT: f32 = 1.0 / 32_768.0;
/// 2⁻⁶⁰.
const PAIR_LEAST: f32 = 1.0 / 1_152_921_504_606_846_976.0;

/// `corners` in the order of `axes`.
fn meet_by_pairs(s: &Setup, [a, b, c]: [V3; 3], limit: f32) -> Known {
    let [x, e1, e2] = [difference(a, s.origin), difference(b, a), difference(c, a)];
    let line = s.direction.map(Pair::new);
    let (n, h) = (cross(&e2, &e1), cross(&line, &x));
    let (det, depth, v, w) = (dot(&line, &n), dot(&x, &n), dot(&h, &e2), dot(&h, &e1).negated());
    let u = det.plus(v.plus(w).negated());

    let [x, e1, e2] = [x, e1, e2].map(|e| upper(&e));
    let (n_size, h_size) = (outer_size(e2, e1), outer_size(s.direction, x));
    let (det_size, depth_size) = (inner_size(s.direction, n_size), inner_size(x, n_size));
    let [v_off, w_off] = [e2, e1].map(|e| PAIR_DOUBT * inner_size(h_size, e) + PAIR_LEAST);
    let off = [PAIR_DOUBT * det_size + (v_off + w_off), v_off, w_off];
    let [det_least, depth_least] = [det_size, depth_size].map(|size| PAIR_RIGHT * size + PAIR_LEAST);
    let size = det.hi.abs();
    if !(s.reach < 1_048_576.0 && size > det_least) {
        return Known::Nothing;
    }
    let weights = [u, v, w].map(|w| if det.hi > 0.0 { w.hi } else { -w.hi });
    if weights.iter().zip(off).any(|(w, off)| *w < -off) {
        return Known::Missed;
    }
    let t = depth.over(det);
    let t_off = (PAIR_DOUBT * depth_size + PAIR_LEAST) / size + t.abs() * (8.0 / 16_777_216.0);
    if t + t_off < s.t_min || t - t_off > limit {
        return Known::Missed;
    }
    if weights.iter().zip(off).any(|(w, off)| *w < off) || depth.hi.abs() <= depth_least {
        return Known::Nothing;
    }
    Known::Met(Meeting { depth: t, det: 1.0, uv: [v.over(det), w.over(det)] })
}

/// `corners` in the order of `axes`.
fn meet_by_integers(s: &Setup, [a, b, c]: [V3; 3]) -> Option<Meeting> {
    if !s.reach.is_finite() {
        return None;
    }
    let weights = [[c, b], [a, c], [b, a]].map(|[p, q]| exact_triple(s.direction, s.origin, p, q, false));
    let least = weights.iter().fold(0.0, |x, w| f32::min(x, w.value.hi));
    let most = weights.iter().fold(0.0, |x, w| f32::max(x, w.value.hi));
    if (least < 0.0 && most > 0.0) || least == most {
        return None;
    }
    let depth = exact_triple(a, s.origin, c, b, true);
    let exponent = weights.iter().map(|w| w.exponent).max()?;
    let mut det = Pair::new(0.0);
    for w in &weights {
        let shift = w.exponent - exponent;
        let sum = Pair::exact_sum(det.hi, scaled(w.value.hi, shift));
        det = Pair { hi: sum.hi, lo: sum.lo + (det.lo + scaled(w.value.lo, shift)) };
    }
    let [t, v, w] = [depth, weights[1], weights[2]].map(|x| scaled(x.value.over(det), x.exponent - exponent));
    Some(Meeting { depth: t, det: 1.0, uv: [v, w] })
}

fn meet_by_doubles(s: &Setup, corners: [V3; 3]) -> Option<Meeting> {
    let (d, o) = (s.direction.map(f64::from), s.origin.map(f64::from));
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let (u, v, w) = (triple(d, o, c, b), triple(d, o, a, c), triple(d, o, b, a));
    let signs = [u, v, w];
    let det = u + v + w;
    if (signs.iter().any(|x| *x < 0.0) && signs.iter().any(|x| *x > 0.0)) || det == 0.0 {
        return None;
    }
    let depth = (u * (a[2] - o[2]) + v * (b[2] - o[2]) + w * (c[2] - o[2])) / (det * d[2]);
    Some(Meeting { depth: depth as f32, det: 1.0, uv: [(v / det) as f32, (w / det) as f32] })
}

/// The nearest hit so far.
#[derive(Debug, Clone, Copy)]
struct Nearest {
    t: f32,
    triangle: u32,
    uv: [f32; 2],
}

/// Nodes that rays walk.
pub trait Nodes {
    /// Node or leaf, or [`INVALID`].
    fn root(&self) -> u32;
    /// The children of a node that a ray meets before `t_max`, farthest first, each with the key that sorts it; counts
    /// what was tested.
    fn met(&self, s: &Setup, node: u32, t_max: f32, tests: &mut Tests) -> Vec<(i32, u32)>;
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
            if node == INVALID || entered(key) > nearest.t {
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
            stack.extend(nodes.met(s, node, nearest.t, &mut tests));
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
        let mut nearest = Nearest { t: s.t_max, triangle: INVALID, uv: [0.0; 2] };
        let tests = self.walk(nodes, &s, &mut nearest, |place, nearest| {
            let (corners, index) = self.triangle(place);
            let Some(m) = self.meet(&s, corners, nearest.t) else { return false };
            let over = 1.0 / m.det;
            let t = m.depth * over;
            if t >= s.t_min && t <= nearest.t.min(f32::MAX) && (t != nearest.t || index < nearest.triangle) {
                *nearest = Nearest { t, triangle: index, uv: m.uv.map(|w| w * over) };
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
        let mut nearest = Nearest { t: s.t_max, triangle: INVALID, uv: [0.0; 2] };
        let tests = self.walk(nodes, &s, &mut nearest, |place, _| {
            occluded |= self.meet(&s, self.triangle(place).0, s.t_max).is_some_and(|m| {
                let t = m.depth * (1.0 / m.det);
                t >= s.t_min && t <= s.t_max.min(f32::MAX)
            });
            occluded
        });
        (if occluded { Hit { t: 0.0, ..Hit::MISS } } else { Hit::MISS }, tests)
    }

    /// Input indices of all triangles of the tree that the line of `ray` meets: no boxes, no order.
    pub fn crossed(&self, ray: &Ray) -> Vec<u32> {
        let s = Setup { t_min: f32::NEG_INFINITY, ..prepare(ray, self.space) };
        let count = self.tree.triangles.len() as u32 / TRIANGLE_WORDS;
        let index_if_met = |place: u32| {
            let (corners, index) = self.triangle(place);
            self.meet(&s, corners, f32::INFINITY).map(|_| index)
        };
        if s.valid { (0..count).filter_map(index_if_met).collect() } else { vec![] }
    }
}
