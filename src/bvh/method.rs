//! Builders by name: what makes the binary tree and which boxes its nodes get, as users choose them together.

use super::{Bases, Builder, Fit, Generator};

/// A builder as arguments, presets and reports name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    /// As typed.
    pub name: &'static str,
    /// What it is, for help.
    pub what: &'static str,
    /// What makes the binary tree.
    pub builder: Builder,
    /// Boxes of its nodes.
    pub fit: Fit,
}

const fn method(name: &'static str, what: &'static str, builder: Builder, fit: Fit) -> Method {
    Method { name, what, builder, fit }
}

const fn odop(name: &'static str, what: &'static str, degree: u32) -> Method {
    let bases = Bases { generator: Generator::Grid, degree };
    method(name, what, Builder::Odop(bases), Fit::Odop(bases))
}

const DITO: &str = "ploc's tree, with oriented boxes by DiTO where they cost less";

impl Method {
    /// All of them; the first is the default.
    pub const ALL: &[Self] = &[
        method("ploc", "Parallel locally-ordered clustering over Morton order", Builder::Ploc, Fit::Aabb),
        method(
            "lbvh",
            "The radix tree over the Morton codes: faster, a worse tree",
            Builder::Lbvh,
            Fit::Aabb,
        ),
        method(
            "sah",
            "Top-down by the surface area heuristic, on the CPU: slower, a better tree",
            Builder::Binned,
            Fit::Aabb,
        ),
        method("dito", DITO, Builder::Ploc, Fit::Dito(14)),
        method("dito12", DITO, Builder::Ploc, Fit::Dito(12)),
        method("dito14", DITO, Builder::Ploc, Fit::Dito(14)),
        method("dito20", DITO, Builder::Ploc, Fit::Dito(20)),
        method("dito26", DITO, Builder::Ploc, Fit::Dito(26)),
        odop(
            "odop2",
            "PLOC by the least of a cluster's boxes in 8 bases, and those boxes where they cost less",
            2,
        ),
        odop("odop3", "Likewise, in 27 bases", 3),
        odop("odop4", "Likewise, in 64 bases", 4),
        odop("odop5", "Likewise, in 125 bases", 5),
        odop("odop6", "Likewise, in 216 bases", 6),
        odop("odop7", "Likewise, in 343 bases", 7),
        odop("odop8", "Likewise, in 512 bases", 8),
        method(
            "hybrid",
            "dito, and boxes in the bases that most triangles share where those cost less",
            Builder::Ploc,
            Fit::Hybrid,
        ),
        method(
            "auto",
            "ploc's tree with the boxes that the scene needs, which each set of rays takes where they are faster",
            Builder::Ploc,
            Fit::Auto,
        ),
    ];

    /// The one of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|m| m.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Recipe;

    #[test]
    fn names_are_distinct_and_recipes_sound() {
        for (i, m) in Method::ALL.iter().enumerate() {
            assert_eq!(Method::ALL.iter().position(|o| o.name == m.name), Some(i));
            let recipe = Recipe { builder: m.builder, fit: m.fit, ..Recipe::default() };
            assert!(recipe.check().is_ok(), "{}", m.name);
        }
        let first = Method::ALL[0];
        assert_eq!((first.builder, first.fit), (Recipe::default().builder, Recipe::default().fit));
    }
}
