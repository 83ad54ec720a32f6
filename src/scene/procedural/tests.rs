//! Generated scenes: pinned, of the promised size, sound, and alike on any number of threads.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use sha2::{Digest, Sha256};

use super::Generator::*;
use super::assembly::{Pen, Run, Size, assemble, total};
use super::*;
use crate::abi::Aabb;
use crate::scene::Camera;

fn digest(scene: &Scene) -> String {
    let mut sha = Sha256::new();
    sha.update(bytemuck::cast_slice(&scene.positions));
    sha.update(bytemuck::cast_slice(&scene.triangles));
    sha.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect()
}

/// Asked for, got, first half of the SHA-256 of positions and triangles. A change here changes every result.
const PINNED: &[(Generator, u64, usize, &str)] = &[
    (Hairball, 1, 8, "3668b7dea4e1f8f3"),
    (Hairball, 10_000, 10_000, "6024021b244324ec"),
    (City, 1, 228, "aed162b6ec233e48"),
    (City, 10_000, 9_844, "03e9fd58619b9807"),
    (City, 200_000, 201_260, "5a5155c6867c4f7c"),
    (CityRotated, 10_000, 9_844, "5165ea0e8beb6534"),
    (Sphere, 1, 12, "342265177f7cae9b"),
    (Sphere, 10_000, 10_092, "1c6d9f52d44a69ee"),
    (Tree, 1, 2, "ae69bc9ff38def5c"),
    (Tree, 10_000, 10_000, "12fb8962778d4031"),
    (Tree, 400_000, 400_000, "09350b268b3abe3c"),
    (Tree, 314_148, 314_148, "84a6dc94c61218e1"),
    (PowerPlant, 1, 44, "4b0a7d6ec21cc8d3"),
    (PowerPlant, 10_000, 9_992, "63647408ee606bad"),
    (PowerPlant, 300_000, 300_008, "638d900ed8e800a5"),
    (Conference, 1, 12, "a95acf19aedd60b4"),
    (Conference, 10_000, 10_004, "f3bd7fcf36f1d42b"),
    (Conference, 400_000, 400_000, "f42e5168e3df85ad"),
    (Conference, 336_668, 336_668, "0adb7367f1f79aef"),
    (Crown, 1, 24, "2a2be412a8d9a741"),
    (Crown, 10_000, 10_000, "3a28e2363f27a650"),
    (Crown, 300_000, 299_992, "3fdf020d60aa42cd"),
    (DragonLike, 1, 18, "761d4dfa750ba19c"),
    (DragonLike, 10_000, 9_996, "8862f990956cbbdb"),
    (DragonLike, 200_000, 200_064, "ecba648c9edd4eb9"),
    (DragonLike, 872_000, 872_000, "6a1bd8c4cf63499c"),
    (Pipes, 1, 32, "3549860acab0c175"),
    (Pipes, 10_000, 10_016, "e98aa015bdf6b2a4"),
    (Pipes, 200_000, 200_000, "962acdc21a5214d2"),
    (Soup, 1, 1, "384b112ab34bfbf4"),
    (Soup, 10_000, 10_000, "02e38286ac415695"),
    (Soup, 200_000, 200_000, "85b18215a176b39f"),
];

fn generate(g: Generator, n: u64) -> Scene {
    g.generate(g.name(), n, Progress::Quiet).unwrap()
}

/// Twice the area, and the longest edge's square.
fn area(corners: [[f32; 3]; 3]) -> (f64, f64) {
    let [a, b, c] = corners.map(|p| DVec3::from_array(p.map(f64::from)));
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    ((b - a).cross(c - a).length(), longest)
}

#[test]
fn pinned() {
    let got: Vec<_> = PINNED
        .iter()
        .map(|&(g, n, _, _)| {
            let s = generate(g, n);
            assert!(s.positions.iter().flatten().all(|x| x.is_finite()), "{g:?}:{n}");
            let used: HashSet<u32> = s.triangles.iter().flatten().copied().collect();
            assert_eq!(used.len(), s.positions.len(), "{g:?}:{n}: vertices unused");
            assert!(used.iter().all(|&v| (v as usize) < s.positions.len()), "{g:?}:{n}");
            assert!(!s.views.is_empty());
            // Rounding to f32 leaves some area to every triangle.
            let flat = (0..s.triangles.len()).filter(|&i| area(s.corners(i)).0 == 0.0).count();
            assert_eq!(flat, 0, "{g:?}:{n}: triangles of no area");
            (g, n, s.triangles.len(), digest(&s))
        })
        .collect();
    let want: Vec<_> = PINNED.iter().map(|&(g, n, t, d)| (g, n, t, d.to_owned())).collect();
    assert_eq!(got, want);
}

#[test]
fn one_thread_gives_the_same_bits() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for &g in Generator::ALL {
        let (many, one) = (generate(g, 30_000), pool.install(|| generate(g, 30_000)));
        assert_eq!(digest(&many), digest(&one), "{g:?}");
    }
}

/// Half a grain, and the runs, of the generators that draw objects.
type Drawn = (Generator, u64, fn(u64) -> Vec<Run>);
const DRAWN: [Drawn; 5] = [
    (Tree, 1, tree::runs),
    (PowerPlant, 22, power_plant::runs),
    (Conference, 6, conference::runs),
    (Crown, 12, crown::runs),
    (Pipes, 16, pipes::runs),
];

