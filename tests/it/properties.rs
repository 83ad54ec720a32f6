//! What must hold of any mesh and any rays: the device answers as its twin, bit for bit, as the f64 reference, and that as
//! brute force; and what must not change an answer, doesn't.

#![allow(clippy::unwrap_used)]

use crate::gpu::{gpu, quiet, quiet_on};
use crate::matrix::narrow;
use crate::soup::{Corners, Random, ray, scene};
use crate::trace::{CLOSEST, Traced, assert_same_hits, bits};
use boxwood::abi::{Hit, Ray};
use boxwood::bvh::{Builder, Fit, Recipe};
use boxwood::oracle::brute;
use boxwood::oracle::compare::{Arithmetic, Query, compare};
use boxwood::oracle::reference::Reference;
use boxwood::trace::{Options, Walk};
use proptest::prelude::*;

/// Every builder, and trees with turned boxes wherever those are smaller.
fn recipes() -> Vec<Recipe> {
    let plain = Recipe::default();
    let turned = Recipe { oriented_cost: plain.collapse.node_cost, ..plain };
    let mut recipes: Vec<Recipe> = Builder::ALL.iter().map(|b| Recipe { builder: *b, ..plain }).collect();
    recipes.extend([Fit::Dito(14), Fit::Auto].map(|fit| Recipe { fit, ..turned }));
    recipes
}

fn point<T: std::fmt::Debug>(x: impl Strategy<Value = T> + Clone) -> impl Strategy<Value = [T; 3]> {
    [x.clone(), x.clone(), x]
}

/// Small integers: corners coincide, rays run along edges and planes, ties abound.
fn lattice() -> impl Strategy<Value = f32> + Clone {
    prop_oneof![9 => (-4i8..=4).prop_map(f32::from), 1 => Just(-0.0f32)]
}

/// Any sign and fraction, and an exponent within 2^±6.
fn uneven() -> impl Strategy<Value = f32> + Clone {
    (any::<u32>(), 121u32..133).prop_map(|(word, e)| f32::from_bits(word & 0x807f_ffff | e << 23))
}

/// Triangles at random, on a lattice, of unlike sizes; some of them flat, thin or doubled.
fn meshes() -> impl Strategy<Value = Vec<Corners>> {
    let triangle = prop_oneof![
        3 => prop::array::uniform3(point(lattice())),
        2 => prop::array::uniform3(point(-4f32..4.0)),
        1 => prop::array::uniform3(point(uneven())),
        // Two corners alike; three in a line; as thin as can be.
        1 => [point(lattice()), point(lattice())].prop_map(|[a, b]| [a, b, a]),
        1 => [point(lattice()), point(lattice())].prop_map(|[a, b]| [a, b, std::array::from_fn(|k| 2.0 * b[k] - a[k])]),
        1 => (point(lattice()), point(1f32..4.0)).prop_map(|(a, b)| [a, b, b.map(f32::next_up)]),
    ];
    let soup = prop::collection::vec(triangle, 1..60);
    // A closed or open net of shared vertices: each triangle has an edge of the one before.
    let strip = prop::collection::vec(prop_oneof![point(lattice()), point(-4f32..4.0)], 3..60)
        .prop_map(|points| points.windows(3).map(|w| [w[0], w[1], w[2]]).collect());
    (prop_oneof![soup, strip], 0usize..4).prop_map(|(mut corners, doubled): (Vec<Corners>, usize)| {
        corners.extend_from_within(..doubled.min(corners.len()));
        corners
    })
}

/// Where a mesh and its rays are put: factor, then shift.
fn places() -> impl Strategy<Value = (f32, f32)> {
    prop_oneof![
        2 => Just((1.0, 0.0)),
        2 => (-60i32..60).prop_map(|e| (2f32.powi(e), 0.0)),
        1 => prop::sample::select(vec![0.1f32, 1e-12, 3e7, 1e-30, 1e30]).prop_map(|s| (s, 0.0)),
        1 => prop::sample::select(vec![1.0f32, 1000.0, -3e4]).prop_map(|shift| (1.0, shift)),
    ]
}

/// Rays at vertices, at points of edges and within triangles, along axes through vertices, and at random.
fn rays_at(corners: &[Corners], seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    let mut rays = vec![];
    for i in 0..40 {
        let t = corners[random.below(corners.len())];
        let [p, q, r] = [0, 1, 2].map(|k| t[(k + i) % 3]);
        let share = [0.5, 0.25, random.unit().abs()][random.below(3)];
        let between =
            |p: [f32; 3], q: [f32; 3]| -> [f32; 3] { std::array::from_fn(|k| p[k] + (q[k] - p[k]) * share) };
        let target = [p, between(p, q), between(between(p, q), r)][random.below(3)];
        let origin = match random.below(4) {
            0 => [0, 1, 2].map(|_| random.below(11) as f32 - 5.0),
            1 => corners[random.below(corners.len())][0],
            _ => random.point().map(|x| 8.0 * x),
        };
        rays.push(match i % 4 {
            // Along an axis, through the target.
            0 => {
                let (k, zero) = (random.below(3), [0.0, -0.0][random.below(2)]);
                let (mut origin, mut direction) = (target, [zero; 3]);
                let way = [1.0, -1.0][random.below(2)];
                origin[k] -= way * 16.0;
                direction[k] = way * [1.0, 0.75, 4.0][random.below(3)];
                ray(origin, direction)
            }
            1 if random.below(2) == 0 => ray(origin, random.point()),
            _ => ray(origin, std::array::from_fn(|k| target[k] - origin[k])),
        });
    }
    rays
}

