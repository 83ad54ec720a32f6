//! Twin of `glsl/lib/by_pairs.glsl`: ray against triangle in double-single precision.

use super::double_single::{Pair, cross, difference, dot, inner_size, outer_size, upper};
use super::{Known, Meeting, Setup, V3};

/// 2⁻⁴²: see `glsl/lib/by_pairs.glsl`.
const PAIR_DOUBT: f32 = 1.0 / 4_398_046_511_104.0;
/// 2⁻¹⁵.
const PAIR_RIGHT: f32 = 1.0 / 32_768.0;
/// 2⁻⁶⁰.
const PAIR_LEAST: f32 = 1.0 / 1_152_921_504_606_846_976.0;

/// Whether d · (c − a) × (b − a) has no term but 0.
fn surely_zero(d: V3, a: V3, b: V3, c: V3) -> bool {
    (0..3).all(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        d[k] == 0.0 || (c[i] == a[i] || b[j] == a[j]) && (c[j] == a[j] || b[i] == a[i])
    })
}

/// `corners` in the order of `axes`.
pub(super) fn meet_by_pairs(s: &Setup, [a, b, c]: [V3; 3], limit: f32) -> Known {
    let [x, e1, e2] = [difference(a, s.origin), difference(b, a), difference(c, a)];
    let line = s.line.map(Pair::new);
    let (n, h) = (cross(&e2, &e1), cross(&line, &x));
    let (det, depth, v, w) = (dot(&line, &n), dot(&x, &n), dot(&h, &e2), dot(&h, &e1).negated());
    let u = det.plus(v.plus(w).negated());

    let [x, e1, e2] = [x, e1, e2].map(|e| upper(&e));
    let (n_size, h_size) = (outer_size(e2, e1), outer_size(s.line, x));
    let (det_size, depth_size) = (inner_size(s.line, n_size), inner_size(x, n_size));
    let [v_off, w_off] = [e2, e1].map(|e| PAIR_DOUBT * inner_size(h_size, e) + PAIR_LEAST);
    let off = [PAIR_DOUBT * det_size + (v_off + w_off), v_off, w_off];
    let [det_least, depth_least] = [det_size, depth_size].map(|size| PAIR_RIGHT * size + PAIR_LEAST);
    let size = det.hi.abs();
    if size <= det_least || size.is_nan() {
        return if surely_zero(s.line, a, b, c) { Known::PassedBy } else { Known::Unknown };
    }
    let weights = [u, v, w].map(|w| if det.hi > 0.0 { w.hi } else { -w.hi });
    if weights.iter().zip(off).any(|(w, off)| *w < -off) {
        return Known::PassedBy;
    }
    let t = depth.over(det);
    let t_off = (PAIR_DOUBT * depth_size + PAIR_LEAST) / size + t.abs() * (8.0 / 16_777_216.0);
    if t + t_off < s.t_min || t - t_off > limit {
        return Known::PassedBy;
    }
    if weights.iter().zip(off).any(|(w, off)| *w < off) || depth.hi.abs() <= depth_least {
        return Known::Unknown;
    }
    Known::Met(Meeting { t, uv: [v.over(det), w.over(det)] })
}
