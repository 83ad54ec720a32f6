//! The report: one HTML file of the rows of a run or of several, that needs no network, no script and no other file. It
//! knows rows alone, and no device.

mod answer;
mod errors;
mod page;
mod plots;
mod printed;

pub use answer::{Against, Answer, Step, answers};
pub use page::html;

/// A report that can't be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A plot fails.
    #[error("can't draw {plot}: {why}")]
    Plot {
        /// Which one.
        plot: String,
        /// Why not.
        why: String,
    },
    /// The page fails.
    #[error("can't fill in the page: {0}")]
    Page(#[from] minijinja::Error),
}

type Result<T> = std::result::Result<T, ReportError>;
