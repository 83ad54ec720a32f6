//! Hashes and noise from integers: no state, no stream, so that any part can be made by itself.

use glam::DVec3;

/// A 32-bit hash of two words and a seed.
pub(super) fn h32(x: u32, y: u32, seed: u32) -> u32 {
    let mut v = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    v ^= v >> 15;
    v = v.wrapping_mul(0x2C1B_3C6D);
    v ^= v >> 12;
    v = v.wrapping_mul(0x297A_2D39);
    v ^ v >> 15
}

/// Uniform in [0, 1), 24 bits.
pub(super) fn u01(x: u32, y: u32, seed: u32) -> f64 {
    f64::from(h32(x, y, seed) >> 8) / f64::from(1u32 << 24)
}

/// A unit vector, uniform over the sphere: the first of a few hashed points of the cube that lies in the ball.
pub(super) fn unit_vector(x: u32, y: u32, seed: u32) -> DVec3 {
    for attempt in 0..64 {
        let axis = |k: u32| 2.0 * u01(x, y, seed.wrapping_add(1 + 3 * attempt + k)) - 1.0;
        let p = DVec3::new(axis(0), axis(1), axis(2));
        let square = p.dot(p);
        if (1e-4..=1.0).contains(&square) {
            return p / square.sqrt();
        }
    }
    DVec3::X
}

/// The lattice cell of `x` and the way through it; saturates far out, where no scene is.
fn cell(x: f64) -> (u32, f64) {
    let floor = x.floor();
    (floor as i64 as u32, x - floor)
}

/// Value noise on the plane, [0, 1).
pub(super) fn value2(x: f64, y: f64, seed: u32) -> f64 {
    let ((i, u), (j, v)) = (cell(x), cell(y));
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let at = |a: u32, b: u32| u01(i.wrapping_add(a), j.wrapping_add(b), seed);
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let (u, v) = (smooth(u), smooth(v));
    mix(mix(at(0, 0), at(1, 0), u), mix(at(0, 1), at(1, 1), u), v)
}

/// Value noise in space, [-1, 1), and its gradient.
pub(super) fn value3(p: DVec3, seed: u32) -> (f64, DVec3) {
    let ((i, u), (j, v), (k, w)) = (cell(p.x), cell(p.y), cell(p.z));
    let smooth = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let slope = |t: f64| 30.0 * t * t * (t - 1.0) * (t - 1.0);
    let layer = |c: u32| {
        let seed = h32(k.wrapping_add(c), seed, 0x51ED);
        let at = |a: u32, b: u32| 2.0 * u01(i.wrapping_add(a), j.wrapping_add(b), seed) - 1.0;
        [at(0, 0), at(1, 0), at(0, 1), at(1, 1)]
    };
    let (lo, hi) = (layer(0), layer(1));
    let (su, sv, sw) = (smooth(u), smooth(v), smooth(w));
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let along_w: [f64; 4] = std::array::from_fn(|c| mix(lo[c], hi[c], sw));
    let step_w: [f64; 4] = std::array::from_fn(|c| hi[c] - lo[c]);
    let plane = |c: [f64; 4]| mix(mix(c[0], c[1], su), mix(c[2], c[3], su), sv);
    let gradient = DVec3::new(
        mix(along_w[1] - along_w[0], along_w[3] - along_w[2], sv) * slope(u),
        (mix(along_w[2], along_w[3], su) - mix(along_w[0], along_w[1], su)) * slope(v),
        plane(step_w) * slope(w),
    );
    (plane(along_w), gradient)
}

/// Octaves of [`value3`], each half as strong and twice as fine: about [-2, 2].
pub(super) fn fbm(p: DVec3, octaves: u32, seed: u32) -> f64 {
    let (mut sum, mut scale) = (0.0, 1.0);
    for i in 0..octaves {
        sum += value3(p * scale, seed.wrapping_add(i)).0 / scale;
        scale *= 2.0;
    }
    sum
}

/// Octaves of creases, 1 at the crease: [0, 2).
pub(super) fn ridged(p: DVec3, octaves: u32, seed: u32) -> f64 {
    let (mut sum, mut scale) = (0.0, 1.0);
    for i in 0..octaves {
        let r = 1.0 - value3(p * scale, seed.wrapping_add(i)).0.abs();
        sum += r * r / scale;
        scale *= 2.0;
    }
    sum
}

/// A field without sources: the curl of three noises.
pub(super) fn curl(p: DVec3, seed: u32) -> DVec3 {
    let [a, b, c] = [0, 1, 2].map(|k| value3(p, seed.wrapping_add(k)).1);
    DVec3::new(c.y - b.z, a.z - c.x, b.x - a.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradient_is_the_difference() {
        let p = DVec3::new(-1.3, 2.7, 0.4);
        let (_, g) = value3(p, 7);
        for (k, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            let d = (value3(p + axis * 1e-5, 7).0 - value3(p - axis * 1e-5, 7).0) / 2e-5;
            assert!((d - g[k]).abs() < 1e-6, "axis {k}: {d} and {}", g[k]);
        }
    }
}
