//! What to build: every choice of a build with its unit, range and effect.

use super::{BuildError, Builder, Directions, Fit, Morton, Result};
use crate::abi::MAX_LEAF;

/// What the binary tree's nodes become: leaves, packed nodes, or nothing, whichever the surface area heuristic expects to
/// cost least \[GOLDSMITH87, WALD07, YLITIE17\].
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Collapse {
    /// Cost of a binary inner node, the tests of its two boxes, c_T, in units of one's choice; above 0. Only for the
    /// measures that are reported: no tree depends on it.
    pub traversal_cost: f32,
    /// Cost of a packed node, whatever its number of children, c_N, in the same units; above 0. Larger: fewer nodes, and
    /// more triangles tested.
    pub node_cost: f32,
    /// Cost of a triangle test, c_I, in the same units; above 0.
    pub triangle_cost: f32,
    /// Triangles that a leaf may hold: 1–64. 1: no collapse.
    pub max_leaf: u32,
}

/// When the binary tree is collapsed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Moment {
    /// Before boxes are fitted: by the areas that the builder goes by.
    #[default]
    Before,
    /// After DiTO has fitted boxes to the binary tree: by their areas, times what an oriented node costs over an
    /// axis-aligned one, where that is less.
    After,
}

impl Moment {
    /// Every choice.
    pub const ALL: [Self; 2] = [Self::Before, Self::After];

    /// As arguments and reports have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Before => "before",
            Self::After => "after",
        }
    }
}

/// A build's choices. [`Recipe::default`] is what the README's figures used.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    /// Builder.
    pub builder: Builder,
    /// Morton codes; the binned builder has none.
    pub morton: Morton,
    /// PLOC's search radius, clusters to either side: 1–128. Larger: slower, a slightly better tree in some scenes.
    pub radius: u32,
    /// Leaves.
    pub collapse: Collapse,
    /// When leaves and packed nodes are chosen. After the fit: DiTO takes far more time and memory, the binary tree having
    /// several times the nodes.
    pub collapsed: Moment,
    /// Boxes.
    pub fit: Fit,
    /// Of [`Fit::Hybrid`]: nodes of more triangles than this try bases only, the others DiTO only; none: all try both.
    /// What a node doesn't try is not computed for it.
    pub threshold: Option<u32>,
    /// Cost of visiting an oriented packed node, c_O, in the units of `collapse`; above 0. No less than `node_cost`.
    pub oriented_cost: f32,
    /// Directions of DiTO's extremal points; of no effect but where boxes are fitted by DiTO.
    pub directions: Directions,
    /// Evaluations of a local search for a smaller box after each fit: 0–1024. More: slower, smaller boxes.
    pub local_search: u32,
    /// Device memory that ODOP may hold beside the scene while it clusters, bytes; where the device has less free, that.
    /// Less: slower, the same tree.
    pub memory: u64,
}

impl Default for Recipe {
    fn default() -> Self {
        // Radius 8: in a prototype 16 took 9–20 % longer and lowered the cost by 0.8 % at best. Not measured here.
        let collapse = Collapse { traversal_cost: 3.0, node_cost: 5.0, triangle_cost: 2.0, max_leaf: 8 };
        Self {
            builder: Builder::Ploc,
            morton: Morton::Auto,
            radius: 8,
            collapse,
            collapsed: Moment::Before,
            fit: Fit::Aabb,
            threshold: None,
            oriented_cost: 6.0,
            directions: Directions::Book,
            local_search: 0,
            memory: 4 << 30,
        }
    }
}

impl Recipe {
    /// Triangles of a node that DiTO fits, at most.
    pub(crate) fn most_of_points(&self) -> u32 {
        self.threshold.unwrap_or(u32::MAX)
    }

    /// Nodes of more triangles than this are fitted to bases.
    pub(crate) fn least_of_bases(&self) -> u32 {
        self.threshold.unwrap_or(0)
    }

    /// What an oriented node costs over an axis-aligned one.
    pub(crate) fn dearer(&self) -> f32 {
        self.oriented_cost / self.collapse.node_cost
    }

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
        if self.local_search > 1024 {
            return refuse("the local search", self.local_search.to_string(), "0 to 1024 evaluations");
        }
        let all_bases = self.builder.bases().into_iter().chain(self.fit.bases());
        if let Some(bases) = all_bases.into_iter().find(|b| !b.is_in_range()) {
            return refuse("the degree of the bases", bases.degree.to_string(), bases.degrees());
        }
        if let Some(threshold) = self.threshold.filter(|_| self.fit != Fit::Hybrid) {
            return refuse("the threshold", threshold.to_string(), "left out where the fit is not hybrid");
        }
        if self.collapsed == Moment::After && self.fit.points().is_none() {
            let range = "before where boxes are not fitted by dito12, dito14, dito20, dito26 or hybrid";
            return refuse("the moment of the collapse", self.collapsed.name().into(), range);
        }
        if self.directions != Directions::Book && !self.fit.has_points() {
            let range = "book where no box is fitted by dito12, dito14, dito20, dito26, hybrid or auto";
            return refuse("the set of directions", self.directions.name().into(), range);
        }
        if !self.fit.is_in_range() {
            let range = "by 12, 14, 20 or 26 points, or of 1 to 16 own bases";
            return refuse("the fit of boxes", format!("{:?}", self.fit), range);
        }
        if ![c.traversal_cost, c.node_cost, c.triangle_cost, self.oriented_cost].into_iter().all(positive) {
            let value =
                format!("{}, {}, {}, {}", c.traversal_cost, c.node_cost, c.triangle_cost, self.oriented_cost);
            return refuse("a cost (traversal, node, triangle, oriented node)", value, "finite and above 0");
        }
        Ok(())
    }
}
