//! Arguments that several subcommands share, and what they mean to the library.

use crate::bench::bytes_of;
use crate::bvh::{Collapse, Fit, Generator, Method, Morton, Recipe};
use crate::scene::Transform;
use crate::trace::{Precision, RayOrder};
use clap::ValueEnum;
use clap::builder::PossibleValue;
use std::path::PathBuf;

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
            Self::Dito(_) => "Oriented where that costs less, by DiTO from so many extremal points",
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

impl ValueEnum for Generator {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(match self {
            Self::Grid => "On a grid, the scene's axes among them",
            Self::Uniform => "Random",
            Self::Sphere => "Random, a quarter turn each",
            Self::Zone => "The scene's axes, and others spread evenly over all that boxes can have",
        }))
    }
}

/// Which triangle test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum PrecisionName {
    /// Watertight, with exact signs.
    Robust,
    /// Möller–Trumbore: leaks at edges and vertices.
    Fast,
}

impl PrecisionName {
    /// As typed.
    pub(super) fn name(self) -> &'static str {
        match self {
            PrecisionName::Robust => "robust",
            PrecisionName::Fast => "fast",
        }
    }
}

impl From<PrecisionName> for Precision {
    fn from(name: PrecisionName) -> Self {
        match name {
            PrecisionName::Robust => Self::Robust,
            PrecisionName::Fast => Self::Fast,
        }
    }
}

/// Whether rays are sorted on the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum SortName {
    /// Where a sample is faster so, the sort included.
    Auto,
    /// Always.
    On,
    /// Never.
    Off,
}

impl SortName {
    /// The orders to try; of rays that go much the same way as they come, only that one.
    pub(super) fn orders(self, coherent: bool) -> &'static [RayOrder] {
        match self {
            Self::On => &[RayOrder::Sorted],
            Self::Auto if !coherent => &RayOrder::ALL,
            Self::Auto | Self::Off => &[RayOrder::AsGiven],
        }
    }
}

/// A scene, and what to do to it.
#[derive(Debug, clap::Args)]
pub(super) struct SceneArgs {
    /// A mesh file or a name, such as dragon or hairball:500k: see `boxwood scenes list`.
    #[arg(value_name = "SCENE")]
    pub(super) spec: String,
    #[command(flatten)]
    pub(super) transform: TransformArgs,
}

/// What to do to scenes.
#[derive(Debug, clap::Args)]
pub(super) struct TransformArgs {
    /// Turn scenes about x, then y, then z, degrees, about the origin of their coordinates; their views turn with them.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    rotate: Option<Triple>,
    /// Scale scenes by S, after rotating; powers of two change no digit.
    #[arg(long, value_name = "S", value_parser = scale, allow_hyphen_values = true)]
    scale: Option<f64>,
    /// Move scenes along x, y and z, scene units, after scaling.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    translate: Option<Triple>,
}

/// Three numbers, as clap keeps them: an array of its own would be three arguments.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Triple([f64; 3]);

impl TransformArgs {
    /// The same for the library.
    pub(super) fn transform(&self) -> Transform {
        let none = Transform::default();
        Transform {
            rotate: self.rotate.map_or(none.rotate, |t| t.0),
            scale: self.scale.unwrap_or(none.scale),
            translate: self.translate.map_or(none.translate, |t| t.0),
        }
    }
}

fn finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

fn triple(text: &str) -> Result<Triple, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(finite).collect();
    let triple = numbers.and_then(|n| <[f64; 3]>::try_from(n).ok());
    triple.map(Triple).ok_or_else(|| "write three numbers as X,Y,Z, such as 45,0,-30".to_owned())
}

fn scale(text: &str) -> Result<f64, String> {
    finite(text).filter(|s| *s > 0.0).ok_or_else(|| "write a number above 0, such as 0.001".to_owned())
}

