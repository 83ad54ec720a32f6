//! Memory for boxes of clusters in bases: as many slabs, each of a box a cluster, as it has room for. The fewer clusters
//! are left, the more bases fit.

use super::{Build, BuildError, Result};
use crate::abi::{Aabb, Pair};
use crate::device::{Buffer, Recorder};

/// Boxes that a buffer holds, unless one slab is more: 1 GiB, which every device allocates at once.
const BUFFER: u64 = (1 << 30) / size_of::<Aabb>() as u64;

/// Room left for what is small: tables, counters, what the recorder holds, bytes.
const SMALL: u64 = 1 << 16;

/// The memory, and where in it the slabs lie.
pub(super) struct Slabs {
    buffers: Vec<Buffer<Aabb>>,
    /// Addresses.
    pub table: Buffer<Pair>,
    /// Slabs wanted.
    bases: usize,
}

impl Slabs {
    /// Room for `bases` slabs of `clusters` boxes, or what of it the recipe allows and the device has: where that is not
    /// all, `beside` bytes less.
    pub fn new(build: &Build<'_>, bases: usize, clusters: usize, beside: u64) -> Result<Self> {
        let box_bytes = size_of::<Aabb>() as u64;
        let (free, taken) = (build.device.memory_free(), build.scratch() + SMALL);
        let slab = clusters as u64;
        let wanted = bases as u64 * slab;
        // Some is for others.
        let left = build.recipe.memory.saturating_sub(taken).min(free - free / 16);
        let left = if left < wanted * box_bytes { left.saturating_sub(beside) } else { left };
        // The boxes of a single cluster must have room whatever is allowed.
        let mut left = (left / box_bytes).max(bases as u64).min(wanted);
        if left < slab {
            let needed = taken + beside + slab * box_bytes;
            return Err(BuildError::Bases { needed, allowed: build.recipe.memory, free });
        }
        let whole = (BUFFER / slab).max(1) * slab;
        let mut buffers = vec![];
        while left >= slab {
            let boxes = left.min(whole);
            buffers.push(build.buffer("odop.boxes", boxes as usize)?);
            left -= boxes;
        }
        Ok(Self { buffers, table: build.buffer("odop.slabs", bases)?, bases })
    }

    /// Slabs of `clusters` boxes that there is room for, no more than are wanted.
    pub fn room(&self, clusters: u32) -> usize {
        let slabs: usize = self.buffers.iter().map(|b| b.len() / clusters as usize).sum();
        slabs.min(self.bases)
    }

    /// Records the table of slabs of `clusters` boxes.
    pub fn lay_out(&self, rec: &mut Recorder, clusters: u32) {
        let bytes = u64::from(clusters) * size_of::<Aabb>() as u64;
        let of_buffer = |b: &Buffer<Aabb>| {
            let [low, high] = b.ptr().0.map(u64::from);
            let slab = move |k| (high << 32 | low) + k * bytes;
            (0..b.len() as u64 / u64::from(clusters)).map(slab)
        };
        let addresses = self.buffers.iter().flat_map(of_buffer).take(self.bases);
        let table: Vec<Pair> = addresses.map(|a| [a as u32, (a >> 32) as u32]).collect();
        rec.update(&self.table, &table);
    }

    /// All of it, bytes.
    pub fn bytes(&self) -> u64 {
        self.buffers.iter().map(Buffer::bytes).sum()
    }
}
