//! What is tried: which scenes, trees over them, and rays through these.

use super::judge::Segment;
use super::{Case, Effort, Load, RaySet, SETS};
use crate::abi::Ray;
use crate::bvh::{Bvh, Collapse, Method, Morton, Recipe};
use crate::oracle::reference::Reference;
use crate::trace::{Boxes, Options, Precision, Query, RayOrder, Walk};

/// What to try.
#[derive(Debug, Clone)]
pub struct Plan {
    /// How much.
    pub effort: Effort,
    /// Builders.
    pub methods: Vec<Method>,
    /// Triangle tests.
    pub precisions: Vec<Precision>,
    /// Rays of a set.
    pub rays: usize,
    /// Of all that is by chance.
    pub seed: u64,
}

/// How a tree is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting {
    /// Builder and boxes.
    pub method: Method,
    /// Codes.
    pub morton: Morton,
    /// Triangles that a leaf may hold.
    pub max_leaf: u32,
}

impl Setting {
    /// For the library.
    pub fn recipe(&self) -> Recipe {
        let book = Recipe::default();
        let collapse = Collapse { max_leaf: self.max_leaf, ..book.collapse };
        let (builder, fit) = (self.method.builder, self.method.fit);
        Recipe { builder, fit, morton: self.morton, collapse, ..book }
    }

    /// Arguments of `boxwood query` and `boxwood build` for the same.
    pub fn arguments(&self) -> Vec<String> {
        let (morton, leaf) = (self.morton.name(), self.max_leaf.to_string());
        ["--builder", self.method.name, "--morton", morton, "--max-leaf", &leaf].map(str::to_owned).to_vec()
    }

    /// A word.
    pub fn name(&self) -> String {
        let usual = Recipe::default();
        let mut name = self.method.name.to_owned();
        if self.morton != usual.morton {
            name += &format!("-{}", self.morton.name());
        }
        if self.max_leaf != usual.collapse.max_leaf {
            name += &format!("-leaf{}", self.max_leaf);
        }
        name
    }
}

/// The cases whose family or title holds one of `patterns`; all where there are none.
pub fn chosen(patterns: &[String]) -> Vec<&'static Case> {
    let wanted = |case: &&Case| {
        let title = case.title();
        patterns.is_empty() || patterns.iter().any(|p| title.contains(p.as_str()))
    };
    super::CASES.iter().filter(wanted).collect()
}

/// Rays of all sets over a scene, and which are whose.
pub(super) fn rays_of(case: &Case, reference: &Reference, plan: &Plan) -> (Vec<Ray>, Vec<Segment>) {
    let (mut rays, mut segments) = (vec![], vec![]);
    for set in SETS {
        let RaySet { name, .. } = *set;
        let first = rays.len();
        rays.extend(set.rays(reference, plan.rays.min(case.load.most_rays(plan.effort)), plan.seed));
        segments.push(Segment { name, range: first..rays.len() });
    }
    (rays, segments)
}

/// How trees over a scene of `case` are built.
pub(super) fn settings(case: &Case, plan: &Plan) -> Vec<Setting> {
    let usual = Recipe::default().morton;
    let variants = case.variants(plan.effort);
    let of = |method: &Method| {
        let method = *method;
        // A builder without codes has no choice of them.
        let sensible = variants.iter().filter(move |v| method.builder.wants_codes() || v.0 == usual);
        sensible.map(move |&(morton, max_leaf)| Setting { method, morton, max_leaf }).collect::<Vec<_>>()
    };
    plan.methods.iter().flat_map(of).collect()
}

/// How rays are traced through `bvh`.
pub(super) fn traces(case: &Case, plan: &Plan, bvh: &Bvh) -> Vec<Options> {
    let mut all = vec![];
    for &precision in &plan.precisions {
        let plain = Options { precision, ..Options::default() };
        let any = Options { query: Query::Any, ..plain };
        if case.load == Load::Full {
            all.extend([plain, any]);
            continue;
        }
        let walks = |options: Options, walks: &[Walk]| {
            walks.iter().map(move |&walk| Options { walk, ..options }).collect::<Vec<_>>()
        };
        match (precision, plan.effort) {
            (Precision::Robust, effort) => {
                all.extend(walks(plain, &Walk::ALL));
                all.push(Options { order: RayOrder::Sorted, ..plain });
                if Boxes::of(bvh).len() > 1 {
                    all.push(Options { boxes: Boxes::AxisAligned, ..plain });
                }
                let few = [Walk::Single, Walk::Packet];
                all.extend(walks(any, if effort == Effort::Whole { &Walk::ALL } else { &few }));
            }
            (Precision::Fast, Effort::Quick) => all.push(plain),
            (Precision::Fast, Effort::Whole) => {
                all.extend(walks(plain, &Walk::ALL));
                all.push(any);
            }
        }
    }
    all
}
