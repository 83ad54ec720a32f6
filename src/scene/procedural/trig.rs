//! Sine, cosine and cube root from + − × ÷ alone: the same bits on every machine, unlike those of C libraries.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::noise::{u01, unit_vector};

/// Sine and cosine of an angle in turns (1 is 360°), to about 1e-15. Exact at quarter turns.
pub(in crate::scene) fn sin_cos(turns: f64) -> (f64, f64) {
    let quarters = (turns * 4.0 + 0.5).floor();
    let x = (turns - quarters / 4.0) * TAU; // within π/4 of 0, where Taylor's series are short
    let s = x * x;
    let series = |factors: &[f64]| factors.iter().rev().fold(1.0, |sum, f| 1.0 - s / f * sum);
    let sin = x * series(&[6.0, 20.0, 42.0, 72.0, 110.0, 156.0, 210.0]);
    let cos = series(&[2.0, 12.0, 30.0, 56.0, 90.0, 132.0, 182.0, 240.0]);
    match (quarters as i64).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Cube root of `x` ≥ 1, by Newton's steps from above.
pub(super) fn cube_root(x: f64) -> f64 {
    (0..64).fold(x, |y, _| (2.0 * y + x / (y * y)) / 3.0)
}

/// Points of the unit circle, anticlockwise from (1, 0).
pub(super) fn circle(sides: usize) -> Vec<(f64, f64)> {
    (0..sides)
        .map(|i| {
            let (sin, cos) = sin_cos(i as f64 / sides as f64);
            (cos, sin)
        })
        .collect()
}

/// Turns about an axis, 0 for x.
pub(in crate::scene) fn about(axis: usize, turns: f64) -> DMat3 {
    let (sin, cos) = sin_cos(turns);
    let mut m = DMat3::IDENTITY;
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    m.col_mut(u)[u] = cos;
    m.col_mut(u)[v] = sin;
    m.col_mut(v)[u] = -sin;
    m.col_mut(v)[v] = cos;
    m
}

/// Two unit vectors across the unit vector `d`, `(x, y, d)` right-handed.
pub(super) fn across(d: DVec3) -> (DVec3, DVec3) {
    let x = d.any_orthonormal_vector();
    (x, d.cross(x))
}

/// A rotation that takes the y axis to the unit vector `d`.
pub(super) fn upright(d: DVec3) -> DMat3 {
    let (x, _) = across(d);
    DMat3::from_cols(x, d, x.cross(d))
}

/// Any rotation at all, by hash.
pub(super) fn any_rotation(x: u32, y: u32, seed: u32) -> DMat3 {
    let z = unit_vector(x, y, seed);
    let (u, v) = across(z);
    let (sin, cos) = sin_cos(u01(x, y, seed.wrapping_add(0xA11)));
    let u = u * cos + v * sin;
    DMat3::from_cols(u, z.cross(u), z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_the_library_has_them() {
        for i in -5000..5000 {
            let turns = f64::from(i) / 1237.0;
            let ((sin, cos), (s, c)) = (sin_cos(turns), (turns * TAU).sin_cos());
            assert!((sin - s).abs() < 1e-14 && (cos - c).abs() < 1e-14, "{turns} turns");
        }
        assert_eq!([0.0, 0.25, 0.5, 0.75].map(|t| sin_cos(t).0), [0.0, 1.0, 0.0, -1.0]);
        for x in [1.0, 2.0, 27.0, 1e6, 1073741824.0f64] {
            assert!((cube_root(x) / x.cbrt() - 1.0).abs() < 1e-15, "{x}");
        }
    }

    #[test]
    fn rotations_keep_lengths_and_hands() {
        let random = (0..100).map(|i| any_rotation(i, 1, 2));
        for m in random.chain((0..3).map(|k| about(k, 0.123))).chain([upright(DVec3::X)]) {
            assert!((m.determinant() - 1.0).abs() < 1e-12);
            assert!((m.transpose() * m).abs_diff_eq(DMat3::IDENTITY, 1e-12));
        }
        assert!((upright(-DVec3::Z) * DVec3::Y).abs_diff_eq(-DVec3::Z, 1e-15));
        assert!((about(1, 0.25) * DVec3::X).abs_diff_eq(-DVec3::Z, 1e-15));
    }
}
