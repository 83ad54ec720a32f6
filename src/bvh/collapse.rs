//! From the binary tree to packed nodes of up to four children and leaves of several triangles. The merges have chosen the
//! cheapest cut of each subtree, from below; here the cuts that count are followed from the root, a round a level of
//! packed nodes, and what is kept is numbered \[YLITIE17\].

use super::raw::{RawTree, half_area, sah};
use super::{Build, Result};
use crate::abi::{
    COLLAPSED_BIT, CollapseCountArgs, CollapseExpandArgs, CollapseNumberArgs, Expansion, LEAF_BIT,
    SPEC_ITEMS, SPEC_WG, ScanExclusiveArgs, WIDTH,
};
use crate::device::{Buffer, Recorder};
use crate::kernels;

/// Which raw nodes the packed tree keeps, and where they go.
pub(super) struct Kept {
    /// Packed index of each kept raw node.
    pub packed: Buffer<u32>,
    /// The kept raw nodes, in order.
    pub nodes: Buffer<u32>,
    /// First triangle below each of them, by raw node.
    pub firsts: Buffer<u32>,
    /// Nodes kept; 0 where the whole scene is one leaf.
    pub count: u32,
    /// Packed index of the root.
    pub root: u32,
    /// SAH cost of the binary tree with these leaves.
    pub sah: f64,
}

/// Finds and numbers the nodes to keep.
pub(super) fn number(build: &mut Build<'_>, tree: &RawTree) -> Result<Kept> {
    let nodes = tree.count.saturating_sub(1);
    let collapse = &build.recipe.collapse;
    let bounds = &tree.root.bounds;
    let one_leaf = [0.0, f64::from(half_area(bounds)) * f64::from(tree.count)];
    let mut kept = Kept {
        packed: build.buffer("collapse.packed", nodes as usize)?,
        nodes: build.buffer("collapse.kept", nodes as usize)?,
        firsts: build.buffer("collapse.firsts", nodes as usize)?,
        count: 0,
        root: 0,
        sah: sah(one_leaf, bounds, collapse),
    };
    if tree.root.node & (LEAF_BIT | COLLAPSED_BIT) == 0 {
        let states = build.buffer("collapse.expansion", expected_rounds(tree.count) as usize + 1)?;
        let rec = expand(build, tree, &kept, &states)?;
        let (count, areas) = count_and_number(build, tree, &kept, rec)?;
        kept.count = count;
        kept.root = kept.packed.read_at(tree.root.node as usize)?;
        kept.sah = sah(areas, bounds, &build.recipe.collapse);
    }
    Ok(kept)
}

impl Kept {
    /// What was done with so many raw nodes.
    pub fn summary(&self, nodes: usize, max_leaf: u32) -> String {
        let kept = self.count;
        format!(
            "collapse: {kept} of {nodes} binary nodes kept, of up to {WIDTH} children, leaves of up to {max_leaf} triangles"
        )
    }
}

/// Rounds to record before looking: a balanced tree has half as many levels of packed nodes as of binary ones, others
/// have some more; empty ones cost next to nothing.
fn expected_rounds(count: u32) -> u32 {
    count.ilog2() + 4
}

/// Records rounds of packed nodes, from the root's on, until none is left or there were as many as binary levels; `kept.nodes`
/// has room for all. All batches but the last have run.
fn expand(
    build: &mut Build<'_>,
    tree: &RawTree,
    kept: &Kept,
    states: &Buffer<Expansion>,
) -> Result<Recorder> {
    let shape = build.device.shape().clone();
    let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items)];
    let mut state = Expansion { groups: [1; 3], first: 0, count: 1 };
    let mut left = tree.root.levels;
    let mut rec = build.recorder()?;
    rec.update(&kept.nodes, &[tree.root.node]);
    // The root's is 0.
    rec.fill(&kept.firsts, kept.firsts.len(), 0);
    loop {
        let batch = left.min(expected_rounds(tree.count));
        let words = (batch as usize + 1) * size_of::<Expansion>() / 4;
        rec.fill(states, words, 0);
        rec.update(states, &[state]);
        for round in 0..batch {
            let args = CollapseExpandArgs {
                raw: tree.nodes.ptr_mut(),
                cuts: tree.cuts.ptr_mut(),
                queue: kept.nodes.ptr_mut(),
                firsts: kept.firsts.ptr_mut(),
                state: states.ptr_mut(),
                round,
            };
            let at = round as usize * size_of::<Expansion>();
            rec.dispatch_indirect(&kernels::COLLAPSE_EXPAND, &constants, states, at, args)?;
        }
        left -= batch;
        if left == 0 {
            return Ok(rec);
        }
        build.run(rec)?;
        state = states.read_at(batch as usize)?;
        rec = build.recorder()?;
        if state.count == 0 {
            return Ok(rec);
        }
    }
}

/// Completes and runs `rec`: counts what `expand` has marked, and numbers it. Returns the nodes kept and the half areas
/// of [`sah`].
fn count_and_number(
    build: &mut Build<'_>,
    tree: &RawTree,
    kept: &Kept,
    mut rec: Recorder,
) -> Result<(u32, [f64; 2])> {
    let shape = build.device.shape().clone();
    let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items)];
    let nodes = tree.count - 1;
    let groups = nodes.div_ceil(shape.workgroup * shape.items);
    let sums = build.buffer::<u32>("collapse.sums", groups as usize)?;
    let total = build.buffer::<u32>("collapse.total", 1)?;
    let areas = build.buffer::<[f32; 2]>("collapse.areas", groups as usize)?;
    rec.dispatch(
        &kernels::COLLAPSE_COUNT,
        &constants,
        groups,
        CollapseCountArgs {
            raw: tree.nodes.ptr(),
            cuts: tree.cuts.ptr(),
            sums: sums.ptr_mut(),
            areas: areas.ptr_mut(),
            count: nodes,
        },
    )?;
    rec.dispatch(
        &kernels::SCAN_EXCLUSIVE,
        &[(SPEC_WG, shape.single_workgroup)],
        1,
        ScanExclusiveArgs { sums: sums.ptr_mut(), total: total.ptr_mut(), count: groups },
    )?;
    rec.dispatch(
        &kernels::COLLAPSE_NUMBER,
        &constants,
        groups,
        CollapseNumberArgs {
            sums: sums.ptr(),
            cuts: tree.cuts.ptr(),
            packed: kept.packed.ptr_mut(),
            kept: kept.nodes.ptr_mut(),
            count: nodes,
        },
    )?;
    build.run(rec)?;
    let count = total.read()?[0];
    let add = |sum: [f64; 2], part: &[f32; 2]| [0, 1].map(|k| sum[k] + f64::from(part[k]));
    Ok((count, areas.read()?.iter().fold([0.0; 2], add)))
}
