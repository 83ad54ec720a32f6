//! DiTO: a small oriented box of every child of a packed tree, from extremal points that climb from the leaves
//! \[LARSSON11, VEVERKOVA24\].
//! A local search may follow each fit, and directions may be generated ones, which the printed algorithm lacks.
//! Differs: of packed nodes, not of the binary tree; each node's points climb once; tolerances are relative; what
//! becomes of the frames is [`super::orient`]'s business.

use super::{Build, Bvh, Directions, Result};
use crate::abi::{
    DitoExtremesArgs, DitoFitArgs, DitoImproveArgs, DitoParentsArgs, Pair, Ptr, Range, SPEC_DIRECTIONS,
    SPEC_ITEMS, SPEC_LEAF_BITS, SPEC_POINTS, SPEC_WG, WIDTH,
};
use crate::device::{Buffer, Recorder};
use crate::kernels;
use glam::Vec3;

/// What is known of every slot, a child of a packed node: slot 4 i + k is child k of node i; the root's comes last.
pub(super) struct Slots {
    /// Slot above each node.
    pub parents: Buffer<u32>,
    /// k extremal points a slot, three floats each.
    pub points: Buffer<u32>,
    /// Triangles of each.
    pub ranges: Buffer<Range>,
    /// Frame of the least box of each.
    pub frames: Buffer<Pair>,
}

/// Slots of a tree of `nodes` packed nodes, the root's among them.
pub(super) fn slots_of(nodes: usize) -> usize {
    WIDTH as usize * nodes + 1
}

/// Records what finds the slot above each node of `bvh`.
pub(super) fn hang(rec: &mut Recorder, bvh: &Bvh, parents: &Buffer<u32>) -> Result<()> {
    let shape = rec.device().shape().clone();
    let count = bvh.nodes.len() as u32;
    rec.dispatch(
        &kernels::DITO_PARENTS,
        &[(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items)],
        count.div_ceil(shape.workgroup * shape.items),
        DitoParentsArgs { nodes: bvh.nodes.ptr(), parents: parents.ptr_mut(), count, root: bvh.root },
    )?;
    Ok(())
}

/// Directions of `points` extremal points, where they aren't those that kernels have.
fn generated_directions(build: &Build<'_>, points: u32) -> Result<Option<Buffer<f32>>> {
    let directions = build.recipe.directions;
    if directions == Directions::Book {
        return Ok(None);
    }
    let words: Vec<f32> = directions.of(points).iter().flat_map(Vec3::to_array).collect();
    Ok(Some(Buffer::from_slice(build.device, "dito.directions", &words)?))
}

/// Finds the frame of every slot of `bvh` from `points` extremal points: 12, 14, 20 or 26; the recipe's local
/// search refines it. Of slots beyond the recipe's threshold only ranges are found.
pub(super) fn fit(build: &mut Build<'_>, bvh: &Bvh, points: u32) -> Result<Slots> {
    let shape = build.device.shape().clone();
    let nodes = bvh.nodes.len();
    let (count, slots) = (nodes as u32, slots_of(nodes));
    // Of a slot its points, extent, range and frame; of a node where it hangs, who has arrived, and its frame.
    let bytes = slots as u64 * (12 * u64::from(points) + 40) + 16 * nodes as u64;
    build.device.require_memory(&format!("orienting {nodes} nodes"), bytes)?;
    let found = Slots {
        parents: build.buffer("dito.parents", nodes)?,
        points: build.buffer("dito.points", slots * 3 * points as usize)?,
        ranges: build.buffer("dito.ranges", slots)?,
        frames: build.buffer("dito.frames", slots)?,
    };
    let arrived = build.buffer::<u32>("dito.arrived", nodes)?;
    let most = build.recipe.most_of_points();
    let directions = generated_directions(build, points)?;
    let tile = shape.workgroup * shape.items;
    let constants = [
        (SPEC_WG, shape.workgroup),
        (SPEC_ITEMS, shape.items),
        (SPEC_POINTS, points),
        (SPEC_LEAF_BITS, bvh.leaf_bits),
        (SPEC_DIRECTIONS, directions.is_some().into()),
    ];
    let mut rec = build.recorder()?;
    rec.fill(&arrived, nodes, 0);
    // Slots without a child have no triangles.
    rec.fill(&found.ranges, slots, 0);
    hang(&mut rec, bvh, &found.parents)?;
    rec.dispatch(
        &kernels::DITO_EXTREMES,
        &constants,
        count.div_ceil(tile),
        DitoExtremesArgs {
            nodes: bvh.nodes.ptr(),
            triangles: bvh.triangles.ptr().cast(),
            parents: found.parents.ptr(),
            arrived: arrived.ptr_shared(),
            points: found.points.ptr_shared().cast(),
            coordinates: found.points.ptr_shared().cast(),
            ranges: found.ranges.ptr_shared(),
            directions: directions.as_ref().map_or(Ptr::new(0), Buffer::ptr),
            count,
            most,
            anchor: bvh.anchor,
        },
    )?;
    rec.dispatch(
        &kernels::DITO_FIT,
        &constants[..3],
        (slots as u32).div_ceil(tile),
        DitoFitArgs {
            points: found.points.ptr().cast(),
            ranges: found.ranges.ptr(),
            frames: found.frames.ptr_mut(),
            slots: slots as u32,
            most,
        },
    )?;
    let evaluations = build.recipe.local_search;
    if evaluations > 0 {
        rec.dispatch(
            &kernels::DITO_IMPROVE,
            &constants[..3],
            (slots as u32).div_ceil(tile),
            DitoImproveArgs {
                points: found.points.ptr().cast(),
                ranges: found.ranges.ptr(),
                frames: found.frames.ptr_mut(),
                slots: slots as u32,
                most,
                evaluations,
            },
        )?;
    }
    build.run(rec)?;
    Ok(found)
}
