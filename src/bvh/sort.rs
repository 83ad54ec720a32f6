//! Triangles in Morton order: a stable least-significant-digit radix sort, reduce-then-scan, so that no workgroup
//! waits for another \[MERRILL10\]. Digits whose bits don't differ are skipped.

use super::morton::{self, Codes};
use super::{Build, Morton, Result};
use crate::abi::{
    SPEC_DIGIT_BITS, SPEC_ITEMS, SPEC_WG, ScanExclusiveArgs, SortCountArgs, SortDuplicatesArgs,
    SortGatherArgs, SortScatterArgs,
};
use crate::device::{Buffer, Recorder};
use crate::kernels;

/// Share of triangles with their predecessor's 30-bit code at which 63 bits pay: with 63 % of a hairball or 93 % of a
/// sphere on a large ground alike, 63 bits took 8–28 % longer and lowered the cost by less than 0.001 %; with 99 % by
/// 0.02 % (PLOC's search mends the order).
const DUPLICATES_FOR_63: f64 = 0.95;

/// Triangles in Morton order.
pub(super) struct Order {
    /// Input indices; those that can't be hit come last.
    pub triangles: Buffer<u32>,
    /// Triangles that can be hit.
    pub count: u32,
    /// Their codes, for builders that compare them.
    pub keys: Option<Keys>,
}

/// Codes in rising order.
pub(super) struct Keys {
    /// Of 30 bits, or the upper 31 of 63.
    pub high: Buffer<u32>,
    /// The lower 32 of 63.
    pub low: Option<Buffer<u32>>,
}

/// Sorts by code.
pub(super) fn by_code(build: &mut Build<'_>, mut codes: Codes) -> Result<Order> {
    let n = build.scene.count() as u32;
    if codes.hittable < n {
        build.note(format!("{} triangles can't be hit and are left out of the tree", n - codes.hittable));
    }
    let mut sorter = Sorter::new(build, n)?;
    let mut rec = build.recorder()?;
    let passes = if let Some(low_keys) = codes.low_keys.take() {
        sorter.wide(build, &mut rec, &mut codes, low_keys)?
    } else {
        sorter.passes(&mut rec, &mut codes.keys, &mut codes.order, codes.live)?
    };
    let what = match build.recipe.morton {
        Morton::Auto | Morton::Bits30 => "30-bit codes",
        Morton::Bits63 => "63-bit codes",
        Morton::Ext4 => "63-bit codes, 15 bits of them of size",
        Morton::Ext7 => "63-bit codes, 9 bits of them of size",
    };
    build.note(format!(
        "morton: {what}, {passes} sort passes for {} live bits",
        codes.live.count_ones() + codes.low_live.count_ones()
    ));
    if build.recipe.morton == Morton::Auto && codes.hittable > 1 {
        sorter.count_duplicates(&mut rec, &codes.keys, codes.hittable)?;
        build.run(rec)?;
        let share = f64::from(sorter.total.read()?[0]) / f64::from(codes.hittable);
        // Where no bit of the codes differs, more of them won't tell the centres apart either.
        if share > DUPLICATES_FOR_63 && codes.live & !crate::abi::UNHITTABLE_KEY != 0 {
            morton::widen(build, &mut codes)?;
            // Even where the low words turn out to be all alike: encoding has put the triangles back in input order.
            if let Some(low_keys) = codes.low_keys.take() {
                let mut rec = build.recorder()?;
                let passes = sorter.wide(build, &mut rec, &mut codes, low_keys)?;
                build.run(rec)?;
                build.note(format!(
                    "morton: {:.0} % shared a 30-bit code, so 63 bits, {passes} more passes",
                    share * 100.0
                ));
            }
        } else {
            build.note(format!("morton: 63-bit codes skipped, {:.1} % share a 30-bit one", share * 100.0));
        }
    } else {
        build.run(rec)?;
    }
    let keys = build.compares_codes().then_some(Keys { high: codes.keys, low: codes.low_keys });
    Ok(Order { triangles: codes.order, count: codes.hittable, keys })
}

/// Buffers of a sort of `count` pairs.
struct Sorter {
    keys: Buffer<u32>,
    values: Buffer<u32>,
    counts: Buffer<u32>,
    total: Buffer<u32>,
    count: u32,
    tiles: u32,
    digit_bits: u32,
    constants: [(u32, u32); 3],
    single: u32,
}

