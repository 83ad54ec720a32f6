//! Twin of `glsl/raysort/*.comp`, to the same bits.

use super::morton::reciprocal;
use super::rays::levelled;
use super::sort;
use crate::abi::{Aabb, Ray, UNORDERED_KEY};
use crate::bvh::raw::{greatest_of, least_of};
use glam::Vec3;

/// Whether a ray has a key: all finite but t, which is a number, and a direction that is not denormal.
pub fn orderable(ray: &Ray) -> bool {
    let largest = Vec3::from_array(ray.direction).abs().max_element();
    ray.origin.iter().chain(&ray.direction).all(|x| x.is_finite())
        && !ray.t_min.is_nan()
        && !ray.t_max.is_nan()
        && largest >= f32::MIN_POSITIVE
}

/// 0 for denormal numbers: devices may take them as that.
fn settled(p: [f32; 3]) -> Vec3 {
    Vec3::from_array(p.map(|x| if x.abs() < f32::MIN_POSITIVE { 0.0 } else { x }))
}

/// The box of the origins of rays that have a key.
pub fn bounds(rays: &[Ray]) -> Aabb {
    let mut bounds = Aabb { lo: [f32::MAX; 3], hi: [f32::MIN; 3] };
    for ray in rays.iter().filter(|r| orderable(r)) {
        let origin = settled(ray.origin);
        for k in 0..3 {
            bounds.lo[k] = least_of(bounds.lo[k], origin[k]);
            bounds.hi[k] = greatest_of(bounds.hi[k], origin[k]);
        }
    }
    bounds
}

/// Cell of each coordinate of `p`, 0 to 1, of `count` in each axis.
fn cells(p: Vec3, count: u32) -> [u32; 3] {
    // A cast of a negative float is 0.
    p.to_array().map(|x| ((x * count as f32) as u32).min(count - 1))
}

/// Bit by bit from the highest: two levels of the origin's five, then the rest and the direction's three in turn.
fn key_of(origin: [u32; 3], direction: [u32; 3]) -> u32 {
    let level = |q: [u32; 3], k: u32| q.map(|x| x >> k & 1);
    let lead = [4, 3].into_iter().flat_map(|k| level(origin, k));
    let rest = [2, 1, 0].into_iter().flat_map(|k| [level(origin, k), level(direction, k)].concat());
    lead.chain(rest).fold(0, |key, bit| key << 1 | bit)
}

/// A key for each ray.
pub fn keys(rays: &[Ray]) -> Vec<u32> {
    let Aabb { lo, hi } = bounds(rays);
    let (lo, hi) = (Vec3::from_array(lo) * 0.5, Vec3::from_array(hi) * 0.5);
    let longest = (hi - lo).abs().max_element();
    let scale = if longest > 1e-30 && longest < 1e30 { reciprocal(longest) } else { 0.0 };
    let key = |ray: &Ray| {
        if !orderable(ray) {
            return UNORDERED_KEY;
        }
        let origin = (settled(ray.origin) * 0.5 - lo) * scale;
        let level = levelled(settled(ray.direction));
        let direction = level * reciprocal(level.abs().max_element()) * 0.5 + 0.5;
        key_of(cells(origin, 32), cells(direction, 8))
    };
    rays.iter().map(key).collect()
}

/// The rays in order: of equal keys the earlier comes first.
pub fn order(rays: &[Ray]) -> Vec<u32> {
    sort::order(&keys(rays).into_iter().map(u64::from).collect::<Vec<_>>())
}
