//! End-point overlap: exactly, by clipping every triangle to the boxes it meets, or from points on the surface.

use super::super::validate::Box64;
use super::survey::{Corners, Leaf, Survey, area_of, box_of, child_count};
use super::{Budget, Chance};
use crate::bvh::frame::is_oriented;
use crate::bvh::{Child, Volume};
use rayon::prelude::*;

/// Leaves a task.
const LEAVES: usize = 256;
/// Strata a task.
const STRATA: usize = 256;
/// Kind of chance.
const POINTS: u64 = 1;

/// End-point overlap in its two terms.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Overlap {
    /// What inner nodes cost.
    pub inner: f64,
    /// What leaves cost.
    pub leaf: f64,
    /// Standard error of their sum; 0 where they are exact.
    pub error: f64,
    /// Points that they are estimated from; 0 where they are exact.
    pub points: usize,
}

/// What part of a triangle, or of whatever stands for it, lies in boxes that don't hold it: once for each child of
/// inner nodes, for each triangle of leaves.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    boxes: f64,
    triangles: f64,
    /// Boxes tested.
    tests: u64,
}

/// Where a triangle is at home.
#[derive(Debug, Clone, Copy)]
struct Home {
    rank: u32,
    first: u32,
}

impl Survey<'_> {
    /// By its definition. None where it takes more than `budget`, or where boxes are oriented.
    pub fn overlap(&self, budget: &Budget) -> Option<Overlap> {
        if self.tree.nodes.iter().any(|n| is_oriented(n.frame)) {
            return None;
        }
        let chunk = |(i, leaves): (usize, &[Leaf])| {
            let mut clip = Clip::default();
            let mut sums = [0.0; 2];
            for (rank, leaf) in (i * LEAVES..).zip(leaves) {
                for place in leaf.first..leaf.first + leaf.count {
                    let triangle = Triangle::new(self.corners(place));
                    if triangle.area > 0.0 {
                        let home = Home { rank: rank as u32, first: leaf.first };
                        let met = self.met(home, |region, volume| {
                            let region = region.map_or(volume.corners, |r| common(r, &volume.corners));
                            (clip.area_inside(&triangle, &region), region)
                        });
                        budget.spend(met.tests)?;
                        sums = [sums[0] + met.boxes, sums[1] + met.triangles];
                    }
                }
            }
            Some(sums)
        };
        let parts: Option<Vec<_>> = self.leaves.par_chunks(LEAVES).enumerate().map(chunk).collect();
        let [boxes, triangles] = parts?.iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        let share = |area: f64| if area > 0.0 { area / self.surface } else { 0.0 };
        let (inner, leaf) = (self.box_cost(share(boxes)), self.triangle_cost(share(triangles)));
        Some(Overlap { inner, leaf, error: 0.0, points: 0 })
    }

    /// From an even number of `points` on the surface, two in each of as many strata of equal area. None where it takes
    /// more than `budget`.
    pub fn estimate(&self, points: usize, budget: &Budget) -> Option<Overlap> {
        let strata = points / 2;
        if self.surface <= 0.0 || strata == 0 {
            return Some(Overlap::default());
        }
        let chunk = |from: usize| {
            let mut part = [0.0; 3];
            for stratum in from..strata.min(from + STRATA) {
                let mut cost = [[0.0; 2]; 2];
                for (k, cost) in cost.iter_mut().enumerate() {
                    let mut chance = Chance::new(POINTS, 2 * stratum + k);
                    let at = (stratum as f64 + chance.share()) / strata as f64 * self.surface;
                    let (home, point) = self.point(at, &mut chance);
                    let met = self.met(home, |_: Option<&()>, volume| {
                        (f64::from(u8::from(holds(&volume.corners, &volume.within(point)))), ())
                    });
                    budget.spend(met.tests)?;
                    *cost = [self.box_cost(met.boxes), self.triangle_cost(met.triangles)];
                }
                let [a, b] = cost;
                part[0] += a[0] + b[0];
                part[1] += a[1] + b[1];
                part[2] += (a[0] + a[1] - b[0] - b[1]).powi(2);
            }
            Some(part)
        };
        let starts: Vec<usize> = (0..strata).step_by(STRATA).collect();
        let parts: Option<Vec<_>> = starts.into_par_iter().map(chunk).collect();
        let [inner, leaf, squares] =
            parts?.iter().fold([0.0; 3], |a, b| std::array::from_fn(|k| a[k] + b[k]));
        let points = 2 * strata;
        let n = points as f64;
        // The mean of two has a quarter of their squared difference for an unbiased variance.
        Some(Overlap { inner: inner / n, leaf: leaf / n, error: squares.sqrt() / n, points })
    }

    /// A point of the surface, `at` of its area from the first leaf on.
    fn point(&self, at: f64, chance: &mut Chance) -> (Home, [f64; 3]) {
        let rank = self.leaves.partition_point(|leaf| leaf.area_before <= at).max(1) - 1;
        let leaf = &self.leaves[rank];
        let mut reached = leaf.area_before;
        let mut place = leaf.first;
        let mut corners = self.corners(place);
        while place + 1 < leaf.first + leaf.count {
            reached += area_of(&corners);
            if at < reached {
                break;
            }
            place += 1;
            corners = self.corners(place);
        }
        let (mut u, mut v) = (chance.share(), chance.share());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let [a, b, c] = corners;
        let point = std::array::from_fn(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
        (Home { rank: rank as u32, first: leaf.first }, point)
    }

    /// Sums over the nodes that don't hold the triangle at `home` what is `inside` each one's box: told the region that
    /// is left of the boxes above and the box, it says how much, and what region is left.
    fn met<R>(&self, home: Home, mut inside: impl FnMut(Option<&R>, &Volume) -> (f64, R)) -> Sums {
        let mut sums = Sums::default();
        self.descend(home, self.tree.root, None, &mut inside, &mut sums);
        sums
    }

    /// [`Self::met`] below `node`: cut by `region`, or none where it holds the triangle.
    fn descend<R>(
        &self,
        home: Home,
        node: u32,
        region: Option<&R>,
        inside: &mut impl FnMut(Option<&R>, &Volume) -> (f64, R),
        sums: &mut Sums,
    ) {
        for (child, volume) in self.tree.children(&self.tree.nodes[node as usize]) {
            sums.tests += 1;
            if region.is_none() && self.is_below(home.rank, home.first, child) {
                if let Child::Node(node) = child {
                    self.descend(home, node, None, inside, sums);
                }
                continue;
            }
            let (part, left) = inside(region, &volume);
            if part > 0.0 {
                match child {
                    Child::Leaf { count, .. } => sums.triangles += part * f64::from(count),
                    Child::Node(node) => {
                        sums.boxes += part * child_count(&self.tree.nodes[node as usize]) as f64;
                        self.descend(home, node, Some(&left), inside, sums);
                    }
                }
            }
        }
    }
}

