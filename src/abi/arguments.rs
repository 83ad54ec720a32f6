//! The arguments of each kernel.

use super::*;

abi! {
    /// Push constants of kernels.
    ARGUMENTS:
    @kernel "morton/bounds"
    struct MortonBoundsArgs {
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// One; lo at the greatest and hi at the least ordered integer, the rest 0.
        bounds: PtrMut<SceneBounds>,
        /// Triangles.
        count: u32,
    }
    @kernel "morton/encode"
    struct MortonEncodeArgs {
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// One, from `morton/bounds`; gains the live bits.
        bounds: PtrMut<SceneBounds>,
        /// Codes of 30 bits, or the upper 31 of 63.
        keys: PtrMut<u32>,
        /// Low 32 of 63 bits; not followed where `code` is [`CODE_30`].
        low_keys: PtrMut<u32>,
        /// 0, 1, 2, …
        order: PtrMut<u32>,
        /// Triangles.
        count: u32,
        /// Which codes: [`CODE_30`] and those that follow it.
        code: u32,
    }
    @kernel "sort/count"
    struct SortCountArgs {
        /// Keys.
        keys: Ptr<u32>,
        /// How often each digit occurs in each tile, digit-major.
        counts: PtrMut<u32>,
        /// Keys.
        count: u32,
        /// Lowest bit of the digit.
        shift: u32,
        /// Tiles: workgroups.
        tiles: u32,
    }
    @kernel "sort/scatter"
    struct SortScatterArgs {
        /// Keys.
        keys: Ptr<u32>,
        /// What travels with them.
        values: Ptr<u32>,
        /// Where each tile's keys of each digit go, digit-major.
        offsets: Ptr<u32>,
        /// Keys in order of the digit, stable.
        keys_out: PtrMut<u32>,
        /// Values likewise.
        values_out: PtrMut<u32>,
        /// Keys.
        count: u32,
        /// Lowest bit of the digit.
        shift: u32,
        /// Tiles: workgroups.
        tiles: u32,
    }
    @kernel "sort/gather"
    struct SortGatherArgs {
        /// Values of one word.
        source: Ptr<u32>,
        /// Which of them, in order.
        order: Ptr<u32>,
        /// `source[order[i]]`.
        gathered: PtrMut<u32>,
        /// Entries of `order`.
        count: u32,
    }
    @kernel "sort/duplicates"
    struct SortDuplicatesArgs {
        /// Sorted keys.
        keys: Ptr<u32>,
        /// One: gains the keys that equal their predecessor.
        duplicates: PtrMut<u32>,
        /// Keys.
        count: u32,
    }
    @kernel "scan/exclusive"
    struct ScanExclusiveArgs {
        /// Numbers; each becomes the sum of those before it.
        sums: PtrMut<u32>,
        /// One: the sum of all.
        total: PtrMut<u32>,
        /// Numbers.
        count: u32,
    }
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
        nodes: PtrShared<RawNode>,
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
        /// One a node: 1 once the first has arrived; all 0 before.
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
        state: PtrShared<Expansion>,
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
    @kernel "dito/parents"
    struct DitoParentsArgs {
        /// The packed tree.
        nodes: Ptr<Node>,
        /// Slot above each node: 4 times the node, and which of its children.
        parents: PtrMut<u32>,
        /// Nodes.
        count: u32,
        /// Root of the packed tree, whose slot comes behind all others.
        root: u32,
    }
    @kernel "dito/extremes"
    struct DitoExtremesArgs {
        /// The packed tree.
        nodes: Ptr<Node>,
        /// Its triangles.
        triangles: Ptr<PackedTriangle>,
        /// From `dito/parents`.
        parents: Ptr<u32>,
        /// One a node: inner children that have arrived; all 0 before.
        arrived: PtrShared<u32>,
        /// k points a slot, those least and greatest along each direction.
        points: PtrShared<Pair>,
        /// Likewise, float by float.
        coordinates: PtrShared<f32>,
        /// One a slot.
        ranges: PtrShared<Range>,
        /// k / 2 directions, three floats each, with SPEC_DIRECTIONS; else none.
        directions: Ptr<f32>,
        /// Nodes.
        count: u32,
        /// Triangles of a slot that has points, at most.
        most: u32,
        /// Unit space is a triangle's corner − `anchor`.
        anchor: [f32; 3],
    }
    @kernel "dito/fit"
    struct DitoFitArgs {
        /// From `dito/extremes`.
        points: Ptr<Pair>,
        /// From `dito/extremes`.
        ranges: Ptr<Range>,
        /// Frame of each slot's least box.
        frames: PtrMut<Pair>,
        /// Slots.
        slots: u32,
        /// Triangles of a slot that has points, at most.
        most: u32,
    }
    @kernel "dito/improve"
    struct DitoImproveArgs {
        /// From `dito/extremes`.
        points: Ptr<Pair>,
        /// From `dito/extremes`.
        ranges: Ptr<Range>,
        /// From `dito/fit`.
        frames: PtrMut<Pair>,
        /// Slots.
        slots: u32,
        /// Triangles of a slot that has points, at most.
        most: u32,
        /// Boxes tried.
        evaluations: u32,
    }
    @kernel "odopfit/climb"
    struct OdopfitClimbArgs {
        /// The packed tree.
        nodes: Ptr<Node>,
        /// Its triangles.
        triangles: Ptr<PackedTriangle>,
        /// From `dito/parents`.
        parents: Ptr<u32>,
        /// One a node: inner children that have arrived; all 0 before.
        arrived: PtrShared<u32>,
        /// Boxes of each node in the group's bases.
        boxes: PtrShared<Aabb>,
        /// Triangles of each node, where `above` is more than 0.
        counts: PtrShared<u32>,
        /// Words of the bases' frames; the first is none, as are those that fill up the last group.
        bases: Ptr<Pair>,
        /// Expected cost of each node in the best frame so far, less what an oriented node costs more.
        least: PtrMut<f32>,
        /// That frame; 0: none.
        chosen: PtrMut<Pair>,
        /// Extent of each child of a node with a frame, in it.
        extents: PtrMut<OrderedBounds>,
        /// Nodes.
        count: u32,
        /// First basis of the group.
        first: u32,
        /// Nodes of more triangles than this get a frame.
        above: u32,
        /// Unit space is a triangle's corner − `anchor`.
        anchor: [f32; 3],
        /// Cost of visiting a node, c_N.
        node_cost: f32,
        /// Cost of visiting an oriented node, c_O.
        oriented_cost: f32,
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
    }
    @kernel "orient/choose"
    struct OrientChooseArgs {
        /// The packed tree.
        nodes: Ptr<Node>,
        /// From `dito/parents`.
        parents: Ptr<u32>,
        /// From `dito/extremes`.
        points: Ptr<Pair>,
        /// From `dito/extremes`.
        ranges: Ptr<Range>,
        /// From `dito/fit`.
        frames: Ptr<Pair>,
        /// Frame of each node; 0: none.
        chosen: PtrMut<Pair>,
        /// One a slot but the root's: becomes empty.
        extents: PtrMut<OrderedBounds>,
        /// One: counts the nodes that have a frame.
        oriented: PtrMut<u32>,
        /// Nodes.
        count: u32,
        /// Triangles of a node that may get a frame, at most.
        most: u32,
        /// Cost of visiting a node, c_N.
        node_cost: f32,
        /// Cost of visiting an oriented node, c_O.
        oriented_cost: f32,
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
    }
    @kernel "orient/refit"
    struct OrientRefitArgs {
        /// The packed tree.
        nodes: Ptr<Node>,
        /// Its triangles.
        triangles: Ptr<PackedTriangle>,
        /// From `dito/extremes`.
        ranges: Ptr<Range>,
        /// From `orient/choose`.
        chosen: Ptr<Pair>,
        /// Extent of each child of a node with a frame, in it.
        extents: PtrMut<OrderedBounds>,
        /// Triangles.
        count: u32,
        /// Root of the packed tree.
        root: u32,
        /// Unit space is a triangle's corner − `anchor`.
        anchor: [f32; 3],
    }
    @kernel "orient/pack"
    struct OrientPackArgs {
        /// From `orient/choose` or `odopfit/climb`.
        chosen: Ptr<Pair>,
        /// From `orient/refit` or `odopfit/climb`.
        extents: Ptr<OrderedBounds>,
        /// The packed tree: becomes oriented where that pays.
        nodes: PtrMut<Node>,
        /// One: counts the nodes that become so.
        oriented: PtrMut<u32>,
        /// Nodes.
        count: u32,
        /// Cost of visiting a node, c_N.
        node_cost: f32,
        /// Cost of visiting an oriented node, c_O.
        oriented_cost: f32,
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
    }
    @kernel "trace/single" "trace/refill" "trace/persistent" "trace/packet"
    struct TraceArgs {
        /// Rays, scene space.
        rays: Ptr<Ray>,
        /// The packed tree.
        nodes: Ptr<Node>,
        /// Its triangles.
        triangles: Ptr<PackedTriangle>,
        /// Hits, one a ray.
        hits: PtrMut<Hit>,
        /// One a ray; not followed where SPEC_COUNT is 0.
        tests: PtrMut<Tests>,
        /// Rays that `trace/persistent` has taken: one number.
        next: PtrShared<u32>,
        /// Rays in the order in which they are taken; not followed where SPEC_ORDERED is 0.
        order: Ptr<u32>,
        /// Rays.
        count: u32,
        /// Root of the packed tree.
        root: u32,
        /// Exponent of the power of two that takes scene space to unit space.
        exponent: i32,
        /// Unit space is scene · 2^exponent − `anchor`.
        anchor: [f32; 3],
        /// Largest coordinate of the tree, unit space.
        reach: f32,
        /// Threads that a software driver deals workgroups to; 1 on a GPU.
        threads: u32,
    }
    @kernel "trace/binary"
    struct TraceBinaryArgs {
        /// Rays, scene space.
        rays: Ptr<Ray>,
        /// Nodes with axis-aligned boxes; not followed where there is none.
        aabbs: Ptr<AabbNode>,
        /// Nodes with oriented boxes, likewise.
        obbs: Ptr<ObbNode>,
        /// Triangles of the packed tree.
        triangles: Ptr<PackedTriangle>,
        /// Hits, one a ray.
        hits: PtrMut<Hit>,
        /// One a ray; not followed where SPEC_COUNT is 0.
        tests: PtrMut<Tests>,
        /// Not followed: rays are taken as they come.
        order: Ptr<u32>,
        /// Rays.
        count: u32,
        /// Root of the binary tree.
        root: u32,
        /// Exponent of the power of two that takes scene space to unit space.
        exponent: i32,
        /// Unit space is scene · 2^exponent − `anchor`.
        anchor: [f32; 3],
        /// Largest coordinate of the tree, unit space.
        reach: f32,
        /// Half over the largest R of a ray that oriented boxes are padded for: see `glsl/lib/binary.glsl`.
        half_over_reach: f32,
        /// Threads that a software driver deals workgroups to; 1 on a GPU.
        threads: u32,
    }
    @kernel "raysort/bounds"
    struct RaysortBoundsArgs {
        /// Rays.
        rays: Ptr<Ray>,
        /// One; lo at the greatest and hi at the least ordered integer.
        bounds: PtrMut<OrderedBounds>,
        /// Rays.
        count: u32,
    }
    @kernel "raysort/keys"
    struct RaysortKeysArgs {
        /// Rays.
        rays: Ptr<Ray>,
        /// One, from `raysort/bounds`.
        bounds: Ptr<OrderedBounds>,
        /// Codes of 24 bits, [`UNORDERED_KEY`] for a ray that has none.
        keys: PtrMut<u32>,
        /// 0, 1, 2, …
        order: PtrMut<u32>,
        /// Rays.
        count: u32,
    }
    @kernel "rays/primary"
    struct RaysPrimaryArgs {
        /// Whole 8×8 blocks in Morton order, x | y << 16.
        blocks: Ptr<u32>,
        /// Rays.
        rays: PtrMut<Ray>,
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Origin of all rays.
        eye: [f32; 3],
        /// From the eye to the picture's top left corner.
        corner: [f32; 3],
        /// From a pixel to the next in its row.
        across: [f32; 3],
        /// From a row to the next.
        down: [f32; 3],
    }
    @kernel "rays/count"
    struct RaysCountArgs {
        /// Primaries.
        rays: Ptr<Ray>,
        /// What they met.
        hits: Ptr<Hit>,
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// Surfaces under each run of primaries.
        sums: PtrMut<u32>,
        /// First primary.
        start: u32,
        /// Behind the last.
        end: u32,
    }
    @kernel "rays/surface"
    struct RaysSurfaceArgs {
        /// Primaries.
        rays: Ptr<Ray>,
        /// What they met.
        hits: Ptr<Hit>,
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// Surfaces before each run of primaries.
        sums: Ptr<u32>,
        /// Surfaces in all; the primary before which `limit` was reached.
        taken: PtrMut<u32>,
        /// The first `limit` of them.
        surfaces: PtrMut<Surface>,
        /// First primary.
        start: u32,
        /// Behind the last.
        end: u32,
        /// Surfaces wanted.
        limit: u32,
    }
    @kernel "rays/secondary"
    struct RaysSecondaryArgs {
        /// Surfaces that rays leave.
        surfaces: Ptr<Surface>,
        /// Points of the unit square, 24-bit fixed point, one a sample.
        points: Ptr<Pair>,
        /// From `rays/surface`.
        taken: Ptr<u32>,
        /// Rays.
        rays: PtrMut<Ray>,
        /// Rays a surface.
        samples: u32,
        /// Surfaces wanted.
        limit: u32,
        /// Greatest t.
        t_max: f32,
    }
    @kernel "rays/facing" "rays/shadow"
    struct RaysShadowArgs {
        /// Surfaces that rays leave.
        surfaces: Ptr<Surface>,
        /// Points of the unit square, 24-bit fixed point, one a sample.
        points: Ptr<Pair>,
        /// From `rays/surface`.
        taken: Ptr<u32>,
        /// [`LIGHTS`] of them: centre and radius.
        lights: Ptr<[f32; 4]>,
        /// Rays made a workgroup; then the sum of those before.
        sums: PtrMut<u32>,
        /// Rays.
        rays: PtrMut<Ray>,
        /// Rays a surface, at most.
        samples: u32,
        /// Surfaces wanted.
        limit: u32,
        /// Workgroups.
        groups: u32,
        /// Greatest t.
        t_max: f32,
    }
}
