//! ODOP-PLOC \[VEVERKOVA24, 4.2\]: PLOC by oriented discrete orientation polytopes. A cluster has a box in each of D³
//! bases, and two are as far apart as the least half area of their common box in any of them. Differs: union takes the
//! least of minima and the greatest of maxima (the printed rule is an intersection); a cluster's boxes stay where they
//! are while clusters move up, so that only merged pairs touch theirs; where memory is short boxes are not kept at all,
//! but projected anew from the triangles each round, a group of bases after the other, for the same tree.

use super::morton::Space;
use super::ploc::{Rounds, check_progress};
use super::raw::RawTree;
use super::slabs::Slabs;
use super::sort::Order;
use super::{Bases, Build, Result};
use crate::abi::{
    Basis, INVALID, OdopLinkArgs, OdopMergeArgs, OdopProjectArgs, OdopSearchArgs, OdopUniteArgs, Pair,
    PlocState, Ptr,
};
use crate::device::{Buffer, Recorder};
use crate::kernels;
use std::ops::Range;

/// Bases of one dispatch at most: with more it would take seconds on large scenes, which watchdogs don't like.
const GROUP: usize = 32;

/// PLOC's rounds, and what they need beside.
struct Odop<'a> {
    rounds: Rounds,
    order: &'a Order,
    space: &'a Space,
    axes: Buffer<Basis>,
    slabs: Slabs,
    /// Where each cluster's boxes lie in a slab, two halves.
    slots: Buffer<u32>,
    /// Of clusters that merged, their slots.
    pairs: Buffer<Pair>,
    /// Where boxes can't be kept from the start.
    lists: Option<Lists>,
}

/// Each cluster's triangles.
struct Lists {
    next: Buffer<u32>,
    tails: Buffer<u32>,
}

impl Lists {
    /// Of those of `count` triangles.
    fn bytes(count: usize) -> u64 {
        2 * size_of::<u32>() as u64 * count as u64
    }
}

/// Clusters the triangles of `order` into a binary tree by their boxes in `bases`.
pub(super) fn cluster(build: &mut Build<'_>, order: &Order, space: &Space, bases: Bases) -> Result<RawTree> {
    if order.count == 0 {
        build.note("odop: skipped, no triangle can be hit");
        return RawTree::new(build, 0);
    }
    let mut odop = Odop::new(build, order, space, bases)?;
    let mut rec = build.recorder()?;
    odop.rounds.record_leaves(build, &mut rec, order, space)?;
    if let Some(lists) = &odop.lists {
        rec.fill(&lists.next, order.count as usize, INVALID);
        rec.fill(&lists.tails, order.count as usize, INVALID);
    }
    let mut state = odop.rounds.first();
    let groups = odop.bases().div_ceil(odop.slabs.room(state.clusters));
    while odop.slabs.room(state.clusters) < odop.bases() {
        let before = state;
        odop.record_anew(build, &mut rec, &state)?;
        build.run(rec)?;
        state = odop.rounds.state.read_at(1)?;
        check_progress("odop", &before, &state)?;
        rec = build.recorder()?;
    }
    let kept = state;
    odop.record_kept(build, &mut rec, &state)?;
    loop {
        let (before, batch) = (state, odop.rounds.expected(state.clusters));
        rec.update(&odop.rounds.state, &[state]);
        for round in 0..batch {
            odop.record_round(build, &mut rec, round)?;
        }
        // Of one cluster it only tells the root.
        if batch == 0 {
            odop.rounds.record_tail(build, &mut rec, 0)?;
        }
        build.run(rec)?;
        if batch == 0 {
            break;
        }
        state = odop.rounds.state.read_at(batch as usize)?;
        check_progress("odop", &before, &state)?;
        rec = build.recorder()?;
    }
    odop.rounds.tree.root = odop.rounds.tree.root_buffer.read()?[0];
    build.note(odop.summary(bases, groups, &kept, state.rounds));
    Ok(odop.rounds.tree)
}

impl<'a> Odop<'a> {
    fn new(build: &Build<'_>, order: &'a Order, space: &'a Space, bases: Bases) -> Result<Self> {
        let count = order.count as usize;
        let axes = Buffer::from_slice(build.device, "odop.bases", &bases.axes())?;
        let rounds = Rounds::new(build, order.count, 1)?;
        let slots = build.buffer("odop.slots", 2 * count)?;
        let pairs = build.buffer("odop.pairs", count / 2)?;
        let slabs = Slabs::new(build, axes.len(), count, Lists::bytes(count))?;
        let lists = if slabs.room(order.count) < axes.len() {
            Some(Lists { next: build.buffer("odop.next", count)?, tails: build.buffer("odop.tails", count)? })
        } else {
            None
        };
        Ok(Self { rounds, order, space, axes, slabs, slots, pairs, lists })
    }

    fn bases(&self) -> usize {
        self.axes.len()
    }

    /// All bases, in groups.
    fn groups(&self, size: usize) -> impl Iterator<Item = Range<u32>> {
        let bases = self.bases();
        (0..bases).step_by(size).map(move |first| first as u32..bases.min(first + size) as u32)
    }

