//! Scenes for tests: random, regular and nasty ones, the same on every run.

use boxwood::abi::Ray;
use boxwood::scene::{Options, Progress, Scene, open};

pub type Corners = [[f32; 3]; 3];

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }
    /// From −1 to 1.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }
    pub fn point(&mut self) -> [f32; 3] {
        [self.unit(), self.unit(), self.unit()]
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
}

/// Triangles that share no vertex.
pub fn scene(corners: &[Corners]) -> Scene {
    let triangles = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Scene { positions: corners.as_flattened().to_vec(), triangles, ..Scene::default() }
}

/// `n` triangles of edge about `size` in a cube of edge 2.
pub fn random(n: usize, size: f32, seed: u64) -> Vec<Corners> {
    let mut random = Random(seed);
    let mut triangle = || {
        let at = random.point();
        [(); 3].map(|()| {
            let step = random.point();
            std::array::from_fn(|k| at[k] + size * step[k])
        })
    };
    (0..n).map(|_| triangle()).collect()
}

/// `n` triangles on an 8 × 8 × 8 grid: few codes, many equal boxes, ±0 coordinates.
pub fn grid(n: usize) -> Vec<Corners> {
    let at = |i: usize| [i % 8, i / 8 % 8, i / 64 % 8].map(|x| x as f32 / 4.0 - 1.0);
    let triangle = |i| {
        let [x, y, z] = at(i);
        [[x, y, z], [x + 0.25, y, z], [x, y + 0.25, -z * 0.0 + z]]
    };
    (0..n).map(triangle).collect()
}

/// A generated scene by its name.
pub fn named(spec: &str) -> Scene {
    let options = Options { progress: Progress::Quiet, cache: None };
    #[allow(clippy::unwrap_used)]
    open(spec, &options).unwrap()
}

/// Each corner moved by `f`.
pub fn moved(corners: &[Corners], f: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<Corners> {
    corners.iter().map(|c| c.map(&f)).collect()
}

/// A ray without limits.
pub fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
}

/// `n` rays from a cube of edge 4 in all directions.
pub fn random_rays(n: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    (0..n).map(|_| ray(random.point().map(|x| 2.0 * x), random.point())).collect()
}

/// A closed sphere with shared vertices: `rings` × 2 `rings` quads.
pub fn sphere(rings: u32, centre: [f32; 3], radius: f64) -> Scene {
    use std::f64::consts::PI;
    let around = 2 * rings;
    let at = |ring: u32, i: u32| {
        let (theta, phi) = (PI * f64::from(ring) / f64::from(rings), PI * f64::from(i) / f64::from(rings));
        let unit = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
        std::array::from_fn(|k| (f64::from(centre[k]) + radius * unit[k]) as f32)
    };
    let index = |ring: u32, i: u32| match ring {
        0 => 0,
        r if r == rings => 1,
        r => 2 + (r - 1) * around + i % around,
    };
    let mut scene = Scene { positions: vec![at(0, 0), at(rings, 0)], ..Scene::default() };
    for ring in 1..rings {
        scene.positions.extend((0..around).map(|i| at(ring, i)));
    }
    for ring in 0..rings {
        for i in 0..around {
            let [a, b, c, d] =
                [index(ring, i), index(ring + 1, i), index(ring + 1, i + 1), index(ring, i + 1)];
            let whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[0] != t[2];
            scene.triangles.extend([[a, b, c], [a, c, d]].into_iter().filter(whole));
        }
    }
    scene
}

/// From `origin` at every vertex of a mesh, and at three points of every edge.
pub fn aimed(scene: &Scene, origin: [f32; 3]) -> Vec<Ray> {
    let toward = |p: [f32; 3]| ray(origin, std::array::from_fn(|k| p[k] - origin[k]));
    let mut rays: Vec<Ray> = scene.positions.iter().map(|p| toward(*p)).collect();
    for t in 0..scene.triangles.len() {
        let [a, b, c] = scene.corners(t);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            rays.extend([0.25, 0.5, 0.7].map(|s| toward(std::array::from_fn(|k| p[k] + (q[k] - p[k]) * s))));
        }
    }
    rays
}
