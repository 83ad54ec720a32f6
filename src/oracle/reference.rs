//! The fast f64 reference: a tree of f32 boxes on the CPU, with `brute`'s triangle test at its leaves.
//!
//! Why it answers as `brute`, bit for bit: a hit's true point lies in all boxes around its triangle, and boxes are
//! exact, for vertices are f32. So the true t lies in the true t-interval of each; the computed interval is off by
//! at most 4u, the computed t by 2⁻²⁸ ([`super::brute`]), both relative, and intervals are widened by `SLACK`
//! before they meet the ray's range. So no node is skipped that holds a computed t in range and not beyond the best.

mod tree;

use self::tree::{Bounds, Item, Node};
use super::brute::{self, Hit64, Ray64};
use crate::abi::Ray;
use crate::scene::Scene;
use rayon::prelude::*;

/// Relative widening of a box's t-interval: 2⁻²⁶.
const SLACK: f64 = 1.0 / (1u64 << 26) as f64;
/// Room for the deepest descent.
const STACK: usize = tree::MAX_DEPTH + 1;
/// Rays a task.
const CHUNK: usize = 1 << 12;

/// Called from any thread with the number of rays just finished.
pub type Progress<'a> = &'a (dyn Fn(usize) + Sync);

/// A triangle in leaf order.
#[derive(Debug, Clone, Copy)]
struct Triangle {
    corners: [[f32; 3]; 3],
    index: u32,
}

/// A scene with a tree over it, ready to answer.
#[derive(Debug)]
pub struct Reference<'s> {
    scene: &'s Scene,
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
}

impl<'s> Reference<'s> {
    /// Builds the tree. Triangles that can't be hit (not finite, two corners alike) stay out of it.
    pub fn new(scene: &'s Scene) -> Self {
        let hittable = |c: &[[f32; 3]; 3]| {
            c.iter().flatten().all(|x| x.is_finite()) && c[0] != c[1] && c[1] != c[2] && c[2] != c[0]
        };
        let item = |i: usize| {
            let corners = scene.corners(i);
            hittable(&corners).then(|| Item { bounds: Bounds::of(&corners), index: i as u32 })
        };
        let mut items: Vec<Item> = (0..scene.triangles.len()).into_par_iter().filter_map(item).collect();
        let nodes = tree::build(scene, &mut items);
        let triangle = |i: &Item| Triangle { corners: scene.corners(i.index as usize), index: i.index };
        Self { scene, nodes, triangles: items.par_iter().map(triangle).collect() }
    }

    /// The scene that this answers for.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// Longest edge of the box of all triangles that can be hit; 0 where there are none.
    pub(super) fn extent(&self) -> f64 {
        let Bounds { lo, hi } = self.nodes[0].bounds;
        (0..3).map(|k| f64::from(hi[k]) - f64::from(lo[k])).fold(0.0, f64::max)
    }

    /// The first hit of `ray`: the same as [`brute::closest`].
    pub fn closest(&self, ray: &Ray) -> Option<Hit64> {
        self.closest64(&Ray64::new(ray)?)
    }

    /// Whether `ray` hits anything: the same as [`brute::any`].
    pub fn any(&self, ray: &Ray) -> bool {
        Ray64::new(ray).and_then(|ray| self.any64(&ray)).is_some()
    }

    /// The first hit of each ray, in parallel.
    pub fn closest_all(&self, rays: &[Ray], progress: Option<Progress>) -> Vec<Option<Hit64>> {
        let chunk = |rays: &[Ray]| {
            let hits: Vec<_> = rays.iter().map(|r| self.closest(r)).collect();
            if let Some(progress) = progress {
                progress(rays.len());
            }
            hits
        };
        rays.par_chunks(CHUNK).map(chunk).collect::<Vec<_>>().concat()
    }

