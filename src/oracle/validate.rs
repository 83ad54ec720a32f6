//! What must hold of a packed tree, checked from the bytes that tracing reads, and what the tree is like.
//!
//! Every triangle that can be hit lies in one leaf, and no other does; leaves hold at most what was asked for; boxes
//! contain what is below them; every node is reached once; the claimed depth and cost are true.

use crate::abi::{Aabb, INVALID, Node, TRIANGLE_WORDS};
use crate::bvh::{Bvh, Child, Collapse, HostTree};
use crate::scene::Scene;

/// Relative difference of the claimed cost, an f32 sum of a million terms in tree order, from the f64 one.
const COST_TOLERANCE: f64 = 1e-4;
/// How far a triangle may stick out of its leaf's box, in units of the tree's reach: an ulp, for box corners are
/// corners less the anchor, rounded once.
const ULP: f64 = 1.0 / (1u32 << 23) as f64;

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
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Stats {
    /// Nodes of two children; 1 where the whole scene is one leaf.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Triangles in leaves.
    pub triangles: usize,
    /// Triangles that can't be hit.
    pub left_out: usize,
    /// Sum of the inner nodes' areas, the root's 1 among them.
    pub inner_area: f64,
    /// Sum of the leaves' areas.
    pub leaf_area: f64,
    /// Mean.
    pub triangles_per_leaf: f64,
    /// Levels of nodes.
    pub depth: u32,
    /// Expected cost of a ray that meets the scene's box.
    pub sah: f64,
    /// Bytes of nodes and triangles.
    pub bytes: u64,
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
    /// A box that doesn't contain its child's boxes.
    #[error("node {node}: a child's box sticks out of it by {gap:e}")]
    NodeSticksOut {
        /// Which.
        node: u32,
        /// How far, unit space.
        gap: f64,
    },
    /// A leaf's box that doesn't contain a triangle.
    #[error("node {node}: triangle {triangle} sticks out of its leaf by {gap:e} (allowed: {allowed:e})")]
    TriangleSticksOut {
        /// The leaf's parent.
        node: u32,
        /// Input index.
        triangle: u32,
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
    /// A cost that isn't the tree's.
    #[error("the tree's cost is {sah}, and {claimed} is claimed")]
    Cost {
        /// Cost.
        sah: f64,
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

/// Half the surface area.
fn half_area(b: &Aabb) -> f64 {
    let e: [f64; 3] = std::array::from_fn(|k| f64::from(b.hi[k]) - f64::from(b.lo[k]));
    e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
}

/// How far `inner` sticks out of `outer`; 0 where it doesn't. NaN sticks out infinitely.
fn sticks_out(inner: &Aabb, outer: &Aabb) -> f64 {
    let gaps = (0..3).flat_map(|k| [(outer.lo[k], inner.lo[k]), (inner.hi[k], outer.hi[k])]);
    let gap =
        |(low, high): (f32, f32)| if low <= high { 0.0 } else { (f64::from(low) - f64::from(high)).abs() };
    gaps.map(gap).fold(0.0, |worst, g| if g.is_nan() { f64::INFINITY } else { g.max(worst) })
}

/// Whether a child is there: the second one of a scene in one leaf has an empty box.
fn is_there(b: &Aabb) -> bool {
    (0..3).all(|k| b.lo[k] <= b.hi[k] || b.lo[k].is_nan() || b.hi[k].is_nan())
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
        walk.all()?;
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
    stats: Stats,
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
            stats: Stats::default(),
            scale: 2f64.powi(claims.exponent),
            scene_area: half_area(&claims.bounds),
        }
    }

    /// Visits everything below the root.
    fn all(&mut self) -> Result<(), Invalid> {
        let root = self.tree.root;
        let mut stack = vec![(root, root, self.claims.bounds, 0)];
        while let Some((parent, index, bounds, level)) = stack.pop() {
            let node = *self.node(parent, index)?;
            self.stats.depth = self.stats.depth.max(level + 1);
            let one_leaf = !is_there(&node.right_bounds);
            if one_leaf {
                self.stats.nodes += 1;
            } else {
                self.inner(&bounds, level);
            }
            for (child_bounds, child) in [(node.left_bounds, node.left), (node.right_bounds, node.right)] {
                if !is_there(&child_bounds) {
                    continue;
                }
                let gap = sticks_out(&child_bounds, &bounds);
                if gap > 0.0 {
                    return Err(Invalid::NodeSticksOut { node: index, gap });
                }
                match self.tree.child(child) {
                    Child::Node(child) => stack.push((index, child, child_bounds, level + 1)),
                    Child::Leaf { first, count } => {
                        self.leaf(index, first, count, &child_bounds)?;
                        self.add_area(level + u32::from(!one_leaf), &child_bounds);
                    }
                }
            }
        }
        Ok(())
    }

    /// The node, not seen before.
    fn node(&mut self, parent: u32, index: u32) -> Result<&'a Node, Invalid> {
        let nodes = self.tree.nodes.len();
        let node = self.tree.nodes.get(index as usize);
        let node = node.ok_or(Invalid::NoSuchNode { parent, child: index, nodes })?;
        if std::mem::replace(&mut self.reached[index as usize], true) {
            return Err(Invalid::Twice(index));
        }
        Ok(node)
    }

    fn share(&self, b: &Aabb) -> f64 {
        if self.scene_area > 0.0 { half_area(b) / self.scene_area } else { 0.0 }
    }

    fn add_area(&mut self, level: u32, b: &Aabb) {
        let levels = &mut self.stats.area_by_level;
        levels.resize(levels.len().max(level as usize + 1), 0.0);
        self.stats.area_by_level[level as usize] += self.share(b);
    }

    fn inner(&mut self, b: &Aabb, level: u32) {
        let share = self.share(b);
        self.stats.nodes += 1;
        self.stats.inner_area += share;
        self.stats.sah += f64::from(self.claims.collapse.traversal_cost) * share;
        self.add_area(level, b);
    }

    fn leaf(&mut self, node: u32, first: u32, count: u32, b: &Aabb) -> Result<(), Invalid> {
        let Collapse { max_leaf, triangle_cost, .. } = self.claims.collapse;
        let triangles = self.tree.triangles.len() / TRIANGLE_WORDS as usize;
        let (from, end) = (u64::from(first), u64::from(first) + u64::from(count));
        if count > max_leaf {
            return Err(Invalid::LeafSize { node, count, max_leaf });
        }
        if end > triangles as u64 {
            return Err(Invalid::LeafRange { node, first: from, end, triangles });
        }
        for slot in from..end {
            self.triangle(node, slot as usize, b)?;
        }
        let share = self.share(b);
        self.stats.leaves += 1;
        self.stats.triangles += count as usize;
        self.stats.leaf_area += share;
        self.stats.sah += f64::from(triangle_cost) * share * f64::from(count);
        Ok(())
    }

    fn triangle(&mut self, node: u32, slot: usize, b: &Aabb) -> Result<(), Invalid> {
        let triangle = self.tree.input_index(slot);
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
        let words = &self.tree.triangles[slot * TRIANGLE_WORDS as usize..];
        let allowed = f64::from(self.claims.reach) * ULP;
        for (k, x) in corners.as_flattened().iter().enumerate() {
            let exact = f64::from(*x) * self.scale;
            // A power of two scales exactly; devices may make a subnormal 0.
            let off = (f64::from(f32::from_bits(words[k])) - exact).abs();
            if off.is_nan() || off > f64::from(f32::MIN_POSITIVE) {
                return wrong("has other corners than in the scene");
            }
            let axis = k % 3;
            let at = exact - f64::from(self.claims.anchor[axis]);
            let gap = (f64::from(b.lo[axis]) - at).max(at - f64::from(b.hi[axis]));
            if gap.is_nan() || gap > allowed {
                return Err(Invalid::TriangleSticksOut { node, triangle, gap, allowed });
            }
        }
        Ok(())
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
        let stats = &mut self.stats;
        if stats.depth > self.claims.depth {
            return Err(Invalid::Depth { depth: stats.depth, claimed: self.claims.depth });
        }
        let claimed = self.claims.sah;
        if (stats.sah - claimed).abs() > COST_TOLERANCE * stats.sah || claimed.is_nan() {
            return Err(Invalid::Cost { sah: stats.sah, claimed });
        }
        stats.left_out = left_out;
        stats.triangles_per_leaf = stats.triangles as f64 / stats.leaves.max(1) as f64;
        stats.bytes = size_of_val(&self.tree.nodes[..]) as u64 + size_of_val(&self.tree.triangles[..]) as u64;
        Ok(self.stats)
    }
}

#[cfg(test)]
mod tests;
