//! What the benchmark does.

use crate::bvh::Recipe;
use crate::trace::BATCH;
use crate::trace::rays::{Light, Secondary};

/// Scenes of the default benchmark: a scanned one, long thin triangles, and a city off the axes.
pub const SCENES: [&str; 3] = ["dragon", "hairball:500k", "city-rotated:1M"];

/// A kind of ray set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RayKind {
    /// From the camera, a ray a pixel: nearest hit.
    Primary,
    /// Ambient occlusion, 32 a hit: any hit within reach.
    Ao,
    /// Diffuse, 32 a hit: nearest hit.
    Diffuse,
    /// From each hit to four lights above the scene, where it faces them: any hit.
    Shadow,
}

impl RayKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Primary, Self::Ao, Self::Diffuse, Self::Shadow];

    /// As typed and reported.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Ao => "ao",
            Self::Diffuse => "diffuse",
            Self::Shadow => "shadow",
        }
    }

    /// How its rays leave the primaries' hits in a scene within `bounds`; none for primaries.
    pub fn secondary(self, bounds: &crate::abi::Aabb) -> Option<Secondary> {
        match self {
            Self::Primary => None,
            Self::Ao => Some(Secondary::ao(bounds)),
            Self::Diffuse => Some(Secondary::diffuse()),
            Self::Shadow => Some(Secondary::shadow(Light::above(bounds))),
        }
    }
}

/// Which of a picture's secondary rays are traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Coverage {
    /// All, in batches that take about half a second at most.
    All,
    /// A sample: runs of neighbouring hits at evenly spaced places of the picture.
    Spans {
        /// Places.
        count: usize,
        /// Rays of each, at most.
        rays: usize,
    },
}

impl Coverage {
    /// 2^20 rays in eight places: about a second on two cores.
    pub const SAMPLE: Self = Self::Spans { count: 8, rays: BATCH / 8 };
    /// 2^16 rays in eight places.
    pub const QUICK: Self = Self::Spans { count: 8, rays: BATCH / 128 };
}

/// Whether hits are checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Checking {
    /// No.
    Off,
    /// Against the f64 reference, a sample of each set.
    Sample {
        /// Rays of each set, at most.
        rays: usize,
    },
}

impl Checking {
    /// Enough to see a fault of one ray in 100,000, and a few seconds.
    pub const DEFAULT: Self = Self::Sample { rays: 200_000 };
}

/// A benchmark.
#[derive(Debug, Clone)]
pub struct Plan {
    /// How trees are built.
    pub recipe: Recipe,
    /// Kinds of rays.
    pub kinds: Vec<RayKind>,
    /// Rounds that count: each builds and traces every scene once.
    pub runs: usize,
    /// Picture width and height, pixels.
    pub size: [u32; 2],
    /// Which secondary rays.
    pub coverage: Coverage,
    /// Whether hits are checked.
    pub checking: Checking,
}
