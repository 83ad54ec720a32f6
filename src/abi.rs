//! Every struct and constant that the host and the kernels share. Compiled into the crate and into `build.rs`,
//! which writes `abi.glsl` from [`STRUCTS`] and [`CONSTANTS`] and refuses a kernel whose SPIR-V offsets differ.
//!
//! All structs are scalar-layout: 4-byte aligned, no padding. A kernel's arguments travel in push constants
//! (at most [`PUSH_BYTES`]); [`Ptr`] and [`PtrMut`] in them become typed buffers in the kernel, written
//! `P(bounds).at[i]`, either a storage-buffer binding or a device address: see `device::kernel`.

use core::marker::PhantomData;

/// Largest push-constant block that every Vulkan device takes, bytes.
pub const PUSH_BYTES: usize = 128;

/// Device address of an array of `T` that a kernel only reads.
#[repr(transparent)]
pub struct Ptr<T>(pub [u32; 2], PhantomData<T>);
/// Device address of an array of `T` that a kernel writes.
#[repr(transparent)]
pub struct PtrMut<T>(pub [u32; 2], PhantomData<T>);

macro_rules! pointer {
    ($name:ident) => {
        impl<T> $name<T> {
            /// The pointer to `address`; 0 is no buffer, and never to be followed.
            pub const fn new(address: u64) -> Self {
                Self([address as u32, (address >> 32) as u32], PhantomData)
            }
        }
        impl<T> Clone for $name<T> {
            fn clone(&self) -> Self {
                *self
            }
        }
        impl<T> Copy for $name<T> {}
    };
}
pointer!(Ptr);
pointer!(PtrMut);

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
    /// The kernel whose push constants these are (`"ploc/search"`), or "" for an element type.
    pub kernel: &'static str,
}

/// Arguments of one kernel.
pub trait Args: bytemuck::NoUninit {
    /// Layout of the arguments.
    const STRUCT: Struct;
}

macro_rules! abi {
    ($( $(#[doc = $doc:literal])* $(@kernel $kernel:literal)? struct $name:ident { $( $(#[doc = $fdoc:literal])* $field:ident : $ty:ty ),* $(,)? } )*) => {
        $(
            $(#[doc = $doc])*
            #[repr(C)]
            #[derive(Clone, Copy)]
            pub struct $name { $( $(#[doc = $fdoc])* pub $field: $ty, )* }
            abi!(@pod $name $($kernel)?);
            impl $name {
                /// Layout, for the generator.
                pub const LAYOUT: Struct = Struct {
                    name: stringify!($name),
                    size: core::mem::size_of::<$name>(),
                    members: &[ $( Member {
                        name: stringify!($field), ty: stringify!($ty), offset: core::mem::offset_of!($name, $field),
                    }, )* ],
                    kernel: concat!($($kernel)?),
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
    (@pod $name:ident $kernel:literal) => {
        // SAFETY: repr(C), 4-byte words only, no padding (asserted below): every byte is initialised.
        #[allow(unsafe_code)]
        unsafe impl bytemuck::NoUninit for $name {}
        impl Args for $name { const STRUCT: Struct = Self::LAYOUT; }
        const _: () = assert!(core::mem::size_of::<$name>() <= PUSH_BYTES);
    };
}

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
    /// Set in [`RawNode::count`]: the surface area heuristic prefers this subtree as one leaf.
    COLLAPSED_BIT = 0x8000_0000;
    /// Words of a triangle in a packed tree: nine coordinates and the input index.
    TRIANGLE_WORDS = 10;

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
}

impl Hit {
    /// What a query writes where nothing is hit.
    pub const MISS: Hit = Hit { t: f32::INFINITY, triangle: INVALID, u: 0.0, v: 0.0 };
    /// Whether the ray met something.
    pub fn is_hit(&self) -> bool {
        self.t < f32::INFINITY
    }
}
