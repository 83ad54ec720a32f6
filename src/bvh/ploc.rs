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
pub(super) struct Rounds {
    pub bounds: Buffer<Aabb>,
    pub clusters: Buffer<Cluster>,
    pub nearest: Buffer<u32>,
    pub sums: Buffer<u32>,
    pub state: Buffer<PlocState>,
    pub tree: RawTree,
    /// Clusters that one workgroup handles.
    tile: u32,
    pub constants: [(u32, u32); 3],
    /// Whether to search with the window in registers.
    pub registers: bool,
    single: u32,
    /// No round begins with as few clusters as these.
    last: u32,
}

/// Clusters the triangles of `order` into a binary tree.
pub(super) fn cluster(build: &mut Build<'_>, order: &Order, space: &Space) -> Result<RawTree> {
    if order.count == 0 {
        build.note("ploc: skipped, no triangle can be hit");
        return RawTree::new(build, 0);
    }
    let mut rounds = Rounds::new(build, order.count, TAIL_CLUSTERS)?;
    let mut rec = build.recorder()?;
    rounds.record_leaves(build, &mut rec, order, space)?;
    let mut state = rounds.first();
    loop {
        let (before, batch) = (state, rounds.expected(state.clusters));
        rec.update(&rounds.state, &[state]);
        for round in 0..batch {
            rounds.record(build, &mut rec, round)?;
        }
        rounds.record_tail(build, &mut rec, batch)?;
        build.run(rec)?;
        state = rounds.state.read_at(batch as usize)?;
        if state.clusters <= TAIL_CLUSTERS {
            break;
        }
        check_progress("ploc", &before, &state)?;
        rec = build.recorder()?;
    }
    rounds.tree.root = rounds.tree.root_buffer.read()?[0];
    let root = rounds.tree.root;
    if root.stalled != 0 {
        let clusters = state.clusters;
        return Err(BuildError::Stalled { builder: "ploc", rounds: root.levels, clusters });
    }
    build.note(format!(
        "ploc: {} rounds, the last {} over {} clusters in one dispatch",
        root.levels,
        root.levels - state.rounds,
        state.clusters
    ));
    Ok(rounds.tree)
}

/// Refuses rounds that merged nothing.
pub(super) fn check_progress(builder: &'static str, before: &PlocState, after: &PlocState) -> Result<()> {
    if after.clusters < before.clusters {
        return Ok(());
    }
    Err(BuildError::Stalled { builder, rounds: after.rounds, clusters: after.clusters })
}

impl Rounds {
    /// Room for rounds over `count` triangles, as long as more than `last` clusters are left.
    pub fn new(build: &Build<'_>, count: u32, last: u32) -> Result<Self> {
        let shape = build.device.shape().clone();
        let capacity = count as usize;
        let tile = shape.workgroup * shape.items;
        Ok(Self {
            bounds: build.buffer("ploc.bounds", 2 * capacity)?,
            clusters: build.buffer("ploc.clusters", 2 * capacity)?,
            nearest: build.buffer("ploc.nearest", capacity)?,
            sums: build.buffer("ploc.sums", count.div_ceil(tile) as usize)?,
            state: build.buffer("ploc.state", BATCH as usize + 1)?,
            tree: RawTree::new(build, count)?,
            tile,
            constants: [
                (SPEC_WG, shape.workgroup),
                (SPEC_ITEMS, shape.items),
                (SPEC_RADIUS, build.recipe.radius),
            ],
            registers: shape.search_in_registers && build.recipe.radius <= REGISTER_RADIUS,
            single: shape.single_workgroup,
            last,
        })
    }

    /// Where the first round stands.
    pub fn first(&self) -> PlocState {
        let clusters = self.tree.count;
        PlocState { groups: self.grid(clusters), clusters, rounds: 0 }
    }

    /// Indirect dispatch of a round over `clusters`, as `ploc/scan` writes it.
    fn grid(&self, clusters: u32) -> [u32; 3] {
        if clusters <= self.last {
            return [0; 3];
        }
        let groups = self.groups(clusters);
        [groups.min(GRID_WIDTH), groups.div_ceil(GRID_WIDTH), 1]
    }

    /// Rounds to record before looking: each leaves about 0.7 of the clusters; empty ones cost next to nothing.
    pub fn expected(&self, clusters: u32) -> u32 {
        if clusters <= self.last {
            return 0;
        }
        let halvings = (f64::from(clusters) / f64::from(self.last)).log2();
        ((halvings * 2.4).ceil() as u32 + 2).min(BATCH)
    }

    /// Workgroups over `clusters`.
    pub fn groups(&self, clusters: u32) -> u32 {
        clusters.div_ceil(self.tile)
    }

    /// Where in `state` a round's dispatch lies, bytes.
    pub fn at(round: u32) -> usize {
        round as usize * size_of::<PlocState>()
    }

    /// Records the clusters of one triangle each.
    pub fn record_leaves(
        &self,
        build: &Build<'_>,
        rec: &mut Recorder,
        order: &Order,
        space: &Space,
    ) -> Result<()> {
        let count = self.tree.count;
        let args = PlocLeavesArgs {
            triangles: build.scene.triangles.ptr().cast(),
            order: order.triangles.ptr(),
            bounds: self.bounds.ptr_mut(),
            clusters: self.clusters.ptr_mut(),
            count,
            scale: space.scale,
            anchor: space.anchor,
            triangle_cost: build.recipe.collapse.triangle_cost,
        };
        rec.dispatch(&kernels::PLOC_LEAVES, &self.constants, self.groups(count), args)?;
        Ok(())
    }

    /// Records where the clusters of a round go, by their least pairs.
    pub fn record_places(&self, rec: &mut Recorder, round: u32) -> Result<()> {
        let args = PlocCountArgs {
            nearest: self.nearest.ptr(),
            state: self.state.ptr(),
            sums: self.sums.ptr_mut(),
            round,
        };
        rec.dispatch_indirect(&kernels::PLOC_COUNT, &self.constants, &self.state, Self::at(round), args)?;
        let args = PlocScanArgs {
            sums: self.sums.ptr_mut(),
            state: self.state.ptr_mut(),
            round,
            tile: self.tile,
            last: self.last,
        };
        rec.dispatch(&kernels::PLOC_SCAN, &[(SPEC_WG, self.single)], 1, args)?;
        Ok(())
    }

    fn record(&self, build: &Build<'_>, rec: &mut Recorder, round: u32) -> Result<()> {
        let capacity = self.tree.count;
        let collapse = &build.recipe.collapse;
        let (bounds, state, nearest) = (self.bounds.ptr(), self.state.ptr(), self.nearest.ptr_mut());
        let search = if self.registers { &kernels::PLOC_SEARCH } else { &kernels::PLOC_SEARCH_LOADS };
        let args = PlocSearchArgs { bounds, state, nearest, round, capacity };
        rec.dispatch_indirect(search, &self.constants, &self.state, Self::at(round), args)?;
        self.record_places(rec, round)?;
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
        rec.dispatch_indirect(&kernels::PLOC_MERGE, &self.constants, &self.state, Self::at(round), args)?;
        Ok(())
    }

    /// Records the rounds that are left once few clusters are, and the root.
    pub fn record_tail(&self, build: &Build<'_>, rec: &mut Recorder, round: u32) -> Result<()> {
        let collapse = &build.recipe.collapse;
        let args = PlocTailArgs {
            nearest: self.nearest.ptr_shared(),
            bounds: self.bounds.ptr_shared(),
            clusters: self.clusters.ptr_shared(),
            state: self.state.ptr(),
            nodes: self.tree.nodes.ptr_mut(),
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
