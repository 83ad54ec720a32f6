//! A city of cubes, as in Rungholt (6.7 million triangles): every face between solid and air, none merged.
//! Small integer coordinates make equal centroids, equal keys and equal costs; turned by 45° about each axis, the same
//! triangles fill their boxes badly.

use rayon::prelude::*;

use super::zeros;
use crate::scene::{Camera, Progress, Scene, SceneError};

mod plan;

use plan::{COLUMN_BITS, PLOT};

/// Triangles a column, over many plots; only a first guess. Measured at 10^6.
const DENSITY: f64 = 18.8;

/// How the city stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pose {
    /// On the axes.
    Upright,
    /// Turned by Rz(45°) Ry(45°) Rx(45°).
    Rotated,
}

impl Pose {
    fn turn(self, p: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = p;
        // Both the sine and the cosine of 45°.
        let h = 0.5f64.sqrt();
        match self {
            Self::Upright => p,
            Self::Rotated => {
                let (y, z) = (h * (y - z), h * (y + z));
                let (x, z) = (h * (x + z), h * (z - x));
                [h * (x - y), h * (x + y), z]
            }
        }
    }
}

/// About `n` triangles, to the nearest row of cubes; the smallest city is one column.
pub(super) fn generate(name: &str, n: u64, pose: Pose, progress: Progress) -> Result<Scene, SceneError> {
    let mut width = ((n as f64 / DENSITY).sqrt() as usize).max(1);
    let (grid, depth) = loop {
        let grid = Grid::new(name, width, width + width / 2 + 2)?;
        if let Some(depth) = grid.depth_for(n) {
            break (grid, depth);
        }
        width += width / 8 + 1; // a sparse corner of the city: try a wider one
    };
    let grid = Grid { depth, ..grid };
    let counts: Vec<usize> = (0..depth).into_par_iter().map(|z| grid.row_faces(z, depth)).collect();
    let faces: usize = counts.iter().sum();
    let mut positions = zeros::<[f32; 3]>(name, 4 * faces)?;
    let mut triangles = zeros::<[u32; 3]>(name, 2 * faces)?;
    let bar = progress.count(format!("generating {name}"), faces as u64);
    let mut rows = Vec::with_capacity(depth);
    let (mut p, mut t, mut first) = (&mut positions[..], &mut triangles[..], 0);
    for &count in &counts {
        let (row_p, rest_p) = p.split_at_mut(4 * count);
        let (row_t, rest_t) = t.split_at_mut(2 * count);
        rows.push((first, row_p, row_t));
        (p, t) = (rest_p, rest_t);
        first += 4 * count;
    }
    rows.into_par_iter().enumerate().for_each(|(z, (first, p, t))| {
        grid.emit(z, pose, p);
        for (i, pair) in t.chunks_exact_mut(2).enumerate() {
            let v = (first + 4 * i) as u32;
            pair[0] = [v, v + 1, v + 2];
            pair[1] = [v, v + 2, v + 3];
        }
        bar.inc(t.len() as u64 / 2);
    });
    bar.finish_and_clear();
    let views = vec![camera(width, depth, pose)];
    Ok(Scene { name: name.to_owned(), positions, triangles, views, ..Scene::default() })
}

/// From above one corner, turned with the city: the same rays meet the same faces in either pose.
fn camera(width: usize, depth: usize, pose: Pose) -> Camera {
    let (w, d) = (width as f64, depth as f64);
    let turned = |p| pose.turn(p).map(|x| x as f32);
    Camera {
        eye: turned([0.7 * w, 30.0 + 0.45 * (w + d) / 2.0, 0.9 * d]),
        target: turned([0.0, 15.0, 0.0]),
        up: turned([0.0, 1.0, 0.0]),
        fov_y: 50.0,
    }
}

/// Columns of cubes: bit y of a column is the cube at height y.
struct Grid {
    width: usize,
    depth: usize,
    columns: Vec<u128>,
}

