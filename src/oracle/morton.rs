//! Twin of `glsl/morton/*.comp` and of the unit space that `bvh::morton` takes from its bounds.

use crate::abi::{Aabb, UNHITTABLE_KEY};
use crate::scene::Scene;

/// Corners of a triangle.
pub type Corners = [[f32; 3]; 3];

/// From scene space to unit space: scene · `scale` − `anchor`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Space {
    /// `scale` is 2 to this power.
    pub exponent: i32,
    /// The longest edge of the scene's box becomes ½ to 1.
    pub scale: f32,
    /// The box's centre, scaled.
    pub anchor: [f32; 3],
    /// Largest absolute coordinate in unit space.
    pub reach: f32,
}

/// `a` where it is less, else `b`: as the kernels have it, so that of −0 and +0 both take the same.
pub fn least_of(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// `a` where it is greater, else `b`.
pub fn greatest_of(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// False where no ray can hit: a corner is not finite, or two corners coincide.
pub fn hittable([a, b, c]: Corners) -> bool {
    [a, b, c].iter().flatten().all(|x| x.is_finite()) && a != b && b != c && c != a
}

/// The triangle's box, scene space.
pub fn triangle_bounds([a, b, c]: Corners) -> Aabb {
    Aabb {
        lo: std::array::from_fn(|k| least_of(a[k], least_of(b[k], c[k]))),
        hi: std::array::from_fn(|k| greatest_of(a[k], greatest_of(b[k], c[k]))),
    }
}

/// Bounds of the triangles that can be hit, and how many these are.
pub fn bounds(scene: &Scene) -> (Aabb, u32) {
    let mut bounds = Aabb { lo: [3.4e38; 3], hi: [-3.4e38; 3] };
    let mut count = 0;
    for i in 0..scene.triangles.len() {
        let corners = scene.corners(i);
        if !hittable(corners) {
            continue;
        }
        let box_of = triangle_bounds(corners);
        for k in 0..3 {
            bounds.lo[k] = least_of(bounds.lo[k], box_of.lo[k]);
            bounds.hi[k] = greatest_of(bounds.hi[k], box_of.hi[k]);
        }
        count += 1;
    }
    (bounds, count)
}

/// 1/x for x > 0 to about an ulp, from correctly rounded operations alone.
pub fn reciprocal(x: f32) -> f32 {
    let mut r = f32::from_bits(0x7ef3_11c7u32.wrapping_sub(x.to_bits()));
    for _ in 0..4 {
        let error = 1.0 - x * r;
        r += r * error;
    }
    r
}

fn longest(lo: [f32; 3], hi: [f32; 3]) -> f32 {
    (0..3).map(|k| hi[k] - lo[k]).fold(f32::NEG_INFINITY, greatest_of)
}

/// Powers of two by which coordinates are multiplied, so that no difference overflows or is denormal.
fn factors(bounds: &Aabb) -> [f32; 3] {
    let [lo, hi] = [bounds.lo, bounds.hi].map(|p| p.map(|x| x * 0.5));
    let longest = longest(lo, hi);
    if longest > 2f32.powi(60) {
        [2f32.powi(-64); 3]
    } else if longest > 2f32.powi(-40) {
        [0.5; 3]
    } else {
        std::array::from_fn(|k| if lo[k].abs().max(hi[k].abs()) > 0.5 { 0.0 } else { 2f32.powi(64) })
    }
}

/// Cell of a triangle's centre in the scene's bounds: 21 bits an axis. `lo` has been multiplied
/// by `factor`.
fn cell(corners: Corners, lo: [f32; 3], factor: [f32; 3], scale: f32) -> [u32; 3] {
    let Aabb { lo: least, hi: greatest } = triangle_bounds(corners);
    std::array::from_fn(|k| {
        let centre = ((least[k] * factor[k] - lo[k]) + (greatest[k] * factor[k] - lo[k])) * (0.5 * scale);
        // A cast of a float too large saturates.
        (greatest_of(centre * 2_097_152.0, 0.0) as u32).min(2_097_151)
    })
}

/// Bit `k` of x, y and z to bits 3k, 3k + 1 and 3k + 2.
fn interleave(q: [u32; 3]) -> u64 {
    let bit = |axis: usize, k: u32| u64::from(q[axis] >> k & 1) << (3 * k + axis as u32);
    (0..21).map(|k| bit(0, k) | bit(1, k) | bit(2, k)).sum()
}

/// A code for each triangle; those that can't be hit have one behind all others.
fn encode(scene: &Scene, bounds: &Aabb, code: impl Fn([u32; 3]) -> u64, unhittable: u64) -> Vec<u64> {
    let factor = factors(bounds);
    let [lo, hi] = [bounds.lo, bounds.hi].map(|p| std::array::from_fn(|k| p[k] * factor[k]));
    let longest = longest(lo, hi);
    let scale = if longest > 0.0 { reciprocal(longest) } else { 0.0 };
    let corners = (0..scene.triangles.len()).map(|i| scene.corners(i));
    corners.map(|c| if hittable(c) { code(cell(c, lo, factor, scale)) } else { unhittable }).collect()
}

/// 30-bit codes: ten bits an axis.
pub fn encode_30(scene: &Scene, bounds: &Aabb) -> Vec<u64> {
    encode(scene, bounds, |q| interleave(q.map(|x| x >> 11)), u64::from(UNHITTABLE_KEY))
}

/// 63-bit codes. The device holds them as two words, the upper 31 bits and the lower 32.
pub fn encode_63(scene: &Scene, bounds: &Aabb) -> Vec<u64> {
    encode(scene, bounds, interleave, u64::from(UNHITTABLE_KEY) << 32)
}

/// Unit space of a scene.
pub fn space(bounds: &Aabb, hittable: u32) -> Space {
    if hittable == 0 {
        return Space { exponent: 0, scale: 1.0, anchor: [0.0; 3], reach: 0.0 };
    }
    let (lo, hi) = (bounds.lo.map(f64::from), bounds.hi.map(f64::from));
    let longest = (0..3).map(|k| hi[k] - lo[k]).fold(0.0, f64::max);
    let exponent = (-(longest.log2().floor() as i32) - 1).clamp(-126, 126);
    let scale = 2f64.powi(exponent);
    // + 0: never −0.
    let anchor: [f32; 3] = std::array::from_fn(|k| ((lo[k] + hi[k]) * 0.5 * scale) as f32 + 0.0);
    let distance = |k: usize, x: f64| (x * scale - f64::from(anchor[k])).abs();
    let reach = (0..3).map(|k| distance(k, lo[k]).max(distance(k, hi[k]))).fold(0.0, f64::max);
    Space { exponent, scale: scale as f32, anchor, reach: reach as f32 * 1.000_001 }
}
