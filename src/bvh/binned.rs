//! Binned SAH: top-down, on the CPU \[WALD07\]. Slow, and the yardstick above PLOC: each split is the one of 3 · 31 planes
//! that costs least. Differs: splits down to single triangles, for the leaves are chosen from below as every builder's
//! are; the tree doesn't depend on the number of threads.

use super::morton::{self, Space};
use super::raw::{HostRawTree, RawTree, Room, Subtree, half_area, hittable, leaf_bounds, merged};
use super::sort::Order;
use super::{Build, Collapse, Result};
use crate::abi::{Aabb, RawRoot};
use crate::device::Buffer;
use rayon::prelude::*;

/// Bins an axis.
pub const BINS: usize = 32;
/// Levels below which triangles are halved by number: no tree is much deeper, whatever the scene.
pub const DEEPEST: u32 = 64;
/// Triangles of a subtree that is worth a task of its own.
const TASK: usize = 2048;
/// Triangles that one task puts into bins.
const CHUNK: usize = 1 << 14;

/// No box: merges to the other.
const NOTHING: Aabb = Aabb { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };

/// A triangle that can be hit.
#[derive(Debug, Clone, Copy)]
struct Item {
    /// Unit space.
    bounds: Aabb,
    /// Input index.
    triangle: u32,
}

impl Item {
    /// Twice the centre of its box.
    fn centre(&self, axis: usize) -> f32 {
        self.bounds.lo[axis] + self.bounds.hi[axis]
    }
}

/// Triangles of a bin, or of some side by side.
#[derive(Debug, Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

const EMPTY: Bin = Bin { bounds: NOTHING, count: 0 };

impl Bin {
    fn with(&self, other: &Bin) -> Bin {
        Bin { bounds: merged(&self.bounds, &other.bounds), count: self.count + other.count }
    }

    /// Expected triangle tests, but for a factor.
    fn cost(&self) -> f32 {
        half_area(&self.bounds) * self.count as f32
    }
}

/// Where bins lie.
#[derive(Debug, Clone, Copy)]
struct Grid {
    lo: [f32; 3],
    /// Bins a unit; infinite where the centres are next to each other.
    per_unit: [f32; 3],
    /// From the least centre to the greatest, doubled.
    extent: [f32; 3],
}

impl Grid {
    fn of(items: &[Item]) -> Self {
        let centres = |items: &[Item]| {
            items.iter().fold(NOTHING, |all, item| {
                let at = std::array::from_fn(|axis| item.centre(axis));
                merged(&all, &Aabb { lo: at, hi: at })
            })
        };
        let all = in_chunks(items, centres, |a, b| merged(&a, &b));
        let extent = std::array::from_fn(|k| all.hi[k] - all.lo[k]);
        Self { lo: all.lo, per_unit: extent.map(|x| BINS as f32 / x), extent }
    }

    fn bin(&self, item: &Item, axis: usize) -> usize {
        // A cast saturates, and makes 0 of NaN.
        (((item.centre(axis) - self.lo[axis]) * self.per_unit[axis]) as usize).min(BINS - 1)
    }

    fn fill(&self, items: &[Item]) -> [[Bin; BINS]; 3] {
        let fill = |items: &[Item]| {
            let mut bins = [[EMPTY; BINS]; 3];
            for item in items {
                for (axis, bins) in bins.iter_mut().enumerate() {
                    let bin = &mut bins[self.bin(item, axis)];
                    *bin = bin.with(&Bin { bounds: item.bounds, count: 1 });
                }
            }
            bins
        };
        in_chunks(items, fill, |mut a, b| {
            for (a, b) in a.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
                *a = a.with(b);
            }
            a
        })
    }

    fn widest(&self) -> usize {
        (1..3).fold(0, |widest, k| if self.extent[k] > self.extent[widest] { k } else { widest })
    }
}

/// `f` of all items: of chunks of them, side by side, joined in order.
fn in_chunks<T: Send>(items: &[Item], f: impl Fn(&[Item]) -> T + Sync, join: impl Fn(T, T) -> T) -> T {
    if items.len() < 2 * CHUNK {
        return f(items);
    }
    let (first, rest) = items.split_at(CHUNK);
    let parts: Vec<T> = rest.par_chunks(CHUNK).map(&f).collect();
    parts.into_iter().fold(f(first), join)
}

/// The last bin on the left and its axis, of the split that costs least; of equal ones the more even. None where all
/// centres coincide.
fn plane(grid: &Grid, items: &[Item]) -> Option<(usize, usize)> {
    let mut best = None;
    let mut least = (f32::INFINITY, usize::MAX);
    for (axis, bins) in grid.fill(items).iter().enumerate() {
        if grid.extent[axis] <= 0.0 {
            continue;
        }
        let mut right = [EMPTY; BINS];
        for k in (0..BINS - 1).rev() {
            right[k] = right[k + 1].with(&bins[k + 1]);
        }
        let mut left = EMPTY;
        for k in 0..BINS - 1 {
            left = left.with(&bins[k]);
            if left.count == 0 || right[k].count == 0 {
                continue;
            }
            let here = (left.cost() + right[k].cost(), left.count.max(right[k].count));
            if here < least {
                (best, least) = (Some((axis, k)), here);
            }
        }
    }
    best
}

