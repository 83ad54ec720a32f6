//! A copy to measure bandwidths by.

use crate::bench::Spread;
use crate::device::{Buffer, Device, Recorder, Result, Timing};
use std::sync::Arc;

/// Bytes copied on a GPU and on a software driver: more than caches hold.
const GPU_BYTES: u64 = 256 << 20;
const CPU_BYTES: u64 = 64 << 20;

/// A buffer's copy into another, by the driver.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Copied {
    /// Bytes read and written, both.
    pub bytes: u64,
    /// Device time between outer stamps, ms.
    pub ms: Spread,
    /// GB/s by the median.
    pub gb_s: f64,
}

impl Copied {
    /// Copies `runs` times after a warm-up, less than [`Copied::bytes`] is by default where memory is short.
    ///
    /// # Errors
    /// Not enough device memory, or a failed Vulkan call.
    pub fn measure(device: &Arc<Device>, runs: usize) -> Result<Self> {
        let wanted = if device.info().is_cpu() { CPU_BYTES } else { GPU_BYTES };
        let words = (wanted.min(device.memory_free() / 8) / 4) as usize;
        let [from, to] =
            [Buffer::<u32>::new(device, "copy.from", words)?, Buffer::new(device, "copy.to", words)?];
        // A software driver's memory that nobody has written is one page of zeros.
        let mut rec = Recorder::new(device, Timing::Off)?;
        rec.fill(&from, words, 1);
        rec.copy(&from, &to);
        rec.submit()?;
        let mut ms = vec![];
        for _ in 0..runs {
            let mut rec = Recorder::new(device, Timing::Outer)?;
            rec.copy(&from, &to);
            ms.push(rec.submit()?.device_ms);
        }
        let (bytes, ms) = (2 * from.bytes(), Spread::of(&ms));
        Ok(Self { bytes, ms, gb_s: gb_s(bytes, ms.median).unwrap_or(0.0) })
    }
}

/// GB/s, of 10⁹ bytes; none where no time was seen.
pub(super) fn gb_s(bytes: u64, ms: f64) -> Option<f64> {
    (ms > 0.0).then(|| bytes as f64 / ms * 1e-6)
}
