//! How far t, u and v of a hit may be from those of exact arithmetic, at worst: forward bounds on what rounding does in
//! `glsl/lib/hit.glsl`, for either test and for devices with and without 64-bit floats. After \[HIGHAM02\], sections 2.2,
//! 3.1 and 3.5.
//!
//! Exact t, u and v are those of the point where the ray's line meets the triangle's plane ([`crossing`]), from the f32
//! that the ray and the corners are. The scales of unit space and of the direction are powers of two and round nothing.
//! The bounds hold as long as nothing underflows: no coordinate, no component of the direction and no distance but 0
//! is less than 2⁻¹²⁶ of the scene's size, or 2⁻⁶² where products count. Of devices they ask what Vulkan asks: sums and
//! products are rounded correctly, divisions within 2½ ulp, f64 ones correctly; 1 / 1 is 1.
//!
//! # Notation
//! u = 2⁻²⁴ and ū = 2⁻⁵³, the greatest relative error of an f32 and an f64 operation; o, d the ray's origin and direction;
//! a, b, c the corners; x = a − o; e₁ = b − a and e₂ = c − a, n = e₂ × e₁, h = d × x; |·| of vectors by component, x ⊗ y a cross
//! product of absolute values: sums in place of differences. Terms of second order are covered by a factor 1 + 2⁻¹⁸, for no
//! chain has 32 roundings.
//!
//! # The robust test
//! D = d·n, t = x·n / D, u = h·e₂ / D and v = −h·e₁ / D.
//!
//! **With doubles** differences are rounded, products, components of n and h, products with them and two sums (2 ū): D is
//! off by 7 ū |d|·(|e₂|⊗|e₁|), D t by 8 ū |x|·(|e₂|⊗|e₁|), D u and D v by 7 ū |d|·(|x|⊗|e|).
//!
//! **Without**, in double-single numbers, a sum is off by 4 u² of its summands, a product by 8 u²: a component of n or h by 12 u²
//! of its two products, an inner product with it by 8 u² more and its sums by 8 u², 28 u² in all of the same.
//!
//! Where that might be more than 2⁻³⁰ (without doubles 2⁻²⁸) of D or D t, or turn the sign of a weight, all is summed exactly by
//! integers, to a share of 2⁻⁴⁶. Quotients are formed in doubles or as two floats, so that their last rounding is all. So t is
//! off by 33/32 u |t| (9/8 u |t|), whatever the triangle; u by 7 ū (28 u²) |d|·(|x|⊗|e₂|) / |D| and 33/32 u · u (17/16 u · u), v
//! likewise; and signs are those of exact arithmetic. With doubles a triangle's own products say more: D and D t are off by
//! what they are above, most often far less than 2⁻³⁰.
//!
//! # The fast test
//! With f = o − a, h = d × e₂ and q = f × e₁: D = e₁·h, D u = f·h, D v = d·q, D t = e₂·q. Differences
//! are rounded (1 u each), products (1 u), components of h and q (1 u), products with them (1 u), two sums (2 u). So D, D u
//! and D v are off by 7 u of |e₁|·(|d|⊗|e₂|), |f|·(|d|⊗|e₂|), |d|·(|f|⊗|e₁|), and D t by 8 u |e₂|·(|f|⊗|e₁|). A quotient of x,
//! off by ξ, and D, off by δ, is off by (ξ + |x / D| δ) / (|D| − δ); 1 / D and its product add 6 u. Contracted or reordered
//! the sums are no worse. The far origin enters: t of a small triangle is off by a share of the distance, divided by the
//! sine of the angle and by the triangle's slenderness.

use super::exact::{Difference, V3, exact, triple};
use crate::abi::Ray;
use crate::trace::Precision;

/// u.
const SINGLE: f64 = 1.0 / (1u32 << 24) as f64;
/// ū.
const DOUBLE: f64 = 1.0 / (1u64 << 53) as f64;
/// For what is of second order.
const SLACK: f64 = 1.0 + 1.0 / (1u32 << 18) as f64;
/// Smallest normal f32: what is less may become 0.
const LEAST: f64 = f32::MIN_POSITIVE as f64;

