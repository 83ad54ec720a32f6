//! What makes the binary tree, and the codes that it goes by.

use super::{Bases, Generator};
use crate::abi::{CODE_30, CODE_63, CODE_EXT4, CODE_EXT7};

/// What makes the binary tree. Everything after, leaves by cost included, is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Builder {
    /// Parallel locally-ordered clustering \[PLOC18\].
    #[default]
    Ploc,
    /// The radix tree over the Morton codes \[KARRAS12\]: faster, a worse tree.
    Lbvh,
    /// PLOC by the least box of a cluster in any of these bases instead of its axis-aligned one \[VEVERKOVA24\].
    Odop(Bases),
    /// Top-down splits by the surface area heuristic, on the CPU \[WALD07\]: slower, a better tree.
    Binned,
}

impl Builder {
    /// Every choice; of sets of bases one.
    pub const ALL: [Self; 4] =
        [Self::Ploc, Self::Lbvh, Self::Odop(Bases { generator: Generator::Grid, degree: 2 }), Self::Binned];

    /// As arguments and reports have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ploc => "ploc",
            Self::Lbvh => "lbvh",
            Self::Odop(bases) => {
                const NAMES: [&str; 8] =
                    ["odop1", "odop2", "odop3", "odop4", "odop5", "odop6", "odop7", "odop8"];
                NAMES[(bases.degree.clamp(1, 8) - 1) as usize]
            }
            Self::Binned => "sah",
        }
    }

    /// Its bases, where it has some.
    pub fn bases(self) -> Option<Bases> {
        match self {
            Self::Odop(bases) => Some(bases),
            Self::Ploc | Self::Lbvh | Self::Binned => None,
        }
    }

    /// The same with bases of another kind, where it has some.
    pub fn with_generator(self, generator: Generator) -> Self {
        match self {
            Self::Odop(bases) => Self::Odop(Bases { generator, ..bases }),
            other => other,
        }
    }

    /// Whether clusters look for neighbours within a radius.
    pub fn has_radius(self) -> bool {
        matches!(self, Self::Ploc | Self::Odop(_))
    }

    /// Whether it goes by Morton codes.
    pub fn wants_codes(self) -> bool {
        self != Self::Binned
    }
}

/// The Morton codes that order the triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Morton {
    /// 30 bits, and 63 where too many triangles share a code.
    #[default]
    Auto,
    /// 10 bits an axis: four sort passes.
    Bits30,
    /// 21 bits an axis: eight sort passes.
    Bits63,
    /// 63 bits, every fourth of the triangle's size: 16 an axis \[VINKLER17\].
    Ext4,
    /// 63 bits, every seventh of the triangle's size: 18 an axis \[VINKLER17\].
    Ext7,
}

impl Morton {
    /// Every choice.
    pub const ALL: [Self; 5] = [Self::Auto, Self::Bits30, Self::Bits63, Self::Ext4, Self::Ext7];

    /// As arguments and reports have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Bits30 => "30",
            Self::Bits63 => "63",
            Self::Ext4 => "ext4",
            Self::Ext7 => "ext7",
        }
    }

    /// The code to start with, as kernels know it.
    pub(super) fn code(self) -> u32 {
        match self {
            Self::Auto | Self::Bits30 => CODE_30,
            Self::Bits63 => CODE_63,
            Self::Ext4 => CODE_EXT4,
            Self::Ext7 => CODE_EXT7,
        }
    }
}
