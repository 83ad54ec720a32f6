//! CPU twins of the kernels, and references that they answer to. Order of trust: brute > reference > device.
//!
//! A twin has its stage's name and its kernels' function and variable names, in the same order. It is slow and
//! obvious: it says what the kernels compute, bit for bit.

pub mod binned;
pub mod bounds;
pub mod brute;
pub mod collapse;
pub mod compare;
pub mod dito;
pub mod exact;
pub mod excess;
pub mod fits;
pub mod layout;
pub mod layouts;
pub mod lbvh;
pub mod mixed;
pub mod morton;
pub mod odop;
pub mod odopfit;
pub mod orient;
pub mod ploc;
pub mod quality;
pub mod rays;
pub mod raysort;
pub mod recut;
pub mod reference;
pub mod scan;
pub mod sort;
pub mod tight;
pub mod trace;
pub mod validate;

use crate::abi::Aabb;
use crate::bvh::orientation::sample;
use crate::bvh::raw::HostRawTree;
use crate::bvh::{Builder, HostTree, Moment, Recipe, auto};
use crate::scene::Scene;

/// What each stage of a build comes to: the twin of `bvh::Stages`, and the tree.
#[derive(Debug, Clone)]
pub struct Built {
    /// Bounds of the triangles that can be hit, scene space.
    pub bounds: Aabb,
    /// Unit space.
    pub space: morton::Space,
    /// Triangles in the builder's order, without those that can't be hit.
    pub order: Vec<u32>,
    /// The binary tree, and what of it is kept; none where no triangle can be hit.
    pub raw: Option<(HostRawTree, collapse::Kept)>,
    /// The packed tree.
    pub tree: HostTree,
    /// Its oriented nodes.
    pub oriented: u32,
}

/// Builds the tree of `scene` by `recipe` as the device does, stage by stage.
pub fn build(scene: &Scene, recipe: &Recipe) -> Built {
    let (bounds, hittable) = morton::bounds(scene);
    let space = morton::space(&bounds, hittable);
    let by_code = || sort::by_code(scene, &bounds, hittable, recipe.morton);
    let (order, raw) = match recipe.builder {
        Builder::Ploc => {
            let order = by_code().0;
            let raw = ploc::cluster(scene, &order, &space, recipe.radius, &recipe.collapse);
            (order, raw)
        }
        Builder::Odop(bases) => {
            let order = by_code().0;
            let raw = odop::cluster(scene, &order, &space, bases, recipe.radius, &recipe.collapse);
            (order, raw)
        }
        Builder::Lbvh => {
            let (order, keys) = by_code();
            let raw = lbvh::climb(scene, &order, &keys, &space, &recipe.collapse);
            (order, raw)
        }
        Builder::Binned => binned::split(scene, &space, &recipe.collapse),
    };
    let trials = auto::trials(recipe.fit, &sample(scene));
    let raw = raw.map(|mut tree| {
        if let Some(points) = trials.points.filter(|_| recipe.collapsed == Moment::After) {
            recut::choose(scene, &order, &space, &mut tree, points, recipe);
        }
        collapse::expand(&mut tree);
        let kept = collapse::number(&tree, &recipe.collapse);
        (tree, kept)
    });
    let parts = raw.as_ref().map(|(tree, kept)| (tree, kept));
    let mut tree = layout::pack(scene, &order, &space, recipe.collapse.max_leaf, parts);
    let mut oriented = 0;
    if !trials.bases.is_empty() {
        oriented += odopfit::fit(&mut tree, space.anchor, &trials.bases, recipe);
    }
    if let Some(points) = trials.points {
        oriented += orient::orient(&mut tree, space.anchor, points, recipe);
    }
    Built { bounds, space, order, raw, tree, oriented }
}
