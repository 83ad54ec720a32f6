//! Measuring: warm-up, repeats, medians and spread; the benchmark, its presets, its rows and its report.
//!
//! # How to read the numbers
//! - **Times** are medians over runs in which all builders took turns, after warm-ups that end once three runs agree within
//!   5 %. *±* is the range between the quartiles, in per cent of the median: differences within it say nothing. Device times
//!   come from the driver's timestamps, from the first pass of a build or a trace to the end of the last; what a host does
//!   for a builder counts as well. Times by kernel are those of one run with a stamp a pass, which costs some.
//! - **Rates** are rays over the time of all of a set's rays, the sort included where rays were sorted. Before they are
//!   measured each builder's rays try all kernels, orders and boxes, and take what is fastest for them.
//! - **Counts**: tests of boxes, of oriented ones and of triangles are those of each ray walking alone, whichever kernel is
//!   timed; *cost* is their sum weighed by what one of each takes on this device ([`Costs`]). Counts, bytes, areas and hashes
//!   are the same on every machine; times are not, and no gate hangs on them.
//! - **SAH cost, EPO, LCV**: what heuristics expect of a tree, in the glossary of the [crate]. *Above optimal*: area of
//!   a sample of boxes over that of near-optimal ones around the same triangles, less 1.
//! - **Faults** are hits that the f64 reference contradicts and rounding does not excuse, **unsure** ones those that it may:
//!   where copies of the ray, moved by an ulp or so, disagree among themselves. Tables of errors count both.
//! - **Error of t** is relative to t, over hits on the reference's own triangle. **RMSE** is that of pixels from 0 to 1
//!   against a picture of many more samples.
//! - **Peak scratch** is the most memory that a build held at once beside the scene and the tree.

mod builds;
mod choice;
mod compare;
pub mod costs;
mod errors;
mod images;
mod kernels;
mod layouts;
mod pictures;
mod plan;
mod presets;
mod rays;
mod report;
mod results;
mod row;
mod rows;
mod run;
mod shards;
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
pub use images::ImageRow;
pub use kernels::{KernelTime, by_kernel};
pub use layouts::{LayoutPlan, LayoutRow, LayoutSize, Layouts, measure_layouts};
pub use pictures::PictureRow;
pub use plan::{Contender, Coverage, ImagePlan, Key, Maker, Plan, RayFile, RayKind, RaySet, Shard};
pub use presets::{Preset, PresetError, Presets};
pub use report::Report;
pub use results::{Results, RowsError};
pub use row::{BuildRow, Check, Header, Order, RayRow, Survey};
pub use rows::Rows;
pub use run::{Open, Progress, Unmeasured, run};
pub use size::bytes_of;
pub use stats::{Spread, settled};
pub use table::Table;
pub use topology::{Tried, try_recipes};
pub use traces::{Counting, Protocol, TestTotals, Traced, trace_all};
pub use views::Views;

use crate::bvh::BuildError;
use crate::device::DeviceError;
use crate::oracle::validate::Invalid;
use crate::picture::PictureError;
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
    /// A picture can't be taken.
    #[error(transparent)]
    Picture(#[from] PictureError),
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

impl BenchError {
    /// Whether other scenes may well be measured still: this one can't be had, or is too large.
    pub fn is_of_one_scene(&self) -> bool {
        use SceneError as S;
        let too_large = |e: &DeviceError| {
            matches!(e, DeviceError::Memory { .. } | DeviceError::Full { .. } | DeviceError::Limit { .. })
        };
        match self {
            Self::Device(e) | Self::Build(BuildError::Device(e)) | Self::Picture(PictureError::Device(e)) => {
                too_large(e)
            }
            Self::Build(e) => {
                matches!(e, BuildError::TooMany { .. } | BuildError::Bases { .. } | BuildError::TooFar { .. })
            }
            // What was typed wrong is said before hours of work.
            Self::Scene(e) => !matches!(e, S::UnknownName { .. } | S::BadSize { .. } | S::Transform { .. }),
            Self::Picture(_) | Self::Rows(_) | Self::Tree { .. } => false,
        }
    }
}

/// Result of a measurement.
pub type Result<T> = std::result::Result<T, BenchError>;
