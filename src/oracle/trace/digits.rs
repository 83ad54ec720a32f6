//! Twin of `glsl/lib/digits.glsl`: x · ((p − o) × (q − o)) of single-precision vectors, exactly, by integers.

use super::double_single::Pair;
use std::iter;

type V3 = [f32; 3];

/// Digits of base 2²⁴, the first of weight 2⁻⁴⁴⁷.
const DIGITS: usize = 41;
/// Of a digit.
const MASK: u128 = 0x00ff_ffff;
/// 2²⁴.
const BASE: f32 = 16_777_216.0;

/// value · 2^exponent, exact to a share of 2⁻⁴⁶; the value's upper part is 0 exactly where that is.
#[derive(Debug, Clone, Copy)]
pub struct Sum {
    /// Between 2²³ and 2⁴⁸, or 0.
    pub value: Pair,
    pub exponent: i32,
}

/// A sum of products, and the first and last digits that may not be 0.
struct Digits {
    all: [i32; DIGITS],
    first: usize,
    last: usize,
}

impl Digits {
    /// None yet.
    fn new() -> Self {
        Self { all: [0; DIGITS], first: DIGITS, last: 0 }
    }

    /// Adds x · y · z · 2^scale, or takes it away; `scale` from 0 to 126.
    fn add(&mut self, numbers: V3, scale: usize, away: bool) {
        let (mut mantissa, mut place, mut negative) = (1u128, scale, away);
        for x in numbers {
            let (exponent, fraction) = (x.to_bits() >> 23 & 0xff, x.to_bits() & 0x007f_ffff);
            mantissa *= u128::from(fraction | exponent.min(1) << 23);
            place += exponent.max(1) as usize - 1;
            negative ^= x.is_sign_negative();
        }
        if mantissa == 0 {
            return;
        }
        let at = place / 24;
        for k in 0..4 {
            let digit = (mantissa << (place % 24) >> (24 * k) & MASK) as i32;
            self.all[at + k] += if negative { -digit } else { digit };
        }
        (self.first, self.last) = (self.first.min(at), self.last.max(at + 3));
    }

    /// The sum to a share of 2⁻⁴⁶.
    fn value(&self) -> Sum {
        let (mut top, mut below, mut place, mut carry) = ([0; 3], [0; 2], 0, 0);
        for i in self.first..=(self.last + 1).min(DIGITS - 1) {
            let sum = self.all[i] + carry;
            carry = (sum + 0x0080_0000) >> 24;
            let digit = sum - (carry << 24);
            if digit != 0 {
                (top, place) = ([digit, below[0], below[1]], i as i32);
            }
            below = [digit, below[0]];
        }
        let [upper, lower, rest] = top.map(|digit| digit as f32);
        let Pair { hi, lo } = Pair::exact_sum(upper * BASE, lower);
        let exponent = if hi == 0.0 { -1000 } else { 24 * (place - 1) - 447 };
        Sum { value: Pair { hi, lo: lo + rest / BASE }, exponent }
    }
}

/// An origin at · 2^scale.
#[derive(Debug, Clone, Copy)]
pub struct Origin {
    pub at: V3,
    /// From 0 to 126.
    pub scale: usize,
}

/// The sum of products ± x · y · 2^scale.
pub fn exact_sum(products: impl IntoIterator<Item = (f32, f32, usize, bool)>) -> Sum {
    let mut digits = Digits::new();
    for (x, y, scale, away) in products {
        digits.add([x, y, 1.0], scale, away);
    }
    digits.value()
}

/// The triple product; of a `point` x, with x − o in its place.
pub fn exact_triple(x: V3, o: Origin, p: V3, q: V3, point: bool) -> Sum {
    let mut digits = Digits::new();
    let Origin { at: o, scale } = o;
    let of_origin = [(x, [q, o], scale, false), (x, [o, p], scale, false), (o, [p, q], scale, true)];
    for (x, [p, q], scale, away) in iter::once((x, [p, q], 0, false)).chain(of_origin) {
        for [i, j, k] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]].into_iter().filter(|_| point || !away) {
            digits.add([x[i], p[j], q[k]], scale, away);
            digits.add([x[i], p[k], q[j]], scale, !away);
        }
    }
    digits.value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::exact::{Difference, exact};

    #[test]
    fn sums_and_quotients_are_those_of_the_reference() {
        let mut state = 1u64;
        let mut next = |count: u64| {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (state >> 33) % count
        };
        let mut zeros = 0;
        for i in 0..40_000 {
            // Of few bits and many; as far apart as floats are, or near; denormal too.
            let (spread, least) = [(4, 120), (30, 90), (252, 0)][next(3) as usize];
            let mut number = || {
                let mask = [0x807f_ffff, 0x807f_e000, 0x8060_0000][next(3) as usize];
                f32::from_bits((next(1 << 31) as u32) << 1 & mask | (next(spread) as u32 + least) << 23)
            };
            let [mut d, o, p, q] = [(); 4].map(|()| [number(), number(), number()]);
            if i % 2 == 0 {
                // Through the edge's middle, or nearly.
                d = std::array::from_fn(|k| 0.5 * (p[k] + q[k]) - o[k]);
            }
            // Half of the origins are scaled, up to as far as they ever are.
            let scale = if i % 4 < 2 { 0 } else { next(127) as usize };
            let wide = |v: V3| v.map(f64::from);
            let from = wide(o).map(|x| x * 2f64.powi(scale as i32));
            let o = Origin { at: o, scale };
            let [to_p, to_q] = [p, q].map(|v| Difference::new(from, wide(v)));
            let value = |sum: &Sum| {
                sum.value.to_f64() * 2f64.powi(sum.exponent / 2) * 2f64.powi(sum.exponent - sum.exponent / 2)
            };
            let ours = [exact_triple(d, o, p, q, false), exact_triple(d, o, p, q, true)];
            let truth = [Difference::vector(wide(d)), Difference::new(from, wide(d))]
                .map(|x| exact(&x, &to_p, &to_q));
            for (ours, truth) in ours.iter().zip(truth) {
                let is = value(ours);
                assert!((is - truth).abs() <= truth.abs() * 2f64.powi(-45), "{is:e}, not {truth:e}");
                assert_eq!(ours.value.hi == 0.0, truth == 0.0);
                zeros += u32::from(truth == 0.0);
            }
            let [x, y] = ours;
            if y.value.hi != 0.0 {
                let [is, should] = [f64::from(x.value.over(y.value)), x.value.to_f64() / y.value.to_f64()];
                assert!(
                    (is - should).abs() <= should.abs() * 1.001 / f64::from(BASE),
                    "{is:e}, not {should:e}"
                );
            }
        }
        assert!(zeros > 100 && zeros < 20_000, "{zeros} of the sums are 0");
    }
}
