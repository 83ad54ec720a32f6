//! What must hold of a packed tree, checked from the bytes that tracing reads, and what the tree is like.
//!
//! Every triangle that can be hit lies in one leaf, and no other does; leaves hold at most what was asked for; boxes
//! contain every triangle below them; every node is reached once; the claimed depth and cost can be true.

use crate::abi::{Aabb, INVALID, ORIENTED_BIT, TRIANGLE_WORDS};
use crate::bvh::frame::is_oriented;
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
    /// A reference to a node that isn't there.
    #[error("node {parent}: its child is node {child}, and there are {nodes}")]
    NoSuchNode {
        /// Where.
        parent: u32,
        /// The child.
        child: u32,
        /// Nodes.
        nodes: usize,
    },
    /// A node with two parents.
    #[error("node {0} is reached twice")]
    Twice(u32),
    /// Nodes without a parent.
    #[error("{unreached} of {nodes} nodes can't be reached, node {first} first")]
    Unreached {
        /// How many.
        unreached: usize,
        /// Of how many.
        nodes: usize,
        /// The first.
        first: usize,
    },
    /// A node whose exponents say that it has a frame, and it hasn't, or the other way round.
    #[error("node {0}: its frame and what its exponents say of it are at odds")]
    Frame(u32),
    /// A leaf of too many triangles.
    #[error("node {node}: a leaf of {count} triangles, where {max_leaf} are the most")]
    LeafSize {
        /// Its parent.
        node: u32,
        /// Triangles.
        count: u32,
        /// Largest leaf asked for.
        max_leaf: u32,
    },
    /// A leaf beyond the triangles.
    #[error("node {node}: a leaf of triangles {first}..{end}, and the tree has {triangles}")]
    LeafRange {
        /// Its parent.
        node: u32,
        /// First triangle.
        first: u64,
        /// One beyond the last.
        end: u64,
        /// There are.
        triangles: usize,
    },
    /// A triangle's place in two leaves.
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
    /// A deeper tree than its stack is made for.
    #[error("the tree has {depth} levels, and {claimed} are claimed")]
    Depth {
        /// Levels.
        depth: u32,
        /// Claimed.
        claimed: u32,
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
    let mut walk = Walk::new(scene, tree, claims, hittable);
    if count > 0 {
        walk.node(tree.root, tree.root, 0)?;
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
    reached: Vec<bool>,
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

impl<'a> Walk<'a> {
    fn new(scene: &'a Scene, tree: &'a HostTree, claims: &'a Claims, wanted: Vec<bool>) -> Self {
        Self {
            scene,
            tree,
            claims,
            wanted,
            reached: vec![false; tree.nodes.len()],
            oriented: tree.nodes.iter().any(|n| is_oriented(n.frame)),
            seen: vec![],
            stats: Stats::default(),
            cost: [0.0; 2],
            leaf_cost: 0.0,
            scale: 2f64.powi(claims.exponent),
            scene_area: half_area(&[claims.bounds.lo, claims.bounds.hi].map(|p| p.map(f64::from))),
        }
    }

    /// Visits everything below node `index`; returns the box of its triangles.
    fn node(&mut self, parent: u32, index: u32, level: u32) -> Result<Box64, Invalid> {
        let nodes = self.tree.nodes.len();
        let node = self.tree.nodes.get(index as usize);
        let node = node.ok_or(Invalid::NoSuchNode { parent, child: index, nodes })?;
        if std::mem::replace(&mut self.reached[index as usize], true) {
            return Err(Invalid::Twice(index));
        }
        if (node.exponents & ORIENTED_BIT != 0) != is_oriented(node.frame) {
            return Err(Invalid::Frame(index));
        }
        // Before its children: no path is longer than there are levels, whatever the tree.
        self.stats.depth = self.stats.depth.max(level + 1);
        if self.stats.depth > self.claims.depth {
            return Err(Invalid::Depth { depth: self.stats.depth, claimed: self.claims.depth });
        }
        let children = self.tree.children(node);
        let one_leaf = children.len() == 1;
        let mut bounds = EMPTY;
        for (slot, (child, volume)) in children.iter().enumerate() {
            let from = self.seen.len();
            let below = match *child {
                Child::Node(child) => self.node(index, child, level + 1)?,
                Child::Leaf { first, count } => {
                    let below = self.leaf(index, first, count)?;
                    self.add_area(level + u32::from(!one_leaf), &below);
                    below
                }
            };
            self.contains(index, slot, volume, &below, from)?;
            bounds = merged(&bounds, &below);
            self.stats.box_area += self.over_scene(volume.half_area());
            self.stats.aabb_area += self.share(&below);
        }
        self.stats.nodes += 1;
        self.stats.oriented += usize::from(is_oriented(node.frame));
        if !one_leaf {
            let share = self.share(&bounds);
            let cost = f64::from(self.claims.collapse.traversal_cost) * share;
            self.stats.node_area += share;
            self.cost[0] += cost;
            self.cost[1] += cost * (children.len() as f64 - 1.0);
            self.add_area(level, &bounds);
        }
        Ok(bounds)
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
        let Collapse { max_leaf, triangle_cost, .. } = self.claims.collapse;
        let triangles = self.tree.triangles.len() / TRIANGLE_WORDS as usize;
        let (from, end) = (u64::from(first), u64::from(first) + u64::from(count));
        if count > max_leaf {
            return Err(Invalid::LeafSize { node, count, max_leaf });
        }
        if end > triangles as u64 {
            return Err(Invalid::LeafRange { node, first: from, end, triangles });
        }
        let mut bounds = EMPTY;
        for place in from..end {
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
        let nodes = self.reached.len();
        if let Some(first) = self.reached.iter().position(|r| !r) {
            let unreached = self.reached.iter().filter(|r| !**r).count();
            return Err(Invalid::Unreached { unreached, nodes, first });
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
