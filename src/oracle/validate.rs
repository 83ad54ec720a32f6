//! What must hold of a packed tree, checked from the bytes that tracing reads, and what the tree is like.
//!
//! What [`structure`] wants holds; every triangle that can be hit lies in one leaf, and no other does; boxes contain every
//! triangle below them; the claimed cost can be true.

use crate::abi::{Aabb, INVALID, TRIANGLE_WORDS};
use crate::bvh::frame::is_oriented;
use crate::bvh::structure::{self, Fault, Shape};
use crate::bvh::{Bvh, Child, Collapse, HostTree, Volume};
use crate::scene::Scene;

/// Relative difference of the claimed cost, an f32 sum of a million terms in tree order, from the f64 one.
const COST_TOLERANCE: f64 = 1e-4;
/// How far a triangle may stick out of a box, in units of the tree's reach: an ulp, for a box's corners are corners less
/// the anchor, rounded, and so is their distance from its node's.
const ULP: f64 = 1.0 / (1u32 << 23) as f64;
/// Likewise out of an oriented box, times its stretch: the corner less the anchor, three products and two sums, and the
/// distance from the node's corner, of coordinates √3 and 2 √3 times as long (see PAD_ORIENTED in `glsl/lib/ray.glsl`).
const FRAME_ULPS: f64 = 6.0;

/// What a build says of its tree.
#[derive(Debug, Clone, Copy)]
pub struct Claims {
    /// As [`Bvh::exponent`].
    pub exponent: i32,
    /// As [`Bvh::anchor`].
    pub anchor: [f32; 3],
    /// As [`Bvh::reach`].
    pub reach: f32,
    /// As [`Bvh::bounds`].
    pub bounds: Aabb,
    /// As [`Bvh::depth`].
    pub depth: u32,
    /// As [`Bvh::sah`].
    pub sah: f64,
    /// As [`Bvh::left_out`].
    pub left_out: u32,
    /// What leaves were asked for.
    pub collapse: Collapse,
}

impl Claims {
    /// Those of `bvh`, built with leaves by `collapse`.
    pub fn of(bvh: &Bvh, collapse: Collapse) -> Self {
        let Bvh { exponent, anchor, reach, bounds, depth, sah, left_out, .. } = *bvh;
        Self { exponent, anchor, reach, bounds, depth, sah, left_out, collapse }
    }
}

/// What a sound tree is like. Areas are over the area of the scene's box.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Stats {
    /// Packed nodes, of two to four children; of one where the whole scene is one leaf.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Triangles in leaves.
    pub triangles: usize,
    /// Triangles that can't be hit.
    pub left_out: usize,
    /// Sum of the packed nodes' areas, the root's 1 among them: those that a ray is expected to visit.
    pub node_area: f64,
    /// Sum of the areas of the binary tree's inner nodes, as its cost has it.
    pub inner_area: f64,
    /// Sum of the leaves' areas.
    pub leaf_area: f64,
    /// Mean.
    pub triangles_per_leaf: f64,
    /// Levels of nodes.
    pub depth: u32,
    /// Expected cost of a ray that meets the scene's box, of the binary tree: the one claimed.
    pub sah: f64,
    /// Bytes of nodes and triangles.
    pub bytes: u64,
    /// Nodes whose boxes are oriented.
    #[serde(default)]
    pub oriented: usize,
    /// Sum of the areas of all children's boxes, oriented or not, as packed: those that rays are tested against.
    #[serde(default)]
    pub box_area: f64,
    /// Sum of the areas of the least axis-aligned boxes of the same children.
    #[serde(default)]
    pub aabb_area: f64,
    /// Area of nodes and leaves together by level, the root's first.
    pub area_by_level: Vec<f64>,
}

