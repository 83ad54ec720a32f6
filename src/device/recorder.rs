//! Records passes: each is bound, labelled, stamped, dispatched and followed by a barrier, all from its kernel's name.

mod submit;

use super::buffer::Allocated;
use super::error::Result;
use super::events::{Statistics, Traffic, Work};
use super::times::Timing;
use super::{Buffer, Device};
use crate::abi::{Args, GRID_WIDTH, PUSH_BYTES};
use crate::kernels::Kernel;
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::ffi::CString;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Passes that one recorder can stamp.
const STAMPS: u32 = 4096;

/// Commands being recorded. [`Recorder::submit`] runs them and waits.
pub struct Recorder {
    device: Arc<Device>,
    pool: vk::CommandPool,
    pub(super) commands: vk::CommandBuffer,
    fence: vk::Fence,
    queries: Option<vk::QueryPool>,
    statistics: Option<Statistics>,
    timing: Timing,
    passes: Vec<&'static str>,
    /// What each of `passes` does, where all is to be seen.
    seen: Vec<(Work, Traffic)>,
    /// Where the device notes the pass that it has finished: readable even after it is lost.
    finished: Allocated,
    overlapping: bool,
    started: Instant,
}

impl Recorder {
    /// A recorder with nothing in it.
    ///
    /// # Errors
    /// A failed Vulkan call.
    pub fn new(device: &Arc<Device>, timing: Timing) -> Result<Self> {
        let mut finished = Allocated::new(device, "recorder.finished", 16, MemoryLocation::GpuToCpu)?;
        if let Some(bytes) = finished.mapped() {
            bytes.fill(0);
        }
        device.recorders.fetch_add(1, Ordering::SeqCst);
        // Whole from here on, so that what fails below is cleaned up: nothing is destroyed where there is nothing yet.
        let mut recorder = Self {
            device: device.clone(),
            pool: vk::CommandPool::null(),
            commands: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            queries: None,
            statistics: None,
            timing,
            passes: vec![],
            seen: vec![],
            finished,
            overlapping: false,
            started: Instant::now(),
        };
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(device.info.queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the device is alive, the family is its queue's.
        let make = || unsafe { device.raw.create_command_pool(&info, None) };
        recorder.pool = device.taking("command pool", make)?;
        let info =
            vk::CommandBufferAllocateInfo::default().command_pool(recorder.pool).command_buffer_count(1);
        // SAFETY: the pool was just made.
        let make = || unsafe { device.raw.allocate_command_buffers(&info) };
        recorder.commands = device.taking("command buffer", make)?[0];
        // SAFETY: default info.
        let make = || unsafe { device.raw.create_fence(&vk::FenceCreateInfo::default(), None) };
        recorder.fence = device.taking("fence", make)?;
        if timing != Timing::Off && device.info.timestamp_period > 0.0 && device.info.timestamp_bits > 0 {
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(STAMPS + 1);
            // SAFETY: the queue's family has timestamps.
            let make = || unsafe { device.raw.create_query_pool(&info, None) };
            recorder.queries = Some(device.taking("query pool", make)?);
        }
        if timing == Timing::Statistics {
            recorder.statistics = Statistics::new(device, STAMPS)?;
        }
        let commands = recorder.commands;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: fresh command buffer.
        device.taking("vkBeginCommandBuffer", || unsafe {
            device.raw.begin_command_buffer(commands, &begin)
        })?;
        if let Some(queries) = recorder.queries {
            // SAFETY: recording; all queries of the pool.
            unsafe { device.raw.cmd_reset_query_pool(commands, queries, 0, STAMPS + 1) };
        }
        if let Some(statistics) = &recorder.statistics {
            statistics.reset(device, commands);
        }
        // What earlier submits wrote is visible to this one.
        recorder.barrier();
        recorder.stamp(0);
        Ok(recorder)
    }

    /// The device that it records for.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Stamps what follows pass `index`; nothing where there is no room.
    fn stamp(&mut self, index: usize) {
        if (index as u32) < STAMPS {
            self.write_stamp(index);
        }
    }

    fn write_stamp(&mut self, index: usize) {
        if let Some(queries) = self.queries {
            let stage = if index == 0 {
                vk::PipelineStageFlags::TOP_OF_PIPE
            } else {
                vk::PipelineStageFlags::BOTTOM_OF_PIPE
            };
            // SAFETY: recording; the query was reset at the start and is written once.
            unsafe { self.device.raw.cmd_write_timestamp(self.commands, stage, queries, index as u32) };
        }
    }

    /// All that was written becomes visible to all that follows.
    fn barrier(&mut self) {
        use vk::{AccessFlags as A, PipelineStageFlags as S};
        let barrier = [vk::MemoryBarrier::default()
            .src_access_mask(A::SHADER_WRITE | A::TRANSFER_WRITE)
            .dst_access_mask(
                A::SHADER_READ
                    | A::SHADER_WRITE
                    | A::TRANSFER_READ
                    | A::TRANSFER_WRITE
                    | A::INDIRECT_COMMAND_READ,
            )];
        let from = S::COMPUTE_SHADER | S::TRANSFER;
        let to = from | S::DRAW_INDIRECT;
        // SAFETY: recording, outside a render pass.
        unsafe {
            self.device.raw.cmd_pipeline_barrier(
                self.commands,
                from,
                to,
                vk::DependencyFlags::empty(),
                &barrier,
                &[],
                &[],
            );
        }
    }

    /// Ends a dispatch.
    fn after_dispatch(&mut self, name: &'static str) {
        if let Some(statistics) = &self.statistics {
            statistics.end(&self.device, self.commands, self.passes.len());
        }
        self.after_pass(name);
        self.unlabel();
    }

    /// Ends a pass that is the driver's own work, of which it alone knows what it moves.
    pub(super) fn after_drivers_pass(&mut self, name: &'static str) {
        if self.timing.sees_all() {
            self.seen.push((Work::Driver, Traffic::default()));
        }
        self.after_pass(name);
    }

    fn after_pass(&mut self, name: &'static str) {
        self.passes.push(name);
        let done = self.passes.len();
        if !self.overlapping {
            self.barrier();
            // SAFETY: recording; a word of a live buffer. Runs behind the barrier, so the pass has finished.
            unsafe { self.device.raw.cmd_fill_buffer(self.commands, self.finished.raw, 0, 4, done as u32) };
        }
        if self.timing.stamps_passes() {
            self.stamp(done);
        }
    }

    /// Makes what a transfer wrote visible; a pass of its own where all is to be seen.
    fn after_transfer(&mut self, name: &'static str, traffic: Traffic) {
        self.barrier();
        if self.timing.sees_all() {
            self.passes.push(name);
            self.seen.push((Work::Transfer, traffic));
            self.stamp(self.passes.len());
        }
    }

    /// Records a dispatch of `groups` workgroups. `constants` are (id, value), id 0 being the workgroup size.
    ///
    /// # Errors
    /// A failed Vulkan call.
    pub fn dispatch<A: Args>(
        &mut self,
        kernel: &Kernel<A>,
        constants: &[(u32, u32)],
        groups: u32,
        args: A,
    ) -> Result<()> {
        if groups == 0 {
            return Ok(());
        }
        let [x, y] = [groups.min(GRID_WIDTH), groups.div_ceil(GRID_WIDTH)];
        self.bind(kernel, constants, &args, Work::groups([x, y], constants))?;
        // SAFETY: a pipeline is bound with all it needs; each count is within Vulkan's least limit of 65535.
        unsafe { self.device.raw.cmd_dispatch(self.commands, x, y, 1) };
        self.after_dispatch(kernel.name);
        Ok(())
    }

    /// Records a dispatch whose three workgroup counts lie at byte `offset` of `counts`.
    ///
    /// # Errors
    /// A failed Vulkan call.
    pub fn dispatch_indirect<A: Args, T: bytemuck::NoUninit>(
        &mut self,
        kernel: &Kernel<A>,
        constants: &[(u32, u32)],
        counts: &Buffer<T>,
        offset: usize,
        args: A,
    ) -> Result<()> {
        self.bind(kernel, constants, &args, Work::indirect(constants))?;
        // SAFETY: a pipeline is bound with all it needs; the counts are the kernels' own, within limits.
        unsafe { self.device.raw.cmd_dispatch_indirect(self.commands, counts.memory.raw, offset as u64) };
        self.after_dispatch(kernel.name);
        Ok(())
    }

    /// Records passes that don't depend on each other: one barrier behind all of them. Say why at each use.
    ///
    /// # Errors
    /// As `passes`.
    pub fn overlap(&mut self, passes: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.overlapping = true;
        let result = passes(self);
        self.overlapping = false;
        self.barrier();
        result
    }

    fn bind<A: Args>(
        &mut self,
        kernel: &Kernel<A>,
        constants: &[(u32, u32)],
        args: &A,
        work: Work,
    ) -> Result<()> {
        let device = self.device.clone();
        let bytes = bytemuck::bytes_of(args);
        let pipeline = device.pipeline(kernel, constants)?;
        if let Some(labels) = device.labels() {
            let name = CString::new(kernel.name).unwrap_or_default();
            let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
            // SAFETY: recording; ended by `unlabel`.
            unsafe { labels.cmd_begin_debug_utils_label(self.commands, &label) };
        }
        // SAFETY: recording; the pipeline is alive.
        unsafe { device.raw.cmd_bind_pipeline(self.commands, vk::PipelineBindPoint::COMPUTE, pipeline.raw) };
        let mut push = [0u8; PUSH_BYTES];
        push[..bytes.len()].copy_from_slice(bytes);
        let stage = vk::ShaderStageFlags::COMPUTE;
        // SAFETY: recording; the layout's range is these bytes.
        unsafe { device.raw.cmd_push_constants(self.commands, pipeline.layout, stage, 0, &push) };
        if self.timing.sees_all() {
            self.seen.push((work, Traffic::of(&device, args)));
        }
        if let Some(statistics) = &self.statistics {
            statistics.begin(&device, self.commands, self.passes.len());
        }
        Ok(())
    }

    fn unlabel(&self) {
        if let Some(labels) = self.device.labels() {
            // SAFETY: recording; `bind` began one.
            unsafe { labels.cmd_end_debug_utils_label(self.commands) };
        }
    }

    /// Sets the first `words` words of `buffer` to `value`.
    pub fn fill<T: bytemuck::NoUninit>(&mut self, buffer: &Buffer<T>, words: usize, value: u32) {
        // SAFETY: recording; callers stay within the buffer, which is a multiple of 16 bytes.
        unsafe {
            self.device.raw.cmd_fill_buffer(self.commands, buffer.memory.raw, 0, 4 * words as u64, value);
        }
        self.after_transfer("fill", Traffic { read: 0, written: 4 * words as u64 });
    }

    /// Writes a few elements to the start of `buffer`: at most 64 KiB, from the command buffer itself.
    pub fn update<T: bytemuck::NoUninit>(&mut self, buffer: &Buffer<T>, elements: &[T]) {
        self.update_bytes(&buffer.memory, 0, bytemuck::cast_slice(elements));
    }

    pub(super) fn update_bytes(&mut self, to: &Allocated, at: u64, bytes: &[u8]) {
        // SAFETY: recording; multiples of 4 bytes, below 64 KiB, within the buffer.
        unsafe { self.device.raw.cmd_update_buffer(self.commands, to.raw, at, bytes) };
        self.after_transfer("update", Traffic { read: 0, written: bytes.len() as u64 });
    }

    /// Copies all of `from` to `to`, which is no shorter.
    pub fn copy<T: bytemuck::NoUninit>(&mut self, from: &Buffer<T>, to: &Buffer<T>) {
        self.copy_bytes(&from.memory, 0, &to.memory, 0, from.bytes());
    }

    pub(super) fn copy_bytes(
        &mut self,
        from: &Allocated,
        from_at: u64,
        to: &Allocated,
        to_at: u64,
        bytes: u64,
    ) {
        let region = [vk::BufferCopy::default().src_offset(from_at).dst_offset(to_at).size(bytes)];
        // SAFETY: recording; the ranges lie within both buffers and don't overlap.
        unsafe { self.device.raw.cmd_copy_buffer(self.commands, from.raw, to.raw, &region) };
        self.after_transfer("copy", Traffic { read: bytes, written: bytes });
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        let device = self.device.clone();
        if let Some(queries) = self.queries {
            // SAFETY: no submit that uses it is pending.
            unsafe { device.raw.destroy_query_pool(queries, None) };
        }
        if let Some(statistics) = &self.statistics {
            statistics.destroy(&device);
        }
        // SAFETY: no submit that uses it is pending.
        unsafe { device.raw.destroy_fence(self.fence, None) };
        // SAFETY: as above; frees the command buffer too.
        unsafe { device.raw.destroy_command_pool(self.pool, None) };
        if device.recorders.fetch_sub(1, Ordering::SeqCst) == 1 {
            device.bury();
        }
    }
}
