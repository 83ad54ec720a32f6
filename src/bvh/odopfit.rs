//! Oriented nodes whose frame is the best of a set of bases, the same for all: the boxes of every node in a group of
//! bases at a time climb from the leaves, exact, and a node keeps the frame in which its children's cost least
//! \[VEVERKOVA24, 4.2\].
//! Differs: over a finished packed tree, and bases are streamed, so that memory doesn't grow with their number; nothing is
//! estimated, so nothing is refitted.

use super::dito::hang;
use super::frame::is_oriented;
use super::orient::{Choice, pack};
use super::{Build, Bvh, Result};
use crate::abi::{Aabb, OdopfitClimbArgs, Pair, SPEC_BASES, SPEC_ITEMS, SPEC_LEAF_BITS, SPEC_WG};
use crate::kernels;

/// Orients the nodes of `bvh` where one of `frames` pays.
pub(super) fn fit(build: &mut Build<'_>, bvh: &mut Bvh, frames: &[Pair]) -> Result<()> {
    let shape = build.device.shape().clone();
    let nodes = bvh.nodes.len();
    let (count, group) = (nodes as u32, shape.bases as usize);
    // The scene's axes first: they are what others are compared with. They fill up the last group as well.
    let mut bases = vec![[0; 2]];
    bases.extend(frames.iter().filter(|words| is_oriented(**words)));
    let others = bases.len() - 1;
    if others == 0 {
        build.note("odopfit: skipped, there is no basis but the scene's axes");
        return Ok(());
    }
    bases.resize(bases.len().next_multiple_of(group), [0; 2]);
    // Of a node its boxes, triangles, slot above, arrivals, least cost, frame and its children's extents.
    let above = build.recipe.least_of_bases();
    let bytes = nodes as u64 * (24 * group as u64 + 24 + 96);
    build.device.require_memory(&format!("fitting {nodes} nodes to bases, {group} at a time"), bytes)?;
    let choice = Choice::new(build, nodes)?;
    let parents = build.buffer::<u32>("odopfit.parents", nodes)?;
    let arrived = build.buffer::<u32>("odopfit.arrived", nodes)?;
    let boxes = build.buffer::<Aabb>("odopfit.boxes", nodes * group)?;
    let counts = build.buffer::<u32>("odopfit.counts", if above > 0 { nodes } else { 1 })?;
    let least = build.buffer::<f32>("odopfit.least", nodes)?;
    let words = build.buffer::<Pair>("odopfit.bases", bases.len())?;
    words.write(&bases)?;
    let constants = [
        (SPEC_WG, shape.workgroup),
        (SPEC_ITEMS, shape.items),
        (SPEC_LEAF_BITS, bvh.leaf_bits),
        (SPEC_BASES, shape.bases),
    ];
    // A submit a group: none gets too long for a display's driver.
    for first in (0..bases.len()).step_by(group) {
        let mut rec = build.recorder()?;
        if first == 0 {
            hang(&mut rec, bvh, &parents)?;
        }
        rec.fill(&arrived, nodes, 0);
        rec.dispatch(
            &kernels::ODOPFIT_CLIMB,
            &constants,
            count.div_ceil(shape.workgroup * shape.items),
            OdopfitClimbArgs {
                nodes: bvh.nodes.ptr(),
                triangles: bvh.triangles.ptr().cast(),
                parents: parents.ptr(),
                arrived: arrived.ptr_shared(),
                boxes: boxes.ptr_shared(),
                counts: counts.ptr_shared(),
                bases: words.ptr(),
                least: least.ptr_mut(),
                chosen: choice.chosen.ptr_mut(),
                extents: choice.extents.ptr_mut(),
                count,
                first: first as u32,
                above,
                anchor: bvh.anchor,
                node_cost: build.recipe.collapse.node_cost,
                oriented_cost: build.recipe.oriented_cost,
                triangle_cost: build.recipe.collapse.triangle_cost,
            },
        )?;
        build.run(rec)?;
    }
    let gained = pack(build, bvh, &choice)?;
    build.note(format!("odopfit: {gained} of {nodes} nodes oriented, by {others} bases, {group} at a time"));
    Ok(())
}
