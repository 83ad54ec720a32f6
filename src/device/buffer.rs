//! Named, typed arrays in device memory, reached by device address.

use super::error::{DeviceError, Result};
use super::{Device, Recorder, lock};
use crate::abi::{Ptr, PtrMut, PtrShared};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan as ga;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Bytes that one staging copy moves.
const STAGING: usize = 32 << 20;

/// A Vulkan buffer and its memory, owned by nobody.
pub(super) struct Memory {
    pub(super) raw: vk::Buffer,
    pub(super) address: u64,
    pub(super) bytes: u64,
    pub(super) location: MemoryLocation,
    /// Beside what all buffers are for.
    pub(super) usage: vk::BufferUsageFlags,
    pub(super) allocation: Option<ga::Allocation>,
}

/// A buffer in use.
pub(super) struct Allocated {
    pub(super) raw: vk::Buffer,
    pub(super) address: u64,
    pub(super) bytes: u64,
    location: MemoryLocation,
    usage: vk::BufferUsageFlags,
    allocation: Option<ga::Allocation>,
    device: Arc<Device>,
}

impl Allocated {
    pub(super) fn new(
        device: &Arc<Device>,
        name: &str,
        bytes: u64,
        location: MemoryLocation,
    ) -> Result<Self> {
        Self::with_usage(device, name, bytes, location, vk::BufferUsageFlags::empty())
    }

    /// With a `usage` beside what all buffers are for.
    pub(super) fn with_usage(
        device: &Arc<Device>,
        name: &str,
        bytes: u64,
        location: MemoryLocation,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self> {
        let bytes = bytes.max(16).next_multiple_of(16);
        let memory = match device.take_spare(bytes, location, usage) {
            Some(memory) => memory,
            None => create(device, name, bytes, location, usage).or_else(|e| {
                // What lies spare may be just what is missing.
                device.free_spare();
                if matches!(e, DeviceError::Memory { .. }) {
                    create(device, name, bytes, location, usage)
                } else {
                    Err(e)
                }
            })?,
        };
        let now = device.in_use.fetch_add(bytes, Ordering::Relaxed) + bytes;
        device.peak.fetch_max(now, Ordering::Relaxed);
        let Memory { raw, address, bytes, location, usage, allocation } = memory;
        device.name(raw, name);
        Ok(Self { raw, address, bytes, location, usage, allocation, device: device.clone() })
    }

    /// The memory as host bytes, where it is mapped.
    pub(super) fn mapped(&mut self) -> Option<&mut [u8]> {
        self.allocation.as_mut().and_then(|a| a.mapped_slice_mut())
    }
}

impl Drop for Allocated {
    fn drop(&mut self) {
        let Self { raw, address, bytes, location, usage, .. } = *self;
        let allocation = self.allocation.take();
        self.device.discard(Memory { raw, address, bytes, location, usage, allocation });
    }
}

/// A new buffer with memory of its own.
fn create(
    device: &Device,
    name: &str,
    bytes: u64,
    location: MemoryLocation,
    usage: vk::BufferUsageFlags,
) -> Result<Memory> {
    use vk::BufferUsageFlags as U;
    let mut all =
        U::TRANSFER_SRC | U::TRANSFER_DST | U::STORAGE_BUFFER | U::INDIRECT_BUFFER | U::SHADER_DEVICE_ADDRESS;
    if device.structures.is_some() {
        // Any may hold triangles for the driver's builder.
        all |= U::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR;
    }
    let info = vk::BufferCreateInfo::default().size(bytes).usage(all | usage);
    let full = || DeviceError::Memory {
        what: name.into(),
        needed: bytes.div_ceil(1 << 20),
        available: device.memory_free() >> 20,
        device: device.info.name.clone(),
    };
    let failed = |result| match result {
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => full(),
        result => DeviceError::Vulkan { call: name.into(), result },
    };
    // SAFETY: the device is alive; the info is complete.
    let make = || unsafe { device.raw.create_buffer(&info, None) };
    let raw = device.due.allocation().and_then(|()| make()).map_err(failed)?;
    let mut memory = Memory { raw, address: 0, bytes, location, usage, allocation: None };
    // SAFETY: `raw` was just made by this device.
    let requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
    let wanted = ga::AllocationCreateDesc {
        name,
        requirements,
        location,
        linear: true,
        allocation_scheme: ga::AllocationScheme::GpuAllocatorManaged,
    };
    let refused = |_| gpu_allocator::AllocationError::OutOfMemory;
    let allowed = device.take_budget(bytes).map_err(refused);
    let allocation = allowed.and_then(|()| lock(&device.allocator).allocate(&wanted));
    let allocation = match allocation {
        Ok(allocation) => allocation,
        Err(source) => {
            device.free(memory);
            return Err(match source {
                gpu_allocator::AllocationError::OutOfMemory => full(),
                source => DeviceError::Allocation { what: name.into(), bytes, source },
            });
        }
    };
    // SAFETY: memory of the buffer's own requirements, bound once.
    let bind = || unsafe { device.raw.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) };
    let bound = device.due.allocation().and_then(|()| bind());
    memory.allocation = Some(allocation);
    if let Err(result) = bound {
        device.free(memory);
        return Err(failed(result));
    }
    let info = vk::BufferDeviceAddressInfo::default().buffer(raw);
    // SAFETY: the buffer has memory and the address usage.
    memory.address = unsafe { device.raw.get_buffer_device_address(&info) };
    lock(&device.buffers).insert(memory.address, bytes);
    Ok(memory)
}

