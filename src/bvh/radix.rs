//! Pairs of words sorted by the first: a stable least-significant-digit radix sort, reduce-then-scan, so that no
//! workgroup waits for another \[MERRILL10\]. Orders triangles and rays.

use crate::abi::{SPEC_DIGIT_BITS, SPEC_ITEMS, SPEC_WG, ScanExclusiveArgs, SortCountArgs, SortScatterArgs};
use crate::device::{Buffer, Device, Recorder, Result};
use crate::kernels;
use std::sync::Arc;

/// Buffers of a sort. A pass writes to another buffer than it reads, so the caller's take turns with these.
#[derive(Debug)]
pub(crate) struct Radix {
    keys: Buffer<u32>,
    values: Buffer<u32>,
    counts: Buffer<u32>,
    total: Buffer<u32>,
    digit_bits: u32,
    /// Keys of a workgroup.
    tile: u32,
    constants: [(u32, u32); 3],
    single: u32,
}

impl Radix {
    /// For up to `capacity` pairs.
    pub(crate) fn new(device: &Arc<Device>, capacity: usize) -> Result<Self> {
        let shape = device.shape();
        let tile = shape.sort_workgroup * shape.sort_items;
        let counts = capacity.div_ceil(tile as usize) << shape.sort_digit_bits;
        Ok(Self {
            keys: Buffer::new(device, "sort.keys_out", capacity)?,
            values: Buffer::new(device, "sort.values_out", capacity)?,
            counts: Buffer::new(device, "sort.counts", counts)?,
            total: Buffer::new(device, "sort.total", 1)?,
            digit_bits: shape.sort_digit_bits,
            tile,
            constants: [
                (SPEC_WG, shape.sort_workgroup),
                (SPEC_ITEMS, shape.sort_items),
                (SPEC_DIGIT_BITS, shape.sort_digit_bits),
            ],
            single: shape.single_workgroup,
        })
    }

    /// Sorts the first `count` of `keys`, and `values` with them, by the bits set in `live`. Both are as long as the
    /// capacity. Returns the passes it took.
    pub(crate) fn sort(
        &mut self,
        rec: &mut Recorder,
        keys: &mut Buffer<u32>,
        values: &mut Buffer<u32>,
        count: u32,
        live: u32,
    ) -> Result<u32> {
        let mut passes = 0;
        let mut left = live;
        while left != 0 {
            let shift = left.trailing_zeros();
            let digit = ((1u64 << self.digit_bits) - 1) << shift;
            left &= !(digit as u32);
            self.pass(rec, keys, values, count, shift)?;
            std::mem::swap(keys, &mut self.keys);
            std::mem::swap(values, &mut self.values);
            passes += 1;
        }
        Ok(passes)
    }

    fn pass(
        &self,
        rec: &mut Recorder,
        keys: &Buffer<u32>,
        values: &Buffer<u32>,
        count: u32,
        shift: u32,
    ) -> Result<()> {
        let tiles = count.div_ceil(self.tile);
        rec.dispatch(
            &kernels::SORT_COUNT,
            &self.constants,
            tiles,
            SortCountArgs { keys: keys.ptr(), counts: self.counts.ptr_mut(), count, shift, tiles },
        )?;
        rec.dispatch(
            &kernels::SCAN_EXCLUSIVE,
            &[(SPEC_WG, self.single)],
            1,
            ScanExclusiveArgs {
                sums: self.counts.ptr_mut(),
                total: self.total.ptr_mut(),
                count: tiles << self.digit_bits,
            },
        )?;
        rec.dispatch(
            &kernels::SORT_SCATTER,
            &self.constants,
            tiles,
            SortScatterArgs {
                keys: keys.ptr(),
                values: values.ptr(),
                offsets: self.counts.ptr(),
                keys_out: self.keys.ptr_mut(),
                values_out: self.values.ptr_mut(),
                count,
                shift,
                tiles,
            },
        )
    }
}
