//! Measuring: warm-up, repeats, medians and spread; the benchmark, its presets, its rows and its report.

mod builds;
mod choice;
mod compare;
pub mod costs;
mod kernels;
mod layouts;
mod plan;
mod presets;
mod rays;
mod report;
mod rows;
mod run;
mod size;
mod stats;
mod table;
mod topology;
mod traces;
mod tree;
mod views;
mod volumes;

pub use builds::{Builds, measure_builds};
pub use choice::{Choice, Trial, choose_walk};
pub use compare::{Comparison, Quantity, Ratio, compare};
pub use costs::Costs;
pub use kernels::{KernelTime, by_kernel};
pub use layouts::{LayoutPlan, LayoutRow, LayoutSize, Layouts, measure_layouts};
pub use plan::{Contender, Coverage, Key, Maker, Plan, RayFile, RayKind, RaySet, Shard};
pub use presets::{Preset, PresetError, Presets};
pub use report::Report;
pub use rows::{BuildRow, Check, Header, Order, RayRow, Results, Rows, RowsError, Survey};
pub use run::{Open, Progress, run};
pub use size::bytes_of;
pub use stats::{Spread, settled};
pub use table::Table;
pub use topology::{Tried, try_recipes};
pub use traces::{Counting, Protocol, TestTotals, Traced, trace_all};
pub use views::Views;

use crate::bvh::BuildError;
use crate::device::DeviceError;
use crate::oracle::validate::Invalid;
use crate::scene::SceneError;

/// A measurement that can't be done.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The build failed.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A scene can't be opened.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A row can't be written.
    #[error(transparent)]
    Rows(#[from] RowsError),
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
