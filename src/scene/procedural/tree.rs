//! A tree on wide ground: five levels of branches as thin tubes, and loose quads as leaves; beyond one tree, a forest.
//! Most triangles lie in a small part of the bounds (a teapot in a stadium) and stand at every angle. A tree is 10 m.

use glam::{DAffine3, DVec3};

use super::assembly::{Pen, Run, Size, assemble};
use super::noise::{h32, u01, unit_vector};
use super::shapes::{tube, tube_size};
use super::trig::{about, across, any_rotation, sin_cos};
use crate::scene::{Camera, Progress, Scene, SceneError};

/// Triangles of one whole tree with its ground: 113,808 of wood, 100,169 leaves, and 2 below.
pub(super) const FULL: u64 = 314_148;
const GROUND: Size = Size { vertices: 4, triangles: 2 };
const LEAF: Size = Size { vertices: 4, triangles: 2 };
const SEED: u32 = 0x7EE5;
/// Golden angle, turns.
const GOLDEN: f64 = 137.507_764_05 / 360.0;
/// Half of the ground's edge under a single tree, metres: ten trees across.
const GROUND_HALF: f64 = 50.0;
/// Scale of the distance between trees of a forest, metres.
const SPACING: f64 = 3.6;

/// Branches of one level.
struct Level {
    branches: u64,
    segments: usize,
    sides: usize,
}

impl Level {
    const fn new(branches: u64, segments: usize, sides: usize) -> Self {
        Self { branches, segments, sides }
    }

    const fn size(&self) -> Size {
        tube_size(self.segments + 1, self.sides)
    }
}

/// Trunk to twigs.
const LEVELS: [Level; 5] = [
    Level::new(1, 24, 16),
    Level::new(9, 12, 10),
    Level::new(63, 8, 8),
    Level::new(378, 6, 6),
    Level::new(1890, 4, 5),
];

/// About `count` triangles, to the nearest 2: branches and leaves in proportion, and a leaf more on some trees.
pub(super) fn generate(name: &str, count: u64, progress: Progress) -> Result<Scene, SceneError> {
    let trees = trees(count);
    let far = if trees == 1 { 0.0 } else { edge(trees) };
    let camera = Camera {
        eye: [9.0 + 0.8 * far as f32, 6.0 + 0.4 * far as f32, 15.0 + 1.2 * far as f32],
        target: [0.0, 4.6, 0.0],
        up: [0.0, 1.0, 0.0],
        fov_y: 45.0,
    };
    assemble(name, &runs(count), camera, progress)
}

/// Trees of a scene: as many as it takes that none is larger than a whole one.
fn trees(count: u64) -> u32 {
    count.div_ceil(FULL).max(1) as u32
}

/// Radius of a forest, metres.
fn edge(trees: u32) -> f64 {
    SPACING * f64::from(trees).sqrt()
}

pub(super) fn runs(count: u64) -> Vec<Run> {
    let trees = trees(count);
    let rest = count.saturating_sub(GROUND.triangles as u64);
    let branches = branches(rest / u64::from(trees));
    let wood: Size = branches.iter().zip(&LEVELS).fold(Size::default(), |s, (n, l)| s + l.size() * *n);
    let leaves = (rest - u64::from(trees) * wood.triangles as u64) / 2;
    let (each, more) = (leaves / u64::from(trees), (leaves % u64::from(trees)) as u32);
    let run = move |trees: u64, first: u32, leaves: u64| {
        let size = wood + LEAF * leaves as usize;
        Run::new(trees, size, move |i, pen| tree(pen, first + i, branches, leaves as u32))
    };
    vec![
        Run::new(1, GROUND, move |_, pen| ground(pen, GROUND_HALF + edge(trees - 1))),
        run(u64::from(more), 0, each + 1),
        run(u64::from(trees - more), more, each),
    ]
}

/// Branches of each level of a tree of `budget` triangles: their share, at least one, while there is room.
fn branches(budget: u64) -> [usize; 5] {
    let mut left = budget;
    let whole = FULL - GROUND.triangles as u64;
    LEVELS.each_ref().map(|level| {
        let one = level.size().triangles as u64;
        let n = (level.branches * budget / whole).max(1).min(left / one);
        left -= n * one;
        n as usize
    })
}

fn ground(pen: &mut Pen, half: f64) {
    let corners = [(-half, half), (half, half), (half, -half), (-half, -half)];
    let corners = corners.map(|(x, z)| pen.vertex(DVec3::new(x, 0.0, z)));
    pen.quad(corners);
}

/// A branch's middle line.
struct Branch {
    points: Vec<DVec3>,
    length: f64,
    /// Radius at its root.
    radius: f64,
}

