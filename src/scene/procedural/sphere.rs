//! A displaced sphere, exactly closed: a scanned statue's even, small triangles at any size.
//! A cube's surface lattice is blown up; shared lattice points are one vertex, made from its integer place alone.

use glam::DVec3;
use rayon::prelude::*;

use super::noise::{fbm, ridged};
use super::zeros;
use crate::scene::{Camera, Progress, Scene, SceneError};

const SEED: u32 = 0xD2A6;

/// The 12 n² triangles nearest to `count`.
pub(super) fn generate(name: &str, count: u64, progress: Progress) -> Result<Scene, SceneError> {
    let lattice = Lattice { n: edge(count) };
    let n = lattice.n as usize;
    let mut positions = zeros::<[f32; 3]>(name, 6 * n * n + 2)?;
    let mut triangles = zeros::<[u32; 3]>(name, 12 * n * n)?;
    let bar = progress.count(format!("generating {name}"), positions.len() as u64);
    positions.par_chunks_mut(4096).enumerate().for_each(|(c, chunk)| {
        for (i, p) in chunk.iter_mut().enumerate() {
            *p = lattice.position(lattice.point((c * 4096 + i) as u32));
        }
        bar.inc(chunk.len() as u64);
    });
    triangles.par_chunks_mut(2 * n).enumerate().for_each(|(row, chunk)| {
        for (column, pair) in chunk.chunks_exact_mut(2).enumerate() {
            lattice.quad((row / n) as u32, (row % n) as u32, column as u32, pair);
        }
    });
    bar.finish_and_clear();
    let camera = Camera { eye: [1.8, 1.4, 2.7], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y: 45.0 };
    Ok(Scene { name: name.to_owned(), positions, triangles, views: vec![camera], ..Scene::default() })
}

/// The edge whose 12 n² is nearest to `count`, at least 1.
fn edge(count: u64) -> u32 {
    let off = |n: u64| (12 * n * n).abs_diff(count);
    let guess = (count / 12).isqrt();
    let best = if off(guess + 1) < off(guess) { guess + 1 } else { guess };
    best.max(1) as u32
}

/// The surface points of an n × n × n lattice, numbered: the layer z = 0, the outlines between, the layer z = n.
struct Lattice {
    n: u32,
}

impl Lattice {
    /// Number of the point (x, y, z), each 0..=n, one of them 0 or n.
    fn number(&self, [x, y, z]: [u32; 3]) -> u32 {
        let n = self.n;
        let (layer, outline) = ((n + 1) * (n + 1), 4 * n);
        if z == 0 {
            return y * (n + 1) + x;
        }
        if z == n {
            return layer + (n - 1) * outline + y * (n + 1) + x;
        }
        let along = match (x, y) {
            (x, 0) if x < n => x,
            (x, y) if x == n && y < n => n + y,
            (x, y) if y == n && x > 0 => 2 * n + (n - x),
            (_, y) => 3 * n + (n - y),
        };
        layer + (z - 1) * outline + along
    }

    /// The point of a number.
    fn point(&self, number: u32) -> [u32; 3] {
        let n = self.n;
        let (layer, outline) = ((n + 1) * (n + 1), 4 * n);
        if number < layer {
            return [number % (n + 1), number / (n + 1), 0];
        }
        let rest = number - layer;
        if rest >= (n - 1) * outline {
            let rest = rest - (n - 1) * outline;
            return [rest % (n + 1), rest / (n + 1), n];
        }
        let (z, along) = (1 + rest / outline, rest % outline);
        match along / n {
            0 => [along, 0, z],
            1 => [n, along - n, z],
            2 => [3 * n - along, n, z],
            _ => [0, 4 * n - along, z],
        }
    }

    /// Where a point ends up.
    fn position(&self, point: [u32; 3]) -> [f32; 3] {
        let n = f64::from(self.n);
        let c = DVec3::from_array(point.map(|i| (2.0 * f64::from(i) - n) / n));
        let s = c * c;
        // Cube to sphere with nearly even cells (P. Nowell's map): each coordinate shrinks by the other two.
        let shrink = |a: f64, b: f64| (1.0 - a / 2.0 - b / 2.0 + a * b / 3.0).sqrt();
        let p = DVec3::new(c.x * shrink(s.y, s.z), c.y * shrink(s.z, s.x), c.z * shrink(s.x, s.y));
        let r = 1.0
            + 0.2 * fbm(p * 1.7, 4, SEED)
            + 0.04 * (ridged(p * 7.0, 3, SEED + 8) - 1.0)
            + 0.004 * fbm(p * 60.0, 3, SEED + 16);
        // Kept off the centre, so that the surface never turns inside out.
        (p * r.max(0.2)).as_vec3().to_array()
    }

    /// The two triangles of a cell of one of six faces, outside anticlockwise.
    fn quad(&self, face: u32, row: u32, column: u32, pair: &mut [[u32; 3]]) {
        let n = self.n;
        let axis = (face % 3) as usize;
        let far = face >= 3;
        let corner = |du: u32, dv: u32| {
            let mut p = [0; 3];
            p[axis] = if far { n } else { 0 };
            p[(axis + 1) % 3] = column + du;
            p[(axis + 2) % 3] = row + dv;
            self.number(p)
        };
        let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
        let [b, d] = if far { [b, d] } else { [d, b] };
        pair[0] = [a, b, c];
        pair[1] = [a, c, d];
    }
}
