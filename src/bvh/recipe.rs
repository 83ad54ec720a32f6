//! What to build: every choice of a build with its unit, range and effect.

use super::{BuildError, Result};
use crate::abi::MAX_LEAF;

/// Length of the Morton codes that order the triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Morton {
    /// 30 bits, and 63 where too many triangles share a code.
    #[default]
    Auto,
    /// 10 bits an axis: four sort passes.
    Bits30,
    /// 21 bits an axis: eight sort passes.
    Bits63,
}

/// When a subtree becomes one leaf: where the surface area heuristic says that it costs less \[GOLDSMITH87, WALD07\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collapse {
    /// Cost of a binary inner node, the tests of its two boxes, c_T, in units of one's choice; above 0.
    pub traversal_cost: f32,
    /// Cost of a triangle test, c_I, in the same units; above 0.
    pub triangle_cost: f32,
    /// Triangles that a leaf may hold: 1–64. 1: no collapse.
    pub max_leaf: u32,
}

/// A build's choices. [`Recipe::default`] is what the README's figures used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recipe {
    /// Morton codes.
    pub morton: Morton,
    /// PLOC's search radius, clusters to either side: 1–128. Larger: slower, a slightly better tree in some scenes.
    pub radius: u32,
    /// Leaves.
    pub collapse: Collapse,
}

impl Default for Recipe {
    fn default() -> Self {
        // Radius 8: in a prototype 16 took 9–20 % longer and lowered the cost by 0.8 % at best. Not measured here.
        let collapse = Collapse { traversal_cost: 3.0, triangle_cost: 2.0, max_leaf: 8 };
        Self { morton: Morton::Auto, radius: 8, collapse }
    }
}

impl Recipe {
    /// Refuses values out of range.
    ///
    /// # Errors
    /// [`BuildError::Recipe`].
    pub fn check(&self) -> Result<()> {
        let refuse = |what, value: String, range| Err(BuildError::Recipe { what, value, range });
        let positive = |x: f32| x.is_finite() && x > 0.0;
        let c = &self.collapse;
        if !(1..=128).contains(&self.radius) {
            return refuse("the search radius", self.radius.to_string(), "1 to 128");
        }
        if !(1..=MAX_LEAF).contains(&c.max_leaf) {
            return refuse("the largest leaf", c.max_leaf.to_string(), "1 to 64");
        }
        if !positive(c.traversal_cost) || !positive(c.triangle_cost) {
            let value = format!("{}, {}", c.traversal_cost, c.triangle_cost);
            return refuse("a cost (traversal, triangle)", value, "finite and above 0");
        }
        Ok(())
    }
}
