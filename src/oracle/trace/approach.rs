//! Twin of `glsl/lib/approach.glsl`: where the walk of a far ray begins.

use super::V3;
use super::double_single::Pair;

/// A ray from nearer is as well off without.
pub(super) const NEAR: f32 = 32.0;

/// How far along `d` the walk begins.
pub(super) fn ahead_of(moved: V3, d: V3, reach: f32) -> f32 {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from −1 to 1.
    fn numbers(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (state >> 11) as f64 / 2f64.powi(52) - 1.0
        }
    }

    fn point(number: &mut impl FnMut() -> f64, most: f64) -> V3 {
        [(); 3].map(|()| (number() * most) as f32)
    }

    #[test]
    fn the_walk_begins_on_the_ray_and_before_the_scene() {
        let mut number = numbers(7);
        let mut off = 0f64;
        for k in 0..20_000 {
            let distance = 2f64.powf(52.0 + 45.0 * number());
            let (anchor, aim) = (point(&mut number, 1e3), point(&mut number, 0.5));
            let mut o = point(&mut number, distance);
            o[k % 3] = distance as f32;
            let moved: V3 = std::array::from_fn(|k| o[k] - anchor[k]);
            let scale = moved.iter().fold(0.0, |a, x| f32::max(a, x.abs()));
            // At the scene, or anywhere.
            let mut d = if k % 2 == 0 { moved.map(|x| -x / scale) } else { point(&mut number, 1.0) };
            if k % 3 == 0 {
                d = std::array::from_fn(|k| d[k] + aim[k] / scale);
            }
            let largest = d.iter().fold(0.0, |a, x| f32::max(a, x.abs()));
            let d = d.map(|x| x / largest * 1.5);
            let reach = 1.0 + scale;
            let ahead = ahead_of(moved, d, reach);
            assert!(ahead != 0.0, "{reach:e}");
            let begin = approached(o, anchor, d, ahead);
            let mut before = 0.0;
            for k in 0..3 {
                let on_ray = f64::from(o[k]) - f64::from(anchor[k]) + f64::from(d[k]) * f64::from(ahead);
                let rounded = on_ray.abs() * 2f64.powi(-24);
                off = off
                    .max(((f64::from(begin[k]) - on_ray).abs() - rounded) / f64::from(reach) * 2f64.powi(48));
                before -= f64::from(begin[k]) * f64::from(d[k]);
            }
            let length = d.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>();
            assert!(before / length > 1.9, "{ahead:e} from {moved:?} along {d:?}: {}", before / length);
        }
        // 11 u², and what the sums in f64 lose, 2⁻⁵³ of R.
        assert!(off > 0.5 && off < 12.0, "{off} · 2⁻⁴⁸ R");
    }

    #[test]
    fn limits_of_the_walk_are_not_within_those_of_t() {
        let mut number = numbers(8);
        for _ in 0..20_000 {
            let mut any = || (number() * 2f64.powf(100.0 * number())) as f32;
            let (t, ahead) = (any(), any());
            for outward in [-1.0, 1.0] {
                let spared = 2.0 * 2f64.powi(-24) * f64::from(t).abs();
                let least = f64::from(t) + outward * spared - f64::from(ahead);
                let limit = f64::from(walk_limit(t, ahead, outward as f32));
                assert!((limit - least) * outward >= 0.0, "{t:e}, {ahead:e}: {limit:e}, {least:e}");
            }
        }
        for t in [f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!((walk_limit(t, 1e9, 1.0), walk_limit(t, -1e9, -1.0)), (t, t));
        }
        assert_eq!(walk_limit(1.0, 0.0, 1.0), 1.0);
    }
}
