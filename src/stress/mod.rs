//! Scenes and rays that try to break builders and traversals, run on a device and judged by the f64 reference.
//!
//! [`CASES`] are the scenes, [`SETS`] the rays; [`run()`] goes through scenes × builders × precisions × queries × walks and
//! says what failed; [`smallest`] makes the least case of a failure and writes it down as files that `boxwood query`
//! takes. [`closed`] sends many rays from within closed meshes, of which none may get out.
//!
//! A case fails where a tree is not sound, where a robust hit is wrong that rounding doesn't excuse, where robust hits
//! differ between two trees or walks in any bit, where a record could be no answer at all, whatever the precision, and
//! where a ray of nonsense hits. A tree too deep for any stack is refused, which is no failure.

pub mod closed;
mod judge;
mod plan;
mod random;
mod rays;
mod results;
mod run;
mod scenes;
mod shapes;
pub mod smallest;

pub use judge::Total;
pub use plan::{Plan, Setting, chosen};
pub use rays::{NONSENSE, RaySet, SETS};
pub use results::{Failure, Kind, Outcome, Row, Summary};
pub use run::{Answer, Step, run, traced};
pub use scenes::{CASES, Case, Load};

/// How much is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// Small scenes, fewer walks: a minute's worth.
    Quick,
    /// All.
    Whole,
}

impl Effort {
    /// The one of two sizes.
    fn pick(self, quick: usize, whole: usize) -> usize {
        match self {
            Self::Quick => quick,
            Self::Whole => whole,
        }
    }

    /// Rays of a set, unless told otherwise.
    pub fn rays(self) -> usize {
        self.pick(60, 252)
    }
}

/// What scenes are hard for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// Shapes of triangles and how they lie to each other.
    Triangles,
    /// Where they are, and how large.
    Coordinates,
    /// Codes that order them.
    Morton,
    /// Trees as deep as can be.
    Depth,
}

impl Family {
    /// As tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Triangles => "triangles",
            Self::Coordinates => "coordinates",
            Self::Morton => "morton",
            Self::Depth => "depth",
        }
    }
}
