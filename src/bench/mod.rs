//! Measuring: warm-up, repeats, medians and spread; the default benchmark and its report.

mod builds;
mod choice;
mod kernels;
mod plan;
mod report;
mod run;
mod stats;
mod traces;

pub use builds::{Builds, measure_builds};
pub use choice::{Choice, Trial, choose_walk};
pub use kernels::{KernelTime, by_kernel};
pub use plan::{Checking, Coverage, Plan, RayKind, SCENES};
pub use report::{Report, SceneReport, SetReport};
pub use run::{run, steps};
pub use stats::{Spread, settled};
pub use traces::{Counting, Protocol, TestTotals, Traced, trace_all};

use crate::bvh::BuildError;
use crate::device::DeviceError;
use crate::oracle::validate::Invalid;

/// A measurement that can't be done.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The build failed.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The build gave a tree that is not sound.
    #[error("the tree of {scene} is not sound: {source}")]
    Tree {
        /// Of which scene.
        scene: String,
        /// What is wrong with it.
        source: Invalid,
    },
}

/// Result of a measurement.
pub type Result<T> = std::result::Result<T, BenchError>;
