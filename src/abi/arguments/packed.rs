//! Arguments of what makes the packed tree of the binary one.

use crate::abi::*;

abi! {
    /// Push constants of these kernels.
    PACKED:
    @kernel "collapse/expand"
    struct CollapseExpandArgs {
        /// The tree: references to the children gain their bits.
        raw: PtrMut<RawNode>,
        /// One a node; those kept are marked.
        cuts: PtrMut<RawCut>,
        /// The nodes kept, a round after the other; this round's are read, the next one's written.
        queue: PtrMut<u32>,
        /// First triangle below each of them, in the order of the tree read left to right; the root's is 0.
        firsts: PtrMut<u32>,
        /// One a round: the next one, all 0 before, is written.
        state: PtrMut<Expansion>,
        /// This round.
        round: u32,
    }
    @kernel "collapse/count"
    struct CollapseCountArgs {
        /// The tree, from `collapse/expand`.
        raw: Ptr<RawNode>,
        /// One a node, likewise.
        cuts: Ptr<RawCut>,
        /// Nodes kept a workgroup.
        sums: PtrMut<u32>,
        /// Half areas a workgroup: of the binary nodes outside leaves, and of leaves, times their triangles.
        areas: PtrMut<[f32; 2]>,
        /// Raw nodes.
        count: u32,
    }
    @kernel "collapse/number"
    struct CollapseNumberArgs {
        /// From `collapse/count`, scanned.
        sums: Ptr<u32>,
        /// One a node, from `collapse/expand`.
        cuts: Ptr<RawCut>,
        /// Packed index of each kept node.
        packed: PtrMut<u32>,
        /// The kept nodes, in order.
        kept: PtrMut<u32>,
        /// Raw nodes.
        count: u32,
    }
    @kernel "recut/whole"
    struct RecutWholeArgs {
        /// One a node; only choices change.
        cuts: PtrMut<RawCut>,
        /// Raw nodes.
        count: u32,
    }
    @kernel "recut/climb"
    struct RecutClimbArgs {
        /// The binary tree as a packed one: node i is raw node i.
        nodes: Ptr<Node>,
        /// The binary tree.
        raw: Ptr<RawNode>,
        /// From `dito/parents`.
        parents: Ptr<u32>,
        /// From `dito/extremes`.
        points: Ptr<Pair>,
        /// From `dito/extremes`.
        ranges: Ptr<Range>,
        /// From `dito/fit`.
        frames: Ptr<Pair>,
        /// One a node: inner children that have arrived; all 0 before.
        arrived: PtrShared<u32>,
        /// Three a node, as [`Cluster::cost`].
        costs: PtrShared<f32>,
        /// One a node.
        cuts: PtrMut<RawCut>,
        /// One: node and cost change.
        root: PtrMut<RawRoot>,
        /// Raw nodes.
        count: u32,
        /// Cost of a packed node.
        node_cost: f32,
        /// Cost of a triangle test.
        triangle_cost: f32,
        /// Triangles that a leaf may hold.
        max_leaf: u32,
        /// What an oriented node costs over an axis-aligned one.
        dearer: f32,
    }
    @kernel "layout/nodes"
    struct LayoutNodesArgs {
        /// The tree.
        raw: Ptr<RawNode>,
        /// The kept nodes, in order.
        kept: Ptr<u32>,
        /// Packed index of each kept node.
        packed: Ptr<u32>,
        /// One a node.
        cuts: Ptr<RawCut>,
        /// First triangle below each kept node.
        firsts: Ptr<u32>,
        /// Triangles in Morton order.
        order: Ptr<u32>,
        /// The packed tree.
        nodes: PtrMut<Node>,
        /// Triangles in leaf order: input indices.
        sequence: PtrMut<u32>,
        /// Kept nodes.
        count: u32,
    }
    @kernel "layout/triangles"
    struct LayoutTrianglesArgs {
        /// Corners, nine floats a triangle.
        source: Ptr<Pair>,
        /// Triangles in leaf order: input indices.
        sequence: Ptr<u32>,
        /// The tree's triangles.
        triangles: PtrMut<PackedTriangle>,
        /// Triangles.
        count: u32,
        /// Unit space is scene · `scale` − anchor.
        scale: f32,
    }
    @kernel "layout/leaf"
    struct LayoutLeafArgs {
        /// The tree.
        raw: Ptr<RawNode>,
        /// From the builder.
        root: Ptr<RawRoot>,
        /// Triangles in Morton order.
        order: Ptr<u32>,
        /// The packed tree: one node.
        nodes: PtrMut<Node>,
        /// Triangles in leaf order: input indices.
        sequence: PtrMut<u32>,
    }
}
