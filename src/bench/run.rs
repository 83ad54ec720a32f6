//! The benchmark, a scene at a time: all builders build it in turn, then, view by view, trace its rays in turn, so that
//! what else the machine does meets all of them alike. A row goes to its file the moment that it is finished.

use super::rays::Rays;
use super::stats::{enough, warm_up};
use super::{BenchError, BuildRow, Contender, Costs, Plan, Result, Rows, Spread, by_kernel};
use super::{images, pictures};
use crate::bvh::{Built, Bvh, Fit, SceneBuffers, build, stages};
use crate::device::{Device, Timing};
use crate::oracle::reference::Reference;
use crate::oracle::validate::{Claims, validate};
use crate::oracle::{excess, mixed, quality, tight};
use crate::picture::{Studio, Subject};
use crate::scene::{Scene, SceneError};
use crate::trace::Precision;
use crate::trace::rays::View;
use std::sync::Arc;

/// Opens a scene by what the plan calls it.
pub type Open<'a> = &'a dyn Fn(&str) -> std::result::Result<Scene, SceneError>;
/// Is told of each step before it is taken.
pub type Progress<'a> = &'a dyn Fn(&str, &Rows);

/// Measures what `rows` lacks of `plan`.
///
/// # Errors
/// A scene that can't be opened, a failed build or trace, a tree that is not sound, a row that can't be written. The
/// rows before it are there.
pub fn run(device: &Arc<Device>, plan: &Plan, open: Open, rows: &mut Rows, progress: Progress) -> Result<()> {
    let mut rays = Rays::new(device, plan)?;
    for spec in &plan.scenes {
        if plan.keys_of(spec).iter().all(|key| rows.has(key)) {
            continue;
        }
        progress(&format!("{spec}: opening"), rows);
        let scene = open(spec)?;
        let mut stage = Stage::new(device, plan, spec, &scene, rows.header().costs)?;
        stage.build(rows, progress)?;
        if plan.check > 0 && !plan.rays.is_empty() {
            progress(&format!("{spec}: preparing the f64 reference"), rows);
            stage.reference = Some(Reference::new(&scene));
        }
        for view in 0..=plan.views {
            rays.trace_view(&stage, view, rows, progress)?;
        }
        if let Some(wanted) = &plan.images {
            images::take(&stage, wanted, rows, progress)?;
        }
        if let Some(size) = plan.pictures {
            pictures::take(&stage, size, rows, progress)?;
        }
    }
    Ok(())
}

/// A scene on the device, and its trees.
pub(super) struct Stage<'a> {
    pub(super) device: &'a Arc<Device>,
    pub(super) plan: &'a Plan,
    /// As the plan has it.
    pub(super) spec: &'a str,
    pub(super) scene: &'a Scene,
    /// Of the device's tests.
    pub(super) costs: Costs,
    pub(super) buffers: SceneBuffers,
    /// One a contender.
    pub(super) trees: Vec<Bvh>,
    pub(super) reference: Option<Reference<'a>>,
}

/// A contender's builds, not finished.
struct Builds<'a> {
    contender: &'a Contender,
    row: BuildRow,
    device_ms: Vec<f64>,
    wall_ms: Vec<f64>,
}

impl<'a> Stage<'a> {
    fn new(
        device: &'a Arc<Device>,
        plan: &'a Plan,
        spec: &'a str,
        scene: &'a Scene,
        costs: Costs,
    ) -> Result<Self> {
        let buffers = SceneBuffers::upload(device, scene)?;
        Ok(Self { device, plan, spec, scene, costs, buffers, trees: vec![], reference: None })
    }

    /// A picture of the first view, of `size` pixels, through the first contender's tree.
    pub(super) fn studio(&self, [width, height]: [u32; 2]) -> Result<Studio<'_>> {
        let Self { device, scene, buffers, trees, .. } = self;
        let subject = Subject { device, scene, buffers, bvh: &trees[0] };
        let view = View { camera: scene.views_or_default()[0], width, height };
        Ok(Studio::new(subject, view, Precision::Robust)?)
    }

    /// Builds every contender's tree; measures those whose rows are missing.
    fn build(&mut self, rows: &mut Rows, progress: Progress) -> Result<()> {
        let mut open = vec![];
        for contender in self.plan.contenders_of(self.spec) {
            progress(&format!("{}, {}: building, checking", self.spec, contender.name), rows);
            let key =
                super::plan::Key { scene: self.spec.to_owned(), builder: contender.name.clone(), rays: None };
            let wanted = !rows.has(&key);
            if wanted {
                let once = || build(self.device, &self.buffers, &contender.recipe, Timing::Outer);
                warm_up(self.plan.warm_ups, || once().map(|b| b.times.device_ms))?;
            }
            let built = build(self.device, &self.buffers, &contender.recipe, Timing::Kernels)?;
            if wanted {
                let row = self.survey(contender, &built)?;
                open.push(Builds { contender, row, device_ms: vec![], wall_ms: vec![] });
            }
            self.trees.push(built.bvh);
        }
        while !open.is_empty() {
            for builds in &mut open {
                progress(&format!("{}, {}: building", self.spec, builds.contender.name), rows);
                let built = build(self.device, &self.buffers, &builds.contender.recipe, Timing::Outer)?;
                builds.device_ms.push(built.times.device_ms);
                builds.wall_ms.push(built.wall_ms);
            }
            let (done, going) = open.into_iter().partition(|b: &Builds| enough(self.plan.runs, &b.device_ms));
            open = going;
            for Builds { row, device_ms, wall_ms, .. } in done {
                let (build_ms, build_wall_ms) = (Spread::of(&device_ms), Spread::of(&wall_ms));
                rows.push_build(BuildRow { build_ms, build_wall_ms, ..row })?;
            }
        }
        Ok(())
    }

    /// All of a row but its times.
    fn survey(&self, contender: &Contender, built: &Built) -> Result<BuildRow> {
        let Built { bvh, times, scratch_bytes, explain, .. } = built;
        let tree = bvh.read()?;
        let claims = Claims::of(bvh, contender.recipe.collapse);
        let stats = validate(self.scene, &tree, &claims)
            .map_err(|source| BenchError::Tree { scene: self.scene.name.clone(), source })?;
        // A study of the binary tree, which is no part of what is built: one more build tells it.
        let mixed = if contender.recipe.fit == Fit::Aabb {
            None
        } else {
            let stages = stages(self.device, &self.buffers, &contender.recipe)?.1;
            Some(mixed::measure(self.scene, &stages))
        };
        Ok(BuildRow {
            scene: self.spec.to_owned(),
            builder: contender.name.clone(),
            triangles: self.scene.triangles.len(),
            build_ms: Spread::default(),
            build_wall_ms: Spread::default(),
            bvh_bytes: bvh.bytes(),
            scratch_bytes: *scratch_bytes,
            tree: stats,
            quality: quality::measure(&tree, &claims),
            tight: tight::measure(&tree, claims.anchor, &claims.bounds),
            mixed,
            excess: (self.plan.boxes > 0).then(|| excess::measure(&tree, claims.anchor, self.plan.boxes)),
            tree_hash: tree.hash(),
            kernels: by_kernel(&times.passes),
            explain: explain.clone(),
        })
    }
}
