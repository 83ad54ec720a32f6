//! The binary tree between builder and collapse, on the device and on the host, and merging on the host: the twin of
//! `glsl/lib/{box,leaf,merge}.glsl`, for builders that run on the CPU and for the oracle.

use super::{Build, Collapse, Result};
use crate::abi::{Aabb, COLLAPSED_BIT, Cluster, INVALID, LEAF_BIT, RawCut, RawNode, RawRoot};
use crate::device::Buffer;

/// Corners of a triangle.
pub type Corners = [[f32; 3]; 3];

/// A binary tree over the triangles in some order, their ranks.
pub(super) struct RawTree {
    pub nodes: Buffer<RawNode>,
    /// One a node.
    pub cuts: Buffer<RawCut>,
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
            cuts: build.buffer("raw.cuts", inner)?,
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
    /// How each is cut.
    pub cuts: Vec<RawCut>,
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
    pub cuts: &'a mut [RawCut],
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

/// A coordinate in unit space, 0 where it is so near that an area may underflow: as in `glsl/lib/leaf.glsl`.
pub fn settled(x: f32) -> f32 {
    if x.abs() < 1.0 / 1_099_511_627_776.0 { 0.0 } else { x }
}

/// A point in unit space: scene · `scale` − `anchor`.
pub fn unit_point(p: [f32; 3], scale: f32, anchor: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|k| settled(p[k] * scale - anchor[k]))
}

/// The triangle's box in unit space.
pub fn leaf_bounds(corners: Corners, scale: f32, anchor: [f32; 3]) -> Aabb {
    let Aabb { lo, hi } = triangle_bounds(corners);
    Aabb { lo: unit_point(lo, scale, anchor), hi: unit_point(hi, scale, anchor) }
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

/// The SAH cost of a tree (see the glossary): `areas` are the half areas of its binary nodes outside leaves, and of its
/// leaves, times their triangles; `bounds` is the scene's.
pub fn sah(areas: [f64; 2], bounds: &Aabb, collapse: &Collapse) -> f64 {
    let e: [f64; 3] = std::array::from_fn(|k| f64::from(bounds.hi[k]) - f64::from(bounds.lo[k]));
    let scene = e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
    let cost = f64::from(collapse.traversal_cost) * areas[0] + f64::from(collapse.triangle_cost) * areas[1];
    if scene > 0.0 { cost / scene } else { 0.0 }
}

impl Subtree {
    /// The triangle of a rank.
    pub fn leaf(rank: u32, bounds: Aabb, collapse: &Collapse) -> Self {
        Self::leaf_of_area(rank, bounds, half_area(&bounds), collapse)
    }

    /// Likewise, where the builder doesn't go by the half area of `bounds`.
    pub fn leaf_of_area(rank: u32, bounds: Aabb, area: f32, collapse: &Collapse) -> Self {
        let cost = collapse.triangle_cost * area;
        Self {
            bounds,
            cluster: Cluster { node: LEAF_BIT | rank, rank, count: 1, cost: [cost; 3] },
            levels: 0,
        }
    }
}

impl Room<'_> {
    /// The subtree of two, `a` before `b`; writes its node and how it is cut.
    pub fn merge(&mut self, a: &Subtree, b: &Subtree, collapse: &Collapse) -> Subtree {
        self.merge_to_area(a, b, half_area(&merged(&a.bounds, &b.bounds)), collapse)
    }

    /// Likewise, where the builder doesn't go by the half area of the common box.
    pub fn merge_to_area(&mut self, a: &Subtree, b: &Subtree, area: f32, collapse: &Collapse) -> Subtree {
        let bounds = merged(&a.bounds, &b.bounds);
        let levels = a.levels.max(b.levels) + 1;
        let ([box_a, box_b], a, b) = ([a.bounds, b.bounds], &a.cluster, &b.cluster);
        let count = a.count + b.count;
        let (cost, choices) = cheapest(a.cost, b.cost, area, count, collapse);
        let cluster = Cluster { node: b.rank - 1, rank: a.rank, count, cost };
        let at = (cluster.node - self.first) as usize;
        self.cuts[at] = RawCut { count, choices };
        self.nodes[at] = RawNode { left_bounds: box_a, right_bounds: box_b, left: a.node, right: b.node };
        Subtree { bounds, cluster, levels }
    }

    /// Room for the triangles before rank `split` and for those from there on; the node between them is left out.
    pub fn split(&mut self, split: u32) -> [Room<'_>; 2] {
        let at = (split - self.first) as usize;
        let (left, right) = self.nodes.split_at_mut(at);
        let (left_cuts, right_cuts) = self.cuts.split_at_mut(at);
        [
            Room { first: self.first, nodes: &mut left[..at - 1], cuts: &mut left_cuts[..at - 1] },
            Room { first: split, nodes: right, cuts: right_cuts },
        ]
    }
}

/// Costs and choices of a subtree of half area `area` and `count` triangles, of those of its two sides: as
/// [`Cluster::cost`] and [`RawCut::choices`].
pub fn cheapest(a: [f32; 3], b: [f32; 3], area: f32, count: u32, collapse: &Collapse) -> ([f32; 3], u32) {
    let two = a[0] + b[0];
    let three = [a[0] + b[1], a[1] + b[0]];
    let four = [a[0] + b[2], a[1] + b[1], a[2] + b[0]];
    let first_of_three = if three[0] <= three[1] { 1 } else { 2 };
    let first_of_four = match four {
        [one, two, three] if two <= one && two <= three => 2,
        [one, _, three] if one <= three => 1,
        _ => 3,
    };
    let (three, four) = (three[first_of_three - 1], four[first_of_four - 1]);

    let inner = collapse.node_cost * area + four;
    let leaf = (collapse.triangle_cost * area) * count as f32;
    let collapsed = count <= collapse.max_leaf && leaf < inner;
    let as_one = if collapsed { leaf } else { inner };
    let as_two = two < as_one || !collapsed && two == as_one;
    let up_to_two = if as_two { two } else { as_one };
    let as_three = three < up_to_two || (as_two || !collapsed) && three == up_to_two;
    let up_to_three = if as_three { three } else { up_to_two };

    let choice = |chosen, first: usize| if chosen { first as u32 } else { 0 };
    let choices =
        choice(!collapsed, first_of_four) | choice(as_two, 1) << 2 | choice(as_three, first_of_three) << 4;
    ([as_one, up_to_two, up_to_three], choices)
}

impl HostRawTree {
    /// A tree over `count` triangles, made by `build` in the room that it is given.
    pub fn build(count: usize, build: impl FnOnce(Room<'_>) -> Subtree) -> Self {
        let nodes = count.saturating_sub(1);
        let mut nodes = vec![bytemuck::Zeroable::zeroed(); nodes];
        let mut cuts: Vec<RawCut> = vec![bytemuck::Zeroable::zeroed(); nodes.len()];
        let Subtree { bounds, cluster, levels } =
            build(Room { first: 0, nodes: &mut nodes, cuts: &mut cuts });
        let collapsed = cluster.node < LEAF_BIT && cuts[cluster.node as usize].choices & 3 == 0;
        let node = if collapsed { cluster.node | COLLAPSED_BIT } else { cluster.node };
        let root = RawRoot { node, levels, stalled: 0, cost: cluster.cost[0], bounds };
        Self { nodes, cuts, root }
    }
}
