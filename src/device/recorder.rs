//! Records passes: each is bound, labelled, stamped, dispatched and followed by a barrier, all from its kernel's name.

use super::buffer::Allocated;
use super::error::{Context, DeviceError, Result};
use super::events::{Event, Statistics, Submit, Traffic, Work, milliseconds, placed};
use super::times::{Pass, Times, Timing, ticks_ms};
use super::{Buffer, Device, lock};
use crate::abi::{Args, GRID_WIDTH, PUSH_BYTES};
use crate::kernels::Kernel;
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::ffi::CString;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

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
        if let Some(labels) = &device.labels {
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
        if let Some(labels) = &self.device.labels {
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

    /// Runs what was recorded and waits for it.
    ///
    /// # Errors
    /// [`DeviceError::Lost`] with the last pass that finished, or a failed Vulkan call.
    pub fn submit(mut self) -> Result<Times> {
        let device = self.device.clone();
        let count = self.passes.len();
        match self.timing {
            Timing::Off | Timing::Outer => self.stamp(1),
            Timing::Kernels => {}
            Timing::Passes | Timing::Statistics => self.write_stamp(STAMPS as usize),
        }
        let host = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ)];
        // SAFETY: recording; makes copies visible to the host.
        unsafe {
            device.raw.cmd_pipeline_barrier(
                self.commands,
                vk::PipelineStageFlags::TRANSFER,
                vk::PipelineStageFlags::HOST,
                vk::DependencyFlags::empty(),
                &host,
                &[],
                &[],
            );
        }
        // SAFETY: recording is complete.
        device.taking("vkEndCommandBuffer", || unsafe { device.raw.end_command_buffer(self.commands) })?;
        let commands = [self.commands];
        let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
        if device.lost.load(Ordering::SeqCst) {
            return Err(self.lost());
        }
        self.started = Instant::now();
        let waited = self.run(&submit);
        let wall = self.started.elapsed();
        match waited {
            Ok(()) => self.times(wall),
            Err(vk::Result::ERROR_DEVICE_LOST) => {
                let lost = self.lost();
                device.lost.store(true, Ordering::SeqCst);
                Err(lost)
            }
            Err(result) => {
                let queue = lock(&device.queue);
                // SAFETY: the queue is locked. What may still run must not lose what it uses.
                let _ = unsafe { device.raw.queue_wait_idle(*queue) };
                drop(queue);
                match result {
                    vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => Err(device.full(&self.pass_name(count))),
                    result => Err(DeviceError::Vulkan { call: self.pass_name(count), result }),
                }
            }
        }
    }

    /// Hands the commands to the device and waits for them.
    fn run(&self, submit: &[vk::SubmitInfo]) -> std::result::Result<(), vk::Result> {
        let device = &self.device;
        let number = device.due.submit()?;
        device.due.allocation()?;
        let queue = lock(&device.queue);
        // SAFETY: the queue is locked; everything referenced lives until the fence is waited for below.
        unsafe { device.raw.queue_submit(*queue, submit, self.fence) }?;
        drop(queue);
        // SAFETY: the fence was given to the submit.
        unsafe { device.raw.wait_for_fences(&[self.fence], true, u64::MAX) }?;
        device.due.fence(number)
    }

    fn pass_name(&self, done: usize) -> String {
        self.passes.get(done).or(self.passes.last()).map_or("copy".into(), |p| (*p).to_owned())
    }

    /// Where the loss of the device was noticed.
    fn lost(&mut self) -> DeviceError {
        let word = self.finished.mapped().map_or(0, |b| u32::from_ne_bytes([b[0], b[1], b[2], b[3]]));
        let done = word as usize;
        let finished = if self.device.lost.load(Ordering::SeqCst) {
            "none: it was lost before".into()
        } else {
            last_finished(&self.passes, done)
        };
        DeviceError::Lost { pass: self.pass_name(done), finished }
    }

    fn times(&self, wall: Duration) -> Result<Times> {
        let wall_ms = wall.as_secs_f64() * 1e3;
        let Some(queries) = self.queries else {
            return Ok(Times { device_ms: wall_ms, wall_ms, ..Times::default() });
        };
        let passes = if self.timing.stamps_passes() { self.passes.len() } else { 1 };
        let ticks = self.ticks(queries, 0, (passes + 1).min(STAMPS as usize))?;
        let ms = |from, to| self.ms(from, to);
        let mut times =
            Times { device_ms: ms(ticks[0], ticks[ticks.len() - 1]), wall_ms, ..Times::default() };
        if self.timing.stamps_passes() {
            let pairs = ticks.windows(2).zip(&self.passes);
            times.passes = pairs.map(|(t, name)| Pass { name, ms: ms(t[0], t[1]) }).collect();
        }
        if self.timing.sees_all() {
            times.device_ms = ms(ticks[0], self.ticks(queries, STAMPS, 1)?[0]);
            times.submits = vec![self.seen(wall_ms, times.device_ms, &ticks)?];
        }
        Ok(times)
    }

    /// Stamps of the submit that has finished.
    fn ticks(&self, queries: vk::QueryPool, first: u32, count: usize) -> Result<Vec<u64>> {
        let mut ticks = vec![0u64; count];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: these queries were written by the submit that has finished.
        unsafe { self.device.raw.get_query_pool_results(queries, first, &mut ticks, flags) }
            .context("timestamps")?;
        Ok(ticks)
    }

    fn ms(&self, from: u64, to: u64) -> f64 {
        ticks_ms(from, to, self.device.info.timestamp_bits, self.device.info.timestamp_period)
    }

    /// What the submit did, by its stamps.
    fn seen(&self, wall_ms: f64, device_ms: f64, ticks: &[u64]) -> Result<Submit> {
        let at = self.started;
        let since = |now| self.ms(ticks[0], now);
        let (device_at, unsure_ms) = placed(&self.device, at, [wall_ms, device_ms], since);
        let mut events = vec![];
        for (i, t) in ticks.windows(2).enumerate() {
            let (work, traffic) = self.seen[i];
            let invocations = match &self.statistics {
                Some(statistics) if work.is_dispatch() => statistics.read(&self.device, i)?,
                _ => None,
            };
            events.push(Event {
                name: self.passes[i],
                at: device_at + milliseconds(self.ms(ticks[0], t[0])),
                ms: self.ms(t[0], t[1]),
                work,
                traffic,
                invocations,
            });
        }
        Ok(Submit { at, wall_ms, device_at, device_ms, unsure_ms, events })
    }
}

/// The last of `passes` that finished, where the first `done` did.
fn last_finished(passes: &[&'static str], done: usize) -> String {
    match done.min(passes.len()) {
        0 => "none of this submit".into(),
        n => format!("{}, pass {n} of {}", passes[n - 1], passes.len()),
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

#[cfg(test)]
mod tests {
    use super::last_finished;

    #[test]
    fn the_last_pass_that_finished_is_named() {
        let passes = ["morton/bounds", "morton/encode", "sort/count"];
        assert_eq!(last_finished(&passes, 0), "none of this submit");
        assert_eq!(last_finished(&passes, 2), "morton/encode, pass 2 of 3");
        assert_eq!(last_finished(&passes, 3), "sort/count, pass 3 of 3");
        // A word that the device never wrote whole, and a submit of copies only.
        assert_eq!(last_finished(&passes, 9), "sort/count, pass 3 of 3");
        assert_eq!(last_finished(&[], 1), "none of this submit");
    }
}
