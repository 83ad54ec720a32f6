//! What to build: every choice of a build with its unit, range and effect.

use super::auto::POINTS;
use super::orientation::MOST;
use super::{Bases, BuildError, Directions, Generator, Result};
use crate::abi::{CODE_30, CODE_63, CODE_EXT4, CODE_EXT7, MAX_LEAF};

/// What makes the binary tree. Everything after, leaves by cost included, is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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

/// What the binary tree's nodes become: leaves, packed nodes, or nothing, whichever the surface area heuristic expects to
/// cost least \[GOLDSMITH87, WALD07, YLITIE17\].
#[derive(Debug, Clone, Copy, PartialEq)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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

/// Which boxes nodes have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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

    fn is_in_range(self) -> bool {
        match self {
            Self::Aabb | Self::Odop(_) | Self::Hybrid | Self::Auto => true,
            Self::Dito(points) => [12, 14, 20, 26].contains(&points),
            Self::Own(most) => (1..=MOST).contains(&most),
        }
    }
}

/// A build's choices. [`Recipe::default`] is what the README's figures used.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// Device memory that ODOP's boxes may take, bytes; where the device has less free, that. Less: slower, the same
    /// tree.
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