    /// Records a round from `state` that keeps no boxes.
    fn record_anew(&self, build: &Build<'_>, rec: &mut Recorder, state: &PlocState) -> Result<()> {
        rec.update(&self.rounds.state, &[*state]);
        self.slabs.lay_out(rec, state.clusters);
        for group in self.groups(self.slabs.room(state.clusters).min(GROUP)) {
            self.record_project(build, rec, state, group.clone(), 0)?;
            self.record_search(rec, 0, group, 0)?;
        }
        self.record_merge(build, rec, 0)?;
        if let Some(lists) = &self.lists {
            let args = OdopLinkArgs {
                pairs: self.pairs.ptr(),
                clusters: self.rounds.clusters.ptr(),
                state: self.rounds.state.ptr(),
                next: lists.next.ptr_mut(),
                tails: lists.tails.ptr_mut(),
                round: 0,
                capacity: self.rounds.tree.count,
            };
            let (constants, state) = (&self.rounds.constants, &self.rounds.state);
            rec.dispatch_indirect(&kernels::ODOP_LINK, constants, state, Rounds::at(0), args)?;
        }
        Ok(())
    }

    /// Records the boxes in all bases of the clusters of `state`, from then on kept.
    fn record_kept(&self, build: &Build<'_>, rec: &mut Recorder, state: &PlocState) -> Result<()> {
        rec.update(&self.rounds.state, &[*state]);
        self.slabs.lay_out(rec, state.clusters);
        for group in self.groups(GROUP) {
            let slab = group.start;
            self.record_project(build, rec, state, group, slab)?;
        }
        Ok(())
    }

    /// Records a round that keeps the boxes.
    fn record_round(&self, build: &Build<'_>, rec: &mut Recorder, round: u32) -> Result<()> {
        for group in self.groups(GROUP) {
            let slab = group.start;
            self.record_search(rec, round, group, slab)?;
        }
        self.record_merge(build, rec, round)?;
        let args = OdopUniteArgs {
            slabs: self.slabs.table.ptr(),
            pairs: self.pairs.ptr(),
            state: self.rounds.state.ptr(),
            round,
            count: self.bases() as u32,
        };
        let (constants, state) = (&self.rounds.constants, &self.rounds.state);
        rec.dispatch_indirect(&kernels::ODOP_UNITE, constants, state, Rounds::at(round), args)?;
        Ok(())
    }

    /// Records the boxes of the clusters of `state` in a group of bases, to slabs from `slab` on.
    fn record_project(
        &self,
        build: &Build<'_>,
        rec: &mut Recorder,
        state: &PlocState,
        group: Range<u32>,
        slab: u32,
    ) -> Result<()> {
        let args = OdopProjectArgs {
            triangles: build.scene.triangles.ptr().cast(),
            order: self.order.triangles.ptr(),
            next: self.lists.as_ref().map_or(Ptr::new(0), |lists| lists.next.ptr()),
            bases: self.axes.ptr(),
            slabs: self.slabs.table.ptr(),
            slots: self.slots.ptr_mut(),
            clusters: self.rounds.clusters.ptr_mut(),
            state: self.rounds.state.ptr(),
            round: 0,
            capacity: self.rounds.tree.count,
            first: group.start,
            count: group.len() as u32,
            slab,
            scale: self.space.scale,
            anchor: self.space.anchor,
            triangle_cost: build.recipe.collapse.triangle_cost,
        };
        // Not indirect: a single triangle has no round, but a cost.
        let (constants, groups) = (&self.rounds.constants, self.rounds.groups(state.clusters));
        rec.dispatch(&kernels::ODOP_PROJECT, constants, groups, args)?;
        Ok(())
    }

    fn record_search(&self, rec: &mut Recorder, round: u32, group: Range<u32>, slab: u32) -> Result<()> {
        let args = OdopSearchArgs {
            slabs: self.slabs.table.ptr(),
            slots: self.slots.ptr(),
            state: self.rounds.state.ptr(),
            nearest: self.rounds.nearest.ptr_mut(),
            round,
            capacity: self.rounds.tree.count,
            first: group.start,
            count: group.len() as u32,
            slab,
        };
        let search = if self.rounds.registers { &kernels::ODOP_SEARCH } else { &kernels::ODOP_SEARCH_LOADS };
        rec.dispatch_indirect(search, &self.rounds.constants, &self.rounds.state, Rounds::at(round), args)?;
        Ok(())
    }

    fn record_merge(&self, build: &Build<'_>, rec: &mut Recorder, round: u32) -> Result<()> {
        self.rounds.record_places(rec, round)?;
        let (rounds, collapse) = (&self.rounds, &build.recipe.collapse);
        let args = OdopMergeArgs {
            nearest: rounds.nearest.ptr(),
            sums: rounds.sums.ptr(),
            state: rounds.state.ptr(),
            bounds: rounds.bounds.ptr_mut(),
            clusters: rounds.clusters.ptr_mut(),
            slots: self.slots.ptr_mut(),
            pairs: self.pairs.ptr_mut(),
            nodes: rounds.tree.nodes.ptr_mut(),
            cuts: rounds.tree.cuts.ptr_mut(),
            round,
            capacity: rounds.tree.count,
            node_cost: collapse.node_cost,
            triangle_cost: collapse.triangle_cost,
            max_leaf: collapse.max_leaf,
        };
        rec.dispatch_indirect(
            &kernels::ODOP_MERGE,
            &rounds.constants,
            &rounds.state,
            Rounds::at(round),
            args,
        )?;
        Ok(())
    }

    /// What was done.
    fn summary(&self, bases: Bases, groups: usize, kept: &PlocState, rounds: u32) -> String {
        let mib = self.slabs.bytes() as f64 / f64::from(1 << 20);
        let what = format!("odop: {rounds} rounds in {} bases ({})", self.bases(), bases.generator.name());
        match kept.rounds {
            0 => format!("{what}, their boxes kept in {mib:.1} MiB"),
            anew => format!(
                "{what}: boxes projected anew in the first {anew}, the very first in {groups} groups of bases, then kept for {} clusters; {mib:.1} MiB for boxes",
                kept.clusters
            ),
        }
    }
}