impl Grid {
    fn new(name: &str, width: usize, depth: usize) -> Result<Self, SceneError> {
        let mut columns = zeros::<u128>(name, width * depth)?;
        columns.par_chunks_mut(PLOT * width).enumerate().for_each(|(pz, strip)| {
            for px in 0..width.div_ceil(PLOT) {
                let plot = plan::plot(px as u32, pz as u32);
                for (row, cells) in strip.chunks_exact_mut(width).zip(&plot) {
                    for (column, cell) in row[px * PLOT..].iter_mut().zip(cells) {
                        *column = *cell;
                    }
                }
            }
        });
        Ok(Self { width, depth, columns })
    }

    /// The column at (x, z); air outside.
    fn column(&self, x: isize, z: isize, depth: usize) -> u128 {
        let inside = (0..self.width as isize).contains(&x) && (0..depth as isize).contains(&z);
        if inside { self.columns[z as usize * self.width + x as usize] } else { 0 }
    }

    /// Cubes of column (x, z) that show their face towards -x, +x, -y, +y, -z, +z.
    fn shown(&self, x: usize, z: usize, depth: usize) -> [u128; 6] {
        let (x, z) = (x as isize, z as isize);
        let at = |dx, dz| self.column(x + dx, z + dz, depth);
        let c = at(0, 0);
        [at(-1, 0), at(1, 0), c << 1, c >> 1, at(0, -1), at(0, 1)].map(|neighbour| c & !neighbour)
    }

    /// Faces of the cubes in row `z` of a city of `depth` rows.
    fn row_faces(&self, z: usize, depth: usize) -> usize {
        (0..self.width)
            .map(|x| self.shown(x, z, depth).iter().map(|m| m.count_ones() as usize).sum::<usize>())
            .sum()
    }

    /// How many rows come nearest to `n` triangles; none where all rows are too few.
    fn depth_for(&self, n: u64) -> Option<usize> {
        let faces = n.div_ceil(2) as usize;
        let inner: Vec<usize> =
            (0..self.depth).into_par_iter().map(|z| self.row_faces(z, self.depth)).collect();
        let (mut before, mut best) = (0, (usize::MAX, 1));
        for (z, row) in inner.iter().enumerate() {
            let total = before + self.row_faces(z, z + 1);
            best = best.min((total.abs_diff(faces), z + 1));
            if total >= faces {
                return Some(best.1);
            }
            before += row;
        }
        None
    }

    /// Writes the corners of row `z`'s faces, outside anticlockwise.
    fn emit(&self, z: usize, pose: Pose, positions: &mut [[f32; 3]]) {
        let mut quads = positions.chunks_exact_mut(4);
        let (west, north) = ((self.width / 2) as f64, (self.depth / 2) as f64);
        for x in 0..self.width {
            for (side, mut mask) in self.shown(x, z, self.depth).into_iter().enumerate() {
                while mask != 0 {
                    let y = mask.trailing_zeros();
                    mask &= mask - 1;
                    let low = [x as f64 - west, f64::from(y), z as f64 - north];
                    if let Some(quad) = quads.next() {
                        for (vertex, corner) in quad.iter_mut().zip(corners(low, side)) {
                            *vertex = pose.turn(corner).map(|v| v as f32);
                        }
                    }
                }
            }
        }
    }
}

/// Corners of one side of the unit cube at `low`.
fn corners(low: [f64; 3], side: usize) -> [[f64; 3]; 4] {
    let (axis, far) = (side / 2, side % 2 == 1);
    let around = if far { [(0, 0), (1, 0), (1, 1), (0, 1)] } else { [(0, 0), (0, 1), (1, 1), (1, 0)] };
    around.map(|(u, v)| {
        let mut p = low;
        p[axis] += f64::from(u8::from(far));
        p[(axis + 1) % 3] += f64::from(u);
        p[(axis + 2) % 3] += f64::from(v);
        p
    })
}

const _: () = assert!(COLUMN_BITS <= 128);
