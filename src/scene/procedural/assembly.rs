//! Many objects into one mesh: how many of each kind, where each begins, and all of them drawn at once.

use std::ops::{Add, Mul};

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::zeros;
use crate::scene::{Camera, Progress, Scene, SceneError};

/// Vertices and triangles of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Size {
    pub(super) vertices: usize,
    pub(super) triangles: usize,
}

impl Add for Size {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { vertices: self.vertices + other.vertices, triangles: self.triangles + other.triangles }
    }
}

impl Mul<usize> for Size {
    type Output = Self;

    fn mul(self, times: usize) -> Self {
        Self { vertices: self.vertices * times, triangles: self.triangles * times }
    }
}

/// Draws one object into the room left for it.
pub(super) struct Pen<'a> {
    pose: DAffine3,
    /// Number of the object's first vertex in the mesh.
    first: u32,
    positions: &'a mut [[f32; 3]],
    triangles: &'a mut [[u32; 3]],
    drawn: Size,
}

impl Pen<'_> {
    /// Draws in coordinates of its own, placed by `pose` in those outside.
    pub(super) fn within(&mut self, pose: DAffine3, draw: impl FnOnce(&mut Self)) {
        let outside = self.pose;
        self.pose = outside * pose;
        draw(self);
        self.pose = outside;
    }

    /// A vertex; its number.
    pub(super) fn vertex(&mut self, p: DVec3) -> u32 {
        let i = self.drawn.vertices;
        self.positions[i] = self.pose.transform_point3(p).as_vec3().to_array();
        self.drawn.vertices += 1;
        self.first + i as u32
    }

    /// A triangle, anticlockwise from outside.
    pub(super) fn triangle(&mut self, corners: [u32; 3]) {
        self.triangles[self.drawn.triangles] = corners;
        self.drawn.triangles += 1;
    }

    /// Two triangles, anticlockwise from outside.
    pub(super) fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }
}

/// Draws the object of a number.
type Draw = dyn Fn(u32, &mut Pen) + Send + Sync;

/// Objects of one size, numbered from 0.
pub(super) struct Run {
    pub(super) objects: u64,
    pub(super) size: Size,
    pub(super) draw: Box<Draw>,
}

impl Run {
    pub(super) fn new(
        objects: u64,
        size: Size,
        draw: impl Fn(u32, &mut Pen) + Send + Sync + 'static,
    ) -> Self {
        Self { objects, size, draw: Box::new(draw) }
    }
}

/// All of the runs' vertices and triangles.
pub(super) fn total(runs: &[Run]) -> Size {
    runs.iter().fold(Size::default(), |sum, run| sum + run.size * run.objects as usize)
}

/// The scene of all runs, one after the other.
///
/// # Errors
/// Not enough memory.
pub(super) fn assemble(
    name: &str,
    runs: &[Run],
    camera: Camera,
    progress: Progress,
) -> Result<Scene, SceneError> {
    let total = total(runs);
    let mut positions = zeros::<[f32; 3]>(name, total.vertices)?;
    let mut triangles = zeros::<[u32; 3]>(name, total.triangles)?;
    let bar = progress.count(format!("generating {name}"), total.triangles as u64);
    let (mut p, mut t, mut first) = (&mut positions[..], &mut triangles[..], 0);
    let mut rooms = Vec::with_capacity(runs.len());
    for run in runs.iter().filter(|run| run.size.triangles > 0) {
        let size = run.size * run.objects as usize;
        let (run_p, rest_p) = p.split_at_mut(size.vertices);
        let (run_t, rest_t) = t.split_at_mut(size.triangles);
        rooms.push((run, first, run_p, run_t));
        (p, t) = (rest_p, rest_t);
        first += size.vertices;
    }
    rooms.into_par_iter().for_each(|(run, first, p, t)| {
        let objects = p.par_chunks_mut(run.size.vertices).zip(t.par_chunks_mut(run.size.triangles));
        objects.enumerate().for_each(|(i, (positions, triangles))| {
            let first = (first + i * run.size.vertices) as u32;
            let drawn = Size::default();
            let mut pen = Pen { pose: DAffine3::IDENTITY, first, positions, triangles, drawn };
            (run.draw)(i as u32, &mut pen);
            debug_assert_eq!(pen.drawn, run.size, "object {i} is of another size than promised");
            bar.inc(run.size.triangles as u64);
        });
    });
    bar.finish_and_clear();
    Ok(Scene { name: name.to_owned(), positions, triangles, views: vec![camera], ..Scene::default() })
}

