//! Every struct and constant that the host and the kernels share. Compiled into the crate and into `build.rs`,
//! which writes `abi.glsl` from [`structs`] and [`CONSTANTS`] and refuses a kernel whose SPIR-V offsets differ.
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
/// Device address of an array of `T` that a kernel writes. What one invocation writes no other of the dispatch reads, but
/// for what atomics return.
#[repr(transparent)]
pub struct PtrMut<T>(pub [u32; 2], PhantomData<T>);
/// Device address of an array of `T` through which invocations of one dispatch hand values to each other, as
/// `glsl/lib/handover.glsl` has it: loads and stores are non-private, and the kernel is compiled for the Vulkan memory
/// model. Others of a kernel's arguments may point to the same memory.
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
    ($(#[doc = $list_doc:literal])* $list:ident: $( $(#[doc = $doc:literal])* $(@kernel $($kernel:literal)+)? struct $name:ident { $( $(#[doc = $fdoc:literal])* $field:ident : $ty:ty ),* $(,)? } )*) => {
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
        $(#[doc = $list_doc])*
        pub const $list: &[Struct] = &[ $( $name::LAYOUT, )* ];
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
pub const PAIRS: &[&str] = &[
    "Ray",
    "Hit",
    "Aabb",
    "Cluster",
    "Climber",
    "RawNode",
    "RawCut",
    "Node",
    "AabbNode",
    "ObbNode",
    "Range",
    "PackedTriangle",
    "Tests",
    "Steps",
    "Surface",
];

mod arguments;
mod constants;
mod elements;

pub use arguments::*;
pub use constants::*;
pub use elements::*;

/// Every shared struct, element types before the arguments that name them.
pub fn structs() -> impl Iterator<Item = &'static Struct> {
    [ELEMENTS, ORDER, BINARY, PACKED, BOXES, TRACE, RAYS, RAY_QUERY].into_iter().flatten()
}
