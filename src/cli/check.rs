//! `--check`: the device's tree and hits against the oracle.

use super::Global;
use crate::abi::{Hit, Ray};
use crate::bvh::{Bvh, Recipe};
use crate::oracle::compare::{self, Verdict, compare};
use crate::oracle::reference::Reference;
use crate::oracle::validate::{Claims, Stats, validate};
use crate::scene::Scene;
use crate::trace::{Options, Precision, Query};
use anyhow::{Context, Result, bail};

/// Rays on which the reference itself is held against brute force.
pub(super) const BRUTE_RAYS: usize = 64;

/// What checks have found.
#[derive(Debug, serde::Serialize)]
pub(super) struct Checks {
    /// The tree is sound, and this is what it is like.
    tree: Stats,
    /// The hits against the f64 reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    hits: Option<Verdict>,
    /// Whether faulty hits are an error: not with the fast test, which is known to leak.
    #[serde(skip)]
    strict: bool,
}

impl Checks {
    /// Checks the tree. One that is not sound is an error at once: its hits mean nothing.
    pub(super) fn of_tree(global: &Global, scene: &Scene, bvh: &Bvh, recipe: &Recipe) -> Result<Self> {
        let tree = validate(scene, &bvh.read()?, &Claims::of(bvh, recipe.collapse))
            .with_context(|| format!("check: the tree of {} is not sound", scene.name))?;
        global.remark(format_args!(
            "check: the tree is sound: {} leaves of {:.2} triangles, {} levels, inner area {:.2}, leaf area {:.2}",
            tree.leaves, tree.triangles_per_leaf, tree.depth, tree.inner_area, tree.leaf_area
        ));
        Ok(Self { tree, hits: None, strict: true })
    }

    /// Judges hits as well.
    pub(super) fn and_hits(
        self,
        global: &Global,
        scene: &Scene,
        rays: &[Ray],
        hits: &[Hit],
        options: Options,
    ) -> Self {
        let query = match options.query {
            Query::Closest => compare::Query::Closest,
            Query::Any => compare::Query::Any,
        };
        let reference = Reference::new(scene);
        let verdict = compare(&reference, rays, hits, query, options.precision.into())
            .sample_brute(&reference, rays, BRUTE_RAYS);
        global.remark(format_args!("check: {}", verdict.to_string().trim_end()));
        Self { hits: Some(verdict), strict: options.precision == Precision::Robust, ..self }
    }

    /// What is wrong, where that is an error.
    pub(super) fn faults(&self) -> Option<String> {
        let verdict = self.hits.as_ref().filter(|v| self.strict && !v.is_clean())?;
        Some(verdict.to_string())
    }
}

/// The command's failure, where there are `faults`.
pub(super) fn fail_on(faults: Option<String>) -> Result<()> {
    match faults {
        Some(faults) => bail!("check: the hits are wrong\n{}", faults.trim_end()),
        None => Ok(()),
    }
}
