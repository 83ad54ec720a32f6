//! Rays in the order of their 6-D Morton keys, origin and direction, so that neighbours go much the same way \[AILA09\].
//! The kernels that trace take rays in that order; nothing is moved, so hits stay where they were.

use crate::abi::{
    OrderedBounds, Ptr, Ray, RaysortBoundsArgs, RaysortKeysArgs, SPEC_ITEMS, SPEC_WG, UNORDERED_KEY,
};
use crate::bvh::Radix;
use crate::device::{Buffer, Device, Recorder, Result};
use crate::kernels;
use std::sync::Arc;

/// Buffers of a sort of rays.
#[derive(Debug)]
pub struct Raysort {
    bounds: Buffer<OrderedBounds>,
    keys: Buffer<u32>,
    order: Buffer<u32>,
    radix: Radix,
}

impl Raysort {
    /// For up to `capacity` rays.
    ///
    /// # Errors
    /// Not enough device memory.
    pub fn new(device: &Arc<Device>, capacity: usize) -> Result<Self> {
        Ok(Self {
            bounds: Buffer::new(device, "raysort.bounds", 1)?,
            keys: Buffer::new(device, "raysort.keys", capacity)?,
            order: Buffer::new(device, "raysort.order", capacity)?,
            radix: Radix::new(device, capacity)?,
        })
    }

    /// Rays that there is room for.
    pub fn capacity(&self) -> usize {
        self.order.len()
    }

    /// Records the sort of the first `count` of `rays`; the order is there for what is recorded behind it.
    ///
    /// # Errors
    /// A failed Vulkan call.
    pub fn record(&mut self, rec: &mut Recorder, rays: Ptr<Ray>, count: u32) -> Result<Ptr<u32>> {
        let shape = rec.device().shape().clone();
        let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items)];
        let groups = count.div_ceil(shape.workgroup * shape.items);
        rec.update(&self.bounds, &[OrderedBounds::EMPTY]);
        let args = RaysortBoundsArgs { rays, bounds: self.bounds.ptr_mut(), count };
        rec.dispatch(&kernels::RAYSORT_BOUNDS, &constants, groups, args)?;
        let (keys, order) = (self.keys.ptr_mut(), self.order.ptr_mut());
        let args = RaysortKeysArgs { rays, bounds: self.bounds.ptr(), keys, order, count };
        rec.dispatch(&kernels::RAYSORT_KEYS, &constants, groups, args)?;
        // By all bits that keys have: to learn which of them differ takes a submit of its own.
        self.radix.sort(rec, &mut self.keys, &mut self.order, count, UNORDERED_KEY)?;
        Ok(self.order.ptr())
    }

    /// The first `count` keys in rising order, and the rays that they are of: for tests.
    ///
    /// # Errors
    /// A failed copy.
    pub fn read(&self, count: usize) -> Result<(Vec<u32>, Vec<u32>)> {
        Ok((self.keys.read_first(count)?, self.order.read_first(count)?))
    }
}
