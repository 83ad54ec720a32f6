//! Arguments of what makes the binary tree.

use crate::abi::*;

abi! {
    /// Push constants of these kernels.
    BINARY:
    @kernel "ploc/leaves"
    struct PlocLeavesArgs {
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// Triangles in Morton order.
        order: Ptr<u32>,
        /// Boxes of the clusters, unit space.
        bounds: PtrMut<Aabb>,
        /// Clusters.
        clusters: PtrMut<Cluster>,
        /// Triangles.
        count: u32,
        /// Unit space is scene · `scale` − `anchor`.
        scale: f32,
        /// As above.
        anchor: [f32; 3],
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
    }
    @kernel "ploc/search" "ploc/search_loads"
    struct PlocSearchArgs {
        /// Boxes of the clusters: `capacity` after an even number of rounds, then `capacity` after an odd one.
        bounds: Ptr<Aabb>,
        /// One a round.
        state: Ptr<PlocState>,
        /// Key of each cluster's least pair.
        nearest: PtrMut<u32>,
        /// This round.
        round: u32,
        /// Clusters that one half of `bounds` holds.
        capacity: u32,
    }
    @kernel "ploc/count"
    struct PlocCountArgs {
        /// Key of each cluster's least pair.
        nearest: Ptr<u32>,
        /// One a round.
        state: Ptr<PlocState>,
        /// Clusters that live on, a workgroup.
        sums: PtrMut<u32>,
        /// This round.
        round: u32,
    }
    @kernel "ploc/scan"
    struct PlocScanArgs {
        /// Clusters that live on, a workgroup; becomes the sum of those before.
        sums: PtrMut<u32>,
        /// One a round: the next one is written.
        state: PtrMut<PlocState>,
        /// This round.
        round: u32,
        /// Clusters that one workgroup of the round's kernels handles.
        tile: u32,
        /// No round begins with as few clusters as these.
        last: u32,
    }
    @kernel "ploc/merge"
    struct PlocMergeArgs {
        /// Key of each cluster's least pair.
        nearest: Ptr<u32>,
        /// From `ploc/scan`.
        sums: Ptr<u32>,
        /// One a round.
        state: Ptr<PlocState>,
        /// Boxes of the clusters, two halves: from one to the other.
        bounds: PtrMut<Aabb>,
        /// Clusters, two halves likewise.
        clusters: PtrMut<Cluster>,
        /// The tree.
        nodes: PtrMut<RawNode>,
        /// One a node.
        cuts: PtrMut<RawCut>,
        /// This round.
        round: u32,
        /// Clusters that one half holds.
        capacity: u32,
        /// Cost of a packed node, c_N.
        node_cost: f32,
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
        /// Largest leaf.
        max_leaf: u32,
    }
    @kernel "ploc/tail"
    struct PlocTailArgs {
        /// Key of each cluster's least pair.
        nearest: PtrShared<u32>,
        /// Boxes of the clusters, two halves.
        bounds: PtrShared<Aabb>,
        /// Clusters, two halves.
        clusters: PtrShared<Cluster>,
        /// One a round.
        state: Ptr<PlocState>,
        /// The tree.
        nodes: PtrMut<RawNode>,
        /// One a node.
        cuts: PtrShared<RawCut>,
        /// One.
        root: PtrMut<RawRoot>,
        /// The round whose state is the last.
        round: u32,
        /// Clusters that one half holds.
        capacity: u32,
        /// Cost of a packed node, c_N.
        node_cost: f32,
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
        /// Largest leaf.
        max_leaf: u32,
    }
    @kernel "odop/project"
    struct OdopProjectArgs {
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// Triangles in Morton order.
        order: Ptr<u32>,
        /// The triangle behind each in its cluster, ranks; not followed before a round has been done.
        next: Ptr<u32>,
        /// All bases.
        bases: Ptr<Basis>,
        /// Addresses of slabs: boxes of clusters in a basis.
        slabs: Ptr<Pair>,
        /// Where each cluster's boxes lie in a slab, two halves as `clusters`.
        slots: PtrMut<u32>,
        /// Clusters, two halves.
        clusters: PtrMut<Cluster>,
        /// One a round.
        state: Ptr<PlocState>,
        /// This round.
        round: u32,
        /// Clusters that one half holds.
        capacity: u32,
        /// First basis.
        first: u32,
        /// Bases.
        count: u32,
        /// Slab of the first.
        slab: u32,
        /// Unit space is scene · `scale` − `anchor`.
        scale: f32,
        /// As above.
        anchor: [f32; 3],
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
    }
    @kernel "odop/search" "odop/search_loads"
    struct OdopSearchArgs {
        /// Addresses of slabs.
        slabs: Ptr<Pair>,
        /// Where each cluster's boxes lie in a slab, two halves.
        slots: Ptr<u32>,
        /// One a round.
        state: Ptr<PlocState>,
        /// Key of each cluster's least pair, in the bases before `first` and then also in these.
        nearest: PtrMut<u32>,
        /// This round.
        round: u32,
        /// Clusters that one half holds.
        capacity: u32,
        /// First basis.
        first: u32,
        /// Bases.
        count: u32,
        /// Slab of the first.
        slab: u32,
    }
    @kernel "odop/merge"
    struct OdopMergeArgs {
        /// Key of each cluster's least pair.
        nearest: Ptr<u32>,
        /// From `ploc/scan`.
        sums: Ptr<u32>,
        /// One a round.
        state: Ptr<PlocState>,
        /// Axis-aligned boxes of the clusters, two halves: from one to the other.
        bounds: PtrMut<Aabb>,
        /// Clusters, two halves likewise.
        clusters: PtrMut<Cluster>,
        /// Where their boxes lie in a slab, likewise.
        slots: PtrMut<u32>,
        /// Slots of the clusters that merged, first and second.
        pairs: PtrMut<Pair>,
        /// The tree.
        nodes: PtrMut<RawNode>,
        /// One a node.
        cuts: PtrMut<RawCut>,
        /// This round.
        round: u32,
        /// Clusters that one half holds.
        capacity: u32,
        /// Cost of a packed node, c_N.
        node_cost: f32,
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
        /// Largest leaf.
        max_leaf: u32,
    }
    @kernel "odop/unite"
    struct OdopUniteArgs {
        /// Addresses of slabs.
        slabs: Ptr<Pair>,
        /// Slots of the clusters that merged.
        pairs: Ptr<Pair>,
        /// One a round.
        state: Ptr<PlocState>,
        /// This round.
        round: u32,
        /// Bases: the first slabs.
        count: u32,
    }
    @kernel "odop/link"
    struct OdopLinkArgs {
        /// Places of the clusters that merged, before the round.
        pairs: Ptr<Pair>,
        /// Clusters, two halves.
        clusters: Ptr<Cluster>,
        /// One a round.
        state: Ptr<PlocState>,
        /// The triangle behind each in its cluster, ranks.
        next: PtrMut<u32>,
        /// The last triangle of a cluster, by its first; [`INVALID`]: the same.
        tails: PtrMut<u32>,
        /// This round.
        round: u32,
        /// Clusters that one half holds.
        capacity: u32,
    }
    @kernel "lbvh/climb"
    struct LbvhClimbArgs {
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// Triangles in Morton order.
        order: Ptr<u32>,
        /// Their codes: of 30 bits, or the upper 31 of 63.
        keys: Ptr<u32>,
        /// Low 32 of 63 bits; not followed where `wide` is 0.
        low_keys: Ptr<u32>,
        /// The tree.
        nodes: PtrShared<RawNode>,
        /// One a node.
        cuts: PtrMut<RawCut>,
        /// Two a node, left and right: what has arrived there.
        climbers: PtrShared<Climber>,
        /// One a node: sides that have arrived; all 0 before.
        arrived: PtrShared<u32>,
        /// One.
        root: PtrMut<RawRoot>,
        /// Triangles.
        count: u32,
        /// Unit space is scene · `scale` − `anchor`.
        scale: f32,
        /// As above.
        anchor: [f32; 3],
        /// Cost of a packed node, c_N.
        node_cost: f32,
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
        /// Largest leaf.
        max_leaf: u32,
        /// 1: codes of two words.
        wide: u32,
    }
}
