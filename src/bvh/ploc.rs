//! PLOC: parallel locally-ordered clustering \[PLOC18\]. Clusters lie in Morton order; each looks RADIUS to either side
//! for the one with which its common box is least; pairs that name each other merge; the rest go on.
//! Differs: ties go by the colour of a pair (see `glsl/lib/pair.glsl`) and nodes are numbered by the rank that dies,
//! so the tree is the same on every device; each merge also decides how its subtree is best cut (see `bvh::collapse`).

use super::morton::Space;
use super::raw::RawTree;
use super::sort::Order;
use super::{Build, BuildError, Result};
use crate::abi::{
    Aabb, Cluster, GRID_WIDTH, PlocCountArgs, PlocLeavesArgs, PlocMergeArgs, PlocScanArgs, PlocSearchArgs,
    PlocState, PlocTailArgs, SPEC_ITEMS, SPEC_RADIUS, SPEC_WG, TAIL_CLUSTERS,
};
use crate::device::{Buffer, Recorder};
use crate::kernels;

/// Largest radius whose window fits in registers.
const REGISTER_RADIUS: u32 = 32;
/// Rounds that one submit records at most: their states are kept.
const BATCH: u32 = 64;

/// The rounds' buffers.
struct Rounds {
    bounds: Buffer<Aabb>,
    clusters: Buffer<Cluster>,
    nearest: Buffer<u32>,
    sums: Buffer<u32>,
    state: Buffer<PlocState>,
    tree: RawTree,
    /// Clusters that one workgroup handles.
    tile: u32,
    constants: [(u32, u32); 3],
    registers: bool,
    single: u32,
}

/// Clusters the triangles of `order` into a binary tree.
pub(super) fn cluster(build: &mut Build<'_>, order: &Order, space: &Space) -> Result<RawTree> {
    let shape = build.device.shape().clone();
    let n = order.count;
    let capacity = n as usize;
    let tile = shape.workgroup * shape.items;
    let groups = n.div_ceil(tile);
    let tree = RawTree::new(build, n)?;
    if n == 0 {
        build.note("ploc: skipped, no triangle can be hit");
        return Ok(tree);
    }
    let mut rounds = Rounds {
        bounds: build.buffer("ploc.bounds", 2 * capacity)?,
        clusters: build.buffer("ploc.clusters", 2 * capacity)?,
        nearest: build.buffer("ploc.nearest", capacity)?,
        sums: build.buffer("ploc.sums", groups as usize)?,
        state: build.buffer("ploc.state", BATCH as usize + 1)?,
        tree,
        tile,
        constants: [
            (SPEC_WG, shape.workgroup),
            (SPEC_ITEMS, shape.items),
            (SPEC_RADIUS, build.recipe.radius),
        ],
        registers: shape.search_in_registers && build.recipe.radius <= REGISTER_RADIUS,
        single: shape.single_workgroup,
    };
    let mut rec = build.recorder()?;
    rec.dispatch(
        &kernels::PLOC_LEAVES,
        &rounds.constants,
        groups,
        PlocLeavesArgs {
            triangles: build.scene.triangles.ptr().cast(),
            order: order.triangles.ptr(),
            bounds: rounds.bounds.ptr_mut(),
            clusters: rounds.clusters.ptr_mut(),
            count: n,
            scale: space.scale,
            anchor: space.anchor,
            triangle_cost: build.recipe.collapse.triangle_cost,
        },
    )?;
    let mut state = PlocState { groups: grid(n, tile), clusters: n, rounds: 0 };
    loop {
        let before = state;
        let batch = expected_rounds(state.clusters);
        rec.update(&rounds.state, &[state]);
        for round in 0..batch {
            rounds.record(build, &mut rec, round)?;
        }
        rounds.record_tail(build, &mut rec, batch)?;
        build.run(rec)?;
        let states = rounds.state.read_first(batch as usize + 1)?;
        state = states[batch as usize];
        if state.clusters <= TAIL_CLUSTERS {
            break;
        }
        if state.clusters >= before.clusters {
            return Err(BuildError::Stalled { rounds: state.rounds, clusters: state.clusters });
        }
        rec = build.recorder()?;
    }
    rounds.tree.root = rounds.tree.root_buffer.read()?[0];
    if rounds.tree.root.stalled != 0 {
        return Err(BuildError::Stalled { rounds: rounds.tree.root.levels, clusters: state.clusters });
    }
    build.note(format!(
        "ploc: {} rounds, the last {} over {} clusters in one dispatch",
        rounds.tree.root.levels,
        rounds.tree.root.levels - state.rounds,
        state.clusters
    ));
    Ok(rounds.tree)
}

