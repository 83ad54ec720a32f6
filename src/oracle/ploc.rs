//! Twin of `glsl/ploc/*.comp`: rounds of search, merge and compaction until one cluster is left. Where the device
//! does its last rounds in one dispatch, or searches with registers, is of no concern here: the tree is the same.

use super::morton::{Space, greatest_of, least_of, triangle_bounds};
use crate::abi::{
    ABSORBED_BIT, Aabb, COLLAPSED_BIT, Cluster, INVALID, LEAF_BIT, PlocRoot, RAW_MASK, RawLink, RawNode,
    SLOTS_SHIFT, WIDTH,
};
use crate::bvh::Collapse;
use crate::scene::Scene;

/// A binary tree over Morton ranks.
#[derive(Debug, Clone)]
pub struct RawTree {
    /// Inner nodes, one fewer than triangles.
    pub nodes: Vec<RawNode>,
    /// What the node above says of each.
    pub links: Vec<RawLink>,
    /// What `ploc/tail` writes.
    pub root: PlocRoot,
}

/// The common box.
pub fn merged(a: &Aabb, b: &Aabb) -> Aabb {
    Aabb {
        lo: std::array::from_fn(|k| least_of(a.lo[k], b.lo[k])),
        hi: std::array::from_fn(|k| greatest_of(a.hi[k], b.hi[k])),
    }
}

/// Half the surface area.
pub fn half_area(b: &Aabb) -> f32 {
    let [x, y, z]: [f32; 3] = std::array::from_fn(|k| b.hi[k] - b.lo[k]);
    x * (y + z) + y * z
}

/// Low bits of a key that hold the colour of a pair.
fn colour_mask(radius: u32) -> u32 {
    2 * radius.next_power_of_two() - 1
}

/// The bit of `i` that tells the pair (i, i + distance) from (i − distance, i).
fn side(i: u32, distance: u32) -> u32 {
    i >> distance.trailing_zeros() & 1
}

/// Key of the pair (i, i + distance).
pub fn pair_key(a: &Aabb, b: &Aabb, i: u32, distance: u32, radius: u32) -> u32 {
    let colour = ((distance - 1) * 2) | side(i, distance);
    half_area(&merged(a, b)).to_bits() & !colour_mask(radius) | colour
}

/// The other cluster of the pair that cluster `i` holds least.
pub fn partner_of(i: u32, key: u32, radius: u32) -> u32 {
    let colour = key & colour_mask(radius);
    let distance = (colour >> 1) + 1;
    if side(i, distance) == colour & 1 { i + distance } else { i.wrapping_sub(distance) }
}

/// `ploc/leaves`: the box of each triangle in unit space, and its cluster of one.
pub fn leaves(scene: &Scene, order: &[u32], space: &Space, collapse: &Collapse) -> (Vec<Aabb>, Vec<Cluster>) {
    let leaf = |(i, t): (usize, &u32)| {
        let scene_box = triangle_bounds(scene.corners(*t as usize));
        let settled = |x: f32| if x.abs() < 1.0 / 1_099_511_627_776.0 { 0.0 } else { x };
        let unit = |p: [f32; 3]| std::array::from_fn(|k| settled(p[k] * space.scale - space.anchor[k]));
        let bounds = Aabb { lo: unit(scene_box.lo), hi: unit(scene_box.hi) };
        let cost = collapse.triangle_cost * half_area(&bounds);
        (bounds, Cluster { node: LEAF_BIT | i as u32, rank: i as u32, count: 1, cost })
    };
    order.iter().enumerate().map(leaf).unzip()
}

/// `ploc/search`: the least key of each cluster's pairs.
pub fn search(bounds: &[Aabb], radius: u32) -> Vec<u32> {
    let count = bounds.len() as u32;
    let mut nearest = vec![INVALID; bounds.len()];
    for i in 0..count {
        for distance in 1..=radius.min(count - 1 - i) {
            let j = i + distance;
            let key = pair_key(&bounds[i as usize], &bounds[j as usize], i, distance, radius);
            for cluster in [i, j] {
                nearest[cluster as usize] = nearest[cluster as usize].min(key);
            }
        }
    }
    nearest
}

fn triangles_of(c: &Cluster) -> u32 {
    c.count & RAW_MASK
}

/// Children that the packed node of a cluster has; 1: it is a leaf.
fn slots_of(c: &Cluster) -> u32 {
    (c.count >> SLOTS_SHIFT) + 1
}

/// Which of two children's packed nodes go up into their parent's.
fn absorbed_of([slots_a, slots_b]: [u32; 2], area_a: f32, area_b: f32) -> [bool; 2] {
    let [a, b] = [slots_a, slots_b].map(|slots| slots > 1 && slots < WIDTH);
    if a && b && slots_a + slots_b > WIDTH {
        let a = area_a >= area_b;
        return [a, !a];
    }
    [a, b]
}

