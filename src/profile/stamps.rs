//! What a stamp costs.

use crate::device::{Buffer, Device, Recorder, Result, Timing};
use std::sync::Arc;

/// Passes of a submit, each a fill of next to nothing.
const PASSES: usize = 64;
/// Submits with and without a stamp behind each; the least of either counts.
const ROUNDS: usize = 16;

/// Device time that a stamp behind a pass takes, ms: what `PASSES` of them add to a submit. Within a pass's own time, for
/// it lies between that stamp and the one before. A software driver ends a scene for it.
pub(super) fn stamp_ms(device: &Arc<Device>) -> Result<f64> {
    let words = Buffer::<u32>::new(device, "stamps.words", 4)?;
    let submit = |timing| {
        let mut rec = Recorder::new(device, timing)?;
        (0..PASSES).for_each(|_| rec.fill(&words, 4, 0));
        rec.submit().map(|times| times.device_ms)
    };
    let mut least = [f64::INFINITY; 2];
    for _ in 0..ROUNDS {
        for (least, timing) in least.iter_mut().zip([Timing::Outer, Timing::Passes]) {
            *least = least.min(submit(timing)?);
        }
    }
    Ok((least[1] - least[0]).max(0.0) / PASSES as f64)
}
