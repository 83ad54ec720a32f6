//! The names by which the library's choices are typed, and what help says of them.

use crate::bvh::{Directions, Fit, Generator, Method, Moment, Morton};
use clap::ValueEnum;
use clap::builder::PossibleValue;

/// A share in per cent: a number from 0.
pub(super) fn percent(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x >= 0.0 => Ok(x),
        _ => Err("give a number from 0, in per cent".into()),
    }
}

impl ValueEnum for Method {
    fn value_variants<'a>() -> &'a [Self] {
        Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name).help(self.what))
    }
}

impl ValueEnum for Fit {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(match self {
            Self::Aabb => "Axis-aligned",
            Self::Auto => "Of these what the scene needs, which rays take where they are faster",
            Self::Dito(_) => "Oriented where that costs less, by DiTO from so many extremal points",
            Self::Odop(_) => "Oriented where that costs less, in the best of D³ bases: see --bases",
            Self::Own(_) => "Likewise, of up to 16 bases that most of the scene's triangles share",
            Self::Hybrid => "Likewise, and by DiTO from 14 points where that costs less still",
        }))
    }
}

impl ValueEnum for Generator {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(match self {
            Self::Grid => "A grid of rotations, none among them",
            Self::Uniform => "Random ones in the same cube",
            Self::Sphere => "Quarter turns about random axes",
            Self::Zone => "None, and others spread evenly over all orientations of a box",
            Self::Dito(_) => "Those that pairs of the directions of this fit span: 30, 16, 90 and 16 at most",
        }))
    }
}

impl ValueEnum for Directions {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(match self {
            Self::Book => {
                "To the corners of an icosahedron or a dodecahedron, or a cube's faces, corners and edges"
            }
            Self::Grid | Self::Uniform | Self::Sphere | Self::Zone => {
                "Axes far apart of the eight bases that --bases has by this name"
            }
        }))
    }
}

impl ValueEnum for Moment {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(match self {
            Self::Before => "By the builder's boxes",
            Self::After => {
                "By those that DiTO fits to the binary tree: takes longer, and several times the memory"
            }
        }))
    }
}

impl ValueEnum for Morton {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(match self {
            Self::Auto => "30 bits, and 63 where too many triangles share a code",
            Self::Bits30 => "10 bits an axis",
            Self::Bits63 => "21 bits an axis",
            Self::Ext4 => "63 bits, every fourth of the triangle's size",
            Self::Ext7 => "63 bits, every seventh of the triangle's size",
        }))
    }
}
