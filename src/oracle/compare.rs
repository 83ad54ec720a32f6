//! Judges a device's hits against the reference.
//!
//! A ray that differs is *stable* when copies of it, changed by what rounding may change, agree with the reference on the
//! plain ray: then rounding is no excuse, and the difference is a fault. Rays that agree need no copies, so none are
//! made for them. What copies there are depends on the [`Arithmetic`] that the device claims.

mod verdict;

pub use self::verdict::{BruteCheck, Example, Fault, Quantiles, Verdict};

use self::verdict::Tally;
use super::brute::{self, Hit64, Ray64};
use super::exact::V3;
use super::reference::Reference;
use crate::abi::{Hit, INVALID, Ray};
use crate::trace::Precision;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;

/// What the device was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Query {
    /// The first hit on the ray.
    Closest,
    /// Whether there is a hit; t is 0 where there is.
    Any,
}

/// What a test of rays and triangles claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arithmetic {
    /// To meet what exact arithmetic meets: only t is rounded, onto an end of its range too, and denormal numbers are 0.
    Exact,
    /// No more than f32 gives: the ray may be off by about what that may move it.
    Rounded,
}

impl From<Precision> for Arithmetic {
    fn from(precision: Precision) -> Self {
        match precision {
            Precision::Robust => Self::Exact,
            Precision::Fast => Self::Rounded,
        }
    }
}

/// Relative difference of t beyond which a hit is on another surface.
const SAME_SURFACE: f64 = 1e-4;
/// Relative difference of t up to which f32 can't tell which of two triangles is nearer.
const TIE: f64 = 1e-6;
/// How far u, v and 1 − u − v may leave [0, 1].
const WEIGHT_TOLERANCE: f32 = 1e-3;
/// Copies on a circle around the ray: enough that some fall on either side of any edge it passes near.
const COPIES: u32 = 8;
/// Radius of the circle at the origin, in units of the origin's largest coordinate: about an f32 ulp.
const ORIGIN_JITTER: f64 = 1e-7;
/// Radius of the circle at the direction's end, in units of its length.
const DIRECTION_JITTER: f64 = 2e-6;
/// By how much two more copies stretch and shrink the range of t: two f32 ulps.
const RANGE_JITTER: f64 = 1.0 / (1u32 << 22) as f64;
/// Spacing of denormal f32: t can't be told more finely.
const GRAIN_OF_T: f64 = f64::from_bits((1023 - 149) << 52);
/// Rays a task.
const CHUNK: usize = 1 << 12;

/// Judges `hits[i]`, the device's answer to `rays[i]`. Where one slice is longer, the rest counts as malformed.
pub fn compare(
    reference: &Reference,
    rays: &[Ray],
    hits: &[Hit],
    query: Query,
    arithmetic: Arithmetic,
) -> Verdict {
    let judge = |tally: &mut Tally, at: usize, ray: &Ray, hit: &Hit| {
        judge(tally, at, reference, ray, hit, (query, arithmetic));
    };
    let chunk = |(chunk, (rays, hits)): (usize, (&[Ray], &[Hit]))| {
        let mut tally = Tally::default();
        for (i, (ray, hit)) in rays.iter().zip(hits).enumerate() {
            judge(&mut tally, chunk * CHUNK + i, ray, hit);
        }
        tally
    };
    let paired = rays.len().min(hits.len());
    let tally = rays[..paired]
        .par_chunks(CHUNK)
        .zip(hits[..paired].par_chunks(CHUNK))
        .enumerate()
        .map(chunk)
        .reduce(Tally::default, Tally::merged);
    let mut verdict = tally.verdict(query);
    verdict.malformed += rays.len().abs_diff(hits.len());
    verdict
}

