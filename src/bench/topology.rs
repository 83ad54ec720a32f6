//! Which of several recipes gives the tree that rays of a scene cost least: each is built once and walked by a sample of
//! them, counted, not timed, so that the answer is the same every time.

use super::traces::count_tests;
use super::{Costs, Result, TestTotals};
use crate::abi::Ray;
use crate::bvh::{self, Bases, Builder, Fit, Generator, Recipe, SceneBuffers};
use crate::device::{Device, Timing};
use crate::trace::{BATCH, Boxes, Options};
use std::sync::Arc;

/// A recipe that was tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tried {
    /// How to build it.
    pub recipe: Recipe,
    /// Through which of its boxes rays cost less.
    pub boxes: Boxes,
    /// Tests of the sample there.
    pub tests: TestTotals,
    /// What they cost a ray in the mean, ns.
    pub cost_per_ray: f64,
}

/// Other trees than that of `recipe`, with its settings: top-down, and where the scene has oriented boxes at all, by
/// oriented distances.
fn others(recipe: &Recipe, oriented: bool) -> Vec<Recipe> {
    let odop = Builder::Odop(Bases { generator: Generator::Grid, degree: 2 });
    let mut others = vec![Recipe { builder: Builder::Binned, ..*recipe }];
    if oriented {
        others.push(Recipe { builder: odop, fit: Fit::Hybrid, ..*recipe });
    }
    others
}

/// `recipe` and others with its settings, the one first that `sample` costs least, by `costs`.
///
/// # Errors
/// A build or a trace that fails, for want of memory or otherwise.
pub fn try_recipes(
    device: &Arc<Device>,
    scene: &SceneBuffers,
    recipe: &Recipe,
    sample: &[Ray],
    options: Options,
    costs: Costs,
) -> Result<Vec<Tried>> {
    let mut tried = vec![];
    let mut try_one = |recipe: Recipe| -> Result<bool> {
        let tree = bvh::build(device, scene, &recipe, Timing::Off)?.bvh;
        for &boxes in Boxes::of(&tree) {
            let options = Options { boxes, ..options };
            let tests = count_tests(device, &tree, sample, options, BATCH.min(sample.len()).max(1))?;
            let cost_per_ray = costs.per_ray(&tests, sample.len());
            tried.push(Tried { recipe, boxes, tests, cost_per_ray });
        }
        Ok(tree.oriented > 0)
    };
    let oriented = try_one(*recipe)?;
    for recipe in others(recipe, oriented) {
        try_one(recipe)?;
    }
    // Stable: of equals the first tried, which builds fastest.
    tried.sort_by(|a, b| a.cost_per_ray.total_cmp(&b.cost_per_ray));
    Ok(tried)
}
