//! A device's memory: what is in use, what lies spare, what is free.

use super::{Device, DeviceError, Result, buffer, lock, select};
use ash::vk;
use std::sync::atomic::Ordering;

impl Device {
    /// Takes a buffer that is no longer needed; spare as soon as no recorder can refer to it.
    pub(super) fn discard(&self, memory: buffer::Memory) {
        lock(&self.dropped).push(memory);
        if self.recorders.load(Ordering::SeqCst) == 0 {
            self.bury();
        }
    }

    /// Makes dropped buffers spare. Only where no recorder is left.
    pub(super) fn bury(&self) {
        self.bury_structures();
        let dropped: Vec<_> = lock(&self.dropped).drain(..).collect();
        self.in_use.fetch_sub(dropped.iter().map(|m| m.bytes).sum(), Ordering::Relaxed);
        let mut spare = lock(&self.spare);
        spare.extend(dropped);
        // The oldest go first.
        let mut excess = spare.iter().map(|m| m.bytes).sum::<u64>().saturating_sub(self.info.memory / 8);
        while excess > 0 && !spare.is_empty() {
            let oldest = spare.remove(0);
            excess = excess.saturating_sub(oldest.bytes);
            self.free(oldest);
        }
    }

    /// A spare buffer of just this size, kind of memory and usage.
    pub(super) fn take_spare(
        &self,
        bytes: u64,
        location: gpu_allocator::MemoryLocation,
        usage: vk::BufferUsageFlags,
    ) -> Option<buffer::Memory> {
        let mut spare = lock(&self.spare);
        let at = spare.iter().rposition(|m| (m.bytes, m.location, m.usage) == (bytes, location, usage))?;
        Some(spare.remove(at))
    }

    /// Gives all spare buffers back to the driver.
    pub(super) fn free_spare(&self) {
        let spare: Vec<_> = lock(&self.spare).drain(..).collect();
        spare.into_iter().for_each(|m| self.free(m));
    }

    pub(super) fn free(&self, memory: buffer::Memory) {
        lock(&self.buffers).remove(&memory.address);
        if let Some(allocation) = memory.allocation {
            // The allocator only refuses what it did not allocate.
            let _ = lock(&self.allocator).free(allocation);
        }
        // SAFETY: no recorder refers to it and no submit is pending; destroyed once.
        unsafe { self.raw.destroy_buffer(memory.raw, None) };
    }

    /// Memory of all live buffers, bytes.
    pub fn memory_in_use(&self) -> u64 {
        self.in_use.load(Ordering::Relaxed)
    }

    /// Starts watching for the most memory in use; returns what is in use now, bytes.
    pub fn track_memory(&self) -> u64 {
        let now = self.memory_in_use();
        self.peak.store(now, Ordering::Relaxed);
        now
    }

    /// The most memory in use since [`Device::track_memory`], bytes.
    pub fn peak_memory(&self) -> u64 {
        self.peak.load(Ordering::Relaxed)
    }

    /// Device-local memory free for this process, bytes: the driver's budget, else the whole heap.
    pub fn memory_free(&self) -> u64 {
        let driver = select::inspect(&self.instance.raw, self.physical, self.info.index);
        let spare: u64 = lock(&self.spare).iter().map(|m| m.bytes).sum();
        self.within_budget(driver.memory_free.unwrap_or(self.info.memory)) + spare
    }

    /// Refuses work that the device's memory can't hold.
    ///
    /// # Errors
    /// [`DeviceError::Memory`], with what was needed and what there is.
    pub fn require_memory(&self, what: &str, bytes: u64) -> Result<()> {
        let free = self.memory_free();
        if bytes <= free {
            return Ok(());
        }
        Err(DeviceError::Memory {
            what: what.into(),
            needed: bytes >> 20,
            available: free >> 20,
            device: self.info.name.clone(),
        })
    }
}