/// Judges one ray.
fn judge(
    tally: &mut Tally,
    at: usize,
    reference: &Reference,
    ray: &Ray,
    hit: &Hit,
    (query, arithmetic): (Query, Arithmetic),
) {
    let ray64 = Ray64::new(ray);
    let expected = match query {
        Query::Closest => ray64.and_then(|r| reference.closest64(&r)),
        Query::Any => ray64.and_then(|r| reference.any64(&r)),
    };
    tally.count_ray(expected.is_some());
    let example = |fault, stable| Example::new(at, fault, stable, ray, hit, expected);
    if malformed(ray, hit, query, reference.scene().triangles.len()) {
        return tally.fault(example(Fault::Malformed, true));
    }
    // A ray that can hit nothing has no copies, and no excuse.
    let copies = || ray64.into_iter().flat_map(|r| copies(&r, reference.extent(), arithmetic));
    if expected.is_some() != hit.is_hit() {
        let stable = match query {
            Query::Closest => copies().all(|c| agrees(expected, reference.closest64(&c))),
            Query::Any => copies().all(|c| reference.any64(&c).is_some() == expected.is_some()),
        };
        let fault = if hit.is_hit() { Fault::False } else { Fault::Missed };
        return tally.fault(example(fault, stable));
    }
    let (Some(expected), Query::Closest) = (expected, query) else { return };
    let plain = Some(expected);
    let stable = || copies().all(|c| agrees(plain, reference.closest64(&c)));
    // +inf is a miss: a t beyond the floats is told as the largest of them.
    let told = expected.t.clamp(-f64::from(f32::MAX), f64::from(f32::MAX));
    let least = ray64.map_or(0.0, |r| r.least_t(reference.extent()));
    if (f64::from(hit.t) - told).abs() > SAME_SURFACE * told.abs() + least.max(GRAIN_OF_T) {
        tally.fault(example(Fault::Leaked, stable()));
    } else if hit.triangle == expected.triangle {
        tally.agreement(hit, &Hit64 { t: told, ..expected });
    } else if arithmetic == Arithmetic::Rounded
        && ray64.is_some_and(|r| brushed(reference, &r, &expected, hit.triangle))
        || ray64.into_iter().chain(copies()).any(|r| tied(reference, &r, &expected, hit.triangle))
    {
        tally.tie();
    } else {
        tally.fault(example(Fault::WrongTriangle, stable()));
    }
}

/// Whether no query could have written `hit`.
fn malformed(ray: &Ray, hit: &Hit, query: Query, triangles: usize) -> bool {
    let in_scene = (hit.triangle as usize) < triangles;
    if hit.t == f32::INFINITY {
        return hit.triangle != INVALID;
    }
    match query {
        // An any-hit query need not say which triangle it met.
        Query::Any => hit.t != 0.0 || !(in_scene || hit.triangle == INVALID),
        Query::Closest => {
            let in_range = ray.t_min <= hit.t && hit.t <= ray.t_max && hit.t.is_finite();
            let weights = [hit.u, hit.v, 1.0 - hit.u - hit.v];
            let inside = |w: &f32| (-WEIGHT_TOLERANCE..=1.0 + WEIGHT_TOLERANCE).contains(w);
            !(in_scene && in_range && weights.iter().all(inside))
        }
    }
}

/// Whether `t` is within `share` of `of`.
fn near(t: f64, of: f64, share: f64) -> bool {
    (t - of).abs() <= share * of.abs()
}

/// Whether a copy's hit is on the same surface as the plain ray's.
fn agrees(plain: Option<Hit64>, copy: Option<Hit64>) -> bool {
    match (plain, copy) {
        (None, None) => true,
        (Some(a), Some(b)) => near(b.t, a.t, SAME_SURFACE),
        _ => false,
    }
}

/// Whether `ray`, the plain one or a copy, meets `triangle` as near as anything, on the surface that is expected.
fn tied(reference: &Reference, ray: &Ray64, expected: &Hit64, triangle: u32) -> bool {
    let met = brute::finite_corners(reference.scene().corners(triangle as usize))
        .and_then(|corners| brute::intersect(ray, corners, triangle));
    match (met, reference.closest64(ray)) {
        (Some(met), Some(first)) => near(met.t, first.t, TIE) && near(first.t, expected.t, SAME_SURFACE),
        _ => false,
    }
}

/// Whether `triangle` comes as close to the ray at the expected hit as the copies go. Copies alone would do, were
/// there no fans of so many triangles that eight copies can't visit them all.
fn brushed(reference: &Reference, ray: &Ray64, expected: &Hit64, triangle: u32) -> bool {
    let Some(corners) = brute::finite_corners(reference.scene().corners(triangle as usize)) else {
        return false;
    };
    let (o, d) = (ray.origin(), ray.direction());
    let hit: V3 = std::array::from_fn(|k| o[k] + expected.t * d[k]);
    let q = nearest(hit, corners);
    let length = dot(d, d).sqrt();
    let away = cross(sub(q, o), d.map(|x| x / length));
    let size = o.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    dot(away, away).sqrt() <= size * ORIGIN_JITTER + (expected.t * length).abs() * DIRECTION_JITTER
        && dot(sub(q, hit), d).abs() <= SAME_SURFACE * expected.t.abs() * length * length
}

/// The point of the triangle `[a, b, c]` nearest to `p`: on an edge, or the foot of the perpendicular inside.
fn nearest(p: V3, [a, b, c]: [V3; 3]) -> V3 {
    let n = cross(sub(b, a), sub(c, a));
    let winds = |a, b| dot(cross(sub(b, a), sub(p, a)), n);
    let edges = [(a, b), (b, c), (c, a)];
    if edges.iter().all(|&(a, b)| winds(a, b) >= 0.0) && dot(n, n) > 0.0 {
        let height = dot(sub(p, a), n) / dot(n, n);
        return std::array::from_fn(|k| p[k] - height * n[k]);
    }
    let on_edge = edges.map(|(a, b)| {
        let ab = sub(b, a);
        let share = (dot(sub(p, a), ab) / dot(ab, ab)).clamp(0.0, 1.0);
        let q: V3 = std::array::from_fn(|k| a[k] + share * ab[k]);
        (dot(sub(q, p), sub(q, p)), q)
    });
    on_edge.into_iter().fold(on_edge[0], |best, x| if x.0 < best.0 { x } else { best }).1
}