/// Greatest differences, of a hit from the exact one; infinite where nothing is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Of t, in lengths of the direction as t is.
    pub t: f64,
    /// Of the weight of the second corner.
    pub u: f64,
    /// Of the weight of the third.
    pub v: f64,
}

/// Where a line meets a plane, to a relative 2⁻⁴⁹.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Ray parameter; negative behind the origin.
    pub t: f64,
    /// Weight of the second corner; not between 0 and 1 outside the triangle.
    pub u: f64,
    /// Weight of the third.
    pub v: f64,
}

/// The line of `ray` and the plane of `corners`, all finite, by exact sums; none where they are parallel.
pub fn crossing(ray: &Ray, corners: [[f32; 3]; 3]) -> Option<Crossing> {
    let [o, d] = [ray.origin, ray.direction].map(|v| v.map(f64::from));
    let [a, b, c] = corners.map(|v| v.map(f64::from));
    let line = Difference::vector(d);
    let [to_a, ab, ac] = [Difference::new(o, a), Difference::new(a, b), Difference::new(a, c)];
    let det = exact(&line, &ab, &ac);
    let share = |x: &Difference, y: &Difference, z: &Difference| exact(x, y, z) / det;
    (det != 0.0).then(|| Crossing {
        t: share(&to_a, &ab, &ac),
        u: share(&line, &ac, &to_a),
        v: share(&line, &to_a, &ab),
    })
}

/// Bounds for the hit of `ray` on the triangle `corners` that `precision`'s test reports on a device with 64-bit floats
/// (`wide`) or without. The module derives them. All coordinates must be finite.
pub fn bound(ray: &Ray, corners: [[f32; 3]; 3], precision: Precision, wide: bool) -> Bound {
    let unknown = Bound { t: f64::INFINITY, u: f64::INFINITY, v: f64::INFINITY };
    let Some(hit) = crossing(ray, corners) else { return unknown };
    let view = View::new(ray, corners);
    let bound = match (precision, wide) {
        (Precision::Robust, true) => Some(view.doubles(&hit)),
        (Precision::Robust, false) => {
            Some(view.robust(&hit, 28.0 * SINGLE * SINGLE, [9.0 / 8.0, 17.0 / 16.0]))
        }
        (Precision::Fast, _) => view.quotients(&hit),
    };
    bound.map_or(unknown, |b| Bound {
        t: b.t * SLACK + f64::from(f32::from_bits(1)),
        u: b.u * SLACK + LEAST,
        v: b.v * SLACK + LEAST,
    })
}

/// A triangle as a ray sees it.
struct View {
    d: V3,
    /// x, e₁, e₂.
    x: V3,
    e1: V3,
    e2: V3,
    det: f64,
}

fn size(x: V3) -> V3 {
    x.map(f64::abs)
}

/// x ⊗ y.
fn outer(x: V3, y: V3) -> V3 {
    let [x, y] = [size(x), size(y)];
    [x[1] * y[2] + x[2] * y[1], x[2] * y[0] + x[0] * y[2], x[0] * y[1] + x[1] * y[0]]
}

