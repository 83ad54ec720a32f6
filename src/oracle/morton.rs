//! Twin of `glsl/morton/*.comp` and of the unit space that `bvh::morton` takes from its bounds.

use crate::abi::{Aabb, UNHITTABLE_KEY};
use crate::bvh::Morton;
use crate::bvh::raw::{Corners, greatest_of, hittable, least_of, triangle_bounds};
use crate::scene::Scene;

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

/// How cells and sizes are measured.
#[derive(Debug, Clone, Copy)]
struct Scale {
    /// By which coordinates are multiplied first.
    factor: [f32; 3],
    /// Least corner of the scene's box, so multiplied.
    lo: [f32; 3],
    /// 1 / the box's longest edge, likewise; 0 where it has none.
    scale: f32,
    /// 1 / (diagonal · `scale`)², of the box, likewise.
    per_diagonal2: f32,
}

impl Scale {
    fn of(bounds: &Aabb) -> Self {
        let factor = factors(bounds);
        let [lo, hi] = [bounds.lo, bounds.hi].map(|p| std::array::from_fn(|k| p[k] * factor[k]));
        let longest = longest(lo, hi);
        let scale = if longest > 0.0 { reciprocal(longest) } else { 0.0 };
        let diagonal2 = length2(std::array::from_fn(|k| (hi[k] - lo[k]) * scale));
        let per_diagonal2 = if scale > 0.0 { reciprocal(diagonal2) } else { 0.0 };
        Self { factor, lo, scale, per_diagonal2 }
    }

    /// Cell of a triangle's centre in the scene's bounds: 21 bits an axis.
    fn cell(&self, corners: Corners) -> [u32; 3] {
        let Aabb { lo: least, hi: greatest } = triangle_bounds(corners);
        std::array::from_fn(|k| {
            let from_lo = |x: f32| x * self.factor[k] - self.lo[k];
            let centre = (from_lo(least[k]) + from_lo(greatest[k])) * (0.5 * self.scale);
            // A cast of a float too large saturates.
            (greatest_of(centre * 2_097_152.0, 0.0) as u32).min(2_097_151)
        })
    }

    /// Diagonal of a triangle's box over the scene's: 15 bits.
    fn size(&self, corners: Corners) -> u32 {
        let Aabb { lo: least, hi: greatest } = triangle_bounds(corners);
        let e =
            std::array::from_fn(|k| (greatest[k] * self.factor[k] - least[k] * self.factor[k]) * self.scale);
        let share2 = length2(e) * self.per_diagonal2 * 1_073_741_824.0;
        (share2 as u32).min((1 << 30) - 1).isqrt()
    }
}

fn length2([x, y, z]: [f32; 3]) -> f32 {
    x * x + y * y + z * z
}

/// Bits of a code from the top: z, y, x in turn, and one of `size` behind each `triples` of them while there are any.
/// A number of n bits gives the upper ones first.
fn interleave(q: [u32; 3], axis_bits: u32, size: u32, size_bits: u32, triples: u32) -> u64 {
    let mut code = 0;
    let mut sizes = (0..size_bits).rev();
    for k in (0..axis_bits).rev() {
        for axis in [2, 1, 0] {
            code = code << 1 | u64::from(q[axis] >> k & 1);
        }
        if (axis_bits - k).is_multiple_of(triples) {
            code = sizes.next().map_or(code, |k| code << 1 | u64::from(size >> k & 1));
        }
    }
    code
}

/// A code for each triangle: of 30 bits, or of 63, which the device holds as two words, the upper 31 bits and the lower
/// 32. Those that can't be hit have one behind all others. With [`Morton::Auto`]: the 30-bit ones.
pub fn encode(scene: &Scene, bounds: &Aabb, morton: Morton) -> Vec<u64> {
    let measure = Scale::of(bounds);
    let code = |corners| {
        let (q, size) = (measure.cell(corners), measure.size(corners));
        match morton {
            Morton::Auto | Morton::Bits30 => interleave(q.map(|x| x >> 11), 10, 0, 0, 1),
            Morton::Bits63 => interleave(q, 21, 0, 0, 1),
            Morton::Ext4 => interleave(q.map(|x| x >> 5), 16, size, 15, 1),
            Morton::Ext7 => interleave(q.map(|x| x >> 3), 18, size >> 6, 9, 2),
        }
    };
    let unhittable = u64::from(UNHITTABLE_KEY) << if is_wide(morton) { 32 } else { 0 };
    let corners = (0..scene.triangles.len()).map(|i| scene.corners(i));
    corners.map(|c| if hittable(c) { code(c) } else { unhittable }).collect()
}

/// Whether codes have two words.
pub fn is_wide(morton: Morton) -> bool {
    !matches!(morton, Morton::Auto | Morton::Bits30)
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
