//! Collapse after the fit: the cuts of the binary tree are chosen anew by the areas of the boxes that DiTO fits to all its
//! nodes and triangles, where the merges went by their own. \[VEVERKOVA24\] collapses before. The area of an oriented box
//! counts as many times as an oriented node costs more: without that rotated city, hairball and tree (50k triangles) cost
//! 0.1 to 1 % more, by the recipe's costs.
//! The binary tree is laid out as a packed one of two children a node and fitted as such; of that nothing is kept but the
//! cuts.

use super::collapse::number;
use super::morton::Space;
use super::raw::RawTree;
use super::sort::Order;
use super::{Build, Result, dito, layout};
use crate::abi::{
    COLLAPSED_BIT, RecutClimbArgs, RecutWholeArgs, SPEC_ITEMS, SPEC_LEAF_BITS, SPEC_POINTS, SPEC_WG,
};
use crate::kernels;

/// Chooses the cuts of `tree` by DiTO's boxes, from `points` extremal points each.
pub(super) fn choose(
    build: &mut Build<'_>,
    order: &Order,
    tree: &mut RawTree,
    space: &Space,
    points: u32,
) -> Result<()> {
    let Some(nodes) = tree.count.checked_sub(1).filter(|nodes| *nodes > 0) else {
        build.note("recut: skipped, there is no inner node");
        return Ok(());
    };
    let shape = build.device.shape().clone();
    let tile = shape.workgroup * shape.items;
    let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items)];
    let mut rec = build.recorder()?;
    rec.dispatch(
        &kernels::RECUT_WHOLE,
        &constants,
        nodes.div_ceil(tile),
        RecutWholeArgs { cuts: tree.cuts.ptr_mut(), count: nodes },
    )?;
    build.run(rec)?;
    tree.root.node &= !COLLAPSED_BIT;
    let kept = number(build, tree)?;
    // Each raw node's packed index is its own, for all are kept.
    let binary = layout::pack(build, order, tree, &kept, space)?;
    drop(kept);
    let slots = dito::fit(build, &binary, points)?;
    let arrived = build.buffer::<u32>("recut.arrived", nodes as usize)?;
    let costs = build.buffer::<f32>("recut.costs", 3 * nodes as usize)?;
    let collapse = &build.recipe.collapse;
    let mut rec = build.recorder()?;
    rec.fill(&arrived, nodes as usize, 0);
    rec.dispatch(
        &kernels::RECUT_CLIMB,
        &[constants[0], constants[1], (SPEC_POINTS, points), (SPEC_LEAF_BITS, binary.leaf_bits)],
        nodes.div_ceil(tile),
        RecutClimbArgs {
            nodes: binary.nodes.ptr(),
            raw: tree.nodes.ptr(),
            parents: slots.parents.ptr(),
            points: slots.points.ptr().cast(),
            ranges: slots.ranges.ptr(),
            frames: slots.frames.ptr(),
            arrived: arrived.ptr_shared(),
            costs: costs.ptr_shared(),
            cuts: tree.cuts.ptr_mut(),
            root: tree.root_buffer.ptr_mut(),
            count: nodes,
            node_cost: collapse.node_cost,
            triangle_cost: collapse.triangle_cost,
            max_leaf: collapse.max_leaf,
            dearer: build.recipe.dearer(),
        },
    )?;
    build.run(rec)?;
    tree.root = tree.root_buffer.read()?[0];
    build.note(format!("recut: cuts chosen by the boxes of {nodes} binary nodes, from {points} points each"));
    Ok(())
}