/// The ray with its range stretched and shrunk, and without denormals in a scene of this extent; where arithmetic rounds, moved
/// to [`COPIES`] places on a circle across it as well.
fn copies(ray: &Ray64, extent: f64, arithmetic: Arithmetic) -> impl Iterator<Item = Ray64> + use<> {
    let ray = *ray;
    let d = ray.direction();
    let length = dot(d, d).sqrt();
    let unit = d.map(|x| x / length);
    let mut axis = [0.0; 3];
    let least = (0..3).fold(0, |best, k| if unit[k].abs() < unit[best].abs() { k } else { best });
    axis[least] = 1.0;
    let across = cross(unit, axis);
    let norm = dot(across, across).sqrt();
    let across = across.map(|x| x / norm);
    let up = cross(unit, across);
    let size = ray.origin().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let moved = move |k: u32| {
        // A third of a step off, so that no copy moves along an axis.
        let (sin, cos) = ((f64::from(k) + 1.0 / 3.0) / f64::from(COPIES) * TAU).sin_cos();
        let offset: [f64; 3] = std::array::from_fn(|i| cos * across[i] + sin * up[i]);
        ray.displaced(offset.map(|x| x * size * ORIGIN_JITTER), offset.map(|x| x * length * DIRECTION_JITTER))
    };
    let around = if arithmetic == Arithmetic::Rounded { COPIES } else { 0 };
    (0..around).map(moved).chain([
        ray.stretched(RANGE_JITTER),
        ray.stretched(-RANGE_JITTER),
        ray.without_denormals(extent),
    ])
}

