//! Twin of `glsl/lib/approach.glsl`: where the walk of a far ray begins.

use super::V3;
use super::double_single::Pair;

/// A ray from nearer is as well off without.
const NEAR: f32 = 32.0;
/// 2¹⁰⁰: from beyond, something might overflow.
const FARTHEST: f32 = 1_267_650_600_228_229_401_496_703_205_376.0;

/// How far along `d` the walk begins; 0 where it does at the ray's origin.
pub(super) fn ahead_of(moved: V3, d: V3, reach: f32) -> f32 {
    if !(reach > NEAR && reach < FARTHEST) {
        return 0.0;
    }
    let sum = |x: V3, y: V3| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    -sum(moved, d) / sum(d, d) - (2.0 + reach * (1.0 / 4_194_304.0))
}

/// o − anchor + ahead · d.
pub(super) fn approached(o: V3, anchor: V3, d: V3, ahead: f32) -> V3 {
    std::array::from_fn(|k| {
        let (moved, way) = (Pair::exact_sum(o[k], -anchor[k]), Pair::exact_product(d[k], ahead));
        let sum = Pair::exact_sum(moved.hi, way.hi);
        sum.hi + (sum.lo + (moved.lo + way.lo))
    })
}

/// A limit of t as the walk counts, not within the range by what was rounded.
pub(super) fn walk_limit(t: f32, ahead: f32, outward: f32) -> f32 {
    if ahead == 0.0 {
        return t;
    }
    let slack = (t.abs() + ahead.abs()).min(f32::MAX) * (1.0 / 2_097_152.0);
    (t - ahead) + outward * slack
}
