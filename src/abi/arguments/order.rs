//! Arguments of what orders triangles along a curve.

use crate::abi::*;

abi! {
    /// Push constants of these kernels.
    ORDER:
    @kernel "morton/bounds"
    struct MortonBoundsArgs {
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// One; lo at the greatest and hi at the least ordered integer, the rest 0.
        bounds: PtrMut<SceneBounds>,
        /// Triangles.
        count: u32,
    }
    @kernel "morton/encode"
    struct MortonEncodeArgs {
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// One, from `morton/bounds`; gains the live bits.
        bounds: PtrMut<SceneBounds>,
        /// Codes of 30 bits, or the upper 31 of 63.
        keys: PtrMut<u32>,
        /// Low 32 of 63 bits; not followed where `code` is [`CODE_30`].
        low_keys: PtrMut<u32>,
        /// 0, 1, 2, …
        order: PtrMut<u32>,
        /// Triangles.
        count: u32,
        /// Which codes: [`CODE_30`] and those that follow it.
        code: u32,
    }
    @kernel "sort/count"
    struct SortCountArgs {
        /// Keys.
        keys: Ptr<u32>,
        /// How often each digit occurs in each tile, digit-major.
        counts: PtrMut<u32>,
        /// Keys.
        count: u32,
        /// Lowest bit of the digit.
        shift: u32,
        /// Tiles: workgroups.
        tiles: u32,
    }
    @kernel "sort/scatter"
    struct SortScatterArgs {
        /// Keys.
        keys: Ptr<u32>,
        /// What travels with them.
        values: Ptr<u32>,
        /// Where each tile's keys of each digit go, digit-major.
        offsets: Ptr<u32>,
        /// Keys in order of the digit, stable.
        keys_out: PtrMut<u32>,
        /// Values likewise.
        values_out: PtrMut<u32>,
        /// Keys.
        count: u32,
        /// Lowest bit of the digit.
        shift: u32,
        /// Tiles: workgroups.
        tiles: u32,
    }
    @kernel "sort/gather"
    struct SortGatherArgs {
        /// Values of one word.
        source: Ptr<u32>,
        /// Which of them, in order.
        order: Ptr<u32>,
        /// `source[order[i]]`.
        gathered: PtrMut<u32>,
        /// Entries of `order`.
        count: u32,
    }
    @kernel "sort/duplicates"
    struct SortDuplicatesArgs {
        /// Sorted keys.
        keys: Ptr<u32>,
        /// One: gains the keys that equal their predecessor.
        duplicates: PtrMut<u32>,
        /// Keys.
        count: u32,
    }
    @kernel "scan/exclusive"
    struct ScanExclusiveArgs {
        /// Numbers; each becomes the sum of those before it.
        sums: PtrMut<u32>,
        /// One: the sum of all.
        total: PtrMut<u32>,
        /// Numbers.
        count: u32,
    }
}
