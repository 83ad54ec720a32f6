//! Arguments of what turns boxes.

use crate::abi::*;

abi! {
    /// Push constants of these kernels.
    BOXES:
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
}