#[test]
fn whole_scenes_have_the_recipes_counts() {
    let counts = [314_148, 12_698_880, 336_668, 3_520_512, 1_000_000];
    for ((g, _, runs), count) in DRAWN.into_iter().zip(counts) {
        assert_eq!(g.full_size(), count);
        assert_eq!(total(&runs(count)).triangles as u64, count, "{g:?}");
        assert_eq!(total(&runs(3 * count)).triangles as u64, 3 * count, "three of {g:?}");
    }
    assert!(PINNED.iter().any(|p| p.0 == DragonLike && p.1 == 872_000 && p.2 == 872_000));
    assert_eq!(DragonLike.full_size(), 872_000);
}

#[test]
fn counts_are_near() {
    for (g, half, runs) in DRAWN {
        let sizes =
            (1..4000u64).map(|n| 3 * n).chain((0..500).map(|k| 12_000 + 2_147_459 * k)).chain([1 << 30]);
        for n in sizes {
            let got = total(&runs(n)).triangles as u64;
            let smallest = PINNED.iter().find(|p| p.0 == g).unwrap().2 as u64;
            assert!(got.abs_diff(n) <= half || got == smallest && n < got, "{g:?}:{n} gave {got}");
        }
    }
    for &g in Generator::ALL {
        for n in [50_000, 100_000, 300_000] {
            let got = generate(g, n).triangles.len() as f64;
            assert!((got / n as f64 - 1.0).abs() < 0.02, "{g:?}:{n} gave {got}");
        }
    }
}

/// Euler's number and six times the volume of a surface in which every edge has its opposite. Vertices are alike where
/// their positions are.
fn closed(s: &Scene) -> (i64, f64) {
    let mut numbers = HashMap::new();
    let mut number = |p: [f32; 3]| {
        let next = numbers.len();
        *numbers.entry(p.map(|x| (x + 0.0).to_bits())).or_insert(next)
    };
    let faces: Vec<[usize; 3]> = (0..s.triangles.len()).map(|i| s.corners(i).map(&mut number)).collect();
    let mut edges = HashSet::new();
    for t in &faces {
        for k in 0..3 {
            assert!(edges.insert((t[k], t[(k + 1) % 3])), "edge of {t:?} twice");
        }
    }
    assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "an edge without its opposite");
    let volume = (0..s.triangles.len()).map(|i| {
        let [a, b, c] = s.corners(i).map(|p| DVec3::from_array(p.map(f64::from)));
        a.dot(b.cross(c))
    });
    (numbers.len() as i64 + faces.len() as i64 - edges.len() as i64 / 2, volume.sum())
}

#[test]
fn nothing_lies_far_below_the_ground() {
    for (g, n, least) in [
        (Tree, 314_148, -0.5),
        (Tree, 3_000_000, -0.5),
        (PowerPlant, 100_000, -8.0),
        (Conference, 700_000, -0.02),
    ] {
        let low = generate(g, n).bounds().lo[1];
        assert!(low >= least, "{g:?}:{n}: {low}");
    }
}

#[test]
fn scanned_surfaces_are_closed() {
    for n in [1, 48, 108, 5000] {
        let (euler, volume) = closed(&generate(Sphere, n));
        assert!(euler == 2 && volume > 0.0, "sphere:{n}: {euler}, {volume}");
    }
    for n in [1, 100, 5000, 100_000] {
        let (euler, volume) = closed(&generate(DragonLike, n));
        assert_eq!(euler, 0, "dragon-like:{n}");
        // At its tiniest it is a flat loop of three.
        assert!(volume > 0.0 || n < 100, "dragon-like:{n}: {volume}");
    }
}

/// One object as a scene.
fn drawn(size: Size, draw: fn(&mut Pen)) -> Scene {
    let run = Run::new(1, size, move |_, pen| draw(pen));
    let camera = Camera::default_for(&Aabb { lo: [0.0; 3], hi: [1.0; 3] });
    assemble("one", &[run], camera, Progress::Quiet).unwrap()
}

#[test]
fn solid_shapes_are_closed() {
    use shapes::*;
    let solids = [
        (drawn(CUBOID, |pen| cuboid(pen, DVec3::new(-1.0, 0.0, 2.0), DVec3::new(0.5, 1.0, 2.5))), 4.5),
        (drawn(cylinder_size(24), |pen| cylinder(pen, 1.0, [0.0, 1.0], 24)), 18.6),
        (drawn(I_BEAM, |pen| i_beam(pen, [DVec3::X, DVec3::X + DVec3::Y], 0.5, 1.0)), 0.782),
        (drawn(I_BEAM, |pen| i_beam(pen, [DVec3::ZERO, DVec3::new(0.0, 0.6, 0.8)], 0.5, 1.0)), 0.782),
        (drawn(cushion_size(32, 20), |pen| cushion(pen, DVec3::ONE, 32, 20)), 38.5),
        (drawn(icosphere_size(8), |pen| icosphere(pen, 8)), 24.8),
        (drawn(crown::gem::SIZE, crown::gem::brilliant), 9.8),
    ];
    for (i, (s, want)) in solids.iter().enumerate() {
        let (euler, volume) = closed(s);
        assert!(euler == 2 && (volume / want - 1.0).abs() < 0.03, "solid {i}: {euler}, {volume}");
    }
}