    pub(super) fn closest64(&self, ray: &Ray64) -> Option<Hit64> {
        let mut best: Option<Hit64> = None;
        self.visit(ray, |hit| {
            if best.is_none_or(|b| hit.precedes(&b)) {
                best = Some(hit);
            }
            best.map_or(ray.t_max, |b| b.t)
        });
        best
    }

    /// Some hit, whichever comes first.
    pub(super) fn any64(&self, ray: &Ray64) -> Option<Hit64> {
        let mut some = None;
        self.visit(ray, |hit| {
            some = Some(hit);
            f64::NEG_INFINITY
        });
        some
    }

    /// Gives `found` the hits of `ray`, nearer nodes first; `found` returns the greatest t still of interest.
    #[inline(always)]
    fn visit(&self, ray: &Ray64, mut found: impl FnMut(Hit64) -> f64) {
        let slabs = Slabs::new(ray);
        let mut limit = ray.t_max;
        let mut stack = [(0u32, 0f64); STACK];
        let mut depth = 0;
        if let Some(near) = slabs.enter(&self.nodes[0].bounds, limit) {
            stack[0] = (0, near);
            depth = 1;
        }
        while depth > 0 {
            depth -= 1;
            let (mut at, mut near) = stack[depth];
            while near <= limit {
                let Node { first, count, .. } = self.nodes[at as usize];
                if count > 0 {
                    for triangle in &self.triangles[first as usize..(first + count) as usize] {
                        let corners = triangle.corners.map(|c| c.map(f64::from));
                        if let Some(hit) = brute::intersect(ray, corners, triangle.index) {
                            limit = found(hit);
                        }
                    }
                    break;
                }
                let [left, right] = [first, first + 1];
                let enter = |child: u32| slabs.enter(&self.nodes[child as usize].bounds, limit);
                (at, near) = match (enter(left), enter(right)) {
                    (Some(l), Some(r)) => {
                        let (nearer, farther) =
                            if l <= r { ((left, l), (right, r)) } else { ((right, r), (left, l)) };
                        stack[depth] = farther;
                        depth += 1;
                        nearer
                    }
                    (Some(l), None) => (left, l),
                    (None, Some(r)) => (right, r),
                    (None, None) => break,
                };
            }
        }
    }
}

/// A ray made ready for boxes.
struct Slabs {
    origin: [f64; 3],
    /// 1/d; +inf for ±0, which makes a slab that holds the origin unbounded, NaN where the origin is on its face
    /// (passed over by the comparisons in `enter`, as it should be) and any other slab empty.
    inverse: [f64; 3],
    backward: [bool; 3],
    t_min: f64,
}

impl Slabs {
    fn new(ray: &Ray64) -> Self {
        Self {
            origin: ray.origin,
            inverse: ray.direction.map(|d| if d == 0.0 { f64::INFINITY } else { 1.0 / d }),
            backward: ray.direction.map(|d| d < 0.0),
            t_min: ray.t_min,
        }
    }

    /// Least t in `b`, if the ray passes through it in its range up to `limit`; early by up to [`SLACK`].
    #[inline(always)]
    fn enter(&self, b: &Bounds, limit: f64) -> Option<f64> {
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for k in 0..3 {
            let (first, last) = if self.backward[k] { (b.hi[k], b.lo[k]) } else { (b.lo[k], b.hi[k]) };
            let x = (f64::from(first) - self.origin[k]) * self.inverse[k];
            let y = (f64::from(last) - self.origin[k]) * self.inverse[k];
            // Not min and max: a NaN must leave the interval alone, and this is one instruction.
            near = if x > near { x } else { near };
            far = if y < far { y } else { far };
        }
        // An infinite end makes the widened one NaN, which fails the comparison: empty, as it is.
        let (near, far) = (near - near.abs() * SLACK, far + far.abs() * SLACK);
        let (start, end) = (near.max(self.t_min), far.min(limit));
        (near <= far && start <= end).then_some(start)
    }
}
