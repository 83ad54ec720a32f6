//! Every struct and constant that the host and the kernels share. Compiled into the crate and into `build.rs`,
//! which writes `abi.glsl` from [`STRUCTS`] and [`CONSTANTS`] and refuses a kernel whose SPIR-V offsets differ.
//!
//! All structs are scalar-layout: 4-byte aligned, no padding. A kernel's arguments travel in push constants
//! (at most [`PUSH_BYTES`]); [`Ptr`] and [`PtrMut`] in them become typed buffers in the kernel, written
//! `P(bounds).at[i]`.

use core::marker::PhantomData;

/// Largest push-constant block that every Vulkan device takes, bytes.
pub const PUSH_BYTES: usize = 128;

/// Device address of an array of `T` that a kernel only reads.
#[repr(transparent)]
pub struct Ptr<T>(pub [u32; 2], PhantomData<T>);
/// Device address of an array of `T` that a kernel writes.
#[repr(transparent)]
pub struct PtrMut<T>(pub [u32; 2], PhantomData<T>);
/// Device address of an array of `T` through which invocations of one dispatch hand values to each other.
#[repr(transparent)]
pub struct PtrShared<T>(pub [u32; 2], PhantomData<T>);

macro_rules! pointer {
    ($name:ident) => {
        impl<T> $name<T> {
            /// The pointer to `address`; 0 is no buffer, and never to be followed.
            pub const fn new(address: u64) -> Self {
                Self([address as u32, (address >> 32) as u32], PhantomData)
            }
            /// The same memory as another element type.
            pub const fn cast<U>(self) -> $name<U> {
                $name(self.0, PhantomData)
            }
        }
        impl<T> Clone for $name<T> {
            fn clone(&self) -> Self {
                *self
            }
        }
        impl<T> Copy for $name<T> {}
        impl<T> core::fmt::Debug for $name<T> {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                write!(f, "{:#010x}{:08x}", self.0[1], self.0[0])
            }
        }
    };
}
pointer!(Ptr);
pointer!(PtrMut);
pointer!(PtrShared);

/// One member of a shared struct: its name, its Rust type as written, its byte offset.
#[derive(Debug, Clone, Copy)]
pub struct Member {
    /// Name, the same in GLSL.
    pub name: &'static str,
    /// Rust type as written in this file, spaces and all.
    pub ty: &'static str,
    /// Byte offset on the host.
    pub offset: usize,
}

/// A shared struct.
#[derive(Debug, Clone, Copy)]
pub struct Struct {
    /// Name, the same in GLSL.
    pub name: &'static str,
    /// Size in bytes.
    pub size: usize,
    /// Members in order.
    pub members: &'static [Member],
    /// The kernels whose push constants these are (`"ploc/search"`); none for an element type.
    pub kernels: &'static [&'static str],
}

/// Arguments of one kernel.
pub trait Args: bytemuck::NoUninit {
    /// Layout of the arguments.
    const STRUCT: Struct;
}

