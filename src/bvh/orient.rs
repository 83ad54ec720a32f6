//! Oriented nodes: a packed node whose children's boxes cost less in another frame is packed again in that one, the same
//! 64 bytes; the others stay as they are and cost no more than before \[DOBB25\].
//! Differs: any rotation, not one of a table; of those of the node's own and its children's DiTO boxes the one whose
//! boxes are expected to cost least, refitted to all triangles, or one that [`super::odopfit`] chose.

use super::dito::{Slots, slots_of};
use super::{Build, Bvh, Result};
use crate::abi::{
    OrderedBounds, OrientChooseArgs, OrientPackArgs, OrientRefitArgs, Pair, SPEC_ITEMS, SPEC_LEAF_BITS,
    SPEC_POINTS, SPEC_STACK, SPEC_WG, WIDTH,
};
use crate::device::Buffer;
use crate::kernels;

/// What nodes may become.
pub(super) struct Choice {
    /// Frame of each node; 0: none.
    pub chosen: Buffer<Pair>,
    /// Extent of each child of a node with a frame, in it.
    pub extents: Buffer<OrderedBounds>,
}

impl Choice {
    /// Of `nodes` nodes, not cleared.
    pub(super) fn new(build: &Build<'_>, nodes: usize) -> Result<Self> {
        Ok(Self {
            chosen: build.buffer("orient.chosen", nodes)?,
            extents: build.buffer("orient.extents", slots_of(nodes) - 1)?,
        })
    }
}

/// Orients the nodes of `bvh` where it pays; `slots` from `points` extremal points each.
pub(super) fn orient(build: &mut Build<'_>, bvh: &mut Bvh, slots: &Slots, points: u32) -> Result<()> {
    let shape = build.device.shape().clone();
    let nodes = bvh.nodes.len();
    let count = nodes as u32;
    let choice = Choice::new(build, nodes)?;
    let wanted = build.buffer::<u32>("orient.wanted", 1)?;
    let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items), (SPEC_POINTS, points)];
    let tile = shape.workgroup * shape.items;
    let mut rec = build.recorder()?;
    rec.fill(&wanted, 1, 0);
    rec.dispatch(
        &kernels::ORIENT_CHOOSE,
        &constants,
        count.div_ceil(tile),
        OrientChooseArgs {
            nodes: bvh.nodes.ptr(),
            parents: slots.parents.ptr(),
            points: slots.points.ptr().cast(),
            ranges: slots.ranges.ptr(),
            frames: slots.frames.ptr(),
            chosen: choice.chosen.ptr_mut(),
            extents: choice.extents.ptr_mut(),
            oriented: wanted.ptr_mut(),
            count,
            most: build.recipe.most_of_points(),
            node_cost: build.recipe.collapse.node_cost,
            oriented_cost: build.recipe.oriented_cost,
            triangle_cost: build.recipe.collapse.triangle_cost,
        },
    )?;
    build.run(rec)?;
    let wanted = wanted.read_at(0)?;
    if wanted == 0 {
        build
            .note(format!("orient: skipped, none of {nodes} nodes has a frame in which its boxes cost less"));
        return Ok(());
    }
    let mut rec = build.recorder()?;
    let refit = [
        (SPEC_WG, shape.workgroup),
        (SPEC_ITEMS, shape.refit_items),
        (SPEC_STACK, bvh.depth.saturating_mul(WIDTH - 1).next_multiple_of(32).max(64)),
    ];
    rec.dispatch(
        &kernels::ORIENT_REFIT,
        &refit,
        bvh.triangle_count.div_ceil(shape.workgroup * shape.refit_items),
        OrientRefitArgs {
            nodes: bvh.nodes.ptr(),
            triangles: bvh.triangles.ptr().cast(),
            ranges: slots.ranges.ptr(),
            chosen: choice.chosen.ptr(),
            extents: choice.extents.ptr_mut(),
            count: bvh.triangle_count,
            root: bvh.root,
            anchor: bvh.anchor,
        },
    )?;
    build.run(rec)?;
    let gained = pack(build, bvh, &choice)?;
    build.note(format!(
        "orient: {} of {nodes} nodes oriented, {gained} of them now; {wanted} tried",
        bvh.oriented
    ));
    Ok(())
}

/// Packs the nodes again whose boxes cost less as chosen; how many became oriented.
pub(super) fn pack(build: &mut Build<'_>, bvh: &mut Bvh, choice: &Choice) -> Result<u32> {
    let shape = build.device.shape().clone();
    let count = bvh.nodes.len() as u32;
    let oriented = build.buffer::<u32>("orient.oriented", 1)?;
    let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items), (SPEC_LEAF_BITS, bvh.leaf_bits)];
    let mut rec = build.recorder()?;
    rec.fill(&oriented, 1, 0);
    rec.dispatch(
        &kernels::ORIENT_PACK,
        &constants,
        count.div_ceil(shape.workgroup * shape.items),
        OrientPackArgs {
            chosen: choice.chosen.ptr(),
            extents: choice.extents.ptr(),
            nodes: bvh.nodes.ptr_mut(),
            oriented: oriented.ptr_mut(),
            count,
            node_cost: build.recipe.collapse.node_cost,
            oriented_cost: build.recipe.oriented_cost,
            triangle_cost: build.recipe.collapse.triangle_cost,
        },
    )?;
    build.run(rec)?;
    let gained = oriented.read_at(0)?;
    bvh.oriented += gained;
    Ok(gained)
}
