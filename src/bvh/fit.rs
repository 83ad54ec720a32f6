//! Which boxes nodes have.

use super::auto::POINTS;
use super::orientation::MOST;
use super::{Bases, Generator};

/// Which boxes nodes have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fit {
    /// Axis-aligned ones.
    #[default]
    Aabb,
    /// Oriented ones where they cost less, by DiTO \[LARSSON11\] from this many extremal points: 12, 14, 20 or 26.
    Dito(u32),
    /// Oriented ones where they cost less, in the best of these bases \[VEVERKOVA24\].
    Odop(Bases),
    /// Likewise, of at most so many bases, 1–16, that most of the scene's triangles share.
    Own(u32),
    /// The scene's own bases, at most 16, then DiTO from 14 points where that costs less still.
    Hybrid,
    /// Of these what the scene needs, see [`super::auto`]; and nodes are kept as they were as well, for rays that go faster
    /// through those: 64 bytes a node more.
    Auto,
}

/// Bases of the degree on a grid.
const fn odop(degree: u32) -> Fit {
    Fit::Odop(Bases { generator: Generator::Grid, degree })
}

impl Fit {
    /// Every choice, bases by the grid and as many as there are.
    pub const ALL: [Self; 16] = [
        Self::Aabb,
        Self::Dito(12),
        Self::Dito(14),
        Self::Dito(20),
        Self::Dito(26),
        odop(1),
        odop(2),
        odop(3),
        odop(4),
        odop(5),
        odop(6),
        odop(7),
        odop(8),
        Self::Own(MOST),
        Self::Hybrid,
        Self::Auto,
    ];

    /// As arguments and reports have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Aabb => "aabb",
            Self::Dito(12) => "dito12",
            Self::Dito(14) => "dito14",
            Self::Dito(20) => "dito20",
            Self::Dito(_) => "dito26",
            Self::Odop(bases) => bases.name(),
            Self::Own(_) => "own",
            Self::Hybrid => "hybrid",
            Self::Auto => "auto",
        }
    }

    /// Bases that every node tries, whatever the scene.
    pub fn bases(self) -> Option<Bases> {
        match self {
            Self::Odop(bases) => Some(bases),
            _ => None,
        }
    }

    /// Whether it depends on how the scene's triangles lie.
    pub fn asks_the_scene(self) -> bool {
        matches!(self, Self::Own(_) | Self::Hybrid | Self::Auto)
    }

    /// DiTO's extremal points, where there are some whatever the scene.
    pub(super) fn points(self) -> Option<u32> {
        match self {
            Self::Dito(points) => Some(points),
            Self::Hybrid => Some(POINTS),
            Self::Aabb | Self::Odop(_) | Self::Own(_) | Self::Auto => None,
        }
    }

    /// Whether some scene's boxes come from extremal points.
    pub fn has_points(self) -> bool {
        matches!(self, Self::Dito(_) | Self::Hybrid | Self::Auto)
    }

    /// The same with bases of another kind, where it has some of a degree.
    pub fn with_generator(self, generator: Generator) -> Self {
        match self {
            Self::Odop(bases) => Self::Odop(Bases { generator, ..bases }),
            other => other,
        }
    }

    pub(super) fn is_in_range(self) -> bool {
        match self {
            Self::Aabb | Self::Odop(_) | Self::Hybrid | Self::Auto => true,
            Self::Dito(points) => [12, 14, 20, 26].contains(&points),
            Self::Own(most) => (1..=MOST).contains(&most),
        }
    }
}
