//! Leaves of several triangles: the merges have marked each subtree that costs less as one leaf; here the marks that
//! count are found (no mark above them) and what is kept is numbered.

use super::raw::RawTree;
use super::{Build, Result};
use crate::abi::{CollapseCountArgs, CollapseNumberArgs, SPEC_ITEMS, SPEC_WG, ScanExclusiveArgs, WIDTH};
use crate::device::Buffer;
use crate::kernels;

/// Which raw nodes the packed tree keeps, and where they go.
pub(super) struct Kept {
    /// Packed index of each kept raw node.
    pub packed: Buffer<u32>,
    /// The kept raw nodes, in order.
    pub nodes: Buffer<u32>,
    /// First triangle of the leaves among the children of each packed node.
    pub leaf_triangles: Buffer<u32>,
    /// Nodes kept; 0 where the whole scene is one leaf.
    pub count: u32,
    /// Packed index of the root.
    pub root: u32,
}

/// Finds and numbers the nodes to keep.
pub(super) fn number(build: &mut Build<'_>, tree: &RawTree) -> Result<Kept> {
    let shape = build.device.shape().clone();
    let nodes = tree.count.saturating_sub(1);
    let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items)];
    let groups = nodes.div_ceil(shape.workgroup * shape.items);
    let kept = Kept {
        packed: build.buffer("collapse.packed", nodes as usize)?,
        nodes: build.buffer("collapse.kept", nodes as usize)?,
        leaf_triangles: build.buffer("collapse.leaf_triangles", nodes as usize)?,
        count: 0,
        root: 0,
    };
    if nodes == 0 {
        return Ok(kept);
    }
    let sums = build.buffer::<u32>("collapse.sums", 2 * groups as usize)?;
    let total = build.buffer::<u32>("collapse.total", 1)?;
    let mut rec = build.recorder()?;
    rec.dispatch(
        &kernels::COLLAPSE_COUNT,
        &constants,
        groups,
        CollapseCountArgs {
            raw: tree.nodes.ptr(),
            links: tree.links.ptr(),
            sums: sums.ptr_mut(),
            leaf_triangles: kept.leaf_triangles.ptr_mut(),
            count: nodes,
            groups,
            max_leaf: build.recipe.collapse.max_leaf,
        },
    )?;
    rec.dispatch(
        &kernels::SCAN_EXCLUSIVE,
        &[(SPEC_WG, shape.single_workgroup)],
        1,
        ScanExclusiveArgs { sums: sums.ptr_mut(), total: total.ptr_mut(), count: 2 * groups },
    )?;
    rec.dispatch(
        &kernels::COLLAPSE_NUMBER,
        &constants,
        groups,
        CollapseNumberArgs {
            sums: sums.ptr(),
            leaf_triangles: kept.leaf_triangles.ptr_mut(),
            packed: kept.packed.ptr_mut(),
            kept: kept.nodes.ptr_mut(),
            count: nodes,
            groups,
        },
    )?;
    build.run(rec)?;
    // Both kinds were summed in one scan: all nodes, then all triangles.
    let all = total.read()?[0];
    let count = all.saturating_sub(tree.count);
    let root = if count == 0 { 0 } else { kept.packed.read_at(tree.root.node as usize)? };
    build.note(format!(
        "collapse: {count} of {nodes} binary nodes kept, of up to {WIDTH} children, leaves of up to {} triangles",
        build.recipe.collapse.max_leaf
    ));
    debug_assert!(count > 0 || tree.count <= crate::abi::MAX_LEAF);
    Ok(Kept { count, root, ..kept })
}
