//! The packed tree: kept nodes as 64-byte lines of up to four children, triangles in leaf order.

use super::collapse::Kept;
use super::morton::Space;
use super::raw::RawTree;
use super::sort::Order;
use super::{Build, Bvh, Result, leaf_bits};
use crate::abi::{
    INVALID, LayoutLeafArgs, LayoutNodesArgs, LayoutTrianglesArgs, Node, RawRoot, SPEC_ITEMS, SPEC_LEAF_BITS,
    SPEC_WG, TRIANGLE_WORDS,
};
use crate::kernels;

/// Packs what is kept of `tree`.
pub(super) fn pack(
    build: &mut Build<'_>,
    order: &Order,
    tree: &RawTree,
    kept: &Kept,
    space: &Space,
) -> Result<Bvh> {
    let shape = build.device.shape().clone();
    let n = tree.count as usize;
    let bits = leaf_bits(build.recipe.collapse.max_leaf);
    let whole_leaf = n > 0 && kept.count == 0;
    let node_count = if whole_leaf { 1 } else { kept.count as usize };
    build.peak_before_tree = build.device.peak_memory();
    let nodes = build.buffer::<Node>("bvh.nodes", node_count)?;
    let triangles = build.buffer::<u32>("bvh.triangles", n * TRIANGLE_WORDS as usize)?;
    let sequence = build.buffer::<u32>("layout.sequence", n)?;
    let mut rec = build.recorder()?;
    let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items), (SPEC_LEAF_BITS, bits)];
    let tile = shape.workgroup * shape.items;
    if whole_leaf {
        rec.dispatch(
            &kernels::LAYOUT_LEAF,
            &[(SPEC_WG, 1), (SPEC_LEAF_BITS, bits)],
            1,
            LayoutLeafArgs {
                raw: tree.nodes.ptr(),
                root: tree.root_buffer.ptr(),
                order: order.triangles.ptr(),
                nodes: nodes.ptr_mut(),
                sequence: sequence.ptr_mut(),
            },
        )?;
    } else {
        rec.dispatch(
            &kernels::LAYOUT_NODES,
            &constants,
            kept.count.div_ceil(tile),
            LayoutNodesArgs {
                raw: tree.nodes.ptr(),
                kept: kept.nodes.ptr(),
                packed: kept.packed.ptr(),
                cuts: tree.cuts.ptr(),
                firsts: kept.firsts.ptr(),
                order: order.triangles.ptr(),
                nodes: nodes.ptr_mut(),
                sequence: sequence.ptr_mut(),
                count: kept.count,
            },
        )?;
    }
    rec.dispatch(
        &kernels::LAYOUT_TRIANGLES,
        &constants[..2],
        tree.count.div_ceil(tile),
        LayoutTrianglesArgs {
            source: build.scene.triangles.ptr().cast(),
            sequence: sequence.ptr(),
            triangles: triangles.ptr_mut().cast(),
            count: tree.count,
            scale: space.scale,
        },
    )?;
    build.run(rec)?;
    let RawRoot { levels, bounds, .. } = tree.root;
    Ok(Bvh {
        nodes,
        triangles,
        root: if n == 0 { INVALID } else { kept.root },
        leaf_bits: bits,
        depth: levels.max(1),
        exponent: space.exponent,
        anchor: space.anchor,
        reach: space.reach,
        bounds,
        sah: kept.sah,
        triangle_count: tree.count,
        left_out: (build.scene.count() - n) as u32,
        oriented: 0,
        axis_aligned: None,
    })
}
