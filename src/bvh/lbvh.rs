//! LBVH: the radix tree over the Morton codes is the tree \[KARRAS12\], built from its leaves in one pass \[APETREI14\].
//! Fast, and the yardstick below PLOC: no box is looked at before the tree stands.
//! Differs: equal codes are told apart by rank; nodes are numbered by where they split, and the surface area
//! heuristic's leaves decided at each merge, as PLOC does.

use super::morton::Space;
use super::raw::RawTree;
use super::sort::Order;
use super::{Build, Result};
use crate::abi::{Climber, LbvhClimbArgs, Ptr, SPEC_ITEMS, SPEC_WG};
use crate::device::Buffer;
use crate::kernels;

/// Builds the radix tree over the triangles of `order`.
pub(super) fn climb(build: &mut Build<'_>, order: &mut Order, space: &Space) -> Result<RawTree> {
    let shape = build.device.shape().clone();
    let n = order.count;
    let inner = n.saturating_sub(1) as usize;
    let mut tree = RawTree::new(build, n)?;
    // Taken: the codes go with this pass.
    let Some(keys) = order.keys.take().filter(|_| n > 0) else {
        build.note("lbvh: skipped, no triangle can be hit");
        return Ok(tree);
    };
    let climbers = build.buffer::<Climber>("lbvh.climbers", 2 * inner)?;
    let arrived = build.buffer::<u32>("lbvh.arrived", inner)?;
    let collapse = &build.recipe.collapse;
    let mut rec = build.recorder()?;
    if inner > 0 {
        rec.fill(&arrived, inner, 0);
    }
    rec.dispatch(
        &kernels::LBVH_CLIMB,
        &[(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items)],
        n.div_ceil(shape.workgroup * shape.items),
        LbvhClimbArgs {
            triangles: build.scene.triangles.ptr().cast(),
            order: order.triangles.ptr(),
            keys: keys.high.ptr(),
            low_keys: keys.low.as_ref().map_or(Ptr::new(0), Buffer::ptr),
            nodes: tree.nodes.ptr_shared(),
            cuts: tree.cuts.ptr_mut(),
            climbers: climbers.ptr_shared(),
            arrived: arrived.ptr_shared(),
            root: tree.root_buffer.ptr_mut(),
            count: n,
            scale: space.scale,
            anchor: space.anchor,
            node_cost: collapse.node_cost,
            triangle_cost: collapse.triangle_cost,
            max_leaf: collapse.max_leaf,
            wide: keys.low.is_some().into(),
        },
    )?;
    build.run(rec)?;
    tree.root = tree.root_buffer.read()?[0];
    build.note(format!("lbvh: {} levels of binary nodes, in one pass from the leaves", tree.root.levels));
    Ok(tree)
}
