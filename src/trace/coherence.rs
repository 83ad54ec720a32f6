//! Whether neighbouring rays of a set go much the same way, so that a packet of them visits much the same nodes.

use crate::abi::Ray;
use glam::Vec3;

/// Rays that would share a packet.
const GROUP: usize = 8;
/// Groups looked at.
const SAMPLES: usize = 1024;
/// Cosine of the widest angle in a coherent group: 4°, about 20 pixels of a 50° view 1024 pixels wide.
const LEAST_COSINE: f32 = 0.9976;
/// Share of groups that must be coherent.
const LEAST_SHARE: f32 = 0.9;

/// Looks at a sample of groups of neighbours: nine in ten must start near each other (compared with `extent`, the
/// scene's longest edge) and keep within 4°.
pub fn is_coherent(rays: &[Ray], extent: f32) -> bool {
    let groups = rays.len() / GROUP;
    if groups == 0 {
        return false;
    }
    let samples = groups.min(SAMPLES);
    let coherent = (0..samples).filter(|i| {
        let first = i * groups / samples * GROUP;
        group_is_coherent(&rays[first..first + GROUP], extent)
    });
    coherent.count() as f32 >= LEAST_SHARE * samples as f32
}

fn group_is_coherent(rays: &[Ray], extent: f32) -> bool {
    let origin = Vec3::from_array(rays[0].origin);
    let direction = Vec3::from_array(rays[0].direction).normalize_or_zero();
    rays[1..].iter().all(|r| {
        Vec3::from_array(r.origin).distance(origin) <= 0.01 * extent
            && Vec3::from_array(r.direction).normalize_or_zero().dot(direction) >= LEAST_COSINE
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fan(step: f32) -> Vec<Ray> {
        let ray = |i: usize| {
            let a = i as f32 * step;
            Ray { origin: [0.0; 3], t_min: 0.0, direction: [a.cos(), a.sin(), 0.0], t_max: f32::INFINITY }
        };
        (0..800).map(ray).collect()
    }

    #[test]
    fn narrow_fans_are_coherent_and_wide_ones_are_not() {
        assert!(is_coherent(&fan(0.001), 1.0));
        assert!(!is_coherent(&fan(0.5), 1.0));
        assert!(!is_coherent(&[], 1.0));
    }
}