fn inner(x: V3, y: V3) -> f64 {
    let [x, y] = [size(x), size(y)];
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

impl View {
    fn new(ray: &Ray, corners: [[f32; 3]; 3]) -> Self {
        let [o, d] = [ray.origin, ray.direction].map(|v| v.map(f64::from));
        let [a, b, c] = corners.map(|v| v.map(f64::from));
        let less = |p: V3, q: V3| std::array::from_fn(|k| p[k] - q[k]);
        let det = triple(&Difference::vector(d), &Difference::new(a, b), &Difference::new(a, c));
        Self { d, x: less(a, o), e1: less(b, a), e2: less(c, a), det }
    }

    /// Of the robust test in doubles: what a triangle's own products leave of the shares that are bound for any.
    fn doubles(&self, hit: &Crossing) -> Bound {
        let n = outer(self.e2, self.e1);
        let [det_off, depth_off] = [(7.0, self.d), (8.0, self.x)]
            .map(|(roundings, v)| roundings * DOUBLE * inner(v, n) / self.det.abs());
        let most = self.robust(hit, 7.0 * DOUBLE, [33.0 / 32.0; 2]);
        let own = self.robust(hit, 7.0 * DOUBLE, [1.0; 2]);
        Bound {
            t: most.t.min(own.t + depth_off + hit.t.abs() * det_off),
            u: most.u.min(own.u + hit.u.abs() * det_off),
            v: most.v.min(own.v + hit.v.abs() * det_off),
        }
    }

    /// Of the robust test, whose weights are off by a `share` of their products, and then t and the weights by roundings.
    fn robust(&self, hit: &Crossing, share: f64, roundings: [f64; 2]) -> Bound {
        let off = |edge: V3| share * inner(self.d, outer(self.x, edge)) / self.det.abs();
        let [t, weight] = roundings.map(|r| r * SINGLE);
        Bound {
            t: t * hit.t.abs(),
            u: off(self.e2) + weight * hit.u.abs(),
            v: off(self.e1) + weight * hit.v.abs(),
        }
    }

    /// Of the fast test.
    fn quotients(&self, hit: &Crossing) -> Option<Bound> {
        let (from, e1, e2) = (self.x, self.e1, self.e2);
        let (h, q) = (outer(self.d, e2), outer(from, e1));
        let det_off = 7.0 * SINGLE * inner(e1, h);
        let least = self.det.abs() - det_off;
        let quotient = |x: f64, off: f64| (off + x.abs() * det_off) / least + 6.0 * SINGLE * x.abs();
        (least > 0.0).then(|| Bound {
            t: quotient(hit.t, 8.0 * SINGLE * inner(e2, q)),
            u: quotient(hit.u, 7.0 * SINGLE * inner(from, h)),
            v: quotient(hit.v, 7.0 * SINGLE * inner(self.d, q)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    fn down(from: f32) -> Ray {
        let direction = [0.0, 0.0, -1.0];
        Ray { origin: [0.25, 0.5, from], t_min: 0.0, direction, t_max: f32::INFINITY }
    }

    #[test]
    fn a_face_seen_from_the_front_has_the_rounding_of_one_number() {
        let hit = crossing(&down(3.0), UNIT).unwrap();
        assert_eq!(hit, Crossing { t: 3.0, u: 0.25, v: 0.5 });
        let bound = bound(&down(3.0), UNIT, Precision::Robust, true);
        assert!(bound.t > 3.0 * SINGLE && bound.t < 3.001 * SINGLE, "{bound:?}");
        assert!(bound.u > 0.25 * SINGLE && bound.u < 0.251 * SINGLE, "{bound:?}");
    }

    /// Tilted, so that no product is 0.
    const TILTED: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];

    #[test]
    fn to_the_robust_test_the_distance_hardly_counts() {
        let from = |s: f32| Ray { origin: [0.3 + 0.5 * s, 0.3 + 0.25 * s, 0.5 + s], ..down(0.0) };
        let of = |s: f32, precision, wide| {
            bound(&Ray { direction: [-0.5, -0.25, -1.0], ..from(s) }, TILTED, precision, wide).v
        };
        let grown = |precision, wide| of(65536.0, precision, wide) / of(8.0, precision, wide);
        assert!((grown(Precision::Robust, true) - 1.0).abs() < 0.1);
        // 28 u² of the distance.
        assert!(grown(Precision::Robust, false) < 10.0 && grown(Precision::Fast, true) > 100.0);
    }

    #[test]
    fn no_bound_edge_on() {
        let along = Ray { direction: [1.0, 0.0, 0.0], ..down(0.0) };
        assert_eq!(crossing(&along, UNIT), None);
        assert_eq!(bound(&along, UNIT, Precision::Robust, true).t, f64::INFINITY);
        // From a point of the face, off its plane by so little that f32's determinant may be 0; doubles know.
        let nearly = Ray { direction: [1.0, 0.0, 1.0f32.next_up()], ..down(0.75) };
        assert_eq!(bound(&nearly, TILTED, Precision::Fast, true).u, f64::INFINITY);
        assert!(bound(&nearly, TILTED, Precision::Robust, true).u < 1e-3);
    }
}