/// Something that does not hold.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Invalid {
    /// A tree over nothing, or no tree over something.
    #[error("{hittable} triangles can be hit, and the root is {root:#x}")]
    Root {
        /// Triangles that can be hit.
        hittable: usize,
        /// Root reference.
        root: u32,
    },
    /// Nodes through which no ray finds its way.
    #[error(transparent)]
    Structure(#[from] Fault),
    /// A triangle in two leaves, or twice in one.
    #[error("triangle {0} is in two leaves")]
    TriangleTwice(u32),
    /// A triangle of no leaf that can be hit.
    #[error("{missing} triangles that can be hit are in no leaf, triangle {first} first")]
    TriangleMissing {
        /// How many.
        missing: usize,
        /// The first.
        first: usize,
    },
    /// An index beyond the scene, or a triangle no ray can hit.
    #[error("node {node}: triangle {triangle} in a leaf {why}")]
    TriangleWrong {
        /// The leaf's parent.
        node: u32,
        /// Input index.
        triangle: u32,
        /// What is wrong with it.
        why: &'static str,
    },
    /// A box that doesn't contain a triangle below it.
    #[error(
        "node {node}: a triangle below child {slot} sticks out of its box by {gap:e} (allowed: {allowed:e})"
    )]
    SticksOut {
        /// Which.
        node: u32,
        /// Its child.
        slot: usize,
        /// How far, unit space.
        gap: f64,
        /// Rounding's share.
        allowed: f64,
    },
    /// A cost that can't be the tree's.
    #[error("the tree's cost is between {least} and {most}, and {claimed} is claimed")]
    Cost {
        /// With packed nodes of one binary node each, all others as small as may be.
        least: f64,
        /// With all binary nodes of a packed node as large as it.
        most: f64,
        /// Claimed.
        claimed: f64,
    },
    /// A count of triangles left out that isn't so.
    #[error("{left_out} triangles can't be hit, and {claimed} are claimed to be left out")]
    LeftOut {
        /// Triangles.
        left_out: usize,
        /// Claimed.
        claimed: u32,
    },
}

/// Whether a ray can hit a triangle of these corners: all finite, no two alike.
fn is_hittable([a, b, c]: [[f32; 3]; 3]) -> bool {
    [a, b, c].iter().flatten().all(|x| x.is_finite()) && a != b && b != c && c != a
}

/// Corners of a box, least first.
pub(super) type Box64 = [[f64; 3]; 2];

/// Of nothing.
pub(super) const EMPTY: Box64 = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];

/// Half the surface area.
pub(super) fn half_area(b: &Box64) -> f64 {
    let e: [f64; 3] = std::array::from_fn(|k| b[1][k] - b[0][k]);
    e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
}

/// The common box.
pub(super) fn merged(a: &Box64, b: &Box64) -> Box64 {
    [std::array::from_fn(|k| a[0][k].min(b[0][k])), std::array::from_fn(|k| a[1][k].max(b[1][k]))]
}

/// How far `inner` sticks out of `outer`, negative where it doesn't. NaN sticks out infinitely.
fn sticks_out(inner: &Box64, outer: &Box64) -> f64 {
    let gaps = (0..3).flat_map(|k| [outer[0][k] - inner[0][k], inner[1][k] - outer[1][k]]);
    gaps.fold(f64::NEG_INFINITY, |worst, g| if g.is_nan() { f64::INFINITY } else { g.max(worst) })
}

/// Checks `tree` over `scene`.
///
/// # Errors
/// The first thing found that does not hold.
pub fn validate(scene: &Scene, tree: &HostTree, claims: &Claims) -> Result<Stats, Invalid> {
    let hittable: Vec<bool> = (0..scene.triangles.len()).map(|t| is_hittable(scene.corners(t))).collect();
    let count = hittable.iter().filter(|h| **h).count();
    let left_out = hittable.len() - count;
    if left_out != claims.left_out as usize {
        return Err(Invalid::LeftOut { left_out, claimed: claims.left_out });
    }
    if (count == 0) != (tree.root == INVALID) {
        return Err(Invalid::Root { hittable: count, root: tree.root });
    }
    let shape = Shape {
        root: tree.root,
        leaf_bits: tree.leaf_bits,
        depth: claims.depth,
        max_leaf: claims.collapse.max_leaf,
        triangles: tree.triangles.len() / TRIANGLE_WORDS as usize,
    };
    let depth = structure::check(&tree.nodes, &shape)?.depth;
    let mut walk = Walk::new(scene, tree, claims, hittable);
    walk.stats.depth = depth;
    if count > 0 {
        walk.below(tree.root)?;
    }
    walk.finish(left_out)
}

