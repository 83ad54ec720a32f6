//! The definition of a hit, and the slow way to it: every ray × every triangle, f64, signs exact.
//!
//! A triangle is closed (a zero edge function is inside) and faces both ways; seen edge-on, or of no area at all, it
//! is no hit. t_min and t_max belong to the ray. Of equal t the lowest triangle index wins.

use super::exact::{self, Difference, GRAIN, V3};
use crate::abi::{Hit, Ray};
use crate::scene::Scene;

/// How far the terms of u and v may exceed the determinant before they are summed exactly: keeps their error below
/// 2⁻²⁶.
const WEIGHT_MARGIN: f64 = (1u32 << 22) as f64;

/// A hit as the references know it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Hit64 {
    /// Ray parameter, relative error at most 2⁻²⁸.
    pub t: f64,
    /// Weight of the triangle's second vertex.
    pub u: f64,
    /// Weight of the triangle's third vertex.
    pub v: f64,
    /// Triangle in input order.
    pub triangle: u32,
}

impl Hit64 {
    /// Whether this hit comes before `other` on the ray: nearer, or as near and of lower index.
    #[inline]
    pub fn precedes(&self, other: &Hit64) -> bool {
        self.t < other.t || (self.t == other.t && self.triangle < other.triangle)
    }
}

impl From<Option<Hit64>> for Hit {
    fn from(hit: Option<Hit64>) -> Hit {
        match hit {
            Some(h) => Hit { t: h.t as f32, triangle: h.triangle, u: h.u as f32, v: h.v as f32 },
            None => Hit::MISS,
        }
    }
}

/// A ray that can hit something: finite, its direction not zero, its range not NaN, its coordinates multiples of
/// [`GRAIN`].
#[derive(Debug, Clone, Copy)]
pub struct Ray64 {
    pub(super) origin: V3,
    pub(super) direction: V3,
    pub(super) t_min: f64,
    pub(super) t_max: f64,
}

impl Ray64 {
    /// The ray as it is; none where it can hit nothing.
    pub fn new(ray: &Ray) -> Option<Self> {
        let ray = Self {
            origin: ray.origin.map(f64::from),
            direction: ray.direction.map(f64::from),
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        };
        let finite = ray.origin.iter().chain(&ray.direction).all(|x| x.is_finite());
        let somewhere = ray.direction.iter().any(|&x| x != 0.0);
        (finite && somewhere && ray.t_min <= ray.t_max).then_some(ray)
    }

    /// Where it starts.
    pub fn origin(&self) -> V3 {
        self.origin
    }

    /// Where it goes; not unit.
    pub fn direction(&self) -> V3 {
        self.direction
    }

    /// The ray with origin and direction displaced, both rounded to multiples of [`GRAIN`].
    pub fn displaced(&self, origin: V3, direction: V3) -> Self {
        let grainy = |x: f64| (x / GRAIN).round() * GRAIN;
        Self {
            origin: std::array::from_fn(|k| grainy(self.origin[k] + origin[k])),
            direction: std::array::from_fn(|k| grainy(self.direction[k] + direction[k])),
            ..*self
        }
    }

    /// Below this t may become 0 on a device, in whose units it is below 2⁻¹²⁶: powers of two scale `extent` there to between 1/2
    /// and 1, and the direction's largest component to between 1 and 2.
    pub fn least_t(&self, extent: f64) -> f64 {
        let largest = self.direction.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        f64::from(f32::MIN_POSITIVE) * 4.0 * extent / largest
    }

    /// The ray as a device sees it to which denormal numbers are 0: without coordinates of its origin and components of its
    /// direction that are below 2⁻¹²⁶ of `extent` and of its largest component.
    pub fn without_denormals(&self, extent: f64) -> Self {
        let least = f64::from(f32::MIN_POSITIVE);
        let without = |v: V3, size: f64| v.map(|x| if x.abs() < least * size { 0.0 } else { x });
        // A device scales by powers of two: by what lies between half of these and all.
        let largest = self.direction.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        Self {
            origin: without(self.origin, 2.0 * extent),
            direction: without(self.direction, largest),
            ..*self
        }
    }

    /// The ray with both ends of its range moved outward by `share` of their size; inward where negative.
    pub fn stretched(&self, share: f64) -> Self {
        let step = |t: f64| if t.is_finite() { share * t.abs() } else { 0.0 };
        Self { t_min: self.t_min - step(self.t_min), t_max: self.t_max + step(self.t_max), ..*self }
    }
}

/// The corners in f64; none where one is NaN or infinite, for such a triangle is never hit.
pub fn finite_corners(corners: [[f32; 3]; 3]) -> Option<[V3; 3]> {
    corners.iter().flatten().all(|x| x.is_finite()).then(|| corners.map(|c| c.map(f64::from)))
}

