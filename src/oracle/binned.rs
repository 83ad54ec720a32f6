//! Twin of `bvh::binned`: one thread, every split's cost anew from all triangles.

use super::morton::Space;
use crate::abi::Aabb;
use crate::bvh::Collapse;
use crate::bvh::binned::{BINS, DEEPEST};
use crate::bvh::raw::{HostRawTree, Room, Subtree, half_area, hittable, leaf_bounds, merged};
use crate::scene::Scene;

/// A triangle's box in unit space, and its input index.
type Item = (Aabb, u32);

fn centre(item: &Item, axis: usize) -> f32 {
    item.0.lo[axis] + item.0.hi[axis]
}

/// Least and greatest centre.
fn range(items: &[Item], axis: usize) -> [f32; 2] {
    let centres = items.iter().map(|item| centre(item, axis));
    [centres.clone().fold(f32::INFINITY, f32::min), centres.fold(f32::NEG_INFINITY, f32::max)]
}

fn bin(item: &Item, axis: usize, [lo, hi]: [f32; 2]) -> usize {
    (((centre(item, axis) - lo) * (BINS as f32 / (hi - lo))) as usize).min(BINS - 1)
}

/// How many there are, and their common half area times that.
fn count_and_cost<'a>(items: impl Iterator<Item = &'a Item>) -> (usize, f32) {
    let mut found: Option<(usize, Aabb)> = None;
    for (bounds, _) in items {
        found = Some(found.map_or((1, *bounds), |(n, all)| (n + 1, merged(&all, bounds))));
    }
    found.map_or((0, 0.0), |(n, all)| (n, half_area(&all) * n as f32))
}

/// The halves of `items`, by the plane that costs least; of equal ones the more even, then the first.
fn halves(items: &[Item], level: u32) -> [Vec<Item>; 2] {
    let ranges = [0, 1, 2].map(|axis| range(items, axis));
    let is_left = |item: &Item, axis: usize, last: usize| bin(item, axis, ranges[axis]) <= last;
    let mut planes = vec![];
    for axis in (0..3).filter(|axis| level < DEEPEST && ranges[*axis][0] < ranges[*axis][1]) {
        for last in 0..BINS - 1 {
            let (left, left_cost) = count_and_cost(items.iter().filter(|i| is_left(i, axis, last)));
            let (right, right_cost) = count_and_cost(items.iter().filter(|i| !is_left(i, axis, last)));
            if left > 0 && right > 0 {
                planes.push((left_cost + right_cost, left.max(right), axis, last));
            }
        }
    }
    let best = planes.into_iter().reduce(|best, p| if (p.0, p.1) < (best.0, best.1) { p } else { best });
    let Some((_, _, axis, last)) = best else { return by_number(items) };
    let (left, right) = items.iter().partition(|item| is_left(item, axis, last));
    [left, right]
}

/// The halves along the axis on which centres are farthest apart.
fn by_number(items: &[Item]) -> [Vec<Item>; 2] {
    let extent = |axis: usize| range(items, axis)[1] - range(items, axis)[0];
    let axis = (1..3).fold(0, |widest, k| if extent(k) > extent(widest) { k } else { widest });
    let mut left = items.to_vec();
    left.sort_by(|a, b| centre(a, axis).total_cmp(&centre(b, axis)));
    let right = left.split_off(items.len() / 2);
    [left, right]
}

fn subtree(room: &mut Room<'_>, items: &[Item], order: &mut Vec<u32>, level: u32, c: &Collapse) -> Subtree {
    if let [(bounds, triangle)] = items {
        order.push(*triangle);
        return Subtree::leaf(order.len() as u32 - 1, *bounds, c);
    }
    let [left, right] = halves(items, level);
    let a = subtree(room, &left, order, level + 1, c);
    let b = subtree(room, &right, order, level + 1, c);
    room.merge(&a, &b, c)
}

/// The triangles of `scene` that can be hit, in the tree's order, and the tree; none where there is no triangle.
pub fn split(scene: &Scene, space: &Space, collapse: &Collapse) -> (Vec<u32>, Option<HostRawTree>) {
    let item = |t: usize| (leaf_bounds(scene.corners(t), space.scale, space.anchor), t as u32);
    let items: Vec<Item> =
        (0..scene.triangles.len()).filter(|t| hittable(scene.corners(*t))).map(item).collect();
    let mut order = vec![];
    let build = |mut room: Room<'_>| subtree(&mut room, &items, &mut order, 0, collapse);
    let tree = (!items.is_empty()).then(|| HostRawTree::build(items.len(), build));
    (order, tree)
}