/// Objects of each kind, that together have about `n` triangles, in the proportions of a whole scene.
/// `kinds`: objects in a whole scene and triangles of each, coarse ones first. What is too little for another object of
/// one kind goes to the next, so the sum is within half of the last kind's triangles.
pub(super) fn shares<const K: usize>(n: u64, kinds: [(u64, usize); K]) -> [u64; K] {
    let whole: u64 = kinds.iter().map(|&(objects, triangles)| objects * triangles as u64).sum();
    let mut left = 0; // in triangles / whole
    let mut counts = [0; K];
    for (k, (objects, triangles)) in kinds.into_iter().enumerate() {
        left += n * objects * triangles as u64;
        let one = triangles as u64 * whole;
        counts[k] = if k + 1 < K { left / one } else { (left + one / 2) / one };
        left = left.saturating_sub(counts[k] * one);
    }
    counts
}

/// Equal wholes side by side, where a scene is larger than one: rooms, plants, crowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Units {
    count: u32,
    columns: u32,
    /// From one to the next in x and z.
    pitch: [f64; 2],
}

impl Units {
    /// As many as it takes that none has more than `whole` triangles.
    pub(super) fn new(n: u64, whole: u64, pitch: [f64; 2]) -> Self {
        let count = n.div_ceil(whole).max(1) as u32;
        let square = count.isqrt();
        let columns = if square * square == count { square } else { square + 1 };
        Self { count, columns, pitch }
    }

    pub(super) fn count(self) -> u32 {
        self.count
    }

    /// Object `i`'s unit and its number there.
    pub(super) fn of(self, i: u32) -> (u32, u32) {
        (i % self.count, i / self.count)
    }

    /// How many of `objects` are in `unit`.
    pub(super) fn share(self, unit: u32, objects: u64) -> u32 {
        let (each, rest) = (objects / u64::from(self.count), objects % u64::from(self.count));
        each as u32 + u32::from(u64::from(unit) < rest)
    }

    /// Where a unit stands.
    pub(super) fn place(self, unit: u32) -> DVec3 {
        let (column, row) = (unit % self.columns, unit / self.columns);
        DVec3::new(f64::from(column) * self.pitch[0], 0.0, f64::from(row) * self.pitch[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up() {
        let kinds = [(7, 1000), (30, 101), (2, 50), (400, 3)];
        let whole = 7 * 1000 + 30 * 101 + 2 * 50 + 400 * 3;
        assert_eq!(shares(whole, kinds), kinds.map(|k| k.0));
        assert_eq!(shares(3 * whole, kinds), kinds.map(|k| 3 * k.0));
        for n in 0..2 * whole {
            let got: u64 = shares(n, kinds).iter().zip(kinds).map(|(c, k)| c * k.1 as u64).sum();
            assert!(got.abs_diff(n) <= 1, "{n}: {got}");
        }
    }

    #[test]
    fn units_share_everything() {
        for n in [1, 10, 11, 95, 100, 1000] {
            let units = Units::new(n, 10, [1.0, 2.0]);
            for objects in [0, 1, 57, 200] {
                let by_unit: u64 = (0..units.count()).map(|u| u64::from(units.share(u, objects))).sum();
                assert_eq!(by_unit, objects);
                assert!((0..objects as u32).all(|i| {
                    let (unit, local) = units.of(i);
                    local < units.share(unit, objects)
                }));
            }
        }
    }
}
