//! Runs what was recorded, and reads its stamps.

use super::super::error::{Context, DeviceError, Result};
use super::super::events::{Event, Submit, milliseconds, placed};
use super::super::lock;
use super::super::times::{Pass, Times, Timing, ticks_ms};
use super::{Recorder, STAMPS};
use ash::vk;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

impl Recorder {
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
