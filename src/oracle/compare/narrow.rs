//! What single precision excuses. A device without 64-bit floats shears the corners before it takes signs, which moves
//! each by as much as rounding may (`glsl/lib/ray.glsl`), and its t is off by a share of the triangle's depth
//! ([`bound`]): by more than the copies of a ray near a surface, or on a circle too wide for what is small and far.

use super::{COPIES, DIRECTION_JITTER, ORIGIN_JITTER, Query, SAME_SURFACE, agrees, cross, dot, near, sub};
use crate::abi::{Hit, Ray};
use crate::oracle::bounds::{bound, crossing};
use crate::oracle::brute::{Hit64, Ray64, finite_corners};
use crate::oracle::exact::V3;
use crate::oracle::reference::Reference;
use crate::trace::Precision;
use std::f64::consts::TAU;

/// Circles of copies about a ray, each an eighth of the last.
const CIRCLES: i32 = 6;

/// Whether single precision could have answered `hit` where `expected` is right.
pub(super) fn excused(
    reference: &Reference,
    (ray, wide): (&Ray, &Ray64),
    hit: &Hit,
    expected: Option<Hit64>,
    query: Query,
) -> bool {
    let grazed = |t: u32| grazes(reference, wide, t) || at_limit(reference, ray, t);
    let invented = hit.is_hit()
        && match query {
            Query::Closest => grazed(hit.triangle),
            Query::Any => (0..reference.scene().triangles.len() as u32).any(grazed),
        };
    let passed =
        || expected.is_some_and(|e| at_limit(reference, ray, e.triangle) || passes(reference, wide, &e));
    let told = hit.is_hit() && query == Query::Closest;
    let rounded = || told && expected.is_some_and(|e| rounded(reference, ray, hit, &e));
    invented || passed() || rounded()
}

/// How far rounding may move the ray where it comes by these corners.
fn doubt(ray: &Ray64, corners: &[V3; 3]) -> f64 {
    let o = ray.origin();
    let size = o.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let reach = corners.iter().flat_map(|c| sub(*c, o)).fold(0.0, |m: f64, x| m.max(x.abs()));
    size * ORIGIN_JITTER + reach * DIRECTION_JITTER
}

/// Whether the ray comes by an edge of `triangle` nearer than rounding may move it.
fn grazes(reference: &Reference, ray: &Ray64, triangle: u32) -> bool {
    let Some(corners) = finite_corners(reference.scene().corners(triangle as usize)) else { return false };
    let doubt = doubt(ray, &corners);
    (0..3).any(|k| beside(ray, corners[k], corners[(k + 1) % 3]) <= doubt)
}

/// Whether the ray's line meets `triangle` where rounding decides if that is within the ray's range.
fn at_limit(reference: &Reference, ray: &Ray, triangle: u32) -> bool {
    let corners = reference.scene().corners(triangle as usize);
    if finite_corners(corners).is_none() {
        return false;
    }
    let bound = bound(ray, corners, Precision::Robust, false);
    crossing(ray, corners).is_some_and(|met| {
        let at = |limit: f32| (met.t - f64::from(limit)).abs() <= bound.t;
        let inside = met.u >= -bound.u && met.v >= -bound.v && met.u + met.v <= 1.0 + bound.u + bound.v;
        inside && (at(ray.t_min) || at(ray.t_max))
    })
}

/// Distance of the ray's line from the segment `p` to `q`.
fn beside(ray: &Ray64, p: V3, q: V3) -> f64 {
    let (o, d) = (ray.origin(), ray.direction());
    let length = dot(d, d).sqrt();
    let d = d.map(|x| x / length);
    let across = |v: V3| {
        let along = dot(v, d);
        [v[0] - along * d[0], v[1] - along * d[1], v[2] - along * d[2]]
    };
    let (from, edge) = (across(sub(p, o)), across(sub(q, p)));
    let size = dot(edge, edge);
    let share = if size > 0.0 { (-dot(from, edge) / size).clamp(0.0, 1.0) } else { 0.0 };
    let nearest: V3 = std::array::from_fn(|k| from[k] + share * edge[k]);
    dot(nearest, nearest).sqrt()
}

