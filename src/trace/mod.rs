//! Traces rays through a packed tree: nearest hit, any hit, and either with tests counted.

mod coherence;
pub mod rays;

pub use coherence::is_coherent;

use crate::abi::{
    Hit, PtrMut, Ray, SPEC_ANY, SPEC_COUNT, SPEC_LEAF_BITS, SPEC_ROBUST, SPEC_STACK, SPEC_WG, Tests,
    TracePacketArgs, TraceSingleArgs,
};
use crate::bvh::Bvh;
use crate::device::{Buffer, Device, DeviceError, Recorder, Result, Times, Timing};
use crate::kernels;
use std::sync::Arc;

/// Rays that one dispatch takes at most (the seed's batch).
pub const BATCH: usize = 1 << 20;
/// Largest stack: beyond it a tree is refused, never traced wrongly.
const MAX_STACK: u32 = 4096;

/// What to find.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Query {
    /// The nearest hit with t, triangle, u, v.
    #[default]
    Closest,
    /// Whether there is a hit: no t, u, v.
    Any,
}

/// Which triangle test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// Watertight, with exact signs \[WOOP13\].
    #[default]
    Robust,
    /// Möller–Trumbore \[MOLLER97\]: leaks at edges and vertices.
    Fast,
}

/// How to trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// What to find.
    pub query: Query,
    /// Which triangle test.
    pub precision: Precision,
    /// Whether neighbouring rays go much the same way; lets devices that gain by it trace packets.
    pub coherent: bool,
}

/// Rays and their results on the device.
#[derive(Debug)]
pub struct Batch {
    /// Rays.
    pub rays: Buffer<Ray>,
    /// One hit a ray.
    pub hits: Buffer<Hit>,
    /// One a ray where tests are counted.
    pub tests: Option<Buffer<Tests>>,
    /// Rays in use.
    pub count: usize,
}

impl Batch {
    /// Room for `capacity` rays; `counting` adds room for their tests.
    ///
    /// # Errors
    /// Not enough device memory.
    pub fn new(device: &Arc<Device>, capacity: usize, counting: bool) -> Result<Self> {
        Ok(Self {
            rays: Buffer::new(device, "trace.rays", capacity)?,
            hits: Buffer::new(device, "trace.hits", capacity)?,
            tests: if counting { Some(Buffer::new(device, "trace.tests", capacity)?) } else { None },
            count: 0,
        })
    }

    /// Uploads `rays`, at most as many as there is room for.
    ///
    /// # Errors
    /// A failed copy; too many rays.
    pub fn set(&mut self, rays: &[Ray]) -> Result<()> {
        self.count = rays.len();
        self.rays.write(rays)
    }
}

/// Entries of the stack for a tree of `depth` levels: few sizes, so that few pipelines are made.
///
/// # Errors
/// [`DeviceError::Limit`] for a tree deeper than any stack.
fn stack_size(depth: u32) -> Result<u32> {
    if depth > MAX_STACK {
        let (wanted, limit) = (depth.into(), MAX_STACK.into());
        return Err(DeviceError::Limit { what: "levels of the tree".into(), wanted, limit });
    }
    Ok(depth.next_power_of_two().max(64))
}

/// Traces the rays of `batch`; counts tests where it has room for them.
///
/// # Errors
/// A failed Vulkan call.
pub fn trace(
    device: &Arc<Device>,
    bvh: &Bvh,
    batch: &Batch,
    options: Options,
    timing: Timing,
) -> Result<Times> {
    let mut rec = Recorder::new(device, timing)?;
    record(&mut rec, bvh, batch, options)?;
    rec.submit()
}

/// The kernel that `options` ask for on this device, by name.
pub fn kernel_name(device: &Device, options: Options) -> &'static str {
    if options.coherent && device.shape().packets {
        kernels::TRACE_PACKET.name
    } else {
        kernels::TRACE_SINGLE.name
    }
}

fn record(rec: &mut Recorder, bvh: &Bvh, batch: &Batch, options: Options) -> Result<()> {
    let device = rec.device().clone();
    let shape = device.shape();
    let constants = [
        (SPEC_WG, shape.trace_workgroup),
        (SPEC_STACK, stack_size(bvh.depth)?),
        (SPEC_LEAF_BITS, bvh.leaf_bits),
        (SPEC_ANY, (options.query == Query::Any).into()),
        (SPEC_COUNT, batch.tests.is_some().into()),
        (SPEC_ROBUST, (options.precision == Precision::Robust).into()),
    ];
    let count = batch.count as u32;
    // Dealing workgroups out in turn wants as many of them as threads divide.
    let groups = count.div_ceil(shape.trace_workgroup).next_multiple_of(shape.threads);
    let tests = batch.tests.as_ref().map_or(PtrMut::new(0), Buffer::ptr_mut);
    let (rays, hits, triangles) = (batch.rays.ptr(), batch.hits.ptr_mut(), bvh.triangles.ptr().cast());
    let Bvh { root, exponent, anchor, reach, .. } = *bvh;
    let threads = shape.threads;
    if options.coherent && shape.packets {
        let nodes = bvh.nodes.ptr();
        let args = TracePacketArgs {
            rays,
            nodes,
            triangles,
            hits,
            tests,
            count,
            root,
            exponent,
            anchor,
            reach,
            threads,
        };
        rec.dispatch(&kernels::TRACE_PACKET, &constants, groups, args)
    } else {
        let nodes = bvh.nodes.ptr();
        let args = TraceSingleArgs {
            rays,
            nodes,
            triangles,
            hits,
            tests,
            count,
            root,
            exponent,
            anchor,
            reach,
            threads,
        };
        rec.dispatch(&kernels::TRACE_SINGLE, &constants, groups, args)
    }
}