/// A walk over the tree.
struct Walk<'a> {
    scene: &'a Scene,
    tree: &'a HostTree,
    claims: &'a Claims,
    /// Triangles that can be hit, input order, and that no leaf has had yet.
    wanted: Vec<bool>,
    /// Whether any node is oriented.
    oriented: bool,
    /// Corners of the triangles seen so far, unit space; none where no node is oriented.
    seen: Vec<[[f64; 3]; 3]>,
    stats: Stats,
    /// What the cost is at least and at most.
    cost: [f64; 2],
    leaf_cost: f64,
    scale: f64,
    scene_area: f64,
}

/// A node some of whose children have been visited.
struct Open {
    index: u32,
    level: u32,
    children: Vec<(Child, Volume)>,
    /// The child that comes next, and the first of its triangles in [`Walk::seen`].
    slot: usize,
    from: usize,
    /// Of the triangles below the children visited.
    bounds: Box64,
}

impl<'a> Walk<'a> {
    fn new(scene: &'a Scene, tree: &'a HostTree, claims: &'a Claims, wanted: Vec<bool>) -> Self {
        Self {
            scene,
            tree,
            claims,
            wanted,
            oriented: tree.nodes.iter().any(|n| is_oriented(n.frame)),
            seen: vec![],
            stats: Stats::default(),
            cost: [0.0; 2],
            leaf_cost: 0.0,
            scale: 2f64.powi(claims.exponent),
            scene_area: half_area(&[claims.bounds.lo, claims.bounds.hi].map(|p| p.map(f64::from))),
        }
    }

