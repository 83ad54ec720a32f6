//! Triple products x·(y×z) of coordinate differences, with exact signs. After \[SHEWCHUK97\] "Adaptive precision
//! floating-point arithmetic and fast robust geometric predicates". Differs: no stages between the f64 filter and
//! the exact sum, and no scaling, for f32 coordinates leave f64 arithmetic neither overflow nor underflow.
//!
//! Why nothing overflows or underflows: a coordinate is a multiple of [`GRAIN`] = 2⁻²¹⁰ and at most 2¹³⁰ in size
//! (an f32 is a multiple of 2⁻¹⁴⁹ below 2¹²⁸; the rest is room for the jittered rays of `compare`). A sum or a
//! product of multiples is rounded to a multiple, and so are the errors of both. So every number here is a multiple
//! of 2⁻⁶³⁰ and at most 6·2³⁹³, all normal f64, and the error-free sums and products below are error-free indeed.
//!
//! Why the filter is right: with u = 2⁻⁵³ each of the six terms x·y·z is formed by at most eight roundings (three
//! differences, two products, the 2×2 minor, two sums), so the error is at most 8u(1+8u)/(1−8u) times the sum of
//! the terms' computed sizes, less than the 16u that [`edge`] asks for.

/// Coordinates are multiples of this: 2⁻²¹⁰. f32 are by themselves.
pub const GRAIN: f64 = f64::from_bits((1023 - 210) << 52);

/// Share of the terms' sizes beyond which a triple product's sign is sure: 2⁻⁴⁹.
const SIGN_MARGIN: f64 = f64::from_bits((1023 - 49) << 52);
/// Share of the terms' sizes beyond which a triple product is right to a relative 2⁻²⁹: 2⁻²⁰.
const VALUE_MARGIN: f64 = f64::from_bits((1023 - 20) << 52);

/// Point or vector, f64.
pub type V3 = [f64; 3];

/// The vector `to - from`, kept as its two ends so that it can be formed exactly where rounding won't do.
#[derive(Debug, Clone, Copy)]
pub struct Difference {
    to: V3,
    from: V3,
}

impl Difference {
    /// From `from` to `to`.
    #[inline]
    pub fn new(from: V3, to: V3) -> Self {
        Self { to, from }
    }

    /// The vector `v` itself.
    #[inline]
    pub fn vector(v: V3) -> Self {
        Self { to: v, from: [0.0; 3] }
    }

    /// The nearest f64 vector.
    #[inline(always)]
    pub fn rounded(&self) -> V3 {
        [self.to[0] - self.from[0], self.to[1] - self.from[1], self.to[2] - self.from[2]]
    }

    /// Component `k` as a rounded value and what the rounding lost.
    fn parts(&self, k: usize) -> [f64; 2] {
        two_sum(self.to[k], -self.from[k])
    }
}

/// A triple product in f64 and the sum of its terms' sizes, which bounds its error.
#[derive(Debug, Clone, Copy)]
pub struct Estimate {
    /// The triple product, rounded.
    pub value: f64,
    /// Sum of the six terms' sizes.
    pub size: f64,
}

/// x·(y×z) in plain f64.
#[inline(always)]
pub fn estimate(x: V3, y: V3, z: V3) -> Estimate {
    let mut e = Estimate { value: 0.0, size: 0.0 };
    for [i, j, k] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
        let (p, q) = (y[j] * z[k], y[k] * z[j]);
        e.value += x[i] * (p - q);
        e.size += x[i].abs() * (p.abs() + q.abs());
    }
    e
}

/// The edge function d·((a−o)×(b−o)) of the line through `o` along `d` and the directed edge `a` → `b`: its sign
/// (zero included) is exact, its size an estimate. Positive where the edge winds counterclockwise about `d`.
#[inline(always)]
pub fn edge(d: V3, o: V3, a: V3, b: V3) -> f64 {
    let (p, q) = (Difference::new(o, a), Difference::new(o, b));
    let e = estimate(d, p.rounded(), q.rounded());
    if e.value.abs() > SIGN_MARGIN * e.size { e.value } else { exact(&Difference::vector(d), &p, &q) }
}

/// x·(y×z) to a relative 2⁻²⁹ or better, so that its sign is exact.
#[inline]
pub fn triple(x: &Difference, y: &Difference, z: &Difference) -> f64 {
    let e = estimate(x.rounded(), y.rounded(), z.rounded());
    if e.value.abs() > VALUE_MARGIN * e.size { e.value } else { exact(x, y, z) }
}