/// Indirect dispatch of a round over `clusters`, as `ploc/scan` writes it.
fn grid(clusters: u32, tile: u32) -> [u32; 3] {
    if clusters <= TAIL_CLUSTERS {
        return [0; 3];
    }
    let groups = clusters.div_ceil(tile);
    [groups.min(GRID_WIDTH), groups.div_ceil(GRID_WIDTH), 1]
}

/// Rounds to record before looking: each leaves about 0.7 of the clusters; empty ones cost next to nothing.
fn expected_rounds(clusters: u32) -> u32 {
    if clusters <= TAIL_CLUSTERS {
        return 0;
    }
    let halvings = (f64::from(clusters) / f64::from(TAIL_CLUSTERS)).log2();
    ((halvings * 2.4).ceil() as u32 + 2).min(BATCH)
}

impl Rounds {
    fn record(&self, build: &Build<'_>, rec: &mut Recorder, round: u32) -> Result<()> {
        let at = round as usize * size_of::<PlocState>();
        let capacity = self.tree.count;
        let collapse = &build.recipe.collapse;
        let (bounds, state, nearest) = (self.bounds.ptr(), self.state.ptr(), self.nearest.ptr_mut());
        let search = if self.registers { &kernels::PLOC_SEARCH } else { &kernels::PLOC_SEARCH_LOADS };
        let args = PlocSearchArgs { bounds, state, nearest, round, capacity };
        rec.dispatch_indirect(search, &self.constants, &self.state, at, args)?;
        let args = PlocCountArgs {
            nearest: self.nearest.ptr(),
            state: self.state.ptr(),
            sums: self.sums.ptr_mut(),
            round,
        };
        rec.dispatch_indirect(&kernels::PLOC_COUNT, &self.constants, &self.state, at, args)?;
        let args =
            PlocScanArgs { sums: self.sums.ptr_mut(), state: self.state.ptr_mut(), round, tile: self.tile };
        rec.dispatch(&kernels::PLOC_SCAN, &[(SPEC_WG, self.single)], 1, args)?;
        let args = PlocMergeArgs {
            nearest: self.nearest.ptr(),
            sums: self.sums.ptr(),
            state: self.state.ptr(),
            bounds: self.bounds.ptr_mut(),
            clusters: self.clusters.ptr_mut(),
            nodes: self.tree.nodes.ptr_mut(),
            cuts: self.tree.cuts.ptr_mut(),
            round,
            capacity,
            node_cost: collapse.node_cost,
            triangle_cost: collapse.triangle_cost,
            max_leaf: collapse.max_leaf,
        };
        rec.dispatch_indirect(&kernels::PLOC_MERGE, &self.constants, &self.state, at, args)?;
        Ok(())
    }

    fn record_tail(&self, build: &Build<'_>, rec: &mut Recorder, round: u32) -> Result<()> {
        let collapse = &build.recipe.collapse;
        let args = PlocTailArgs {
            nearest: self.nearest.ptr_shared(),
            bounds: self.bounds.ptr_shared(),
            clusters: self.clusters.ptr_shared(),
            state: self.state.ptr(),
            nodes: self.tree.nodes.ptr_shared(),
            cuts: self.tree.cuts.ptr_shared(),
            root: self.tree.root_buffer.ptr_mut(),
            round,
            capacity: self.tree.count,
            node_cost: collapse.node_cost,
            triangle_cost: collapse.triangle_cost,
            max_leaf: collapse.max_leaf,
        };
        let constants = [(SPEC_WG, self.single), (SPEC_RADIUS, build.recipe.radius)];
        rec.dispatch(&kernels::PLOC_TAIL, &constants, 1, args)?;
        Ok(())
    }
}
