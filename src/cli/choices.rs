//! Arguments that several subcommands share, and what they mean to the library.

use super::Global;
use crate::bench::{Costs, bytes_of};
use crate::bvh::{Collapse, Directions, Fit, Generator, Method, Moment, Morton, Recipe};
use crate::device::Device;
use crate::scene::Transform;
use crate::trace::{Precision, RayOrder};
use anyhow::{Result, bail};
use clap::ValueEnum;
use std::path::PathBuf;
use std::sync::Arc;

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

fn triple(text: &str) -> std::result::Result<Triple, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(finite).collect();
    let triple = numbers.and_then(|n| <[f64; 3]>::try_from(n).ok());
    triple.map(Triple).ok_or_else(|| "write three numbers as X,Y,Z, such as 45,0,-30".to_owned())
}

fn scale(text: &str) -> std::result::Result<f64, String> {
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
    /// Device memory that odop may hold beside the scene, such as 8GiB; with less than it wants it takes longer, for the same
    /// tree.
    #[arg(long, value_name = "SIZE", default_value = "4GiB", value_parser = memory)]
    memory: u64,
    /// Boxes of nodes, instead of the builder's own.
    #[arg(long, value_enum)]
    fit: Option<Fit>,
    /// Of hybrid: nodes of more triangles than N are fitted to bases only, the others by DiTO only. Default: all by both.
    #[arg(long, value_name = "N")]
    threshold: Option<u32>,
    /// Where the bases of odop1 to odop8 come from, those of the builder and of the boxes. Default: grid.
    #[arg(long, value_enum)]
    bases: Option<Generator>,
    /// Directions in which DiTO looks for extremal points.
    #[arg(long, value_enum, default_value_t = Recipe::default().directions)]
    directions: Directions,
    /// Cost of visiting an oriented node, beside --node-cost: oriented boxes stay where they cost less. Default: 6; that of
    /// --costs measured.
    #[arg(long, value_name = "cO", value_parser = cost)]
    oriented_cost: Option<f32>,
    /// Evaluations of a local search for a smaller box after each fit by DiTO: 0–1024.
    #[arg(long, value_name = "N", default_value_t = Recipe::default().local_search, value_parser = clap::value_parser!(u32).range(0..=1024))]
    local_search: u32,
    /// Whether leaves and nodes of four are chosen before or after boxes are fitted.
    #[arg(long, value_enum, value_name = "MOMENT", default_value_t = Recipe::default().collapsed)]
    collapse: Moment,
    /// Triangles that a leaf may hold: 1–64.
    #[arg(long, value_name = "N", default_value_t = Recipe::default().collapse.max_leaf, value_parser = clap::value_parser!(u32).range(1..=64))]
    max_leaf: u32,
    /// Costs of a box-pair test, for the SAH cost that is reported, and of a triangle test: two numbers; book: 3,2; measured:
    /// what tests take on this device, ns, and a node's visits likewise.
    #[arg(long, value_name = "book|measured|cT,cI", default_value = "book", value_parser = costs)]
    costs: CostsName,
    /// Cost of visiting a packed node, whatever its number of children, in the units of --costs: larger ones make fewer
    /// nodes. Default: 5; that of --costs measured.
    #[arg(long, value_name = "cN", value_parser = cost)]
    node_cost: Option<f32>,
}

impl RecipeArgs {
    /// The same for the library, on `device`: measures what tests cost there, where that is asked for.
    pub(super) fn recipe(&self, global: &Global, device: &Arc<Device>) -> Result<Recipe> {
        let book = Recipe::default();
        let priced = match self.costs {
            CostsName::Book => book,
            CostsName::Measured => Costs::measured(device, global.cache().as_deref())?.price(book),
            CostsName::Pair(traversal_cost, triangle_cost) => {
                Recipe { collapse: Collapse { traversal_cost, triangle_cost, ..book.collapse }, ..book }
            }
        };
        let recipe = self.with_costs(priced);
        if self.bases.is_some() && recipe.builder.bases().or(recipe.fit.bases()).is_none() {
            bail!(
                "--bases is for builders and fits that have some, odop1 to odop8: choose one of them, or leave it out"
            );
        }
        Ok(recipe)
    }

    /// The same for the library, with the costs of `priced` where none are given.
    fn with_costs(&self, priced: Recipe) -> Recipe {
        let Self { builder, morton, radius, threshold, directions, local_search, max_leaf, memory, .. } =
            *self;
        let node_cost = self.node_cost.unwrap_or(priced.collapse.node_cost);
        let collapse = Collapse { node_cost, max_leaf, ..priced.collapse };
        let oriented_cost = self.oriented_cost.unwrap_or(priced.oriented_cost);
        let (mut builder, mut fit) = (builder.builder, self.fit.unwrap_or(builder.fit));
        if let Some(generator) = self.bases {
            (builder, fit) = (builder.with_generator(generator), fit.with_generator(generator));
        }
        let collapsed = self.collapse;
        Recipe {
            builder,
            morton,
            radius,
            collapse,
            collapsed,
            fit,
            threshold,
            oriented_cost,
            directions,
            local_search,
            memory,
        }
    }
}

/// Which costs.
#[derive(Debug, Clone, Copy, PartialEq)]
enum CostsName {
    /// The library's defaults.
    Book,
    /// The device's.
    Measured,
    /// Of a binary node and of a triangle.
    Pair(f32, f32),
}

/// An amount of memory.
fn memory(text: &str) -> Result<u64, String> {
    bytes_of(text).ok_or_else(|| "write a size with its unit, such as 8GiB or 512MiB".into())
}

/// A number above 0.
fn cost(text: &str) -> std::result::Result<f32, String> {
    let number = text.trim().parse().ok().filter(|x: &f32| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "write a number above 0, such as 4".into())
}

/// `book`, `measured`, or two numbers above 0 with a comma between them.
fn costs(text: &str) -> std::result::Result<CostsName, String> {
    let pair = || {
        let (traversal, triangle) = text.split_once(',')?;
        Some(CostsName::Pair(cost(traversal).ok()?, cost(triangle).ok()?))
    };
    match text {
        "book" => Ok(CostsName::Book),
        "measured" => Ok(CostsName::Measured),
        _ => pair().ok_or_else(|| "write book, measured, or two numbers above 0, such as 3,2".into()),
    }
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
    fn costs_have_a_name_or_are_positive() {
        assert_eq!(costs("3,2"), Ok(CostsName::Pair(3.0, 2.0)));
        assert_eq!(costs(" 1.5, 1 "), Ok(CostsName::Pair(1.5, 1.0)));
        assert_eq!((costs("book"), costs("measured")), (Ok(CostsName::Book), Ok(CostsName::Measured)));
        for bad in ["", "Book", "3", "3,", "0,1", "3,-2", "inf,1", "nan,1", "1,2,3"] {
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
        let typed = |args: &[&str]| Only::parse_from([&["x"], args].concat()).recipe;
        assert_eq!(typed(&[]).costs, CostsName::Book);
        assert_eq!(typed(&[]).with_costs(Recipe::default()), Recipe::default());
        // What is typed wins over what is measured.
        let costs = Costs { boxes: 10.0, oriented: 12.0, triangles: 20.0 };
        let recipe =
            typed(&["--costs", "measured", "--node-cost", "7"]).with_costs(costs.price(Recipe::default()));
        assert_eq!(
            (recipe.collapse.node_cost, recipe.oriented_cost, recipe.collapse.triangle_cost),
            (7.0, 48.0, 20.0)
        );
    }
}
