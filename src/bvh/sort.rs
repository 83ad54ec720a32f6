//! Triangles in Morton order, by 30- or 63-bit codes. Digits whose bits don't differ are skipped.

use super::morton::{self, Codes};
use super::radix::Radix;
use super::{Build, Morton, Result};
use crate::abi::{SPEC_ITEMS, SPEC_WG, SortDuplicatesArgs, SortGatherArgs};
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
    let mut radix = Radix::new(build.device, n as usize)?;
    let mut rec = build.recorder()?;
    let passes = if let Some(low_keys) = codes.low_keys.take() {
        wide(build, &mut radix, &mut rec, &mut codes, low_keys)?
    } else {
        radix.sort(&mut rec, &mut codes.keys, &mut codes.order, n, codes.live)?
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
        let duplicates = build.buffer("sort.duplicates", 1)?;
        count_duplicates(build, &mut rec, &codes, &duplicates)?;
        build.run(rec)?;
        let share = f64::from(duplicates.read()?[0]) / f64::from(codes.hittable);
        // Where no bit of the codes differs, more of them won't tell the centres apart either.
        if share > DUPLICATES_FOR_63 && codes.live & !crate::abi::UNHITTABLE_KEY != 0 {
            morton::widen(build, &mut codes)?;
            // Even where the low words turn out to be all alike: encoding has put the triangles back in input order.
            if let Some(low_keys) = codes.low_keys.take() {
                let mut rec = build.recorder()?;
                let passes = wide(build, &mut radix, &mut rec, &mut codes, low_keys)?;
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

/// Sorts by codes of two words: low words first, then the high words in that order.
fn wide(
    build: &Build<'_>,
    radix: &mut Radix,
    rec: &mut Recorder,
    codes: &mut Codes,
    low_keys: Buffer<u32>,
) -> Result<u32> {
    let count = build.scene.count() as u32;
    // Passes use up what they sort. A builder that compares codes wants the low words once more, in the end's order.
    let (mut words, kept) = if build.compares_codes() {
        let words = build.buffer("sort.words", count as usize)?;
        gather(build, rec, &low_keys, &codes.order, &words)?;
        (words, Some(low_keys))
    } else {
        (low_keys, None)
    };
    let low = radix.sort(rec, &mut words, &mut codes.order, count, codes.low_live)?;
    gather(build, rec, &codes.keys, &codes.order, &words)?;
    let high = radix.sort(rec, &mut words, &mut codes.order, count, codes.live)?;
    let unsorted = std::mem::replace(&mut codes.keys, words);
    if let Some(low_keys) = kept {
        // In the place of the unsorted high words, which have been read.
        gather(build, rec, &low_keys, &codes.order, &unsorted)?;
        codes.low_keys = Some(unsorted);
    }
    Ok(low + high)
}

/// What `order` names of `source`, in its order.
fn gather(
    build: &Build<'_>,
    rec: &mut Recorder,
    source: &Buffer<u32>,
    order: &Buffer<u32>,
    gathered: &Buffer<u32>,
) -> Result<()> {
    let (workgroup, count) = (build.device.shape().trace_workgroup, build.scene.count() as u32);
    let (source, order, gathered) = (source.ptr(), order.ptr(), gathered.ptr_mut());
    let args = SortGatherArgs { source, order, gathered, count };
    rec.dispatch(&kernels::SORT_GATHER, &[(SPEC_WG, workgroup)], count.div_ceil(workgroup), args)?;
    Ok(())
}

fn count_duplicates(
    build: &Build<'_>,
    rec: &mut Recorder,
    codes: &Codes,
    duplicates: &Buffer<u32>,
) -> Result<()> {
    let shape = build.device.shape();
    rec.fill(duplicates, 1, 0);
    rec.dispatch(
        &kernels::SORT_DUPLICATES,
        &[(SPEC_WG, shape.sort_workgroup), (SPEC_ITEMS, shape.sort_items)],
        codes.hittable.div_ceil(shape.sort_workgroup * shape.sort_items),
        SortDuplicatesArgs {
            keys: codes.keys.ptr(),
            duplicates: duplicates.ptr_mut(),
            count: codes.hittable,
        },
    )?;
    Ok(())
}
