//! Oriented nodes: a packed node whose children's boxes cost less in another frame is packed again in that one, the same
//! 64 bytes; the others stay axis-aligned and cost no more than before \[DOBB25\].
//! Differs: any rotation, not one of a table; of those of the node's own and its children's DiTO boxes the one whose
//! boxes are expected to cost least, refitted to all triangles.

use super::dito::{Slots, slots_of};
use super::{Build, Bvh, Result};
use crate::abi::{
    OrderedBounds, OrientChooseArgs, OrientPackArgs, OrientRefitArgs, Pair, SPEC_ITEMS, SPEC_POINTS,
    SPEC_STACK, SPEC_WG, WIDTH,
};
use crate::kernels;

/// Orients the nodes of `bvh` where it pays; `slots` from `points` extremal points each.
pub(super) fn orient(build: &mut Build<'_>, bvh: &mut Bvh, slots: &Slots, points: u32) -> Result<()> {
    let shape = build.device.shape().clone();
    let nodes = bvh.nodes.len();
    let count = nodes as u32;
    let chosen = build.buffer::<Pair>("orient.chosen", nodes)?;
    let extents = build.buffer::<OrderedBounds>("orient.extents", slots_of(nodes) - 1)?;
    let wanted = build.buffer::<u32>("orient.wanted", 1)?;
    let oriented = build.buffer::<u32>("orient.oriented", 1)?;
    let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items), (SPEC_POINTS, points)];
    let tile = shape.workgroup * shape.items;
    let (node_cost, triangle_cost) = (build.recipe.collapse.node_cost, build.recipe.collapse.triangle_cost);
    let oriented_cost = build.recipe.oriented_cost;
    let mut rec = build.recorder()?;
    rec.fill(&wanted, 1, 0);
    rec.fill(&oriented, 1, 0);
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
            chosen: chosen.ptr_mut(),
            extents: extents.ptr_mut(),
            oriented: wanted.ptr_mut(),
            count,
            node_cost,
            oriented_cost,
            triangle_cost,
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
            chosen: chosen.ptr(),
            extents: extents.ptr_mut(),
            count: bvh.triangle_count,
            root: bvh.root,
            anchor: bvh.anchor,
        },
    )?;
    rec.dispatch(
        &kernels::ORIENT_PACK,
        &constants[..2],
        count.div_ceil(tile),
        OrientPackArgs {
            ranges: slots.ranges.ptr(),
            chosen: chosen.ptr(),
            extents: extents.ptr(),
            nodes: bvh.nodes.ptr_mut(),
            oriented: oriented.ptr_mut(),
            count,
            node_cost,
            oriented_cost,
            triangle_cost,
        },
    )?;
    build.run(rec)?;
    bvh.oriented = oriented.read_at(0)?;
    build.note(format!("orient: {} of {nodes} nodes oriented, {wanted} tried", bvh.oriented));
    Ok(())
}
