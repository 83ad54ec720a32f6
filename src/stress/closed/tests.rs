//! What is said of the solids holds, by brute force and by the f64 reference.

use super::shots::{Kind, Shots};
use super::solids::{Solid, Surface};
use crate::abi::Ray;
use crate::oracle::brute;
use crate::oracle::reference::Reference;
use glam::Vec3;
use std::collections::HashMap;

#[test]
fn edges_have_two_sides() {
    for solid in Solid::all() {
        let mut balance: HashMap<(u32, u32), i32> = HashMap::new();
        for [a, b, c] in &solid.scene.triangles {
            for (p, q) in [(*a, *b), (*b, *c), (*c, *a)] {
                assert_ne!(p, q, "{}", solid.name);
                *balance.entry((p.min(q), p.max(q))).or_default() += if p < q { 1 } else { -1 };
            }
        }
        let open = balance.values().filter(|n| **n != 0).count();
        assert_eq!(open, 0, "{}: open edges of {}", solid.name, balance.len());
        // Vertices that lie in one place would be a seam that no index shows.
        let mut places: Vec<_> =
            solid.scene.positions.iter().map(|p| p.map(|x| (x + 0.0).to_bits())).collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), solid.scene.positions.len(), "{}", solid.name);
    }
}

#[test]
fn balls_are_within() {
    for solid in Solid::all() {
        for ball in solid.balls.iter().step_by(solid.balls.len() / 8 + 1) {
            for way in [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_ONE] {
                let origin = ball.centre.as_vec3() + 0.55 * ball.radius as f32 * way;
                let direction = [0.31, -0.67, 0.53];
                let ray = Ray { origin: origin.to_array(), t_min: 0.0, direction, t_max: f32::INFINITY };
                let Some(ray) = brute::Ray64::new(&ray) else { panic!("a good ray is refused") };
                let crossed = (0..solid.scene.triangles.len()).filter(|i| {
                    let corners = brute::finite_corners(solid.scene.corners(*i));
                    corners.is_some_and(|c| brute::intersect(&ray, c, 0).is_some())
                });
                assert_eq!(crossed.count() % 2, 1, "{}: {origin} is outside", solid.name);
            }
        }
    }
}

#[test]
fn the_surface_lies_where_rays_are_told() {
    for solid in Solid::all() {
        let reference = Reference::new(&solid.scene);
        for kind in Kind::ALL {
            let shots = Shots::new(&solid, kind, 7);
            let mut widest: f64 = 0.0;
            for i in 0..600 {
                let shot = shots.shot(i);
                let what = format!("{}, {}, ray {i}: {shot:?}", solid.name, kind.name());
                let Some(hit) = reference.closest(&shot.ray) else { panic!("{what} misses") };
                assert!((shot.least..=shot.most).contains(&hit.t), "{what}: t {}", hit.t);
                let stepped = solid.blocks.is_some() && kind == Kind::Axes;
                if matches!(solid.surface, Surface::Star { .. }) && !stepped {
                    widest = widest.max(shot.most / shot.least - 1.0);
                }
                assert!(shot.most.is_finite() && shot.ray.t_max == f32::INFINITY, "{what}");
            }
            // Needles are long and thin; far off, a point of an edge that a ray along an axis is to go through is rounded.
            let limit = if ["needles", "far sphere"].contains(&solid.name) { 1e-3 } else { 3e-5 };
            assert!(widest < limit, "{}, {}: ranges of up to {widest:e}", solid.name, kind.name());
        }
    }
}

#[test]
fn kinds_are_what_they_say() {
    for solid in Solid::all() {
        let axes = Shots::new(&solid, Kind::Axes, 1);
        let mut zeros = [0; 2];
        let mut ways = [0; 6];
        for i in 0..300 {
            let d = axes.shot(i).ray.direction;
            let along: Vec<usize> = (0..3).filter(|k| d[*k] != 0.0).collect();
            assert_eq!(along.len(), 1, "{}: {d:?}", solid.name);
            ways[2 * along[0] + usize::from(d[along[0]] < 0.0)] += 1;
            d.iter().filter(|x| **x == 0.0).for_each(|x| zeros[usize::from(x.is_sign_negative())] += 1);
        }
        assert!(zeros.iter().all(|n| *n > 200), "{}: {zeros:?}", solid.name);
        // A turned solid may have no vertex near an axis.
        let axes_met = ways.chunks(2).filter(|n| n[0] > 0 && n[1] > 0).count();
        assert!(axes_met == 3 || (axes_met == 2 && solid.turned), "{}: {ways:?}", solid.name);
        // The same seed, the same ray; another, another.
        let same = Shots::new(&solid, Kind::Axes, 1).shot(5).ray;
        let other = Shots::new(&solid, Kind::Axes, 2).shot(5).ray;
        assert_eq!(bytemuck::bytes_of(&axes.shot(5).ray), bytemuck::bytes_of(&same));
        assert_ne!(bytemuck::bytes_of(&same), bytemuck::bytes_of(&other));
    }
}
