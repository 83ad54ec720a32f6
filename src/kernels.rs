//! The kernels: one constant for each `glsl/<stage>/<verb>.comp`, written by `build.rs`.

use crate::abi;
use core::marker::PhantomData;

/// A compiled kernel and the type of its arguments.
#[derive(Debug)]
pub struct Kernel<A> {
    /// `stage/verb`: its file, its label, its row in a report, its name in an error.
    pub name: &'static str,
    /// SPIR-V without and with 64-bit integers and floats.
    pub spirv: [&'static [u8]; 2],
    args: PhantomData<fn(A)>,
}

impl<A> Kernel<A> {
    const fn new(name: &'static str, spirv: [&'static [u8]; 2]) -> Self {
        Self { name, spirv, args: PhantomData }
    }
}

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