/// Where `ray` meets the triangle `index` of finite corners `[a, b, c]`.
#[inline]
pub fn intersect(ray: &Ray64, [a, b, c]: [V3; 3], index: u32) -> Option<Hit64> {
    let (o, d) = (ray.origin, ray.direction);
    // The weights of a, b and c, not normalised; the sum of the exact three is d·n, the determinant.
    let w_a = exact::edge(d, o, b, c);
    let w_b = exact::edge(d, o, c, a);
    if (w_a < 0.0 && w_b > 0.0) || (w_a > 0.0 && w_b < 0.0) {
        return None;
    }
    let w_c = exact::edge(d, o, a, b);
    let inside = w_a.min(w_b).min(w_c) >= 0.0 || w_a.max(w_b).max(w_c) <= 0.0;
    let edge_on = w_a == 0.0 && w_b == 0.0 && w_c == 0.0;
    (inside && !edge_on).then(|| locate(ray, [a, b, c], index)).flatten()
}

/// [`intersect`] once the ray is known to cross the triangle: t by the plane, u and v by edges taken from `a`, whose
/// products are far smaller than those taken from a distant origin.
fn locate(ray: &Ray64, [a, b, c]: [V3; 3], index: u32) -> Option<Hit64> {
    let d = Difference::vector(ray.direction);
    let (to_a, ab, ac) = (Difference::new(ray.origin, a), Difference::new(a, b), Difference::new(a, c));
    let det = exact::triple(&d, &ab, &ac);
    let t = exact::triple(&to_a, &ab, &ac) / det;
    if !(ray.t_min <= t && t <= ray.t_max) {
        return None;
    }
    let weight = |x: &Difference, y: &Difference| {
        let e = exact::estimate(d.rounded(), x.rounded(), y.rounded());
        let w = if e.size <= WEIGHT_MARGIN * det.abs() { e.value } else { exact::exact(&d, x, y) };
        (w / det).clamp(0.0, 1.0)
    };
    let u = weight(&ac, &to_a);
    let v = weight(&to_a, &ab).min(1.0 - u);
    Some(Hit64 { t, u, v, triangle: index })
}

/// Every hit of `ray`, in input order.
fn hits<'s>(scene: &'s Scene, ray: &'s Ray64) -> impl Iterator<Item = Hit64> + 's {
    (0..scene.triangles.len()).filter_map(|i| intersect(ray, finite_corners(scene.corners(i))?, i as u32))
}

/// The first hit of `ray`, found by trying every triangle.
pub fn closest(scene: &Scene, ray: &Ray) -> Option<Hit64> {
    let ray = Ray64::new(ray)?;
    hits(scene, &ray).reduce(|best, hit| if hit.precedes(&best) { hit } else { best })
}

/// Whether `ray` hits anything, found by trying every triangle.
pub fn any(scene: &Scene, ray: &Ray) -> bool {
    Ray64::new(ray).is_some_and(|ray| hits(scene, &ray).next().is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f32; 3]; 3]) -> Scene {
        Scene { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Scene::default() }
    }

    fn ray(origin: [f32; 3], direction: [f32; 3], t_min: f32, t_max: f32) -> Ray {
        Ray { origin, t_min, direction, t_max }
    }

    const UNIT: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn closed_triangle_range_and_weights() {
        let s = triangle(UNIT);
        let down = |x, y, t_min, t_max| closest(&s, &ray([x, y, 2.0], [0.0, -0.0, -2.0], t_min, t_max));
        let hit = Hit64 { t: 1.0, u: 0.25, v: 0.5, triangle: 0 };
        assert_eq!(down(0.25, 0.5, 0.0, f32::INFINITY), Some(hit));
        assert_eq!(down(0.25, 0.5, 1.0, 1.0), Some(hit), "both ends of the range belong to it");
        assert_eq!(down(0.25, 0.5, 0.0, 0.99), None);
        assert_eq!(down(0.25, 0.5, 1.01, 9.0), None);
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.5, 0.0)] {
            assert!(down(x, y, 0.0, 9.0).is_some_and(|h| h.u == x as f64 && h.v == y as f64), "({x}, {y})");
        }
        assert_eq!(down(0.5, 0.5f32.next_up(), 0.0, 9.0), None);
        assert_eq!(down(f32::from_bits(1).copysign(-1.0), 0.5, 0.0, 9.0), None);
    }

    #[test]
    fn what_can_never_be_hit() {
        let s = triangle(UNIT);
        assert!(!any(&s, &ray([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0], 0.0, 9.0)), "edge-on");
        assert!(!any(&s, &ray([0.2, 0.2, 1.0], [0.0; 3], 0.0, 9.0)), "no direction");
        assert!(!any(&s, &ray([0.2, f32::NAN, 1.0], [0.0, 0.0, -1.0], 0.0, 9.0)), "NaN origin");
        assert!(!any(&s, &ray([0.2, 0.2, 1.0], [0.0, 0.0, -1.0], f32::NAN, 9.0)), "NaN range");
        let line = triangle([[0.0; 3], [1.0, 1.0, 0.0], [3.0, 3.0, 0.0]]);
        assert!(!any(&line, &ray([1.0, 1.0, 1.0], [0.0, 0.0, -1.0], 0.0, 9.0)), "no area");
        let open = triangle([[0.0; 3], [f32::INFINITY, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert!(!any(&open, &ray([0.2, 0.2, 1.0], [0.0, 0.0, -1.0], 0.0, 9.0)), "infinite vertex");
    }
}