fn sub(a: V3, b: V3) -> V3 {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_surround_the_ray() {
        let ray = Ray { origin: [1.0, -2.0, 3.0], t_min: 0.0, direction: [0.0, 5.0, -0.0], t_max: 1.0 };
        let Some(plain) = Ray64::new(&ray) else { panic!("a good ray is refused") };
        let moved: Vec<Ray64> = copies(&plain, 1.0, Arithmetic::Rounded).collect();
        assert_eq!(moved.len(), COPIES as usize + 3);
        let mut sum = [0.0; 3];
        for c in &moved[..COPIES as usize] {
            let off: [f64; 3] = std::array::from_fn(|k| c.direction()[k] - plain.direction()[k]);
            let size = off.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!((size / 1e-5 - 1.0).abs() < 1e-6 && off[1].abs() < 1e-12, "{off:?}");
            (0..3).for_each(|k| sum[k] += off[k]);
        }
        assert!(sum.iter().all(|x| x.abs() < 1e-12), "not centred: {sum:?}");
    }

    /// What [`compare`] says of one triangle's answer to one ray.
    fn verdict(corners: [[f32; 3]; 3], ray: Ray, hit: Hit) -> Verdict {
        let scene = crate::scene::Scene {
            positions: corners.to_vec(),
            triangles: vec![[0, 1, 2]],
            ..Default::default()
        };
        let reference = Reference::new(&scene);
        let [exact, rounded] = [Arithmetic::Exact, Arithmetic::Rounded]
            .map(|arithmetic| compare(&reference, &[ray], &[hit], Query::Closest, arithmetic));
        assert_eq!(exact, rounded);
        exact
    }

    #[test]
    fn exact_arithmetic_is_not_excused_by_what_f32_may_move() {
        let floor = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let scene = crate::scene::Scene {
            positions: floor.to_vec(),
            triangles: vec![[0, 1, 2]],
            ..Default::default()
        };
        let reference = Reference::new(&scene);
        let of = |x: f32, t_max: f32, hit: Hit| {
            let ray = Ray { origin: [x, 0.5, 1.0], t_min: 0.0, direction: [0.0, 0.0, -1.0], t_max };
            [Arithmetic::Exact, Arithmetic::Rounded].map(|arithmetic| {
                let v = compare(&reference, &[ray], &[hit], Query::Closest, arithmetic);
                (v.missed + v.false_hits, v.missed_stable + v.false_stable)
            })
        };
        let hit = Hit { t: 1.0, triangle: 0, u: 0.0, v: 0.5 };
        assert_eq!(of(0.0, 9.0, Hit::MISS), [(1, 1), (1, 0)], "a miss of an edge");
        assert_eq!(of(-1e-30, 9.0, hit), [(1, 1), (1, 0)], "a hit beside an edge");
        assert_eq!(of(0.25, 1.0, Hit::MISS), [(1, 0); 2], "t at the end of its range");
    }

    #[test]
    fn a_t_beyond_the_floats_is_the_largest_of_them() {
        let floor = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let far = Ray {
            origin: [0.25, 0.25, 4.0],
            t_min: 0.0,
            direction: [0.0, 0.0, -1e-41],
            t_max: f32::INFINITY,
        };
        let hit = Hit { t: f32::MAX, triangle: 0, u: 0.25, v: 0.25 };
        let right = verdict(floor, far, hit);
        assert!(right.is_clean() && right.leaked == 0 && right.t_error.max < 1e-6, "{right}");
        assert_eq!(verdict(floor, far, Hit { t: 3e38, ..hit }).leaked_stable, 1);
        // So near that t is denormal: told to half of the least.
        let near = Ray { direction: [0.0, 0.0, -3e38], origin: [0.25, 0.25, 1e-6], ..far };
        let t = (1e-6f32 as f64 / 3e38f32 as f64) as f32;
        assert!(0.0 < t && t < 1e-43);
        assert_eq!(verdict(floor, near, Hit { t, ..hit }).leaked, 0);
        assert_eq!(verdict(floor, near, Hit { t: 1e-40, ..hit }).leaked, 1);
    }

    #[test]
    fn a_t_that_is_no_distance_to_a_scene_may_be_0() {
        let floor = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let above = |z| Ray { origin: [0.25, 0.25, z], t_min: 0.0, direction: [0.0, 0.0, -1.0], t_max: 9.0 };
        let hit = Hit { t: 0.0, triangle: 0, u: 0.25, v: 0.25 };
        assert_eq!(verdict(floor, above(1e-38), hit).leaked, 0);
        // An origin so near is nothing to the device either; one beyond is told, and so is t.
        assert_eq!(verdict(floor, above(1e-37), hit).leaked_stable, 1);
        assert_eq!(verdict(floor, above(1e-38), Hit { t: 1e-37, ..hit }).leaked, 1);
    }

    #[test]
    fn what_only_a_denormal_decides_is_unsure() {
        // Past the tip of a spike, by less than any device with denormals of 0 can tell.
        let spike = [[1.0, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0; 3]];
        let ray = |y| Ray { origin: [1.0, 0.0, 2.0], t_min: 0.0, direction: [0.0, y, -2.0], t_max: 9.0 };
        let hit = Hit { t: 1.0, triangle: 0, u: 0.0, v: 0.0 };
        assert!(verdict(spike, ray(0.0), hit).is_clean());
        let past = verdict(spike, ray(-1e-40), hit);
        assert_eq!((past.false_hits, past.false_stable), (1, 0), "{past}");
        assert_eq!(verdict(spike, ray(-1e-37), hit).false_stable, 1);
    }

    #[test]
    fn nearest_is_inside_on_an_edge_or_a_corner() {
        let t = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        assert_eq!(nearest([1.0, 1.0, 5.0], t), [1.0, 1.0, 0.0]);
        assert_eq!(nearest([1.0, -2.0, 5.0], t), [1.0, 0.0, 0.0]);
        assert_eq!(nearest([3.0, 3.0, -1.0], t), [2.0, 2.0, 0.0]);
        assert_eq!(nearest([9.0, -9.0, 1.0], t), [4.0, 0.0, 0.0]);
    }

    #[test]
    fn what_no_query_writes() {
        let ray = Ray { origin: [0.0; 3], t_min: 1.0, direction: [1.0; 3], t_max: 2.0 };
        let good = Hit { t: 1.5, triangle: 3, u: 0.5, v: 0.5 };
        let bad = |hit: Hit| malformed(&ray, &hit, Query::Closest, 4);
        assert!(!bad(good) && !bad(Hit::MISS) && !bad(Hit { u: -0.0009, ..good }));
        assert!(bad(Hit { triangle: 4, ..good }) && bad(Hit { triangle: INVALID, ..good }));
        assert!(bad(Hit { t: f32::NAN, ..good }) && bad(Hit { t: f32::NEG_INFINITY, ..good }));
        assert!(bad(Hit { t: 0.99, ..good }) && bad(Hit { t: 2.01, ..good }));
        assert!(bad(Hit { u: -0.002, ..good }) && bad(Hit { v: 1.1, ..good }) && bad(Hit { u: 0.6, ..good }));
        assert!(bad(Hit { u: f32::NAN, ..good }));
        assert!(bad(Hit { triangle: 0, ..Hit::MISS }));
        let any = |hit: Hit| malformed(&ray, &hit, Query::Any, 4);
        assert!(any(good) && !any(Hit { t: 0.0, ..good }) && !any(Hit { t: 0.0, ..Hit::MISS }));
    }
}
