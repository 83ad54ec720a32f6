//! Twin of `glsl/lib/by_doubles.glsl`: ray against triangle in double precision.

use super::{Known, Meeting, Setup, V3};

/// 2⁻²⁰: see `glsl/lib/by_doubles.glsl`.
const DOUBLE_RIGHT: f64 = 1.0 / 1_048_576.0;
/// 2⁻⁴⁶.
const DOUBLE_DOUBT: f64 = 1.0 / 70_368_744_177_664.0;

type D3 = [f64; 3];

fn dot(a: D3, b: D3) -> f64 {
    a[0] * b[0] + (a[1] * b[1] + a[2] * b[2])
}

fn sum(a: D3) -> f64 {
    a[0] + (a[1] + a[2])
}

/// The products of a × b, and those that are taken from them.
fn products(a: D3, b: D3) -> [D3; 2] {
    let product = |i: usize, j: usize| std::array::from_fn(|k| a[(k + i) % 3] * b[(k + j) % 3]);
    [product(1, 2), product(2, 1)]
}

fn each(a: D3, b: D3, f: impl Fn(f64, f64) -> f64) -> D3 {
    std::array::from_fn(|k| f(a[k], b[k]))
}

/// `corners` in the order of `axes`.
pub(super) fn meet_by_doubles(s: &Setup, corners: [V3; 3], limit: f32) -> Known {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let line = s.line.map(f64::from);
    let minus = |a: D3, b: D3| each(a, b, |a, b| a - b);
    let (x, e1, e2) = (minus(a, s.origin.map(f64::from)), minus(b, a), minus(c, a));
    let ([n_more, n_less], [h_more, h_less]) = (products(e2, e1), products(line, x));
    let (n, h) = (minus(n_more, n_less), minus(h_more, h_less));
    let (det, depth, v, w) = (dot(line, n), dot(x, n), dot(h, e2), -dot(h, e1));
    let u = det - (v + w);

    let size = |a: D3| a.map(f64::abs);
    let n_size = each(size(n_more), size(n_less), |a, b| a + b);
    let e_sum = sum(each(size(e1), size(e2), |a, b| a + b));
    let det_size = dot(size(line), n_size);
    let off = (DOUBLE_DOUBT * e_sum) * (sum(size(x)) + e_sum);
    let (least, most) = (u.min(v).min(w), u.max(v).max(w));
    let over = 1.0 / det;
    let (t, t_size) = (depth * over, dot(size(x), n_size) * over.abs());
    let t_off = DOUBLE_DOUBT * t_size + t.abs() * (8.0 / 16_777_216.0);
    let det_right = det.abs() > DOUBLE_RIGHT * det_size;
    // Of t that differ by less than the least normal float both may be one: then neither is beyond the other.
    let latest = f64::from(limit) + if limit < s.t_max { f64::from(f32::MIN_POSITIVE) } else { 0.0 };
    let out_of_range = t + t_off < f64::from(s.t_min) || t - t_off > latest;
    if (least < -off && most > off) || (det_right && out_of_range) || det_size == 0.0 {
        return Known::PassedBy;
    }
    if det_right && (least > off || most < -off) && t.abs() > DOUBLE_RIGHT * t_size {
        return Known::Met(Meeting { t: t as f32, uv: [(v * over) as f32, (w * over) as f32] });
    }
    Known::Unknown
}