/// Moves those on the left before the others, both in their order. Returns how many.
fn partition(items: &mut [Item], scratch: &mut [Item], is_left: impl Fn(&Item) -> bool) -> usize {
    let (mut left, mut right) = (0, 0);
    for i in 0..items.len() {
        let item = items[i];
        if is_left(&item) {
            items[left] = item;
            left += 1;
        } else {
            scratch[right] = item;
            right += 1;
        }
    }
    items[left..].copy_from_slice(&scratch[..right]);
    left
}

/// The subtree over `items`, which it puts in order. `scratch` is as long.
fn subtree(
    items: &mut [Item],
    scratch: &mut [Item],
    mut room: Room<'_>,
    level: u32,
    collapse: &Collapse,
) -> Subtree {
    if let [item] = items {
        return Subtree::leaf(room.first, item.bounds, collapse);
    }
    let at = halves(items, scratch, level);
    let (left, right) = items.split_at_mut(at);
    let (left_scratch, right_scratch) = scratch.split_at_mut(at);
    let parallel = left.len() + right.len() >= TASK;
    let [left_room, right_room] = room.split(room.first + at as u32);
    let a = || subtree(left, left_scratch, left_room, level + 1, collapse);
    let b = || subtree(right, right_scratch, right_room, level + 1, collapse);
    let (a, b) = if parallel { rayon::join(a, b) } else { (a(), b()) };
    room.merge(&a, &b, collapse)
}

/// Puts what goes left first. Returns how many.
fn halves(items: &mut [Item], scratch: &mut [Item], level: u32) -> usize {
    let grid = Grid::of(items);
    let plane = if level < DEEPEST { plane(&grid, items) } else { None };
    if let Some((axis, last)) = plane {
        return partition(items, scratch, |item| grid.bin(item, axis) <= last);
    }
    let axis = grid.widest();
    items.sort_by(|a, b| a.centre(axis).total_cmp(&b.centre(axis)));
    items.len() / 2
}

/// The tree over triangles of `corners`, nine floats each, and their order.
fn tree(corners: &[f32], space: &Space, collapse: &Collapse) -> (Vec<u32>, Option<HostRawTree>) {
    let corner = |c: &[f32], k: usize| [c[3 * k], c[3 * k + 1], c[3 * k + 2]];
    let item = |(triangle, c): (usize, &[f32])| {
        let corners = [corner(c, 0), corner(c, 1), corner(c, 2)];
        let bounds = leaf_bounds(corners, space.scale, space.anchor);
        hittable(corners).then_some(Item { bounds, triangle: triangle as u32 })
    };
    let mut items: Vec<Item> = corners.par_chunks_exact(9).enumerate().filter_map(item).collect();
    let mut scratch = items.clone();
    let tree = (!items.is_empty()).then(|| {
        HostRawTree::build(items.len(), |room| subtree(&mut items, &mut scratch, room, 0, collapse))
    });
    (items.iter().map(|item| item.triangle).collect(), tree)
}

/// Builds a tree over the scene's triangles, from the top.
pub(super) fn split(build: &mut Build<'_>) -> Result<(Order, RawTree, Space)> {
    let space = morton::bounds(build)?;
    let scene = build.scene;
    let corners = build.on_host("binned/read", || scene.triangles.read())?;
    let collapse = build.recipe.collapse;
    let (order, host) = build.on_host("binned/split", || tree(&corners, &space, &collapse));
    drop(corners);
    let left_out = build.scene.count() - order.len();
    if left_out > 0 {
        build.note(format!("{left_out} triangles can't be hit and are left out of the tree"));
    }
    let count = order.len() as u32;
    let triangles = build.buffer("sort.order", order.len())?;
    let mut tree = RawTree::new(build, count)?;
    let Some(host) = host else {
        build.note("binned: skipped, no triangle can be hit");
        return Ok((Order { triangles, count, keys: None }, tree, space));
    };
    tree.root = host.root;
    build.on_host("binned/write", || write(&tree, &triangles, &host, &order))?;
    let RawRoot { levels, .. } = tree.root;
    build.note(format!(
        "binned: {BINS} bins an axis, {levels} levels of binary nodes, built by {} threads of the CPU: binned/* are its \
         wall times and part of the build's; no codes, no sort",
        rayon::current_num_threads()
    ));
    Ok((Order { triangles, count, keys: None }, tree, space))
}

/// Copies what was built to the device.
fn write(
    tree: &RawTree,
    triangles: &Buffer<u32>,
    host: &HostRawTree,
    order: &[u32],
) -> crate::device::Result<()> {
    tree.nodes.write(&host.nodes)?;
    tree.cuts.write(&host.cuts)?;
    tree.root_buffer.write(&[host.root])?;
    triangles.write(order)
}