/// `len` elements of `T` in device memory.
pub struct Buffer<T> {
    pub(super) memory: Allocated,
    len: usize,
    element: PhantomData<T>,
}

impl<T: bytemuck::NoUninit> Buffer<T> {
    /// `len` elements, not cleared. `name` shows in errors: `"ploc.nodes"`.
    ///
    /// # Errors
    /// [`DeviceError::Memory`] where the device has not as much.
    pub fn new(device: &Arc<Device>, name: &str, len: usize) -> Result<Self> {
        let bytes = (len as u64).saturating_mul(size_of::<T>() as u64);
        let memory = Allocated::new(device, name, bytes, MemoryLocation::GpuOnly)?;
        Ok(Self { memory, len, element: PhantomData })
    }

    /// A buffer of `elements`.
    ///
    /// # Errors
    /// As [`Buffer::new`], or a failed copy.
    pub fn from_slice(device: &Arc<Device>, name: &str, elements: &[T]) -> Result<Self> {
        let buffer = Self::new(device, name, elements.len())?;
        buffer.write(elements)?;
        Ok(buffer)
    }

    /// Elements.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether it holds no element.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Bytes of device memory.
    pub fn bytes(&self) -> u64 {
        self.memory.bytes
    }

    /// For kernels that read it.
    pub fn ptr(&self) -> Ptr<T> {
        Ptr::new(self.memory.address)
    }

    /// For kernels that write it.
    pub fn ptr_mut(&self) -> PtrMut<T> {
        PtrMut::new(self.memory.address)
    }

    /// For kernels whose invocations hand values to each other through it.
    pub fn ptr_shared(&self) -> PtrShared<T> {
        PtrShared::new(self.memory.address)
    }

    /// Copies `elements` to the start, through host-visible memory: the buffer itself may not be.
    ///
    /// # Errors
    /// A failed copy; more elements than fit.
    pub fn write(&self, elements: &[T]) -> Result<()> {
        self.write_at(0, elements)
    }

