//! Uniformly random lines through a box, and the leaves that lines meet.

use super::super::validate::Box64;
use super::survey::Survey;
use super::{Budget, Chance};
use crate::abi::{Aabb, INVALID};
use crate::bvh::{Child, Volume};
use rayon::prelude::*;

/// Lines a task.
const CHUNK: usize = 64;
/// Kind of chance.
const LINES: u64 = 2;

/// A line without ends, unit space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Where it enters the scene's box.
    pub origin: [f64; 3],
    /// Unit.
    pub direction: [f64; 3],
}

/// `count` lines, uniform among those that meet `bounds`: entering anywhere on its faces with the same density, at
/// angles of a cosine's. None where the box has no area.
pub fn lines(bounds: &Aabb, count: usize) -> Vec<Line> {
    let (lo, hi) = (bounds.lo.map(f64::from), bounds.hi.map(f64::from));
    let edge: [f64; 3] = std::array::from_fn(|k| hi[k] - lo[k]);
    let face: [f64; 3] = std::array::from_fn(|k| edge[(k + 1) % 3] * edge[(k + 2) % 3]);
    let area = face[0] + face[1] + face[2];
    let line = |i: usize| {
        let mut chance = Chance::new(LINES, i);
        let at = chance.share() * area;
        let axis = if at < face[0] { 0 } else { 1 + usize::from(at >= face[0] + face[1]) };
        let mut origin: [f64; 3] = std::array::from_fn(|k| lo[k] + chance.share() * edge[k]);
        let upward = chance.bits() >> 63 == 0;
        origin[axis] = if upward { lo[axis] } else { hi[axis] };
        let [x, y] = disc(&mut chance);
        let z = (1.0 - (x * x + y * y)).sqrt();
        let mut direction = [0.0; 3];
        direction[axis] = if upward { z } else { -z };
        direction[(axis + 1) % 3] = x;
        direction[(axis + 2) % 3] = y;
        Line { origin, direction }
    };
    if area > 0.0 { (0..count).map(line).collect() } else { vec![] }
}

/// A point inside the unit circle.
fn disc(chance: &mut Chance) -> [f64; 2] {
    loop {
        let p = [(); 2].map(|()| 2.0 * chance.share() - 1.0);
        if p[0] * p[0] + p[1] * p[1] < 1.0 {
            return p;
        }
    }
}

/// A line made ready for boxes.
#[derive(Clone, Copy)]
struct Slabs {
    origin: [f64; 3],
    /// Infinite where the line keeps its distance from a pair of faces; NaN comes of it where it runs in one, which the
    /// comparisons pass over.
    inverse: [f64; 3],
}

impl Slabs {
    fn new(line: &Line) -> Self {
        Self { origin: line.origin, inverse: line.direction.map(|d| 1.0 / d) }
    }

    /// Those of the line as the corners of `volume` are.
    fn within(&self, line: &Line, volume: &Volume) -> Self {
        match volume.frame {
            None => *self,
            Some(_) => Self::new(&Line {
                origin: volume.within(line.origin),
                direction: volume.within(line.direction),
            }),
        }
    }

    fn meets(&self, b: &Box64) -> bool {
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for (k, inverse) in self.inverse.into_iter().enumerate() {
            let x = (b[0][k] - self.origin[k]) * inverse;
            let y = (b[1][k] - self.origin[k]) * inverse;
            let (x, y) = if inverse < 0.0 { (y, x) } else { (x, y) };
            near = if x > near { x } else { near };
            far = if y < far { y } else { far };
        }
        near <= far
    }
}

impl Survey<'_> {
    /// How many leaves each line meets: those whose boxes it crosses, and all boxes above them. None where it takes
    /// more than `budget`.
    pub fn leaves_met(&self, lines: &[Line], budget: &Budget) -> Option<Vec<u32>> {
        let chunk = |lines: &[Line]| {
            let mut stack = vec![];
            let count = |line| {
                let (leaves, tests) = self.leaves_of(line, &mut stack);
                budget.spend(tests).map(|()| leaves)
            };
            lines.iter().map(count).collect::<Option<Vec<u32>>>()
        };
        let parts: Option<Vec<_>> = lines.par_chunks(CHUNK).map(chunk).collect();
        Some(parts?.concat())
    }

    /// Leaves that `line` meets, and the boxes tested.
    fn leaves_of(&self, line: &Line, stack: &mut Vec<u32>) -> (u32, u64) {
        let slabs = Slabs::new(line);
        let (mut leaves, mut tests) = (0, 0);
        stack.extend(Some(self.tree.root).filter(|root| *root != INVALID));
        while let Some(node) = stack.pop() {
            for (child, volume) in self.tree.children(&self.tree.nodes[node as usize]) {
                tests += 1;
                if slabs.within(line, &volume).meets(&volume.corners) {
                    match child {
                        Child::Node(node) => stack.push(node),
                        Child::Leaf { .. } => leaves += 1,
                    }
                }
            }
        }
        (leaves, tests)
    }
}
