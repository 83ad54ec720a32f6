//! The f64 references among themselves: exact signs against integers, the tree against brute force, the judge
//! against doctored hits.

mod signs;

use boxwood::abi::{Hit, INVALID, Ray};
use boxwood::oracle::brute;
use boxwood::oracle::compare::{Arithmetic, Query, compare};
use boxwood::oracle::reference::Reference;
use boxwood::scene::Scene;
use proptest::prelude::*;
use std::fmt::Debug;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

fn point<T: Debug>(x: impl Strategy<Value = T> + Clone) -> impl Strategy<Value = [T; 3]> {
    [x.clone(), x.clone(), x]
}

// ---- the tree against brute force ----------------------------------------------------------

fn soup(corners: &[[[f32; 3]; 3]]) -> Scene {
    let triangles = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Scene { positions: corners.as_flattened().to_vec(), triangles, ..Scene::default() }
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
}

/// Small integers: corners coincide, rays run along edges, planes and box faces, ties abound.
fn lattice() -> impl Strategy<Value = f32> + Clone {
    prop_oneof![(-4i8..=4).prop_map(f32::from), Just(-0.0f32)]
}

fn assert_same(scene: &Scene, rays: &[Ray]) {
    let reference = Reference::new(scene);
    let all = reference.closest_all(rays, None);
    for (i, r) in rays.iter().enumerate() {
        let truth = brute::closest(scene, r);
        let shown: [f32; 8] = bytemuck::cast(*r);
        assert_eq!(reference.closest(r), truth, "ray {i}: {shown:?}");
        assert_eq!(all[i], truth, "ray {i} of the batch: {shown:?}");
        assert_eq!(reference.any(r), truth.is_some(), "any hit, ray {i}: {shown:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn tree_is_brute_on_lattices(
        corners in prop::collection::vec(prop::array::uniform3(point(lattice())), 0..60),
        lines in prop::collection::vec([point(lattice()), point(lattice())], 1..30),
        range in (-3i8..3, 0i8..4),
        scale in prop::sample::select(vec![1.0f32, 1e-30, 1e30, f32::MIN_POSITIVE]),
        shift in prop::sample::select(vec![0.0f32, 1e7]),
    ) {
        // Scaled and moved together; a shift by 1e7 keeps integers exact.
        let place = |v: [f32; 3]| v.map(|x| if shift == 0.0 { x * scale } else { x + shift });
        let scene = soup(&corners.iter().map(|t| t.map(place)).collect::<Vec<_>>());
        let rays: Vec<Ray> = lines.iter().map(|&[o, d]| Ray {
            t_min: f32::from(range.0), t_max: f32::from(range.0 + range.1), ..ray(place(o), d.map(|x| x * scale))
        }).collect();
        assert_same(&scene, &rays);
    }

    #[test]
    fn tree_is_brute_on_soups(
        corners in prop::collection::vec(prop::array::uniform3(point(-1f32..1.0)), 0..200),
        lines in prop::collection::vec([point(-2f32..2.0), point(-1f32..1.0)], 1..30),
    ) {
        let rays: Vec<Ray> = lines.iter().map(|&[o, d]| ray(o, d)).collect();
        assert_same(&soup(&corners), &rays);
    }

    #[test]
    fn tree_is_brute_on_any_floats(
        corners in prop::collection::vec(prop::array::uniform3(point(any::<u32>().prop_map(f32::from_bits))), 0..40),
        lines in prop::collection::vec(prop::array::uniform8(any::<u32>().prop_map(f32::from_bits)), 1..20),
    ) {
        assert_same(&soup(&corners), &lines.iter().map(|&r| bytemuck::cast(r)).collect::<Vec<Ray>>());
    }
}

#[test]
fn axis_rays_with_either_zero_graze_box_faces() {
    let mut corners = vec![];
    for i in 0..64 {
        let (x, y, z) = ((i % 4) as f32, (i / 4 % 4) as f32, (i / 16) as f32);
        corners.push([[x, y, z], [x + 1.0, y, z], [x, y + 1.0, z]]);
        corners.push([[x, y, z], [x, y + 1.0, z], [x, y, z + 1.0]]);
    }
    let mut rays = vec![];
    for (axis, sign, zero) in [0, 1, 2]
        .into_iter()
        .flat_map(|a| [(a, 1.0, 0.0f32), (a, -1.0, 0.0), (a, 1.0, -0.0), (a, -1.0, -0.0)])
    {
        for i in 0..81 {
            let mut origin = [(i % 9) as f32 * 0.5; 3];
            origin[(axis + 1) % 3] = (i / 9) as f32 * 0.5;
            origin[axis] = -9.0 * sign;
            let mut direction = [zero; 3];
            direction[axis] = sign;
            rays.push(ray(origin, direction));
        }
    }
    let scene = soup(&corners);
    assert_same(&scene, &rays);
    assert!(rays.iter().filter(|r| brute::any(&scene, r)).count() > 200);
}

#[test]
fn degenerate_scenes_stay_cheap() {
    let one = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let down = ray([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
    let first =
        |corners: Vec<[[f32; 3]; 3]>| Reference::new(&soup(&corners)).closest(&down).map(|h| h.triangle);
    assert_eq!(first(vec![]), None);
    assert_eq!(first(vec![one]), Some(0));
    assert_eq!(first(vec![[[1.0; 3]; 3]; 100_000]), None, "points");
    let same = soup(&vec![one; 100_000]);
    let reference = Reference::new(&same);
    // Quadratic would be 1e10 tests here.
    let hits = reference.closest_all(&vec![down; 100_000], None);
    assert!(hits.iter().all(|h| h.is_some_and(|h| h.triangle == 0)));
    // Each triangle half the size of the one before, down to the last denormal: splits peel off a few at a time.
    let nested: Vec<_> = (0..20_000)
        .map(|i| one.map(|c| c.map(|x: f32| x * 2f32.powi(100 - i % 240) * (1.0 + i as f32 * 1e-5))))
        .collect();
    assert_eq!(first(nested), brute::closest(&soup(&[one]), &down).map(|h| h.triangle));
    // One centre, all different.
    let concentric: Vec<_> = (1..=50_000)
        .map(|i| {
            let s = i as f32;
            [[-s, -s, 0.0], [s, -s, 0.0], [0.0, s, 0.0]]
        })
        .collect();
    assert_eq!(first(concentric), Some(0));
}

// ---- closed surfaces -----------------------------------------------------------------------

/// A sphere of `rings` × 2 `rings` quads with shared vertices, closed at the poles.
fn sphere(rings: u32, centre: [f32; 3], radius: f64) -> Scene {
    use std::f64::consts::PI;
    let around = 2 * rings;
    let at = |ring: u32, i: u32| {
        let (theta, phi) = (PI * ring as f64 / rings as f64, PI * i as f64 / rings as f64);
        let unit = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
        std::array::from_fn(|k| (f64::from(centre[k]) + radius * unit[k]) as f32)
    };
    let mut scene = Scene { positions: vec![at(0, 0), at(rings, 0)], ..Scene::default() };
    let index = |ring: u32, i: u32| match ring {
        0 => 0,
        r if r == rings => 1,
        r => 2 + (r - 1) * around + i % around,
    };
    for ring in 1..rings {
        scene.positions.extend((0..around).map(|i| at(ring, i)));
    }
    for ring in 0..rings {
        for i in 0..around {
            let [a, b, c, d] =
                [index(ring, i), index(ring + 1, i), index(ring + 1, i + 1), index(ring, i + 1)];
            scene.triangles.extend(
                [[a, b, c], [a, c, d]].into_iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[0] != t[2]),
            );
        }
    }
    scene
}

/// From `origin` at every vertex, and at three points of every edge, of a closed mesh around it.
fn aimed(scene: &Scene, origin: [f32; 3]) -> Vec<Ray> {
    let toward = |p: [f32; 3]| ray(origin, std::array::from_fn(|k| p[k] - origin[k]));
    let mut rays: Vec<Ray> = scene.positions.iter().map(|&p| toward(p)).collect();
    for t in 0..scene.triangles.len() {
        let [a, b, c] = scene.corners(t);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            rays.extend([0.25, 0.5, 0.7].map(|s| toward(std::array::from_fn(|k| p[k] + (q[k] - p[k]) * s))));
        }
    }
    rays
}

#[test]
fn closed_surfaces_leak_nowhere() {
    for (centre, radius) in [([0.0; 3], 1.0), ([1e3, -2e3, 5e2], 1.0), ([0.0; 3], 1e-30), ([0.0; 3], 1e30)] {
        let scene = sphere(24, centre, radius);
        let reference = Reference::new(&scene);
        for off in [0.0, 0.3] {
            let origin =
                std::array::from_fn(|k| (f64::from(centre[k]) + off * radius * (k as f64 - 1.0)) as f32);
            let rays = aimed(&scene, origin);
            let missed = rays.iter().filter(|r| !reference.any(r)).count();
            assert_eq!(missed, 0, "of {} rays, sphere at {centre:?} of radius {radius:e}", rays.len());
        }
    }
}

// ---- the judge -----------------------------------------------------------------------------

fn answers(reference: &Reference, rays: &[Ray]) -> Vec<Hit> {
    reference.closest_all(rays, None).into_iter().map(Hit::from).collect()
}

/// Rays from inside and beside a sphere of 2208 triangles: a third of them miss.
fn judged() -> (Scene, Vec<Ray>) {
    let rays = (0..3000).map(|i| {
        let angle = i as f32 * 2.399;
        let z = (i as f32 + 0.5) / 1500.0 - 1.0;
        let r = (1.0 - z * z).sqrt();
        ray([if i % 3 == 0 { 5.0 } else { 0.1 }, 0.05, -0.02], [r * angle.cos(), r * angle.sin(), z])
    });
    (sphere(24, [0.0; 3], 1.0), rays.collect())
}

#[test]
fn honest_hits_are_clean() {
    let (scene, rays) = judged();
    let reference = Reference::new(&scene);
    let verdict =
        compare(&reference, &rays, &answers(&reference, &rays), Query::Closest, Arithmetic::Rounded)
            .sample_brute(&reference, &rays, 50);
    assert!(verdict.is_clean() && verdict.examples.is_empty(), "{verdict}");
    assert_eq!((verdict.rays, verdict.ties), (3000, 0));
    assert!(
        verdict.hits >= 2000 && verdict.t_error_ulps.max <= 0.51 && verdict.weight_error_max < 1e-7,
        "{verdict}"
    );
    assert_eq!(verdict.brute.map(|b| (b.rays, b.disagreements)), Some((50, 0)));
    let json = serde_json::to_value(&verdict).map(|json| json["missed_stable"] == 0);
    assert!(matches!(json, Ok(true)), "{json:?}");
}

#[test]
fn doctored_hits_are_counted_one_by_one() {
    let (scene, rays) = judged();
    let reference = Reference::new(&scene);
    let mut hits = answers(&reference, &rays);
    let hit: Vec<usize> = (0..rays.len()).filter(|&i| hits[i].is_hit()).collect();
    let miss: Vec<usize> = (0..rays.len()).filter(|&i| i % 3 == 0 && !hits[i].is_hit()).collect();
    let far = |i: u32| (i + scene.triangles.len() as u32 / 2) % scene.triangles.len() as u32;
    for &i in &hit[..3] {
        hits[i] = Hit::MISS;
    }
    for &i in &miss[..4] {
        hits[i] = Hit { t: 3.0, triangle: 7, u: 0.2, v: 0.2 };
    }
    for &i in &hit[10..15] {
        hits[i].t *= 1.01;
    }
    for &i in &hit[20..26] {
        hits[i].triangle = far(hits[i].triangle);
    }
    hits[hit[30]].t = f32::NAN;
    hits[hit[31]].triangle = scene.triangles.len() as u32;
    hits[hit[32]].triangle = INVALID;
    hits[hit[33]].u = -0.5;
    hits[hit[34]].t = -1.0;
    hits[miss[30]].triangle = 0;
    let v = compare(&reference, &rays, &hits, Query::Closest, Arithmetic::Rounded);
    assert_eq!(
        (v.missed, v.false_hits, v.leaked, v.wrong_triangle, v.malformed, v.ties),
        (3, 4, 5, 6, 6, 0),
        "{v}"
    );
    assert_eq!(
        (v.missed_stable, v.false_stable, v.leaked_stable, v.wrong_triangle_stable),
        (3, 4, 5, 6),
        "{v}"
    );
    assert!(!v.is_clean() && v.examples.len() == 5 && v.to_string().starts_with("FAULTY"), "{v}");
    let short =
        compare(&reference, &rays, &answers(&reference, &rays)[..2990], Query::Closest, Arithmetic::Rounded);
    assert_eq!((short.malformed, short.rays), (10, 2990));
}

#[test]
fn any_hit_is_judged_by_occlusion_alone() {
    let (scene, rays) = judged();
    let reference = Reference::new(&scene);
    let occluded = Hit { t: 0.0, ..Hit::MISS };
    let mut hits: Vec<Hit> =
        rays.iter().map(|r| if reference.any(r) { occluded } else { Hit::MISS }).collect();
    let verdict = compare(&reference, &rays, &hits, Query::Any, Arithmetic::Rounded);
    assert!(verdict.is_clean() && verdict.examples.is_empty(), "{verdict}");
    let hit: Vec<usize> = (0..rays.len()).filter(|&i| hits[i].is_hit()).collect();
    let miss: Vec<usize> = (0..rays.len()).filter(|&i| i % 3 == 0 && !hits[i].is_hit()).collect();
    hits[hit[0]] = Hit::MISS;
    hits[hit[1]].t = 0.5;
    hits[miss[0]] = occluded;
    hits[miss[1]] = occluded;
    let v = compare(&reference, &rays, &hits, Query::Any, Arithmetic::Rounded);
    assert_eq!((v.missed_stable, v.false_stable, v.malformed), (1, 2, 1), "{v}");
}

#[test]
fn ties_and_grazes_are_no_faults() {
    // Two copies of a square, one in front of nothing but the other: four triangles, all at t = 1.
    let square = [
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
        [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
    ];
    let scene = soup(&[square[0], square[1], square[0], square[1]]);
    let reference = Reference::new(&scene);
    let down = |x: f32, y: f32| ray([x, y, 1.0], [0.0, 0.0, -1.0]);
    let hit = |triangle, u, v| Hit { t: 1.0, triangle, u, v };
    // The copy; the neighbour across the diagonal from just beside it; beside the outline, either answer.
    let rays = [
        down(0.75, 0.25),
        down(0.5, 0.5f32.next_down()),
        down(1.0, 0.5),
        down(1.0f32.next_up(), 0.5),
        down(0.75, 0.25),
    ];
    let hits = [hit(2, 0.5, 0.25), hit(1, 0.5, 0.0), Hit::MISS, hit(0, 0.5, 0.5), hit(1, 0.1, 0.1)];
    let v = compare(&reference, &rays, &hits, Query::Closest, Arithmetic::Rounded);
    assert_eq!((v.ties, v.missed, v.missed_stable, v.false_hits, v.false_stable), (2, 1, 0, 1, 0), "{v}");
    assert_eq!((v.wrong_triangle, v.wrong_triangle_stable), (1, 1), "{v}");
    assert_eq!(v.examples.first().map(|e| e.ray), Some(4), "stable faults come first");
    // A hit at the very end of the range, which f32 may put on either side.
    let end = [Ray { t_max: 1.0, ..down(0.75, 0.25) }, Ray { t_max: 1.0f32.next_down(), ..down(0.75, 0.25) }];
    let v = compare(&reference, &end, &[Hit::MISS, Hit::MISS], Query::Closest, Arithmetic::Rounded);
    assert_eq!((v.missed, v.missed_stable), (1, 0), "{v}");
}

#[test]
fn progress_counts_every_ray() {
    let (scene, rays) = judged();
    let rays = rays.repeat(5);
    let done = AtomicUsize::new(0);
    let count = |n: usize| {
        done.fetch_add(n, Relaxed);
    };
    Reference::new(&scene).closest_all(&rays, Some(&count));
    assert_eq!(done.into_inner(), rays.len());
}
