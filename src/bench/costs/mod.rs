//! What tests cost: by the book, or as this device was measured to take (see `costs/calibrate.rs`).
//!
//! **Unit.** ns of device time that one test of one ray adds to a large batch: on a device that runs many rays at once,
//! the time of the batch over its tests, not how long one test takes. A test is what [`TestTotals`] counts: a child's
//! box, with its share of fetching the node, of the stack and of the choice of what comes next, and a triangle, with its
//! share of the leaf's.
//!
//! **Of which walk.** Of [`crate::trace::Walk::Refill`], made for rays that have little in common, as the calibration's
//! have: for its nearest hits, by the watertight test. Packets share a node's fetch among rays, so that each pays less,
//! while the tests counted are those of rays that walk alone: costs rank trees for packets, and don't tell their times.

mod cache;
mod calibrate;
mod regression;

use super::{Result, TestTotals};
use crate::abi::WIDTH;
use crate::bvh::{Collapse, Recipe};
use crate::device::Device;
use crate::oracle::tight;
use std::path::Path;
use std::sync::Arc;

/// What a test costs: ns, see [the module](self); by the book, in its units.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Costs {
    /// An axis-aligned child box.
    pub boxes: f64,
    /// A child box of an oriented node.
    pub oriented: f64,
    /// A triangle.
    pub triangles: f64,
}

impl Default for Costs {
    fn default() -> Self {
        Self::book()
    }
}

impl Costs {
    /// Those of the literature, in units of its own: c_T = 3 for the two boxes of a binary node, 4 where they are
    /// oriented, c_I = 2 \[VEVERKOVA24\].
    pub fn book() -> Self {
        let [boxes, oriented, triangles] = tight::BOOK;
        Self { boxes, oriented, triangles }
    }

    /// Those of `device`: what `cache` remembers of this device, driver, commit and kernel shape; else measured, which
    /// takes about a second, and remembered. A cache that can't be read or written does no harm.
    ///
    /// # Errors
    /// A failed build or trace.
    pub fn measured(device: &Arc<Device>, cache: Option<&Path>) -> Result<Self> {
        let key = cache::Key::of(device);
        if let Some(costs) = cache.and_then(|folder| key.read(folder)) {
            return Ok(costs);
        }
        let costs = calibrate::calibrate(device)?;
        if let Some(folder) = cache
            && let Err(e) = key.write(folder, &costs)
        {
            tracing::info!("the device's costs can't be kept in {}: {e}", folder.display());
        }
        Ok(costs)
    }

    /// What `tests` cost.
    pub fn of(&self, tests: &TestTotals) -> f64 {
        self.boxes * tests.boxes as f64
            + self.oriented * tests.oriented as f64
            + self.triangles * tests.triangles as f64
    }

    /// What the tests of each of `rays` rays cost in the mean.
    pub fn per_ray(&self, tests: &TestTotals, rays: usize) -> f64 {
        self.of(tests) / rays.max(1) as f64
    }

    /// `recipe` with these costs: of a binary node two boxes, of a packed one all that it has room for, for a visit
    /// tests that many whether they are there or not.
    pub fn price(&self, recipe: Recipe) -> Recipe {
        let node = |test: f64| (f64::from(WIDTH) * test) as f32;
        let collapse = Collapse {
            traversal_cost: (2.0 * self.boxes) as f32,
            node_cost: node(self.boxes),
            triangle_cost: self.triangles as f32,
            ..recipe.collapse
        };
        Recipe { collapse, oriented_cost: node(self.oriented), ..recipe }
    }

    /// Box, oriented box, triangle.
    pub fn to_array(self) -> [f64; 3] {
        [self.boxes, self.oriented, self.triangles]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_costs_what_its_tests_do() {
        let tests = TestTotals { boxes: 100, oriented: 10, triangles: 1 };
        let costs = Costs { boxes: 2.0, oriented: 3.0, triangles: 5.0 };
        assert_eq!((costs.of(&tests), costs.per_ray(&tests, 10)), (235.0, 23.5));
        assert_eq!(costs.per_ray(&TestTotals::default(), 0), 0.0);
        assert_eq!(Costs::book().of(&tests), 150.0 + 20.0 + 2.0);
    }

    #[test]
    fn prices_reach_the_recipe() {
        let costs = Costs { boxes: 2.0, oriented: 3.0, triangles: 5.0 };
        let Recipe { collapse, oriented_cost, .. } = costs.price(Recipe::default());
        assert_eq!((collapse.traversal_cost, collapse.node_cost, collapse.triangle_cost), (4.0, 8.0, 5.0));
        assert_eq!((oriented_cost, collapse.max_leaf), (12.0, Recipe::default().collapse.max_leaf));
    }
}
