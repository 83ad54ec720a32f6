//! The kernels: one constant for each `glsl/<stage>/<verb>.comp`, written by `build.rs`.

use crate::abi;
use core::marker::PhantomData;

/// A compiled kernel and the type of its arguments.
#[derive(Debug)]
pub struct Kernel<A> {
    /// `stage/verb`: its file, its label, its row in a report, its name in an error.
    pub name: &'static str,
    /// SPIR-V whose buffers are storage-buffer bindings.
    pub bindings: &'static [u8],
    /// SPIR-V whose buffers are device addresses.
    pub addresses: &'static [u8],
    args: PhantomData<fn(A)>,
}

impl<A> Kernel<A> {
    const fn new(name: &'static str, bindings: &'static [u8], addresses: &'static [u8]) -> Self {
        Self { name, bindings, addresses, args: PhantomData }
    }
}

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
