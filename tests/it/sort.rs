//! The radix sort by its kernels alone. Every build of `matrix` compares its order too.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::assert_twin;
use crate::soup::{Random, scene};
use boxwood::abi::{
    SPEC_DIGIT_BITS, SPEC_ITEMS, SPEC_WG, ScanExclusiveArgs, SortCountArgs, SortDuplicatesArgs,
    SortGatherArgs, SortScatterArgs,
};
use boxwood::bvh::{Morton, Recipe};
use boxwood::device::{Buffer, Device, Recorder, Timing};
use boxwood::kernels;
use boxwood::oracle::{scan, sort};
use std::sync::Arc;

/// One pass by the digit at `shift`: keys and values.
fn pass(device: &Arc<Device>, keys: &[u32], values: &[u32], shift: u32) -> (Vec<u32>, Vec<u32>) {
    let shape = device.shape();
    let count = keys.len() as u32;
    let tiles = count.div_ceil(shape.sort_workgroup * shape.sort_items);
    let constants = [
        (SPEC_WG, shape.sort_workgroup),
        (SPEC_ITEMS, shape.sort_items),
        (SPEC_DIGIT_BITS, shape.sort_digit_bits),
    ];
    let numbers = tiles << shape.sort_digit_bits;
    let new = |name: &str, len: usize| Buffer::<u32>::new(device, name, len).unwrap();
    let keys_in = Buffer::from_slice(device, "keys", keys).unwrap();
    let values_in = Buffer::from_slice(device, "values", values).unwrap();
    let (keys_out, values_out) = (new("keys_out", keys.len()), new("values_out", keys.len()));
    let (counts, total) = (new("counts", numbers as usize), new("total", 1));
    let mut rec = Recorder::new(device, Timing::Off).unwrap();
    let args = SortCountArgs { keys: keys_in.ptr(), counts: counts.ptr_mut(), count, shift, tiles };
    rec.dispatch(&kernels::SORT_COUNT, &constants, tiles, args).unwrap();
    let args = ScanExclusiveArgs { sums: counts.ptr_mut(), total: total.ptr_mut(), count: numbers };
    rec.dispatch(&kernels::SCAN_EXCLUSIVE, &[(SPEC_WG, shape.single_workgroup)], 1, args).unwrap();
    let args = SortScatterArgs {
        keys: keys_in.ptr(),
        values: values_in.ptr(),
        offsets: counts.ptr(),
        keys_out: keys_out.ptr_mut(),
        values_out: values_out.ptr_mut(),
        count,
        shift,
        tiles,
    };
    rec.dispatch(&kernels::SORT_SCATTER, &constants, tiles, args).unwrap();
    rec.submit().unwrap();
    assert_eq!(total.read().unwrap(), [count], "the digits' counts add up");
    (keys_out.read().unwrap(), values_out.read().unwrap())
}

#[test]
fn a_pass_is_stable_at_every_size() {
    let device = quiet();
    let tile = (device.shape().sort_workgroup * device.shape().sort_items) as usize;
    let mask = (1u32 << device.shape().sort_digit_bits) - 1;
    for n in [1, 2, 7, 8, 9, 1023, 1024, 1025, tile - 1, tile, tile + 1, 3 * tile + 5] {
        let mut random = Random(n as u64);
        let keys: Vec<u32> = (0..n).map(|_| random.bits() as u32).collect();
        let values: Vec<u32> = (0..n as u32).map(|i| !i).collect();
        // The last digit has bits beyond the word.
        for shift in [0, 11, 29] {
            let (sorted, carried) = pass(&device, &keys, &values, shift);
            let digits: Vec<u64> = keys.iter().map(|k| u64::from(k >> shift & mask)).collect();
            let order = sort::order(&digits);
            let by = |from: &[u32]| order.iter().map(|i| from[*i as usize]).collect::<Vec<_>>();
            assert_eq!(sorted, by(&keys), "{n} keys, shift {shift}");
            assert_eq!(carried, by(&values), "{n} values, shift {shift}");
        }
    }
}

#[test]
fn duplicates_and_gathering() {
    let device = quiet();
    let shape = device.shape();
    for n in [1usize, 2, 9, 2047, 2049, 9000] {
        let mut random = Random(n as u64);
        let mut keys: Vec<u32> = (0..n).map(|_| random.below(n) as u32).collect();
        let order: Vec<u32> = (0..n).map(|_| random.below(n) as u32).collect();
        let expected: Vec<u32> = order.iter().map(|i| keys[*i as usize]).collect();
        let source = Buffer::from_slice(&device, "source", &keys).unwrap();
        let order = Buffer::from_slice(&device, "order", &order).unwrap();
        let gathered = Buffer::<u32>::new(&device, "gathered", n).unwrap();
        keys.sort_unstable();
        let sorted = Buffer::from_slice(&device, "keys", &keys).unwrap();
        let duplicates = Buffer::from_slice(&device, "duplicates", &[0u32]).unwrap();
        let count = n as u32;
        let mut rec = Recorder::new(&device, Timing::Off).unwrap();
        let wg = shape.trace_workgroup;
        let args =
            SortGatherArgs { source: source.ptr(), order: order.ptr(), gathered: gathered.ptr_mut(), count };
        rec.dispatch(&kernels::SORT_GATHER, &[(SPEC_WG, wg)], count.div_ceil(wg), args).unwrap();
        let constants = [(SPEC_WG, shape.sort_workgroup), (SPEC_ITEMS, shape.sort_items)];
        let groups = count.div_ceil(shape.sort_workgroup * shape.sort_items);
        let args = SortDuplicatesArgs { keys: sorted.ptr(), duplicates: duplicates.ptr_mut(), count };
        rec.dispatch(&kernels::SORT_DUPLICATES, &constants, groups, args).unwrap();
        rec.submit().unwrap();
        assert_eq!(gathered.read().unwrap(), expected);
        let keys: Vec<u64> = keys.into_iter().map(u64::from).collect();
        assert_eq!(duplicates.read().unwrap()[0] as usize, sort::duplicates(&keys), "{n} keys");
    }
}

#[test]
fn long_codes_that_say_no_more_keep_the_order() {
    let device = quiet();
    // Ten alike in each of 4³ cells, centres on powers of two: 30-bit codes are shared, low words all 0.
    let corners: Vec<_> = (0..640u32)
        .map(|i| {
            let cell = i * 37 % 64;
            let at = [cell % 4, cell / 4 % 4, cell / 16].map(|x| x as f32 * 0.25);
            [at, at.map(|x| x + 0.25), [at[0], at[1] + 0.25, at[2]]]
        })
        .collect();
    let soup = scene(&corners);
    let (_, twin) = assert_twin("aligned cells", &device, &soup, &Recipe::default());
    assert_ne!(twin.order, (0..640).collect::<Vec<u32>>());
    assert_twin("aligned cells", &device, &soup, &Recipe { morton: Morton::Bits63, ..Recipe::default() });
}

#[test]
fn a_scan_of_nothing_is_nothing() {
    assert_eq!(scan::exclusive(&mut []), 0);
}