/// How to build.
#[derive(Debug, clap::Args)]
pub(super) struct RecipeArgs {
    /// Builder.
    #[arg(long, value_enum, default_value_t = Method::ALL[0])]
    builder: Method,
    /// PLOC's search radius, clusters to either side: 1–128.
    #[arg(long, value_name = "N", default_value_t = Recipe::default().radius, value_parser = clap::value_parser!(u32).range(1..=128))]
    radius: u32,
    /// Morton codes.
    #[arg(long, value_enum, default_value_t = Recipe::default().morton)]
    morton: Morton,
    /// Bases of odop2 to odop8.
    #[arg(long, value_enum)]
    bases: Option<Generator>,
    /// Device memory that odop's boxes may take, such as 8GiB; with less than they want it takes longer, for the same
    /// tree.
    #[arg(long, value_name = "SIZE", default_value = "4GiB", value_parser = memory)]
    memory: u64,
    /// Boxes of nodes, instead of the builder's own.
    #[arg(long, value_enum)]
    fit: Option<Fit>,
    /// Cost of visiting an oriented node, beside --node-cost: oriented boxes stay where they cost less.
    #[arg(long, value_name = "cO", default_value_t = Recipe::default().oriented_cost, value_parser = cost)]
    oriented_cost: f32,
    /// Triangles that a leaf may hold: 1–64.
    #[arg(long, value_name = "N", default_value_t = Recipe::default().collapse.max_leaf, value_parser = clap::value_parser!(u32).range(1..=64))]
    max_leaf: u32,
    /// Costs of a box-pair test, for the SAH cost that is reported, and of a triangle test.
    #[arg(long, value_name = "cT,cI", default_value = "3,2", value_parser = costs)]
    costs: (f32, f32),
    /// Cost of visiting a packed node, whatever its number of children, in the units of --costs: larger ones make fewer
    /// nodes.
    #[arg(long, value_name = "cN", default_value_t = Recipe::default().collapse.node_cost, value_parser = cost)]
    node_cost: f32,
}

impl RecipeArgs {
    /// The same for the library.
    pub(super) fn recipe(&self) -> Recipe {
        let (traversal_cost, triangle_cost) = self.costs;
        let Self { builder, morton, radius, fit, oriented_cost, node_cost, max_leaf, memory, .. } = *self;
        let collapse = Collapse { traversal_cost, node_cost, triangle_cost, max_leaf };
        let fit = fit.unwrap_or(builder.fit);
        let tree = self.bases.map_or(builder.builder, |bases| builder.builder.with_generator(bases));
        Recipe { builder: tree, morton, radius, collapse, fit, oriented_cost, memory }
    }
}

/// An amount of memory.
fn memory(text: &str) -> Result<u64, String> {
    bytes_of(text).ok_or_else(|| "write a size with its unit, such as 8GiB or 512MiB".into())
}

/// A number above 0.
fn cost(text: &str) -> Result<f32, String> {
    let number = text.trim().parse().ok().filter(|x: &f32| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "write a number above 0, such as 4".into())
}

/// Two numbers above 0, with a comma between them.
fn costs(text: &str) -> Result<(f32, f32), String> {
    let pair = text.split_once(',').and_then(|(a, b)| Some((cost(a).ok()?, cost(b).ok()?)));
    pair.ok_or_else(|| "write two numbers above 0, such as 3,2".into())
}

/// What to measure, and what to say of it.
#[derive(Debug, clap::Args)]
pub(super) struct ReportArgs {
    /// Measured runs, after a warm-up; medians and the least are reported.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(super) runs: u32,
    /// Write the JSON to this file as well.
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Check the tree, and the hits where there are any; exit with 1 where anything is wrong with them (with
    /// `--precision fast`, report only).
    #[arg(long)]
    pub(super) check: bool,
    /// Say what was done and what was skipped.
    #[arg(long)]
    pub(super) explain: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_are_two_positive_numbers() {
        assert_eq!(costs("3,2"), Ok((3.0, 2.0)));
        assert_eq!(costs(" 1.5, 1 "), Ok((1.5, 1.0)));
        for bad in ["", "3", "3,", "0,1", "3,-2", "inf,1", "nan,1", "1,2,3"] {
            assert!(costs(bad).is_err(), "{bad}");
        }
        assert_eq!(cost(" 0.5"), Ok(0.5));
        for bad in ["", "0", "-1", "inf", "nan", "4,"] {
            assert!(cost(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn defaults_are_the_librarys() {
        use clap::Parser;
        #[derive(Parser)]
        struct Only {
            #[command(flatten)]
            recipe: RecipeArgs,
        }
        assert_eq!(Only::parse_from(["x"]).recipe.recipe(), Recipe::default());
    }
}
