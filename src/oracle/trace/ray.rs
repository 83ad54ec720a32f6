//! Twin of `glsl/lib/ray.glsl`: a ray made ready for boxes and triangles.

use super::V3;
use super::approach::{NEAR, ahead_of, approached, walk_limit};
use super::distant::{DISTANT, Far};
use crate::abi::Ray;
use crate::oracle::morton::Space;

/// Box padding, in units of the largest coordinate difference: see `glsl/lib/ray.glsl`.
const PAD: f32 = 32.0 / 16_777_216.0;
/// Likewise in a node's frame, times its stretch.
pub(super) const PAD_ORIENTED: f32 = 64.0 / 16_777_216.0;
/// Direction components below this are raised to it.
const LEAST_DIRECTION: f32 = 1.0 / 1_099_511_627_776.0;

/// A ray made ready for boxes and triangles.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// Unit scale · 2^−`scale`, not moved; in the order of `axes`.
    pub origin: V3,
    /// Of the triangle test.
    pub shear: V3,
    /// A permutation of 0 1 2; the last is the direction's largest component.
    pub axes: [usize; 3],
    /// Scaled direction, of a distant ray unscaled; in the order of `axes`.
    pub line: V3,
    /// 0, but of a distant ray.
    pub scale: usize,
    /// Likewise: t here = t in lengths of `line` · 2^`shift`.
    pub shift: i32,
    /// Largest coordinate difference between the origin and the scene.
    pub reach: f32,
    /// Where the walk begins, in lengths of the direction: what is of the walk counts t from there.
    pub ahead: f32,
    /// `t_min`, of the walk.
    pub begin: f32,
    /// R, of the walk.
    pub walk_reach: f32,
    /// Origin of the walk, moved; as given.
    pub moved: V3,
    /// Scaled direction, as given.
    pub unturned: V3,
    /// 1 / direction.
    pub inverse: V3,
    /// Of the walk, t of a near plane at p: p · inverse + near.
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

impl Setup {
    /// Whether the origin is so far away that `glsl/lib/distant.glsl` sees to it.
    pub(super) fn is_distant(&self) -> bool {
        self.reach >= DISTANT
    }

    /// What is beyond t, as the walk counts.
    pub(super) fn limit_at(&self, t: f32) -> f32 {
        if self.is_distant() { f32::MAX } else { walk_limit(t, self.ahead, 1.0) }
    }
}

/// x · 2^exponent, exactly; what is denormal is rounded. In f64 every f32 is normal.
pub(super) fn rescaled(x: f32, exponent: i32) -> f32 {
    (f64::from(x) * 2f64.powi(exponent)) as f32
}

/// Likewise; what is denormal becomes 0 of x's sign, as it is to some devices.
pub(super) fn scaled(x: f32, exponent: i32) -> f32 {
    let exact = f64::from(x) * 2f64.powi(exponent);
    if exact.abs() < f64::from(f32::MIN_POSITIVE) { 0f32.copysign(x) } else { exact as f32 }
}

/// Likewise a limit of t, which stays on its side of 0.
fn scaled_limit(t: f32, exponent: i32) -> f32 {
    let scaled = scaled(t, exponent);
    if scaled == 0.0 && t != 0.0 { f32::MIN_POSITIVE.copysign(t) } else { scaled }
}

/// 1 / d, finite.
pub(super) fn inverse_of(d: V3) -> V3 {
    d.map(|x| 1.0 / if x.abs() < LEAST_DIRECTION { LEAST_DIRECTION.copysign(x) } else { x })
}

/// Prepares `ray` for a tree of unit space `space`.
pub fn prepare(ray: &Ray, space: &Space) -> Setup {
    let (mut d, mut o) = (ray.direction, ray.origin);
    let finite = d.iter().chain(&o).all(|x| x.is_finite());
    let mut largest = d.iter().fold(0.0, |a, x| f32::max(a, x.abs()));
    let mut valid = finite && !ray.t_min.is_nan() && !ray.t_max.is_nan() && largest > 0.0;
    if !valid {
        d = [0.0, 0.0, 1.0];
        largest = 1.0;
    }
    // In f64 every f32 is normal.
    let exponent = (f64::from(largest).to_bits() >> 52) as i32 - 1023;
    d = d.map(|x| scaled(x, -exponent));
    let mut t_exponent = -exponent - space.exponent;

    o = o.map(|x| scaled(x, space.exponent));
    let reach_from = |p: V3| space.reach + p.iter().fold(0.0, |a, x| f32::max(a, x.abs()));
    let mut moved: V3 = std::array::from_fn(|k| o[k] - space.anchor[k]);
    let reach = reach_from(moved);
    let (mut ahead, mut walk_reach) = (0.0, reach);
    let a = d.map(f32::abs);
    let axes = if a[2] >= a[0] && a[2] >= a[1] {
        [0, 1, 2]
    } else if a[1] >= a[0] {
        [2, 0, 1]
    } else {
        [1, 2, 0]
    };
    let far = (reach >= DISTANT).then(|| Far::new([ray.origin, ray.direction], [o, d], exponent, space));
    if let Some(far) = &far {
        o = far.origin;
        t_exponent += far.scale as i32 + 2;
    }
    let (t_min, t_max) = (scaled_limit(ray.t_min, -t_exponent), scaled_limit(ray.t_max, -t_exponent));
    let mut begin = t_min;
    if let Some(far) = &far {
        let start = far.begin(space.anchor, axes[2]);
        moved = start.at;
        valid &= !(start.aside || start.is_out_of(t_min, t_max));
        begin = 0.0;
        walk_reach = reach_from(moved) + 2.0;
    } else if reach > NEAR {
        ahead = ahead_of(moved, d, reach);
        moved = approached(o, space.anchor, d, ahead);
        begin = walk_limit(t_min, ahead, -1.0);
        walk_reach = reach_from(moved) + reach * (1.0 / 16_777_216.0);
    }
    let inverse = inverse_of(d);
    let centre: V3 = std::array::from_fn(|k| -moved[k] * inverse[k]);
    let pad: V3 = std::array::from_fn(|k| (PAD * walk_reach) * inverse[k].abs());

    let line = far.map_or(d, |far| far.line);
    Setup {
        origin: axes.map(|k| o[k]),
        shear: [d[axes[0]] / d[axes[2]], d[axes[1]] / d[axes[2]], 1.0 / d[axes[2]]],
        axes,
        line: axes.map(|k| line[k]),
        scale: far.map_or(0, |far| far.scale),
        shift: far.map_or(0, |far| far.shift()),
        reach,
        ahead,
        begin,
        walk_reach,
        moved,
        unturned: d,
        inverse,
        near: std::array::from_fn(|k| centre[k] - pad[k]),
        far: std::array::from_fn(|k| centre[k] + pad[k]),
        t_min,
        t_max,
        t_exponent,
        valid,
    }
}