fn placed((scale, shift): (f32, f32), corners: &[Corners], rays: &[Ray]) -> (Vec<Corners>, Vec<Ray>) {
    // 0 of either sign stays what it is.
    let put = |p: [f32; 3]| p.map(|x| if shift == 0.0 { x * scale } else { x + shift });
    let turned = |r: &Ray| Ray { origin: put(r.origin), direction: r.direction.map(|x| x * scale), ..*r };
    (corners.iter().map(|c| c.map(put)).collect(), rays.iter().map(turned).collect())
}

/// 40 of each; more where proptest's own variable says so (`PROPTEST_CASES=5000 cargo test properties::`).
fn cases() -> ProptestConfig {
    let more = std::env::var_os("PROPTEST_CASES").is_some();
    if more { ProptestConfig::default() } else { ProptestConfig::with_cases(40) }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn device_twin_reference_and_brute_force_agree(
        on_narrow in any::<bool>(),
        corners in meshes(),
        place in places(),
        seed in any::<u64>(),
    ) {
        let device = quiet_on(if on_narrow { narrow } else { gpu });
        let (corners, rays) = placed(place, &corners, &rays_at(&corners, seed));
        let scene = scene(&corners);
        let reference = Reference::new(&scene);
        let mut first: Option<Vec<Hit>> = None;
        for recipe in recipes() {
            let what = format!("{:?} {:?}", recipe.builder, recipe.fit);
            let hits = Traced::new(&device, &scene, &recipe).assert_twin(&what, &rays);
            assert_same_hits(&what, &rays, first.get_or_insert_with(|| hits.clone()), &hits);
        }
        let hits = first.unwrap();
        let verdict = compare(&reference, &rays, &hits, Query::Closest, Arithmetic::Exact).sample_brute(&reference, &rays, rays.len());
        prop_assert!(verdict.is_clean(), "{verdict}");
    }

    #[test]
    fn any_bits_are_the_twins(
        words in prop::collection::vec(any::<u32>(), 9..300),
        lines in prop::collection::vec(prop::array::uniform8(any::<u32>()), 1..40),
        on_narrow in any::<bool>(),
    ) {
        let device = quiet_on(if on_narrow { narrow } else { gpu });
        let corners: Vec<Corners> = words
            .chunks_exact(9)
            .map(|w| std::array::from_fn(|c| std::array::from_fn(|k| f32::from_bits(w[3 * c + k]))))
            .collect();
        let scene = scene(&corners);
        let mut rays: Vec<Ray> = lines.iter().map(|w| bytemuck::cast(*w)).collect();
        rays.extend(rays_at(&corners, u64::from(words[0])));
        for recipe in recipes() {
            Traced::new(&device, &scene, &recipe).assert_twin("any bits", &rays);
        }
        let reference = Reference::new(&scene);
        for r in &rays {
            prop_assert_eq!(reference.closest(r), brute::closest(&scene, r));
        }
    }

    #[test]
    fn what_must_not_change_hits_does_not(
        corners in meshes(),
        seed in any::<u64>(),
        exponent in -50i32..50,
        walk in prop::sample::select(Walk::ALL.to_vec()),
        recipe in prop::sample::select(recipes()),
    ) {
        let device = quiet();
        let options = Options { walk, ..CLOSEST };
        let rays = rays_at(&corners, seed);
        let traced = Traced::new(&device, &scene(&corners), &recipe);
        let hits = traced.hits(&rays, options);

        // Triangles in another order: the same ones, or others as near.
        let mut random = Random(seed);
        let mut order: Vec<usize> = (0..corners.len()).collect();
        for i in (1..order.len()).rev() {
            order.swap(i, random.below(i + 1));
        }
        let shuffled: Vec<Corners> = order.iter().map(|i| corners[*i]).collect();
        let others = Traced::new(&device, &scene(&shuffled), &recipe).hits(&rays, options);
        for (i, (hit, other)) in hits.iter().zip(&others).enumerate() {
            // −0 is as near as 0.
            prop_assert_eq!(hit.t, other.t, "ray {}: {:?}: {:?}, {:?}", i, rays[i], hit, other);
            if hit.is_hit() && order[other.triangle as usize] == hit.triangle as usize {
                prop_assert_eq!([hit.u, hit.v].map(f32::to_bits), [other.u, other.v].map(f32::to_bits), "ray {}", i);
            }
        }

        // Mesh and rays times a power of two: the same t where directions grow too, else t times it.
        let scale = 2f32.powi(exponent);
        let (larger, grown) = placed((scale, 0.0), &corners, &rays);
        let traced_larger = Traced::new(&device, &scene(&larger), &recipe);
        assert_same_hits("mesh and rays scaled", &rays, &hits, &traced_larger.hits(&grown, options));
        let as_long: Vec<Ray> = grown.iter().zip(&rays).map(|(g, r)| Ray { direction: r.direction, ..*g }).collect();
        let scaled: Vec<Hit> = hits.iter().map(|h| Hit { t: h.t * scale, ..*h }).collect();
        assert_same_hits("mesh and origins scaled", &rays, &scaled, &traced_larger.hits(&as_long, options));

        // A range that ends at the hit has it yet; one that ends before has not.
        let ended: Vec<Ray> = rays.iter().zip(&hits).map(|(r, h)| Ray { t_max: h.t, ..*r }).collect();
        assert_same_hits("t_max at the hit", &ended, &hits, &traced.hits(&ended, options));
        let before: Vec<Ray> = ended.iter().map(|r| Ray { t_max: r.t_max.next_down(), ..*r }).collect();
        for (i, hit) in traced.hits(&before, options).iter().enumerate() {
            // Of a range that ends at a denormal number the end counts as 0.
            prop_assert!(before[i].t_max.abs() < f32::MIN_POSITIVE || bits(hit) == bits(&Hit::MISS), "{:?}: {hit:?}", before[i]);
        }
    }
}
