//! The binary tree between builder and collapse, on the device and on the host, and merging on the host: the twin of
//! `glsl/lib/{box,leaf,merge}.glsl`, for builders that run on the CPU and for the oracle.

use super::{Build, Collapse, Result};
use crate::abi::{
    ABSORBED_BIT, Aabb, COLLAPSED_BIT, Cluster, INVALID, LEAF_BIT, RAW_MASK, RawLink, RawNode, RawRoot,
    SLOTS_SHIFT, WIDTH,
};
use crate::device::Buffer;

/// Corners of a triangle.
pub type Corners = [[f32; 3]; 3];

/// A binary tree over the triangles in some order, their ranks.
pub(super) struct RawTree {
    pub nodes: Buffer<RawNode>,
    /// One a node.
    pub links: Buffer<RawLink>,
    /// One.
    pub root_buffer: Buffer<RawRoot>,
    pub root: RawRoot,
    /// Triangles.
    pub count: u32,
}

impl RawTree {
    /// Room for a tree over `count` triangles, and the root of none.
    pub fn new(build: &Build<'_>, count: u32) -> Result<Self> {
        let inner = count.saturating_sub(1) as usize;
        Ok(Self {
            nodes: build.buffer("raw.nodes", inner)?,
            links: build.buffer("raw.links", inner)?,
            root_buffer: build.buffer("raw.root", 1)?,
            root: RawRoot {
                node: INVALID,
                levels: 0,
                stalled: 0,
                cost: 0.0,
                bounds: Aabb { lo: [0.0; 3], hi: [0.0; 3] },
            },
            count,
        })
    }
}

/// As `RawTree`, on the host.
#[derive(Debug, Clone)]
pub struct HostRawTree {
    /// Inner nodes, one fewer than triangles: node i splits between ranks i and i + 1.
    pub nodes: Vec<RawNode>,
    /// What the node above says of each.
    pub links: Vec<RawLink>,
    /// The root.
    pub root: RawRoot,
}

/// A subtree being built, and the room for its nodes.
#[derive(Debug)]
pub struct Room<'a> {
    /// Rank of its first triangle, and so its first node.
    pub first: u32,
    /// Its nodes, one fewer than triangles.
    pub nodes: &'a mut [RawNode],
    /// One a node.
    pub links: &'a mut [RawLink],
}

/// A cluster, its box and its levels of raw nodes.
#[derive(Debug, Clone, Copy)]
pub struct Subtree {
    /// Box, unit space.
    pub bounds: Aabb,
    /// The rest.
    pub cluster: Cluster,
    /// 0: a triangle.
    pub levels: u32,
}