    /// Likewise, from element `first` on.
    ///
    /// # Errors
    /// A failed copy; more elements than fit.
    pub fn write_at(&self, first: usize, elements: &[T]) -> Result<()> {
        let device = &self.memory.device;
        let bytes: &[u8] = bytemuck::cast_slice(elements);
        let from = (first as u64).saturating_mul(size_of::<T>() as u64);
        if from.saturating_add(bytes.len() as u64) > self.memory.bytes {
            let (wanted, limit) = ((first as u64).saturating_add(elements.len() as u64), self.len as u64);
            return Err(DeviceError::Limit { what: "elements to write".into(), wanted, limit });
        }
        if bytes.is_empty() {
            return Ok(());
        }
        let size = bytes.len().min(STAGING);
        let mut staging = Allocated::new(device, "staging.write", size as u64, MemoryLocation::CpuToGpu)?;
        for (i, chunk) in bytes.chunks(STAGING).enumerate() {
            let Some(mapped) = staging.mapped() else { return Err(unmapped("staging.write")) };
            mapped[..chunk.len()].copy_from_slice(chunk);
            let mut rec = Recorder::new(device, super::Timing::Off)?;
            rec.copy_bytes(&staging, 0, &self.memory, from + (i * STAGING) as u64, chunk.len() as u64);
            rec.submit()?;
        }
        Ok(())
    }
}

impl<T: bytemuck::Pod> Buffer<T> {
    /// All elements.
    ///
    /// # Errors
    /// A failed copy.
    pub fn read(&self) -> Result<Vec<T>> {
        self.read_first(self.len)
    }

    /// Element `index`.
    ///
    /// # Errors
    /// A failed copy; no such element.
    pub fn read_at(&self, index: usize) -> Result<T> {
        if index >= self.len {
            let (wanted, limit) = (index as u64, self.len as u64);
            return Err(DeviceError::Limit { what: "element to read".into(), wanted, limit });
        }
        let device = &self.memory.device;
        let size = size_of::<T>() as u64;
        let mut staging = Allocated::new(device, "staging.read", size, MemoryLocation::GpuToCpu)?;
        let mut rec = Recorder::new(device, super::Timing::Off)?;
        rec.copy_bytes(&self.memory, index as u64 * size, &staging, 0, size);
        rec.submit()?;
        let Some(mapped) = staging.mapped() else { return Err(unmapped("staging.read")) };
        Ok(bytemuck::pod_read_unaligned(&mapped[..size as usize]))
    }

    /// The first `count` elements.
    ///
    /// # Errors
    /// A failed copy; more elements than there are.
    pub fn read_first(&self, count: usize) -> Result<Vec<T>> {
        self.read_from(0, count)
    }

    /// `count` elements from `first` on.
    ///
    /// # Errors
    /// A failed copy; more elements than there are.
    pub fn read_from(&self, first: usize, count: usize) -> Result<Vec<T>> {
        let end = first.saturating_add(count);
        if end > self.len {
            let (wanted, limit) = (end as u64, self.len as u64);
            return Err(DeviceError::Limit { what: "elements to read".into(), wanted, limit });
        }
        let mut out = vec![T::zeroed(); count];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut out);
        if bytes.is_empty() {
            return Ok(out);
        }
        let device = &self.memory.device;
        let from = (first * size_of::<T>()) as u64;
        let size = bytes.len().min(STAGING);
        let mut staging = Allocated::new(device, "staging.read", size as u64, MemoryLocation::GpuToCpu)?;
        for (i, chunk) in bytes.chunks_mut(STAGING).enumerate() {
            let mut rec = Recorder::new(device, super::Timing::Off)?;
            rec.copy_bytes(&self.memory, from + (i * STAGING) as u64, &staging, 0, chunk.len() as u64);
            rec.submit()?;
            let Some(mapped) = staging.mapped() else { return Err(unmapped("staging.read")) };
            chunk.copy_from_slice(&mapped[..chunk.len()]);
        }
        Ok(out)
    }
}

fn unmapped(what: &str) -> DeviceError {
    DeviceError::Vulkan { call: what.into(), result: vk::Result::ERROR_MEMORY_MAP_FAILED }
}

impl<T> std::fmt::Debug for Buffer<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Buffer").field("len", &self.len).finish_non_exhaustive()
    }
}