macro_rules! abi {
    ($( $(#[doc = $doc:literal])* $(@kernel $($kernel:literal)+)? struct $name:ident { $( $(#[doc = $fdoc:literal])* $field:ident : $ty:ty ),* $(,)? } )*) => {
        $(
            $(#[doc = $doc])*
            $($(#[doc = concat!("Arguments of `", $kernel, "`.")])+)?
            #[repr(C)]
            #[derive(Debug, Clone, Copy)]
            pub struct $name { $( $(#[doc = $fdoc])* pub $field: $ty, )* }
            abi!(@pod $name $($($kernel)+)?);
            impl $name {
                /// Layout, for the generator.
                pub const LAYOUT: Struct = Struct {
                    name: stringify!($name),
                    size: core::mem::size_of::<$name>(),
                    members: &[ $( Member {
                        name: stringify!($field), ty: stringify!($ty), offset: core::mem::offset_of!($name, $field),
                    }, )* ],
                    kernels: &[$($($kernel),+)?],
                };
            }
            const _: () = assert!(core::mem::align_of::<$name>() == 4);
            const _: () = assert!({ let mut sum = 0; $( sum += core::mem::size_of::<$ty>(); )* sum } == core::mem::size_of::<$name>());
        )*
        /// Every shared struct, element types before the arguments that name them.
        pub const STRUCTS: &[Struct] = &[ $( $name::LAYOUT, )* ];
    };
    (@pod $name:ident) => {
        // SAFETY: repr(C), 4-byte words only, no padding (asserted below), any bit pattern is a value.
        #[allow(unsafe_code)]
        unsafe impl bytemuck::Zeroable for $name {}
        // SAFETY: as above.
        #[allow(unsafe_code)]
        unsafe impl bytemuck::Pod for $name {}
    };
    (@pod $name:ident $($kernel:literal)+) => {
        // SAFETY: repr(C), 4-byte words only, no padding (asserted below): every byte is initialised.
        #[allow(unsafe_code)]
        unsafe impl bytemuck::NoUninit for $name {}
        impl Args for $name { const STRUCT: Struct = Self::LAYOUT; }
        const _: () = assert!(core::mem::size_of::<$name>() <= PUSH_BYTES);
    };
}

/// Two words: how kernels see arrays that they load two words at a time.
pub type Pair = [u32; 2];

/// Structs that buffers hold as pairs of words, which kernels load with `LOAD_S(buffer, i)` and store with
/// `STORE_S(buffer, i, value)`; the others are plain structs in their buffers.
pub const PAIRS: &[&str] =
    &["Ray", "Hit", "Aabb", "Cluster", "RawNode", "RawLink", "Node", "PackedTriangle", "Tests", "Surface"];

macro_rules! constants {
    ($( $(#[doc = $doc:literal])* $name:ident = $value:expr; )*) => {
        $( $(#[doc = $doc])* pub const $name: u32 = $value; )*
        /// Constants under the names that kernels use.
        pub const CONSTANTS: &[(&str, u32)] = &[ $( (stringify!($name), $name), )* ];
    };
}

constants! {
    /// No triangle, no node, no partner.
    INVALID = 0xffff_ffff;
    /// Set in a child reference: the rest names a leaf.
    LEAF_BIT = 0x8000_0000;
    /// Set in a raw node's count, and in its parent's reference to it: the surface area heuristic prefers this subtree
    /// as one leaf.
    COLLAPSED_BIT = 0x4000_0000;
    /// Set likewise: the packed node of the parent takes this node's children in its place.
    ABSORBED_BIT = 0x2000_0000;
    /// Bits of a raw node's count that count, and of a reference to a raw node that name it.
    RAW_MASK = 0x0fff_ffff;
    /// Children of a packed node.
    WIDTH = 4;
    /// Lowest bit of what a cluster's count holds beside the triangles.
    SLOTS_SHIFT = 28;
    /// Words of a triangle in a packed tree: nine coordinates and the input index.
    TRIANGLE_WORDS = 10;
    /// Key of a triangle that can't be hit: sorts behind every Morton code.
    UNHITTABLE_KEY = 0x8000_0000;
    /// Clusters at and below which one workgroup runs PLOC's remaining rounds in one dispatch.
    TAIL_CLUSTERS = 2048;
    /// Largest triangle count of a leaf.
    MAX_LEAF = 64;

    // Specialization constants: the id is the value. Every kernel gets its workgroup size as `WG`.
    /// Workgroup size, invocations.
    SPEC_WG = 0;
    /// Consecutive items that one invocation handles.
    SPEC_ITEMS = 1;
    /// PLOC search radius, clusters to either side.
    SPEC_RADIUS = 2;
    /// Bits of a radix sort digit.
    SPEC_DIGIT_BITS = 3;
    /// Entries of the traversal stack.
    SPEC_STACK = 4;
    /// Bits of a packed leaf reference that hold its triangle count less one.
    SPEC_LEAF_BITS = 5;
    /// 1: any-hit query.
    SPEC_ANY = 6;
    /// 1: count box and triangle tests.
    SPEC_COUNT = 7;
    /// 1: watertight triangle test with exact signs, 0: Möller–Trumbore.
    SPEC_ROBUST = 8;
}

abi! {
    // ---- elements --------------------------------------------------------------------------
    /// A ray as files hold it: direction of any length but zero, t in units of the direction's length.
    struct Ray {
        /// Origin, scene units.
        origin: [f32; 3],
        /// Least t that counts as a hit.
        t_min: f32,
        /// Direction; need not be unit.
        direction: [f32; 3],
        /// Greatest t that counts as a hit; may be +inf.
        t_max: f32,
    }
    /// What a ray met.
    struct Hit {
        /// Ray parameter; +inf on a miss; 0 where an any-hit query was occluded.
        t: f32,
        /// Triangle in input order, [`INVALID`] on a miss.
        triangle: u32,
        /// Barycentric weight of the triangle's second vertex.
        u: f32,
        /// Barycentric weight of the triangle's third vertex.
        v: f32,
    }
    /// An axis-aligned box; empty where lo > hi.
    struct Aabb {
        /// Least corner.
        lo: [f32; 3],
        /// Greatest corner.
        hi: [f32; 3],
    }
    /// What the triangles have in common. Floats as ordered integers: see `ordered` in `glsl/lib/ordered.glsl`.
    struct SceneBounds {
        /// Least corner, ordered integers.
        lo: [u32; 3],
        /// Greatest corner, ordered integers.
        hi: [u32; 3],
        /// Triangles that can be hit.
        hittable: u32,
        /// Bits of the (high) Morton codes that are 1 somewhere.
        ones: u32,
        /// Bits of the (high) Morton codes that are 0 somewhere.
        zeros: u32,
        /// As `ones`, of the low words of 63-bit codes.
        low_ones: u32,
        /// As `zeros`, of the low words of 63-bit codes.
        low_zeros: u32,
    }
    /// A cluster of PLOC, beside its box.
    struct Cluster {
        /// Raw node, or [`LEAF_BIT`] | Morton rank of a triangle.
        node: u32,
        /// Morton rank of the first triangle: unique among live clusters, rising.
        rank: u32,
        /// Triangles, and from [`SLOTS_SHIFT`] on one less than the children that a packed node of `node` would have: 0
        /// for a triangle, or where `node` is collapsed.
        count: u32,
        /// Expected cost of the subtree if hit times its half area (not divided by the scene's): \[GOLDSMITH87\].
        cost: f32,
    }
    /// An inner node of the binary tree before collapse and layout.
    struct RawNode {
        /// First child's box, unit space.
        left_bounds: Aabb,
        /// Second child's box, unit space.
        right_bounds: Aabb,
        /// First child: raw node, with [`COLLAPSED_BIT`] and [`ABSORBED_BIT`], or [`LEAF_BIT`] | Morton rank.
        left: u32,
        /// Second child.
        right: u32,
    }
    /// What the node above says of a raw node.
    struct RawLink {
        /// Triangles below, with [`COLLAPSED_BIT`] and [`ABSORBED_BIT`].
        count: u32,
        /// Raw node above; [`INVALID`] at the root.
        parent: u32,
    }
    /// An inner node of a packed tree, one 64-byte line: up to four children, their boxes on the node's own grid of
    /// 256 planes an axis, rounded outward: plane q lies at origin + q · 2^exponent \[YLITIE17\].
    struct Node {
        /// Least corner of the node's box, unit space.
        origin: [f32; 3],
        /// Exponents + 127 of x, y, z in the low three bytes.
        exponents: u32,
        /// Least planes of the children, child k's in byte k; 255 where there is none.
        lo: [u32; 3],
        /// Greatest planes of the children; 0 where there is none.
        hi: [u32; 3],
        /// Node, or [`LEAF_BIT`] | count − 1 | first triangle (see `SPEC_LEAF_BITS`), or [`INVALID`], which come last.
        children: [u32; 4],
        /// 0: keeps a node within one cache line.
        pad: [u32; 2],
    }
    /// A triangle of a packed tree.
    struct PackedTriangle {
        /// First corner · 2^exponent.
        a: [f32; 3],
        /// Second corner.
        b: [f32; 3],
        /// Third corner.
        c: [f32; 3],
        /// Input index.
        index: u32,
    }
    /// Where PLOC stands before a round; the first four words are an indirect dispatch and its workgroup count.
    struct PlocState {
        /// Workgroups of this round's dispatches; all 0 once the tail takes over.
        groups: [u32; 3],
        /// Live clusters.
        clusters: u32,
        /// Rounds done.
        rounds: u32,
    }
    /// What PLOC leaves behind.
    struct PlocRoot {
        /// The root: raw node, or [`LEAF_BIT`] | 0.
        node: u32,
        /// Rounds in all: no path of the tree is longer.
        rounds: u32,
        /// 1: a round merged nothing, the tree is unfinished (never seen; see `ploc/tail`).
        stalled: u32,
        /// Cost of the root, as [`Cluster::cost`].
        cost: f32,
        /// Box of all triangles, unit space.
        bounds: Aabb,
    }
    /// Box and triangle tests of one ray.
    struct Tests {
        /// Child boxes tested.
        boxes: u32,
        /// Triangles tested.
        triangles: u32,
    }

    // ---- arguments -------------------------------------------------------------------------
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
        /// Codes: 30 bits, or the upper 31 of 63.
        keys: PtrMut<u32>,
        /// Low 32 of 63 bits; not followed where `wide` is 0.
        low_keys: PtrMut<u32>,
        /// 0, 1, 2, …
        order: PtrMut<u32>,
        /// Triangles.
        count: u32,
        /// 1: 63-bit codes.
        wide: u32,
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
    @kernel "ploc/leaves"
    struct PlocLeavesArgs {
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// Triangles in Morton order.
        order: Ptr<u32>,
        /// Boxes of the clusters, unit space.
        bounds: PtrMut<Aabb>,
        /// Clusters.
        clusters: PtrMut<Cluster>,
        /// Triangles.
        count: u32,
        /// Unit space is scene · `scale` − `anchor`.
        scale: f32,
        /// As above.
        anchor: [f32; 3],
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
    }
    @kernel "ploc/search" "ploc/search_loads"
    struct PlocSearchArgs {
        /// Boxes of the clusters: `capacity` after an even number of rounds, then `capacity` after an odd one.
        bounds: Ptr<Aabb>,
        /// One a round.
        state: Ptr<PlocState>,
        /// Key of each cluster's least pair.
        nearest: PtrMut<u32>,
        /// This round.
        round: u32,
        /// Clusters that one half of `bounds` holds.
        capacity: u32,
    }
    @kernel "ploc/count"
    struct PlocCountArgs {
        /// Key of each cluster's least pair.
        nearest: Ptr<u32>,
        /// One a round.
        state: Ptr<PlocState>,
        /// Clusters that live on, a workgroup.
        sums: PtrMut<u32>,
        /// This round.
        round: u32,
    }
    @kernel "ploc/scan"
    struct PlocScanArgs {
        /// Clusters that live on, a workgroup; becomes the sum of those before.
        sums: PtrMut<u32>,
        /// One a round: the next one is written.
        state: PtrMut<PlocState>,
        /// This round.
        round: u32,
        /// Clusters that one workgroup of the round's kernels handles.
        tile: u32,
    }
    @kernel "ploc/merge"
    struct PlocMergeArgs {
        /// Key of each cluster's least pair.
        nearest: Ptr<u32>,
        /// From `ploc/scan`.
        sums: Ptr<u32>,
        /// One a round.
        state: Ptr<PlocState>,
        /// Boxes of the clusters, two halves: from one to the other.
        bounds: PtrMut<Aabb>,
        /// Clusters, two halves likewise.
        clusters: PtrMut<Cluster>,
        /// The tree.
        nodes: PtrMut<RawNode>,
        /// One a node; the root's stays unwritten.
        links: PtrMut<RawLink>,
        /// This round.
        round: u32,
        /// Clusters that one half holds.
        capacity: u32,
        /// Cost of a box-pair test, c_T.
        traversal_cost: f32,
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
        /// Largest leaf.
        max_leaf: u32,
    }
    @kernel "ploc/tail"
    struct PlocTailArgs {
        /// Key of each cluster's least pair.
        nearest: PtrShared<u32>,
        /// Boxes of the clusters, two halves.
        bounds: PtrShared<Aabb>,
        /// Clusters, two halves.
        clusters: PtrShared<Cluster>,
        /// One a round.
        state: Ptr<PlocState>,
        /// The tree.
        nodes: PtrShared<RawNode>,
        /// One a node.
        links: PtrShared<RawLink>,
        /// One.
        root: PtrMut<PlocRoot>,
        /// The round whose state is the last.
        round: u32,
        /// Clusters that one half holds.
        capacity: u32,
        /// Cost of a box-pair test, c_T.
        traversal_cost: f32,
        /// Cost of a triangle test, c_I.
        triangle_cost: f32,
        /// Largest leaf.
        max_leaf: u32,
    }
    @kernel "collapse/count"
    struct CollapseCountArgs {
        /// The tree.
        raw: Ptr<RawNode>,
        /// One a node.
        links: Ptr<RawLink>,
        /// Nodes kept a workgroup, then leaf triangles a workgroup.
        sums: PtrMut<u32>,
        /// Triangles of the leaves that are children of each packed node; [`INVALID`] where the raw node isn't kept.
        leaf_triangles: PtrMut<u32>,
        /// Raw nodes.
        count: u32,
        /// Workgroups.
        groups: u32,
        /// Largest leaf.
        max_leaf: u32,
    }
    @kernel "collapse/number"
    struct CollapseNumberArgs {
        /// From `collapse/count`, scanned.
        sums: Ptr<u32>,
        /// From `collapse/count`; becomes the first triangle of the leaves below each kept node.
        leaf_triangles: PtrMut<u32>,
        /// Packed index of each kept node.
        packed: PtrMut<u32>,
        /// The kept nodes, in order.
        kept: PtrMut<u32>,
        /// Raw nodes.
        count: u32,
        /// Workgroups.
        groups: u32,
    }
    @kernel "layout/nodes"
    struct LayoutNodesArgs {
        /// The tree.
        raw: Ptr<RawNode>,
        /// One a node.
        links: Ptr<RawLink>,
        /// The kept nodes, in order.
        kept: Ptr<u32>,
        /// Packed index of each kept node.
        packed: Ptr<u32>,
        /// First triangle of the leaves below each kept node.
        leaf_triangles: Ptr<u32>,
        /// Triangles in Morton order.
        order: Ptr<u32>,
        /// The packed tree.
        nodes: PtrMut<Node>,
        /// Triangles in leaf order: input indices.
        sequence: PtrMut<u32>,
        /// Kept nodes.
        count: u32,
    }
    @kernel "layout/triangles"
    struct LayoutTrianglesArgs {
        /// Corners, nine floats a triangle.
        source: Ptr<Pair>,
        /// Triangles in leaf order: input indices.
        sequence: Ptr<u32>,
        /// The tree's triangles.
        triangles: PtrMut<PackedTriangle>,
        /// Triangles.
        count: u32,
        /// Unit space is scene · `scale` − anchor.
        scale: f32,
    }
    @kernel "layout/leaf"
    struct LayoutLeafArgs {
        /// The tree.
        raw: Ptr<RawNode>,
        /// From `ploc/tail`.
        root: Ptr<PlocRoot>,
        /// Triangles in Morton order.
        order: Ptr<u32>,
        /// The packed tree: one node.
        nodes: PtrMut<Node>,
        /// Triangles in leaf order: input indices.
        sequence: PtrMut<u32>,
    }
    @kernel "trace/single" "trace/refill" "trace/packet"
    struct TraceArgs {
        /// Rays, scene space.
        rays: Ptr<Ray>,
        /// The packed tree.
        nodes: Ptr<Node>,
        /// Its triangles.
        triangles: Ptr<PackedTriangle>,
        /// Hits, one a ray.
        hits: PtrMut<Hit>,
        /// One a ray; not followed where SPEC_COUNT is 0.
        tests: PtrMut<Tests>,
        /// Rays.
        count: u32,
        /// Root of the packed tree.
        root: u32,
        /// Exponent of the power of two that takes scene space to unit space.
        exponent: i32,
        /// Unit space is scene · 2^exponent − `anchor`.
        anchor: [f32; 3],
        /// Largest coordinate of the tree, unit space.
        reach: f32,
        /// Threads that a software driver deals workgroups to; 1 on a GPU.
        threads: u32,
    }
    /// Where a primary ray met the scene, made ready for secondary rays.
    struct Surface {
        /// Hit point, off the triangle by a bound on its rounding.
        origin: [f32; 3],
        /// Unit normal, facing the primary.
        normal: [f32; 3],
        /// The primary's index.
        primary: u32,
        /// 0: a whole number of pairs.
        pad: u32,
    }
    @kernel "rays/primary"
    struct RaysPrimaryArgs {
        /// Whole 8×8 blocks in Morton order, x | y << 16.
        blocks: Ptr<u32>,
        /// Rays.
        rays: PtrMut<Ray>,
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Origin of all rays.
        eye: [f32; 3],
        /// From the eye to the picture's top left corner.
        corner: [f32; 3],
        /// From a pixel to the next in its row.
        across: [f32; 3],
        /// From a row to the next.
        down: [f32; 3],
    }
    @kernel "rays/count"
    struct RaysCountArgs {
        /// Primaries.
        rays: Ptr<Ray>,
        /// What they met.
        hits: Ptr<Hit>,
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// Surfaces under each run of primaries.
        sums: PtrMut<u32>,
        /// First primary.
        start: u32,
        /// Behind the last.
        end: u32,
    }
    @kernel "rays/surface"
    struct RaysSurfaceArgs {
        /// Primaries.
        rays: Ptr<Ray>,
        /// What they met.
        hits: Ptr<Hit>,
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// Surfaces before each run of primaries.
        sums: Ptr<u32>,
        /// Surfaces in all; the primary before which `limit` was reached.
        taken: PtrMut<u32>,
        /// The first `limit` of them.
        surfaces: PtrMut<Surface>,
        /// First primary.
        start: u32,
        /// Behind the last.
        end: u32,
        /// Surfaces wanted.
        limit: u32,
    }
    @kernel "rays/secondary"
    struct RaysSecondaryArgs {
        /// Surfaces that rays leave.
        surfaces: Ptr<Surface>,
        /// Points of the unit square, 24-bit fixed point, one a sample.
        points: Ptr<Pair>,
        /// From `rays/surface`.
        taken: Ptr<u32>,
        /// Rays.
        rays: PtrMut<Ray>,
        /// Rays a surface.
        samples: u32,
        /// Surfaces wanted.
        limit: u32,
        /// Greatest t.
        t_max: f32,
    }
}

impl Hit {
    /// What a query writes where nothing is hit.
    pub const MISS: Hit = Hit { t: f32::INFINITY, triangle: INVALID, u: 0.0, v: 0.0 };
    /// Whether the ray met something.
    pub fn is_hit(&self) -> bool {
        self.t < f32::INFINITY
    }
}