impl Branch {
    fn radius_at(&self, t: f64) -> f64 {
        self.radius * (1.0 - 0.75 * t)
    }

    /// Point and direction at t in 0..1 of its length.
    fn at(&self, t: f64) -> (DVec3, DVec3) {
        let last = self.points.len() - 2;
        let place = t * (last + 1) as f64;
        let k = (place as usize).min(last);
        let step = self.points[k + 1] - self.points[k];
        (self.points[k] + step * (place - k as f64), step.normalize())
    }
}

/// Tree `number`, with so many branches of each level and leaves.
fn tree(pen: &mut Pen, number: u32, branches: [usize; 5], leaves: u32) {
    let key = h32(number, 0, SEED);
    let mut pose = DAffine3::IDENTITY;
    if number > 0 {
        let (sin, cos) = sin_cos(f64::from(number) * GOLDEN);
        let r = SPACING * f64::from(number).sqrt();
        let scale = 0.7 + 0.6 * u01(key, 1, SEED);
        pose = DAffine3::from_mat3_translation(
            about(1, u01(key, 0, SEED)) * scale,
            DVec3::new(r * cos, 0.0, r * sin),
        );
    }
    pen.within(pose, |pen| {
        let mut parents = vec![trunk(key)];
        for (l, level) in LEVELS.iter().enumerate() {
            if l > 0 {
                let children = branches[l].max(1);
                parents = (0..children).map(|i| child(key, l, i, &parents)).collect();
            }
            for branch in &parents[..branches[l]] {
                let along = |k: usize| k as f64 / level.segments as f64;
                tube(pen, &branch.points, level.sides, |k| branch.radius_at(along(k)));
            }
        }
        for i in 0..leaves {
            leaf(pen, key, i, &parents);
        }
    });
}

fn trunk(key: u32) -> Branch {
    let direction = DVec3::Y + unit_vector(key, 2, SEED) * 0.04;
    let root = DVec3::new(0.0, -0.1, 0.0);
    Branch { points: line(h32(key, 3, SEED), 0, root, direction, 5.6), length: 5.6, radius: 0.26 }
}

/// Branch `i` of level `l`; siblings stand a golden angle apart about their parent.
fn child(tree: u32, l: usize, i: usize, parents: &[Branch]) -> Branch {
    let key = h32(i as u32, l as u32, tree);
    let u = |k: u32| u01(key, k, SEED + 1);
    let (parent, nth) = (&parents[i % parents.len()], i / parents.len());
    let t = 0.25 + 0.7 * u(0);
    let (root, d) = parent.at(t);
    let (x, y) = across(d);
    let (sin, cos) = sin_cos(nth as f64 * GOLDEN + 0.12 * (u(1) - 0.5));
    let (pitch_sin, pitch_cos) = sin_cos((35.0 + 25.0 * u(2)) / 360.0);
    let direction = d * pitch_cos + (x * cos + y * sin) * pitch_sin;
    let length = 0.62 * parent.length * (0.8 + 0.4 * u(3));
    let points = line(key, l, root, direction, length);
    Branch { points, length, radius: 0.55 * parent.radius_at(t) }
}

/// Points of a branch, which droops, and gropes for the light.
fn line(key: u32, l: usize, root: DVec3, direction: DVec3, length: f64) -> Vec<DVec3> {
    let segments = LEVELS[l].segments;
    let (mut p, mut d) = (root, direction.normalize());
    let mut points = vec![p];
    for k in 0..segments {
        p += d * (length / segments as f64);
        points.push(p);
        d += unit_vector(key, k as u32, SEED + 2) * 0.1;
        d.y += 0.05 - 0.04 * l as f64;
        if l > 0 {
            d.y += 0.6 * (1.4 - p.y).max(0.0); // and keeps off the ground
        }
        d = d.normalize();
    }
    points
}

/// A leaf of 20 to 40 cm, half as wide, one end at a twig.
fn leaf(pen: &mut Pen, tree: u32, i: u32, twigs: &[Branch]) {
    let key = h32(i, 5, tree);
    let u = |k: u32| u01(key, k, SEED + 3);
    let (stalk, _) = twigs[i as usize % twigs.len()].at(u(0));
    let turn = any_rotation(key, 9, SEED + 4);
    let length = 0.2 + 0.2 * u(1);
    let (along, side) = (turn.x_axis * length, turn.y_axis * (length / 4.0));
    let corners = [stalk - side, stalk + along - side, stalk + along + side, stalk + side];
    let corners = corners.map(|p| pen.vertex(p));
    pen.quad(corners);
}