/// x·(y×z) to 2⁻⁵¹, from the exact sum of its terms.
#[cold]
#[inline(never)]
pub fn exact(x: &Difference, y: &Difference, z: &Difference) -> f64 {
    let mut sum = Expansion::default();
    for [i, j, k] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]] {
        let sign = if (j + 3 - i) % 3 == 1 { 1.0 } else { -1.0 };
        for a in y.parts(j) {
            for b in z.parts(k) {
                for product in two_product(a, b) {
                    for c in x.parts(i) {
                        let [high, low] = two_product(product, sign * c);
                        sum.add(low);
                        sum.add(high);
                    }
                }
            }
        }
    }
    sum.leading()
}

/// a + b as the rounded sum and its error, whichever is larger.
fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let b_part = sum - a;
    [sum, (a - (sum - b_part)) + (b - b_part)]
}

/// a·b as the rounded product and its error.
fn two_product(a: f64, b: f64) -> [f64; 2] {
    let product = a * b;
    [product, a.mul_add(b, -product)]
}

/// Most terms that [`exact`] adds: 6 permutations × 2⁵ parts.
const TERMS: usize = 6 * 32;

/// A sum of nonzero f64, smallest first, no two sharing a binary place: \[SHEWCHUK97\] section 2.
struct Expansion {
    parts: [f64; TERMS],
    len: usize,
}

impl Default for Expansion {
    fn default() -> Self {
        Self { parts: [0.0; TERMS], len: 0 }
    }
}

impl Expansion {
    /// Adds `term` exactly (GROW-EXPANSION with zero elimination).
    fn add(&mut self, term: f64) {
        if term == 0.0 {
            return;
        }
        let (mut carry, mut kept) = (term, 0);
        for i in 0..self.len {
            let [sum, error] = two_sum(carry, self.parts[i]);
            carry = sum;
            if error != 0.0 {
                self.parts[kept] = error;
                kept += 1;
            }
        }
        if carry != 0.0 {
            self.parts[kept] = carry;
            kept += 1;
        }
        self.len = kept;
    }

    /// The sum, rounded. Goes down from the largest part: going up, rounding could cancel the whole sum.
    fn leading(&self) -> f64 {
        let mut value = 0.0;
        for &part in self.parts[..self.len].iter().rev() {
            let [sum, error] = two_sum(value, part);
            value = sum;
            if error != 0.0 {
                break;
            }
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leading_survives_cancellation_of_the_upper_parts() {
        let tiny = 2f64.powi(-40);
        let mut sum = Expansion::default();
        for term in [2f64.powi(60), -(2f64.powi(60) - 128.0), -128.0, tiny] {
            sum.add(term);
        }
        assert_eq!(sum.leading(), tiny);
        sum.add(-tiny);
        assert_eq!(sum.leading(), 0.0);
    }

    #[test]
    fn edge_has_no_range_problem_at_either_end() {
        for s in [f32::from_bits(1) as f64, f32::MAX as f64] {
            let (d, o) = ([0.0, 0.0, s], [0.0; 3]);
            assert!(edge(d, o, [s, 0.0, s], [0.0, s, s]) > 0.0, "scale {s:e}");
            assert!(edge(d, o, [0.0, s, s], [s, 0.0, s]) < 0.0, "scale {s:e}");
            assert_eq!(edge(d, o, [s, s, 0.0], [-s, -s, s]), 0.0, "scale {s:e}");
        }
    }

    #[test]
    fn the_smallest_difference_decides() {
        // The line grazes the edge by one unit in the last place of one end, 2^80 away.
        let (far, unit) = (2f64.powi(80), f32::from_bits(1) as f64);
        let (d, o) = ([1.0, 0.0, 0.0], [-far, 0.0, 0.0]);
        assert_eq!(edge(d, o, [far, 1.0, 1.0], [-far, -1.0, -1.0]), 0.0);
        assert!(edge(d, o, [far, 1.0, 1.0], [-far, -1.0, -1.0 + 2f64.powi(-24)]) > 0.0);
        assert!(edge(d, o, [far, unit, unit], [-far, -far, -far + 2f64.powi(57)]) > 0.0);
        assert_eq!(edge(d, o, [far, unit, unit], [-far, -far, -far]), 0.0);
    }
}