impl Sorter {
    fn new(build: &Build<'_>, count: u32) -> Result<Self> {
        let shape = build.device.shape();
        let tiles = count.div_ceil(shape.sort_workgroup * shape.sort_items);
        Ok(Self {
            keys: build.buffer("sort.keys_out", count as usize)?,
            values: build.buffer("sort.values_out", count as usize)?,
            counts: build.buffer("sort.counts", (tiles as usize) << shape.sort_digit_bits)?,
            total: build.buffer("sort.total", 1)?,
            count,
            tiles,
            digit_bits: shape.sort_digit_bits,
            constants: [
                (SPEC_WG, shape.sort_workgroup),
                (SPEC_ITEMS, shape.sort_items),
                (SPEC_DIGIT_BITS, shape.sort_digit_bits),
            ],
            single: shape.single_workgroup,
        })
    }

    /// Sorts `keys`, and `values` with them, by the bits set in `live`. Returns the passes it took.
    fn passes(
        &mut self,
        rec: &mut Recorder,
        keys: &mut Buffer<u32>,
        values: &mut Buffer<u32>,
        live: u32,
    ) -> Result<u32> {
        let mut passes = 0;
        let mut left = live;
        while left != 0 {
            let shift = left.trailing_zeros();
            let digit = ((1u64 << self.digit_bits) - 1) << shift;
            left &= !(digit as u32);
            self.pass(rec, keys, values, shift)?;
            std::mem::swap(keys, &mut self.keys);
            std::mem::swap(values, &mut self.values);
            passes += 1;
        }
        Ok(passes)
    }

    fn pass(&self, rec: &mut Recorder, keys: &Buffer<u32>, values: &Buffer<u32>, shift: u32) -> Result<()> {
        let (count, tiles) = (self.count, self.tiles);
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
        )?;
        Ok(())
    }

    /// Sorts by codes of two words: low words first, then the high words in that order.
    fn wide(
        &mut self,
        build: &Build<'_>,
        rec: &mut Recorder,
        codes: &mut Codes,
        low_keys: Buffer<u32>,
    ) -> Result<u32> {
        // Passes use up what they sort. A builder that compares codes wants the low words once more, in the end's order.
        let (mut words, kept) = if build.compares_codes() {
            let words = build.buffer("sort.words", self.count as usize)?;
            self.gather(build, rec, &low_keys, &codes.order, &words)?;
            (words, Some(low_keys))
        } else {
            (low_keys, None)
        };
        let low = self.passes(rec, &mut words, &mut codes.order, codes.low_live)?;
        self.gather(build, rec, &codes.keys, &codes.order, &words)?;
        let high = self.passes(rec, &mut words, &mut codes.order, codes.live)?;
        if let Some(low_keys) = kept {
            self.gather(build, rec, &low_keys, &codes.order, &self.keys)?;
            codes.low_keys = Some(std::mem::replace(&mut self.keys, low_keys));
        }
        codes.keys = words;
        Ok(low + high)
    }

    fn gather(
        &self,
        build: &Build<'_>,
        rec: &mut Recorder,
        source: &Buffer<u32>,
        order: &Buffer<u32>,
        gathered: &Buffer<u32>,
    ) -> Result<()> {
        let workgroup = build.device.shape().trace_workgroup;
        let (source, order, gathered) = (source.ptr(), order.ptr(), gathered.ptr_mut());
        let args = SortGatherArgs { source, order, gathered, count: self.count };
        let groups = self.count.div_ceil(workgroup);
        rec.dispatch(&kernels::SORT_GATHER, &[(SPEC_WG, workgroup)], groups, args)?;
        Ok(())
    }

    fn count_duplicates(&self, rec: &mut Recorder, keys: &Buffer<u32>, count: u32) -> Result<()> {
        rec.fill(&self.total, 1, 0);
        let constants = &self.constants[..2];
        rec.dispatch(
            &kernels::SORT_DUPLICATES,
            constants,
            count.div_ceil(constants[0].1 * constants[1].1),
            SortDuplicatesArgs { keys: keys.ptr(), duplicates: self.total.ptr_mut(), count },
        )?;
        Ok(())
    }
}
