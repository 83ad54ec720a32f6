//! What `build` and `query` report of a tree, built or loaded.

use super::Global;
use crate::bench::Builds;
use crate::bvh::{Bvh, Fit, Recipe};
use crate::device::Device;
use crate::saved::Loaded;
use crate::scene::Scene;
use anyhow::Result;
use std::path::PathBuf;

/// A tree, however it came about.
#[derive(Debug, serde::Serialize)]
struct TreeReport {
    device: String,
    driver: String,
    commit: &'static str,
    scene: String,
    triangles: usize,
    left_out: u32,
    builder: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    morton: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radius: Option<u32>,
    max_leaf: u32,
    collapse: &'static str,
    fit: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    bases: Option<&'static str>,
    node_cost: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    oriented_cost: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    threshold: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    directions: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    local_search: Option<u32>,
    /// Of a binary node and of a triangle.
    sah_costs: [f32; 2],
    bvh_bytes: u64,
    sah: f64,
    depth: u32,
    nodes: usize,
    /// Those whose boxes are oriented.
    oriented: u32,
    tree_hash: String,
}

impl TreeReport {
    /// Of `bvh`, by `recipe` over the scene of that name; reads the tree back for its hash.
    fn new(device: &Device, scene: &str, recipe: &Recipe, bvh: &Bvh) -> Result<Self> {
        Ok(Self {
            device: device.info().name.clone(),
            driver: device.info().driver.clone(),
            commit: env!("BOXWOOD_COMMIT"),
            scene: scene.to_owned(),
            triangles: bvh.triangle_count as usize + bvh.left_out as usize,
            left_out: bvh.left_out,
            builder: recipe.builder.name(),
            morton: recipe.builder.wants_codes().then_some(recipe.morton.name()),
            radius: recipe.builder.has_radius().then_some(recipe.radius),
            max_leaf: recipe.collapse.max_leaf,
            collapse: recipe.collapsed.name(),
            fit: recipe.fit.name(),
            bases: recipe.builder.bases().or(recipe.fit.bases()).map(|b| b.generator.name()),
            node_cost: recipe.collapse.node_cost,
            oriented_cost: (recipe.fit != Fit::Aabb).then_some(recipe.oriented_cost),
            threshold: recipe.threshold,
            directions: recipe.fit.has_points().then_some(recipe.directions.name()),
            local_search: (recipe.local_search > 0).then_some(recipe.local_search),
            sah_costs: [recipe.collapse.traversal_cost, recipe.collapse.triangle_cost],
            bvh_bytes: bvh.bytes(),
            sah: bvh.sah,
            depth: bvh.depth,
            nodes: bvh.nodes.len(),
            oriented: bvh.oriented,
            tree_hash: bvh.read()?.hash(),
        })
    }
}

/// A tree that was built, and what that took.
#[derive(Debug, serde::Serialize)]
pub(super) struct BuildReport {
    #[serde(flatten)]
    tree: TreeReport,
    runs: usize,
    build_ms: f64,
    /// Of the last build, the share of its time that the CPU took.
    build_host_ms: f64,
    build_ms_min: f64,
    build_wall_ms: f64,
    scratch_bytes: u64,
}

impl BuildReport {
    /// Of `builds`.
    pub(super) fn new(device: &Device, scene: &Scene, recipe: &Recipe, builds: &Builds) -> Result<Self> {
        Ok(Self {
            tree: TreeReport::new(device, &scene.name, recipe, &builds.built.bvh)?,
            runs: builds.device.runs,
            build_ms: builds.device.median,
            build_host_ms: builds.built.times.host_ms,
            build_ms_min: builds.device.min,
            build_wall_ms: builds.wall.median,
            scratch_bytes: builds.built.scratch_bytes,
        })
    }

    /// For people.
    pub(super) fn remark(&self, global: &Global) {
        let tree = &self.tree;
        let per_triangle = tree.triangles.max(1) as f64;
        global.remark(format_args!(
            "{}: {} triangles built in {:.2} ms (least {:.2}, wall {:.2}) on {}",
            tree.scene, tree.triangles, self.build_ms, self.build_ms_min, self.build_wall_ms, tree.device
        ));
        global.remark(format_args!(
            "tree: {} nodes, {:.1} MB, SAH cost {:.2}; scratch {:.0} bytes a triangle",
            tree.nodes,
            tree.bvh_bytes as f64 * 1e-6,
            tree.sah,
            self.scratch_bytes as f64 / per_triangle
        ));
    }
}

/// A tree that was loaded, and what that took.
#[derive(Debug, serde::Serialize)]
pub(super) struct LoadReport {
    #[serde(flatten)]
    tree: TreeReport,
    /// Of its traces.
    runs: usize,
    loaded: PathBuf,
    /// From opening the file to the tree on the device, checked.
    loaded_ms: f64,
    loaded_bytes: u64,
    /// The boxwood that built it: version and commit.
    built_by: String,
}

impl LoadReport {
    /// Of the file `path`, loaded within `ms`.
    pub(super) fn new(device: &Device, path: PathBuf, loaded: &Loaded, ms: f64, runs: usize) -> Result<Self> {
        let origin = &loaded.origin;
        Ok(Self {
            tree: TreeReport::new(device, &origin.scene, &origin.recipe, &loaded.bvh)?,
            runs,
            loaded: path,
            loaded_ms: ms,
            loaded_bytes: loaded.bytes,
            built_by: format!("{} ({})", origin.boxwood, origin.commit),
        })
    }

    /// For people.
    pub(super) fn remark(&self, global: &Global) {
        let tree = &self.tree;
        global.remark(format_args!(
            "{}: the tree of {}, {} triangles, loaded in {:.2} ms onto {}",
            self.loaded.display(),
            tree.scene,
            tree.triangles,
            self.loaded_ms,
            tree.device
        ));
        global.remark(format_args!(
            "tree: {} nodes, {:.1} MB, SAH cost {:.2}; by {} of boxwood {}",
            tree.nodes,
            tree.bvh_bytes as f64 * 1e-6,
            tree.sah,
            tree.builder,
            self.built_by
        ));
    }
}

/// A tree, built or loaded.
#[derive(Debug, serde::Serialize)]
#[serde(untagged)]
pub(super) enum Source {
    /// Built.
    Built(BuildReport),
    /// Loaded.
    Loaded(LoadReport),
}
