//! Measuring: warm-up, repeats, medians and spread; the default benchmark and its report.

mod builds;
mod kernels;
mod stats;
mod traces;

pub use builds::{Builds, measure_builds};
pub use kernels::{KernelTime, by_kernel};
pub use stats::{Spread, settled};
pub use traces::{Counting, Protocol, TestTotals, Traced, trace_all};

use crate::bvh::BuildError;
use crate::device::DeviceError;

/// A measurement that can't be done.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The build failed.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

/// Result of a measurement.
pub type Result<T> = std::result::Result<T, BenchError>;