    /// Visits everything below node `root`. Without recursion: a tree may be deeper than the program's own stack.
    fn below(&mut self, root: u32) -> Result<(), Invalid> {
        let mut open = vec![self.open(root, 0)];
        while let Some(top) = open.last_mut() {
            match top.children.get(top.slot).map(|(child, _)| *child) {
                Some(Child::Node(child)) => {
                    let level = top.level + 1;
                    open.push(self.open(child, level));
                }
                Some(Child::Leaf { first, count }) => {
                    let below = self.leaf(top.index, first, count)?;
                    self.add_area(top.level + u32::from(top.children.len() > 1), &below);
                    self.child(top, &below)?;
                }
                None => {
                    let Some(node) = open.pop() else { break };
                    self.close(&node);
                    if let Some(parent) = open.last_mut() {
                        self.child(parent, &node.bounds)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn open(&self, index: u32, level: u32) -> Open {
        let children = self.tree.children(&self.tree.nodes[index as usize]);
        Open { index, level, children, slot: 0, from: self.seen.len(), bounds: EMPTY }
    }

    /// The next child of `node` has been visited: `below` is the box of its triangles.
    fn child(&mut self, node: &mut Open, below: &Box64) -> Result<(), Invalid> {
        let volume = node.children[node.slot].1;
        self.contains(node.index, node.slot, &volume, below, node.from)?;
        node.bounds = merged(&node.bounds, below);
        node.slot += 1;
        node.from = self.seen.len();
        self.stats.box_area += self.over_scene(volume.half_area());
        self.stats.aabb_area += self.share(below);
        Ok(())
    }

    /// All children of `node` have been visited.
    fn close(&mut self, node: &Open) {
        self.stats.nodes += 1;
        self.stats.oriented += usize::from(is_oriented(self.tree.nodes[node.index as usize].frame));
        if node.children.len() > 1 {
            let share = self.share(&node.bounds);
            let cost = f64::from(self.claims.collapse.traversal_cost) * share;
            self.stats.node_area += share;
            self.cost[0] += cost;
            self.cost[1] += cost * (node.children.len() as f64 - 1.0);
            self.add_area(node.level, &node.bounds);
        }
    }

    /// Whether child `slot` of a node holds the triangles of bounds `below`, those seen from `from` on.
    fn contains(
        &self,
        node: u32,
        slot: usize,
        volume: &Volume,
        below: &Box64,
        from: usize,
    ) -> Result<(), Invalid> {
        let reach = f64::from(self.claims.reach);
        let (gap, allowed) = match volume.frame {
            None => (sticks_out(below, &volume.corners), reach * ULP),
            Some(frame) => {
                let corners = self.seen[from..].iter().flatten();
                let gaps = corners.map(|p| sticks_out(&[volume.within(*p); 2], &volume.corners));
                (
                    gaps.fold(f64::NEG_INFINITY, f64::max),
                    reach * FRAME_ULPS * ULP * f64::from(frame.stretch()),
                )
            }
        };
        if gap > allowed { Err(Invalid::SticksOut { node, slot, gap, allowed }) } else { Ok(()) }
    }

    fn over_scene(&self, area: f64) -> f64 {
        if self.scene_area > 0.0 { area / self.scene_area } else { 0.0 }
    }

    fn share(&self, b: &Box64) -> f64 {
        self.over_scene(half_area(b))
    }

    fn add_area(&mut self, level: u32, b: &Box64) {
        let levels = &mut self.stats.area_by_level;
        levels.resize(levels.len().max(level as usize + 1), 0.0);
        self.stats.area_by_level[level as usize] += self.share(b);
    }

    /// The box of a leaf's triangles.
    fn leaf(&mut self, node: u32, first: u32, count: u32) -> Result<Box64, Invalid> {
        let Collapse { triangle_cost, .. } = self.claims.collapse;
        let mut bounds = EMPTY;
        for place in first..first + count {
            bounds = merged(&bounds, &self.triangle(node, place as usize)?);
        }
        let share = self.share(&bounds);
        let cost = f64::from(triangle_cost) * share * f64::from(count);
        self.stats.leaves += 1;
        self.stats.triangles += count as usize;
        self.stats.leaf_area += share;
        self.cost = self.cost.map(|c| c + cost);
        self.leaf_cost += cost;
        Ok(bounds)
    }

    /// The box of the triangle at `place`.
    fn triangle(&mut self, node: u32, place: usize) -> Result<Box64, Invalid> {
        let triangle = self.tree.input_index(place);
        let wrong = |why| Err(Invalid::TriangleWrong { node, triangle, why });
        let Some(wanted) = self.wanted.get_mut(triangle as usize) else {
            return wrong("is not in the scene");
        };
        let corners = self.scene.corners(triangle as usize);
        if !is_hittable(corners) {
            return wrong("can't be hit");
        }
        if !std::mem::replace(wanted, false) {
            return Err(Invalid::TriangleTwice(triangle));
        }
        let words = &self.tree.triangles[place * TRIANGLE_WORDS as usize..];
        let mut bounds = EMPTY;
        let mut seen = [[0.0; 3]; 3];
        for (k, x) in corners.as_flattened().iter().enumerate() {
            let exact = f64::from(*x) * self.scale;
            // A power of two scales exactly; devices may make a subnormal 0.
            let off = (f64::from(f32::from_bits(words[k])) - exact).abs();
            if off.is_nan() || off > f64::from(f32::MIN_POSITIVE) {
                return wrong("has other corners than in the scene");
            }
            let axis = k % 3;
            let at = exact - f64::from(self.claims.anchor[axis]);
            seen[k / 3][axis] = at;
            bounds[0][axis] = bounds[0][axis].min(at);
            bounds[1][axis] = bounds[1][axis].max(at);
        }
        if self.oriented {
            self.seen.push(seen);
        }
        Ok(bounds)
    }

    /// What can be said once all was seen.
    fn finish(mut self, left_out: usize) -> Result<Stats, Invalid> {
        if let Some(first) = self.wanted.iter().position(|w| *w) {
            let missing = self.wanted.iter().filter(|w| **w).count();
            return Err(Invalid::TriangleMissing { missing, first });
        }
        let claimed = self.claims.sah;
        let [least, most] = self.cost;
        if !(least * (1.0 - COST_TOLERANCE) <= claimed && claimed <= most * (1.0 + COST_TOLERANCE)) {
            return Err(Invalid::Cost { least, most, claimed });
        }
        let stats = &mut self.stats;
        stats.sah = claimed;
        stats.inner_area =
            ((claimed - self.leaf_cost) / f64::from(self.claims.collapse.traversal_cost)).max(0.0);
        stats.left_out = left_out;
        stats.triangles_per_leaf = stats.triangles as f64 / stats.leaves.max(1) as f64;
        stats.bytes = size_of_val(&self.tree.nodes[..]) as u64 + size_of_val(&self.tree.triangles[..]) as u64;
        Ok(self.stats)
    }
}

#[cfg(test)]
mod tests;
