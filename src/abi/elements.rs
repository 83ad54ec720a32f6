//! What buffers hold.

use super::*;

abi! {
    /// Element types of buffers.
    ELEMENTS:
    /// A ray as files hold it: direction of any length but zero, t in units of the direction's length.
    struct Ray {
        /// Origin, scene units.
        origin: [f32; 3],
        /// Least t that counts as a hit.
        t_min: f32,
        /// Direction; need not be unit.
        direction: [f32; 3],
        /// Greatest t that counts as a hit; may be +inf.
        t_max: f32,
    }
    /// What a ray met.
    struct Hit {
        /// Ray parameter; +inf on a miss; 0 where an any-hit query was occluded.
        t: f32,
        /// Triangle in input order, [`INVALID`] on a miss.
        triangle: u32,
        /// Barycentric weight of the triangle's second vertex.
        u: f32,
        /// Barycentric weight of the triangle's third vertex.
        v: f32,
    }
    /// An axis-aligned box; empty where lo > hi.
    struct Aabb {
        /// Least corner.
        lo: [f32; 3],
        /// Greatest corner.
        hi: [f32; 3],
    }
    /// What the triangles have in common. Floats as ordered integers: see `ordered` in `glsl/lib/ordered.glsl`.
    struct SceneBounds {
        /// Least corner, ordered integers.
        lo: [u32; 3],
        /// Greatest corner, ordered integers.
        hi: [u32; 3],
        /// Triangles that can be hit.
        hittable: u32,
        /// Bits of the (high) Morton codes that are 1 somewhere.
        ones: u32,
        /// Bits of the (high) Morton codes that are 0 somewhere.
        zeros: u32,
        /// As `ones`, of the low words of codes that have two.
        low_ones: u32,
        /// As `zeros`, of the low words.
        low_zeros: u32,
    }
    /// A box that many invocations grow. Floats as ordered integers: see `ordered` in `glsl/lib/ordered.glsl`.
    struct OrderedBounds {
        /// Least corner, ordered integers.
        lo: [u32; 3],
        /// Greatest corner.
        hi: [u32; 3],
    }
    /// Three axes at right angles, of length 1 but for rounding.
    struct Basis {
        /// First.
        x: [f32; 3],
        /// Second.
        y: [f32; 3],
        /// Third.
        z: [f32; 3],
    }
    /// A cluster of PLOC, beside its box.
    struct Cluster {
        /// Raw node, or [`LEAF_BIT`] | Morton rank of a triangle.
        node: u32,
        /// Morton rank of the first triangle: unique among live clusters, rising.
        rank: u32,
        /// Triangles.
        count: u32,
        /// Least expected cost of the subtree, as one child of a packed node and as up to two and three of them, times
        /// its half area (not divided by the scene's) \[YLITIE17\].
        cost: [f32; 3],
    }
    /// An inner node of the binary tree before collapse and layout.
    struct RawNode {
        /// First child's box, unit space.
        left_bounds: Aabb,
        /// Second child's box, unit space.
        right_bounds: Aabb,
        /// First child: raw node, with [`COLLAPSED_BIT`] and [`ABSORBED_BIT`], or [`LEAF_BIT`] | Morton rank.
        left: u32,
        /// Second child.
        right: u32,
    }
    /// How a raw node is best cut into children of packed nodes.
    struct RawCut {
        /// Triangles below.
        count: u32,
        /// Two bits each for a packed node of its own, and for its place in another one's, as up to two and three
        /// children of that: how many of the children its first side gets. 0: it is a leaf; one fewer cost no more.
        /// Then [`KEPT_BIT`].
        choices: u32,
    }
    /// An inner node of a packed tree, one 64-byte line: up to four children, their boxes on the node's own grid of
    /// 256 planes an axis, rounded outward: plane q lies at origin + q · 2^exponent \[YLITIE17\]. All four boxes have
    /// the directions of the node's frame \[DOBB25\].
    struct Node {
        /// Least corner of the node's box, unit space; of an oriented node in its frame.
        origin: [f32; 3],
        /// Exponents + 127 of x, y, z in the low three bytes; [`ORIENTED_BIT`] where there is a frame.
        exponents: u32,
        /// Least planes of the children, child k's in byte k; 255 where there is none.
        lo: [u32; 3],
        /// Greatest planes of the children; 0 where there is none.
        hi: [u32; 3],
        /// Node, or [`LEAF_BIT`] | count − 1 | first triangle (see `SPEC_LEAF_BITS`), or [`INVALID`], which come last.
        children: [u32; 4],
        /// Rotation from unit space to the boxes' axes: see `glsl/lib/frame.glsl`; 0: none, the boxes are axis-aligned.
        frame: [u32; 2],
    }
    /// A node of a binary tree with axis-aligned boxes, the literature's 64 bytes: see `src/trace/layouts.rs`.
    struct AabbNode {
        /// First child's box, unit space.
        left: Aabb,
        /// Second child's.
        right: Aabb,
        /// Node, with [`OBB_BIT`] where it is an [`ObbNode`], or leaf as [`Node::children`] has it.
        children: [u32; 2],
        /// 0: a whole line.
        pad: [u32; 2],
    }
    /// An oriented box, by the rows of the matrix that takes unit space to a cube of edge 1 around the origin, which holds
    /// it. Of an axis-aligned one (see [`ObbNode`]) the least corner and the greatest are the first six numbers.
    struct Obb {
        /// First.
        x: [f32; 4],
        /// Second.
        y: [f32; 4],
        /// Third.
        z: [f32; 4],
    }
    /// A node of a binary tree with oriented boxes, the literature's 112 bytes.
    struct ObbNode {
        /// First child's box.
        left: Obb,
        /// Second child's.
        right: Obb,
        /// As [`AabbNode::children`].
        children: [u32; 2],
        /// Bit k: child k's box is axis-aligned. 0 where a tree has nothing but oriented ones.
        aligned: u32,
        /// 0: a whole number of pairs.
        pad: u32,
    }
    /// Triangles below a child of a packed node.
    struct Range {
        /// The first.
        first: u32,
        /// How many; 0 where there is no child.
        count: u32,
    }
    /// A triangle of a packed tree.
    struct PackedTriangle {
        /// First corner · 2^exponent.
        a: [f32; 3],
        /// Second corner.
        b: [f32; 3],
        /// Third corner.
        c: [f32; 3],
        /// Input index.
        index: u32,
    }
    /// Where PLOC stands before a round; the first four words are an indirect dispatch and its workgroup count.
    struct PlocState {
        /// Workgroups of this round's dispatches; all 0 once the tail takes over.
        groups: [u32; 3],
        /// Live clusters.
        clusters: u32,
        /// Rounds done.
        rounds: u32,
    }
    /// Where the expansion of packed nodes stands before a round; the first three words are an indirect dispatch.
    struct Expansion {
        /// Workgroups of the round's dispatch; all 0 where there is no node.
        groups: [u32; 3],
        /// The round's first place in the queue.
        first: u32,
        /// Nodes of the round.
        count: u32,
    }
    /// What a cluster that climbs leaves for its sibling, beside its box.
    struct Climber {
        /// As [`Cluster::node`].
        node: u32,
        /// As [`Cluster::count`].
        count: u32,
        /// As [`Cluster::cost`].
        cost: [f32; 3],
        /// Levels of raw nodes below, `node`'s own among them.
        levels: u32,
    }
    /// What a builder says of the binary tree.
    struct RawRoot {
        /// The root: raw node, with [`COLLAPSED_BIT`], or [`LEAF_BIT`] | 0.
        node: u32,
        /// Levels of raw nodes, or more: PLOC's rounds, none of which adds two.
        levels: u32,
        /// 1: a round of PLOC merged nothing, the tree is unfinished (never seen; see `ploc/tail`).
        stalled: u32,
        /// Cost of the root as one child, as [`Cluster::cost`].
        cost: f32,
        /// Box of all triangles, unit space.
        bounds: Aabb,
    }
    /// Box and triangle tests of one ray.
    struct Tests {
        /// Axis-aligned child boxes tested.
        boxes: u32,
        /// Child boxes of oriented nodes tested.
        oriented: u32,
        /// Triangles tested.
        triangles: u32,
        /// 0: a whole number of pairs.
        pad: u32,
    }
    /// What one ray has part in, and of that what it alone counts for its subgroup: see `glsl/lib/steps.glsl`.
    struct Steps {
        /// Nodes visited; of a packet, those of which the ray meets a child.
        nodes: u32,
        /// Nodes counted for the subgroup.
        node_steps: u32,
        /// Triangles tested.
        triangles: u32,
        /// Triangles counted for the subgroup.
        triangle_steps: u32,
    }
    /// Where a primary ray met the scene, made ready for secondary rays.
    struct Surface {
        /// Hit point, off the triangle by a bound on its rounding.
        origin: [f32; 3],
        /// Unit normal, facing the primary.
        normal: [f32; 3],
        /// The primary's index.
        primary: u32,
        /// 0: a whole number of pairs.
        pad: u32,
    }
}

impl Hit {
    /// What a query writes where nothing is hit.
    pub const MISS: Hit = Hit { t: f32::INFINITY, triangle: INVALID, u: 0.0, v: 0.0 };
    /// Whether the ray met something.
    pub fn is_hit(&self) -> bool {
        self.t < f32::INFINITY
    }
}

impl OrderedBounds {
    /// Of nothing.
    pub const EMPTY: OrderedBounds = OrderedBounds { lo: [u32::MAX; 3], hi: [0; 3] };
}

impl SceneBounds {
    /// Of no triangle: what `morton/bounds` starts from.
    pub const EMPTY: SceneBounds = SceneBounds {
        lo: [u32::MAX; 3],
        hi: [0; 3],
        hittable: 0,
        ones: 0,
        zeros: 0,
        low_ones: 0,
        low_zeros: 0,
    };
}
