//! What is stamped, and the times that come of it.

use super::events::{HostWork, Submit};
use std::time::{Duration, Instant};

/// What to stamp. Stamps cost time themselves, so totals come from runs with outer stamps only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Timing {
    /// Nothing.
    Off,
    /// The first and the last pass.
    #[default]
    Outer,
    /// Every pass.
    Kernels,
    /// Every pass, transfers among them, and the whole beside: see [`Submit`].
    Passes,
    /// Likewise, and the device counts invocations, which may take it time.
    Statistics,
}

impl Timing {
    pub(super) fn stamps_passes(self) -> bool {
        matches!(self, Self::Kernels | Self::Passes | Self::Statistics)
    }

    pub(super) fn sees_all(self) -> bool {
        matches!(self, Self::Passes | Self::Statistics)
    }
}

/// How long a pass took.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    /// The kernel's name, or that of work on the host.
    pub name: &'static str,
    /// Device time, ms; wall time of work on the host.
    pub ms: f64,
}

/// How long a submit took.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Times {
    /// From the first pass to the end of the last, device time, ms; wall time where the device has no timestamps, and of
    /// passes on the host.
    pub device_ms: f64,
    /// The share of `device_ms` that passes on the host took.
    pub host_ms: f64,
    /// From submit to its fence, ms.
    pub wall_ms: f64,
    /// With [`Timing::Kernels`]: each pass in order; with [`Timing::Passes`] transfers too.
    pub passes: Vec<Pass>,
    /// With [`Timing::Passes`]: each submit in order.
    pub submits: Vec<Submit>,
    /// With [`Timing::Passes`]: each pass on the host in order.
    pub host: Vec<HostWork>,
}

impl Times {
    /// Those of a pass that just ran on the host in a kernel's stead, for `wall`.
    pub fn on_host(name: &'static str, wall: Duration, timing: Timing) -> Self {
        let ms = wall.as_secs_f64() * 1e3;
        let passes = if timing.stamps_passes() { vec![Pass { name, ms }] } else { vec![] };
        let at = Instant::now().checked_sub(wall).filter(|_| timing.sees_all());
        let host = at.map(|at| HostWork { name, at, ms }).into_iter().collect();
        Self { device_ms: ms, host_ms: ms, wall_ms: ms, passes, submits: vec![], host }
    }

    /// Adds the times of a submit that followed.
    pub fn append(&mut self, next: Times) {
        self.device_ms += next.device_ms;
        self.host_ms += next.host_ms;
        self.wall_ms += next.wall_ms;
        self.passes.extend(next.passes);
        self.submits.extend(next.submits);
        self.host.extend(next.host);
    }
}

/// Milliseconds between two timestamps of `bits` valid bits, which may have wrapped once; `period` is ns a tick.
pub(super) fn ticks_ms(from: u64, to: u64, bits: u32, period: f32) -> f64 {
    let mask = if bits >= 64 { u64::MAX } else { (1 << bits) - 1 };
    (to.wrapping_sub(from) & mask) as f64 * f64::from(period) * 1e-6
}

#[cfg(test)]
mod tests {
    use super::ticks_ms;

    #[test]
    fn timestamps_wrap() {
        assert_eq!(ticks_ms(10, 1_000_010, 64, 1.0), 1.0);
        assert_eq!(ticks_ms((1 << 36) - 5, 5, 36, 100.0), 10.0 * 100.0 * 1e-6);
        assert_eq!(ticks_ms(u64::MAX, 0, 64, 1.0), 1e-6);
    }
}
