//! Twin of `glsl/lib/triple.glsl`: d · ((p − o) × (q − o)) of single-precision vectors, with the sign of exact arithmetic.

type V3 = [f64; 3];

/// 2⁻⁴⁰.
const DOUBT: f64 = 9.094_947_017_729_282e-13;
/// 2²⁹ + 1 \[DEKKER71\].
const SPLIT: f64 = 536_870_913.0;

/// A sum as parts that share no binary place, smallest first, and `term` added to it \[SHEWCHUK97\].
fn grown(parts: &[f64], mut term: f64) -> Vec<f64> {
    let mut kept = vec![];
    for part in parts {
        let sum = term + part;
        let share = sum - term;
        let lost = (term - (sum - share)) + (part - share);
        if lost != 0.0 {
            kept.push(lost);
        }
        term = sum;
    }
    if term != 0.0 {
        kept.push(term);
    }
    kept
}

/// From the exact sum d · (p × q) + d · (q × o) + d · (o × p).
fn exact_triple(d: V3, o: V3, p: V3, q: V3) -> f64 {
    let mut parts = vec![];
    for [p, q] in [[p, q], [q, o], [o, p]] {
        for [x, y, z] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
            let products = [p[y] * q[z], p[z] * q[y]];
            let uppers = products.map(|product| {
                let wide = product * SPLIT;
                wide - (wide - product)
            });
            parts = grown(&parts, (products[0] - uppers[0]) * d[x]);
            parts = grown(&parts, (products[1] - uppers[1]) * -d[x]);
            parts = grown(&parts, uppers[0] * d[x]);
            parts = grown(&parts, uppers[1] * -d[x]);
        }
    }
    parts.iter().rev().fold(0.0, |value, part| value + part)
}

/// The triple product, off by a share of 2⁻¹⁰ at most.
pub fn triple(d: V3, o: V3, p: V3, q: V3) -> f64 {
    let x: V3 = std::array::from_fn(|k| p[k] - o[k]);
    let e: V3 = std::array::from_fn(|k| q[k] - p[k]);
    let m = [x[1] * e[2], x[2] * e[0], x[0] * e[1]];
    let n = [x[2] * e[1], x[0] * e[2], x[1] * e[0]];
    let sum = d[0] * (m[0] - n[0]) + (d[1] * (m[1] - n[1]) + d[2] * (m[2] - n[2]));
    let size: V3 = std::array::from_fn(|k| d[k].abs() * (m[k].abs() + n[k].abs()));
    if sum.abs() > DOUBT * (size[0] + size[1] + size[2]) { sum } else { exact_triple(d, o, p, q) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::exact::{Difference, exact};

    #[test]
    fn sums_are_those_of_the_reference() {
        // Of few bits and many, far apart and near; half of the lines cross the edge.
        let mut state = 1u64;
        let mut number = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            let bits = (state >> 40) as u32 & [0xff_ffff, 0xff_fc00, 0xc0_0000][(state >> 33) as usize % 3];
            (bits as f32 - 8_388_608.0) * 2f32.powi((state >> 35) as i32 % 30 - 50)
        };
        let mut zeros = 0;
        for i in 0..20_000 {
            let [mut d, o, p, q] = [(); 4].map(|()| [number(), number(), number()].map(f64::from));
            if i % 2 == 0 {
                d = std::array::from_fn(|k| f64::from((0.5 * (p[k] + q[k]) - o[k]) as f32));
            }
            let [line, to_p, to_q] = [Difference::vector(d), Difference::new(o, p), Difference::new(o, q)];
            let (ours, truth) = (exact_triple(d, o, p, q), exact(&line, &to_p, &to_q));
            assert!((ours - truth).abs() <= truth.abs() * 2f64.powi(-50), "{ours:e}, not {truth:e}");
            assert!((triple(d, o, p, q) - truth).abs() <= truth.abs() * 2f64.powi(-10));
            zeros += u32::from(truth == 0.0);
        }
        assert!(zeros > 20 && zeros < 10_000, "{zeros} of the sums are 0");
    }
}
