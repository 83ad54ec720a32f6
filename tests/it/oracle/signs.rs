//! Exact signs of the edge function against wide integers.

use super::point;
use boxwood::oracle::exact::edge;
use proptest::prelude::*;
use std::cmp::Ordering;

/// A 1024-bit two's complement integer, lowest word first: holds any edge function of f32 in units of 2⁻⁴⁴⁷.
type Wide = [u64; 16];

fn negated(a: &Wide) -> Wide {
    let mut carry = true;
    a.map(|word| {
        let (sum, over) = (!word).overflowing_add(u64::from(carry));
        carry = over;
        sum
    })
}

fn plus(a: &Wide, b: &Wide) -> Wide {
    let mut carry = 0;
    std::array::from_fn(|i| {
        let sum = u128::from(a[i]) + u128::from(b[i]) + carry;
        carry = sum >> 64;
        sum as u64
    })
}

fn minus(a: &Wide, b: &Wide) -> Wide {
    plus(a, &negated(b))
}

fn times(a: &Wide, b: &Wide) -> Wide {
    let mut product = [0; 16];
    for i in 0..16 {
        let mut carry = 0;
        for j in 0..16 - i {
            let sum = u128::from(a[i]) * u128::from(b[j]) + u128::from(product[i + j]) + carry;
            product[i + j] = sum as u64;
            carry = sum >> 64;
        }
    }
    product
}

/// `x` in units of 2⁻¹⁴⁹.
fn wide(x: f32) -> Wide {
    let bits = x.to_bits();
    let (exponent, fraction) = (bits >> 23 & 0xff, u128::from(bits & 0x7f_ffff));
    let (mantissa, shift) = if exponent == 0 { (fraction, 0) } else { (fraction | 1 << 23, exponent - 1) };
    let mut w = [0; 16];
    let (word, placed) = ((shift / 64) as usize, mantissa << (shift % 64));
    w[word] = placed as u64;
    w[word + 1] = (placed >> 64) as u64;
    if x.is_sign_negative() { negated(&w) } else { w }
}

fn integer_sign(d: [f32; 3], o: [f32; 3], a: [f32; 3], b: [f32; 3]) -> Ordering {
    let (d, o, a, b) = (d.map(wide), o.map(wide), a.map(wide), b.map(wide));
    let p: [Wide; 3] = std::array::from_fn(|k| minus(&a[k], &o[k]));
    let q: [Wide; 3] = std::array::from_fn(|k| minus(&b[k], &o[k]));
    let mut sum = [0; 16];
    for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        let minor = minus(&times(&p[j], &q[k]), &times(&p[k], &q[j]));
        sum = plus(&sum, &times(&d[i], &minor));
    }
    if sum[15] >> 63 == 1 { Ordering::Less } else { sum.iter().any(|&w| w != 0).cmp(&false) }
}

fn float_sign(d: [f32; 3], o: [f32; 3], a: [f32; 3], b: [f32; 3]) -> Option<Ordering> {
    let f = |v: [f32; 3]| v.map(f64::from);
    edge(f(d), f(o), f(a), f(b)).partial_cmp(&0.0)
}

fn any_finite() -> impl Strategy<Value = f32> + Clone {
    any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |x| x.is_finite())
}

/// The float `steps` representable values from `x`.
fn nudged(x: f32, steps: i8) -> f32 {
    (0..steps.unsigned_abs()).fold(x, |x, _| if steps > 0 { x.next_up() } else { x.next_down() })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn signs_of_arbitrary_floats(v in prop::array::uniform4(point(any_finite()))) {
        let [d, o, a, b] = v;
        prop_assert_eq!(float_sign(d, o, a, b), Some(integer_sign(d, o, a, b)));
    }

    /// Lines through the edge or a few representable values beside it, at any scale.
    #[test]
    fn signs_of_near_misses(
        v in prop::array::uniform3(point(-4000i32..4000)),
        share in 0i32..=16,
        nudge in prop::array::uniform3(-2i8..=2),
        exponent in -149i32..=100,
        lift in prop_oneof![Just(0), 0i32..=16],
    ) {
        let scale = 2f64.powi(exponent);
        let [o, a, b] = v.map(|p| p.map(|x| (f64::from(16 * x) * scale) as f32));
        // The direction to a point of the edge, all integers: exact before the nudge.
        let aim: [i32; 3] = std::array::from_fn(|k| share * v[1][k] + (16 - share) * v[2][k] - 16 * v[0][k]);
        let d: [f32; 3] = std::array::from_fn(|k| nudged((aim[k] as f64 * 2f64.powi(lift)) as f32, nudge[k]));
        let sign = integer_sign(d, o, a, b);
        prop_assert_eq!(float_sign(d, o, a, b), Some(sign));
        prop_assert_eq!(float_sign(d, o, b, a), Some(sign.reverse()));
        if nudge == [0; 3] {
            prop_assert_eq!(sign, Ordering::Equal);
        }
    }

    /// Coordinates of wildly different size, many equal or opposite, so that whole terms cancel.
    #[test]
    fn signs_of_mixed_scales(v in prop::array::uniform4(point(prop::sample::select(vec![
        0.0, -0.0, 1.0, -1.0, f32::EPSILON, 1.0 + f32::EPSILON, -1.0 - f32::EPSILON, 1e-30, -1e-30, 1e30, -1e30,
        1e30 + 1e23, f32::MAX, f32::MIN, f32::MIN_POSITIVE, f32::from_bits(1), -f32::from_bits(1),
    ])))) {
        let [d, o, a, b] = v;
        prop_assert_eq!(float_sign(d, o, a, b), Some(integer_sign(d, o, a, b)));
    }
}