/// `a` where it is less, else `b`: as the kernels have it, so that of −0 and +0 both take the same.
pub fn least_of(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// `a` where it is greater, else `b`.
pub fn greatest_of(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// False where no ray can hit: a corner is not finite, or two corners coincide.
pub fn hittable([a, b, c]: Corners) -> bool {
    [a, b, c].iter().flatten().all(|x| x.is_finite()) && a != b && b != c && c != a
}

/// The triangle's box, scene space.
pub fn triangle_bounds([a, b, c]: Corners) -> Aabb {
    Aabb {
        lo: std::array::from_fn(|k| least_of(a[k], least_of(b[k], c[k]))),
        hi: std::array::from_fn(|k| greatest_of(a[k], greatest_of(b[k], c[k]))),
    }
}

/// The triangle's box in unit space: scene · `scale` − `anchor`.
pub fn leaf_bounds(corners: Corners, scale: f32, anchor: [f32; 3]) -> Aabb {
    let Aabb { lo, hi } = triangle_bounds(corners);
    // As in `glsl/lib/leaf.glsl`: no area underflows.
    let settled = |x: f32| if x.abs() < 1.0 / 1_099_511_627_776.0 { 0.0 } else { x };
    let unit = |p: [f32; 3]| std::array::from_fn(|k| settled(p[k] * scale - anchor[k]));
    Aabb { lo: unit(lo), hi: unit(hi) }
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

/// Triangles of a cluster.
pub fn triangles_of(c: &Cluster) -> u32 {
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

impl Subtree {
    /// The triangle of a rank.
    pub fn leaf(rank: u32, bounds: Aabb, collapse: &Collapse) -> Self {
        let cost = collapse.triangle_cost * half_area(&bounds);
        Self { bounds, cluster: Cluster { node: LEAF_BIT | rank, rank, count: 1, cost }, levels: 0 }
    }
}

impl Room<'_> {
    /// The subtree of two, `a` before `b`; writes its node and its children's links.
    pub fn merge(&mut self, a: &Subtree, b: &Subtree, collapse: &Collapse) -> Subtree {
        let bounds = merged(&a.bounds, &b.bounds);
        let levels = a.levels.max(b.levels) + 1;
        let ([box_a, box_b], a, b) = ([a.bounds, b.bounds], &a.cluster, &b.cluster);
        let count = triangles_of(a) + triangles_of(b);
        let area = half_area(&bounds);
        let inner = collapse.traversal_cost * area + (a.cost + b.cost);
        let leaf = (collapse.triangle_cost * area) * count as f32;
        let collapsed = count <= collapse.max_leaf && leaf < inner;
        let cost = if collapsed { leaf } else { inner };
        let slots = [slots_of(a), slots_of(b)];
        let absorbed = absorbed_of(slots, half_area(&box_a), half_area(&box_b));
        let slots: u32 = (0..2).map(|k| if absorbed[k] { slots[k] } else { 1 }).sum();
        let beside = if collapsed { 0 } else { (slots - 1) << SLOTS_SHIFT };
        let cluster = Cluster { node: b.rank - 1, rank: a.rank, count: count | beside, cost };
        let bits = [bits_of(a, absorbed[0]), bits_of(b, absorbed[1])];
        self.nodes[(cluster.node - self.first) as usize] = RawNode {
            left_bounds: box_a,
            right_bounds: box_b,
            left: a.node | bits[0],
            right: b.node | bits[1],
        };
        for (child, bits) in [a, b].into_iter().zip(bits) {
            self.link(child, triangles_of(child) | bits, cluster.node);
        }
        Subtree { bounds, cluster, levels }
    }

    fn link(&mut self, child: &Cluster, count: u32, parent: u32) {
        if child.node < LEAF_BIT {
            self.links[(child.node - self.first) as usize] = RawLink { count, parent };
        }
    }

    /// Room for the triangles before rank `split` and for those from there on; the node between them is left out.
    pub fn split(&mut self, split: u32) -> [Room<'_>; 2] {
        let at = (split - self.first) as usize;
        let (left, right) = self.nodes.split_at_mut(at);
        let (left_links, right_links) = self.links.split_at_mut(at);
        [
            Room { first: self.first, nodes: &mut left[..at - 1], links: &mut left_links[..at - 1] },
            Room { first: split, nodes: right, links: right_links },
        ]
    }
}

impl HostRawTree {
    /// A tree over `count` triangles, made by `build` in the room that it is given.
    pub fn build(count: usize, build: impl FnOnce(Room<'_>) -> Subtree) -> Self {
        let nodes = count.saturating_sub(1);
        let mut nodes = vec![bytemuck::Zeroable::zeroed(); nodes];
        let mut links = vec![bytemuck::Zeroable::zeroed(); nodes.len()];
        let Subtree { bounds, cluster, levels } =
            build(Room { first: 0, nodes: &mut nodes, links: &mut links });
        let count = triangles_of(&cluster) | bits_of(&cluster, false);
        Room { first: 0, nodes: &mut nodes, links: &mut links }.link(&cluster, count, INVALID);
        let root = RawRoot { node: cluster.node, levels, stalled: 0, cost: cluster.cost, bounds };
        Self { nodes, links, root }
    }
}