/// What is in both boxes; lo > hi somewhere where nothing is.
fn common(a: &Box64, b: &Box64) -> Box64 {
    [std::array::from_fn(|k| a[0][k].max(b[0][k])), std::array::from_fn(|k| a[1][k].min(b[1][k]))]
}

/// Whether a closed box holds `point`.
fn holds(region: &Box64, point: &[f64; 3]) -> bool {
    (0..3).all(|k| region[0][k] <= point[k] && point[k] <= region[1][k])
}

/// A triangle made ready for clipping.
struct Triangle {
    corners: Corners,
    bounds: Box64,
    area: f64,
}

impl Triangle {
    fn new(corners: Corners) -> Self {
        Self { corners, bounds: box_of(&corners), area: area_of(&corners) }
    }
}

/// Room for polygons.
#[derive(Default)]
struct Clip {
    polygon: Vec<[f64; 3]>,
    next: Vec<[f64; 3]>,
}

impl Clip {
    /// Area of `triangle` inside a closed box: a triangle in a face is inside.
    fn area_inside(&mut self, triangle: &Triangle, region: &Box64) -> f64 {
        let b = &triangle.bounds;
        if !(0..3).all(|k| b[0][k] <= region[1][k] && region[0][k] <= b[1][k] && region[0][k] <= region[1][k])
        {
            return 0.0;
        }
        if holds(region, &b[0]) && holds(region, &b[1]) {
            return triangle.area;
        }
        self.polygon.clear();
        self.polygon.extend(triangle.corners);
        for k in 0..3 {
            if b[0][k] < region[0][k] {
                self.keep(k, region[0][k], |x, plane| x >= plane);
            }
            if b[1][k] > region[1][k] {
                self.keep(k, region[1][k], |x, plane| x <= plane);
            }
        }
        area_of(&self.polygon)
    }

    /// Sutherland–Hodgman: what of the polygon lies on one side of a plane across axis `k`, the plane included.
    fn keep(&mut self, k: usize, plane: f64, inside: impl Fn(f64, f64) -> bool) {
        self.next.clear();
        let Some(mut from) = self.polygon.last().copied() else { return };
        for to in &self.polygon {
            if inside(from[k], plane) != inside(to[k], plane) {
                // From the same end either way, so that an edge is cut where its neighbour's is.
                let (p, q) = if from[k] < to[k] { (from, *to) } else { (*to, from) };
                let t = (plane - p[k]) / (q[k] - p[k]);
                let mut cut: [f64; 3] = std::array::from_fn(|i| p[i] + t * (q[i] - p[i]));
                cut[k] = plane;
                self.next.push(cut);
            }
            if inside(to[k], plane) {
                self.next.push(*to);
            }
            from = *to;
        }
        std::mem::swap(&mut self.polygon, &mut self.next);
    }
}