/// Whether a ray beside this one, no farther than rounding may move it, has no hit on the expected surface.
fn passes(reference: &Reference, ray: &Ray64, expected: &Hit64) -> bool {
    let Some(corners) = finite_corners(reference.scene().corners(expected.triangle as usize)) else {
        return false;
    };
    let d = ray.direction();
    let mut axis = [0.0; 3];
    axis[(0..3).fold(0, |best, k| if d[k].abs() < d[best].abs() { k } else { best })] = 1.0;
    let unit = |v: V3| {
        let length = dot(v, v).sqrt();
        v.map(|x| x / length)
    };
    let across = unit(cross(d, axis));
    let up = unit(cross(d, across));
    let doubt = doubt(ray, &corners);
    (0..CIRCLES * COPIES as i32).any(|i| {
        let (circle, k) = (i / COPIES as i32, i % COPIES as i32);
        let radius = doubt * 8f64.powi(-circle);
        let (sin, cos) = ((f64::from(k) + 1.0 / 3.0) / f64::from(COPIES) * TAU).sin_cos();
        let offset = std::array::from_fn(|c| radius * (cos * across[c] + sin * up[c]));
        !agrees(Some(*expected), reference.closest64(&ray.displaced(offset, [0.0; 3])))
    })
}

/// Whether bounds on t allow for the difference.
fn rounded(reference: &Reference, ray: &Ray, hit: &Hit, expected: &Hit64) -> bool {
    let of =
        |triangle: u32| bound(ray, reference.scene().corners(triangle as usize), Precision::Robust, false).t;
    let most = of(expected.triangle) + if hit.triangle == expected.triangle { 0.0 } else { of(hit.triangle) };
    (f64::from(hit.t) - expected.t).abs() <= most || near(f64::from(hit.t), expected.t, SAME_SURFACE)
}

#[cfg(test)]
mod tests {
    use super::super::{Query, compare_on};
    use crate::abi::{Hit, INVALID, Ray};
    use crate::oracle::reference::Reference;
    use crate::scene::Scene;

    /// Faults that nothing excuses, of a ray down at (x, 0.25) on a triangle at z = 0 that is answered with `hit`.
    fn faults(x: f32, hit: Hit, wide: bool) -> usize {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let scene = Scene { positions, triangles: vec![[0, 1, 2]], ..Default::default() };
        let ray =
            Ray { origin: [x, 0.25, 1.0], t_min: 0.0, direction: [0.0, 0.0, -1.0], t_max: f32::INFINITY };
        let v = compare_on(&Reference::new(&scene), &[ray], &[hit], Query::Closest, wide);
        v.missed_stable + v.false_stable + v.leaked_stable
    }

    #[test]
    fn single_precision_excuses_what_it_moves_and_no_more() {
        let hit = |t: f32, x: f32| Hit { t, triangle: 0, u: x.max(0.0), v: 0.25 };
        let miss = Hit { t: f32::INFINITY, triangle: INVALID, u: 0.0, v: 0.0 };
        for wide in [true, false] {
            assert_eq!(faults(0.25, miss, wide), 1, "a miss within");
            assert_eq!(faults(-0.001, hit(1.0, -0.001), wide), 1, "a hit outside");
            assert_eq!(faults(0.25, hit(1.001, 0.25), wide), 1, "another t");
            assert_eq!(faults(0.25, hit(1.0, 0.25), wide), 0);
        }
        assert_eq!(faults(-1e-7, hit(1.0, 0.0), false), 0, "a hit by the edge");
        assert_eq!(faults(1e-7, miss, false), 0, "a miss by the edge");
    }
}