/// What the parent holds of a cluster: the bits beside its node, or its count.
fn bits_of(c: &Cluster, absorbed: bool) -> u32 {
    if c.node >= LEAF_BIT {
        0
    } else if slots_of(c) == 1 {
        COLLAPSED_BIT
    } else if absorbed {
        ABSORBED_BIT
    } else {
        0
    }
}

/// The cluster of two and its node, which it adds to `tree`.
fn merge(
    tree: &mut RawTree,
    (box_a, a): (&Aabb, &Cluster),
    (box_b, b): (&Aabb, &Cluster),
    collapse: &Collapse,
) -> (Aabb, Cluster) {
    let bounds = merged(box_a, box_b);
    let count = triangles_of(a) + triangles_of(b);
    let area = half_area(&bounds);
    let inner = collapse.traversal_cost * area + (a.cost + b.cost);
    let leaf = (collapse.triangle_cost * area) * count as f32;
    let collapsed = count <= collapse.max_leaf && leaf < inner;
    let cost = if collapsed { leaf } else { inner };
    let slots = [slots_of(a), slots_of(b)];
    let absorbed = absorbed_of(slots, half_area(box_a), half_area(box_b));
    let slots: u32 = (0..2).map(|k| if absorbed[k] { slots[k] } else { 1 }).sum();
    let beside = if collapsed { 0 } else { (slots - 1) << SLOTS_SHIFT };
    let cluster = Cluster { node: b.rank - 1, rank: a.rank, count: count | beside, cost };
    let bits = [bits_of(a, absorbed[0]), bits_of(b, absorbed[1])];
    tree.nodes[cluster.node as usize] = RawNode {
        left_bounds: *box_a,
        right_bounds: *box_b,
        left: a.node | bits[0],
        right: b.node | bits[1],
    };
    for (child, bits) in [a, b].into_iter().zip(bits) {
        if child.node < LEAF_BIT {
            let count = triangles_of(child) | bits;
            tree.links[child.node as usize] = RawLink { count, parent: cluster.node };
        }
    }
    (bounds, cluster)
}

/// `ploc/count`, `ploc/scan` and `ploc/merge`: pairs that name each other become one, the rest go on, in order.
fn round(
    tree: &mut RawTree,
    bounds: &[Aabb],
    clusters: &[Cluster],
    radius: u32,
    collapse: &Collapse,
) -> (Vec<Aabb>, Vec<Cluster>) {
    let nearest = search(bounds, radius);
    let mut next = (vec![], vec![]);
    for i in 0..clusters.len() {
        let key = nearest[i];
        let j = partner_of(i as u32, key, radius) as usize;
        let mutual = nearest.get(j) == Some(&key);
        if mutual && j < i {
            continue;
        }
        let (mut box_of, mut cluster) = (bounds[i], clusters[i]);
        if mutual {
            (box_of, cluster) = merge(tree, (&bounds[i], &clusters[i]), (&bounds[j], &clusters[j]), collapse);
        }
        next.0.push(box_of);
        next.1.push(cluster);
    }
    next
}

/// Clusters the triangles of `order` into a binary tree; none where there is no triangle.
pub fn cluster(
    scene: &Scene,
    order: &[u32],
    space: &Space,
    radius: u32,
    collapse: &Collapse,
) -> Option<RawTree> {
    let (mut bounds, mut clusters) = leaves(scene, order, space, collapse);
    let inner = order.len().saturating_sub(1);
    let root = PlocRoot { node: INVALID, rounds: 0, stalled: 0, cost: 0.0, bounds: *bounds.first()? };
    let mut tree = RawTree {
        nodes: vec![bytemuck::Zeroable::zeroed(); inner],
        links: vec![bytemuck::Zeroable::zeroed(); inner],
        root,
    };
    while clusters.len() > 1 {
        let count = clusters.len();
        (bounds, clusters) = round(&mut tree, &bounds, &clusters, radius, collapse);
        assert!(clusters.len() < count, "round {} merged none of {count} clusters", tree.root.rounds);
        tree.root.rounds += 1;
    }
    let (bounds, cluster) = (bounds[0], clusters[0]);
    if cluster.node < LEAF_BIT {
        let count = triangles_of(&cluster) | bits_of(&cluster, false);
        tree.links[cluster.node as usize] = RawLink { count, parent: INVALID };
    }
    tree.root = PlocRoot { node: cluster.node, cost: cluster.cost, bounds, ..tree.root };
    Some(tree)
}
