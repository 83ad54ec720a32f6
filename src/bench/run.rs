//! The benchmark, a scene at a time: all builders build it in turn, then, view by view, trace its rays in turn, so that
//! what else the machine does meets all of them alike. A row goes to its file the moment that it is finished.

use super::plan::Maker;
use super::rays::Rays;
use super::stats::{enough, warm_up};
use super::tree::{Made, Tree};
use super::{BenchError, BuildRow, Contender, Costs, Plan, Result, Rows, Spread, Survey, by_kernel};
use super::{images, pictures};
use crate::bvh::{Bvh, Fit, Recipe, SceneBuffers, stages};
use crate::device::{Device, Timing};
use crate::oracle::reference::Reference;
use crate::oracle::validate::{Claims, validate};
use crate::oracle::{excess, mixed, quality, tight};
use crate::picture::{Studio, Subject};
use crate::scene::Scene;
use crate::trace::Precision;
use crate::trace::rays::View;
use std::sync::Arc;

/// Opens a scene by what the plan calls it.
pub type Open<'a> = &'a dyn Fn(&str) -> Result<Scene>;
/// Is told of each step before it is taken.
pub type Progress<'a> = &'a dyn Fn(&str, &Rows);

/// A scene that could not be measured, or not whole: the others don't suffer.
#[derive(Debug)]
pub struct Unmeasured {
    /// As the plan has it.
    pub scene: String,
    /// Why not.
    pub why: BenchError,
}

/// Measures what `rows` lacks of `plan`; says which scenes could not be had, or don't fit.
///
/// # Errors
/// A scene that is none, a failed build or trace, a lost device, a tree that is not sound, a row that can't be written.
/// The rows before it are there.
pub fn run(
    device: &Arc<Device>,
    plan: &Plan,
    open: Open,
    rows: &mut Rows,
    progress: Progress,
) -> Result<Vec<Unmeasured>> {
    let mut rays = Rays::new(device, plan)?;
    let mut unmeasured = vec![];
    for spec in &plan.scenes {
        if plan.keys_of(spec).iter().all(|key| rows.has(key)) {
            continue;
        }
        match measure(device, plan, spec, open, &mut rays, rows, progress) {
            Err(why) if why.is_of_one_scene() => {
                progress(&format!("{spec}: goes unmeasured: {why}"), rows);
                unmeasured.push(Unmeasured { scene: spec.clone(), why });
            }
            done => done?,
        }
    }
    Ok(unmeasured)
}

fn measure(
    device: &Arc<Device>,
    plan: &Plan,
    spec: &str,
    open: Open,
    rays: &mut Rays,
    rows: &mut Rows,
    progress: Progress,
) -> Result<()> {
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
    /// One a contender, and one more where the lookout is none of theirs.
    pub(super) trees: Vec<Tree>,
    /// The tree that tells what primary rays meet, for all contenders: any that is not a driver's.
    pub(super) lookout: usize,
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
        Ok(Self { device, plan, spec, scene, costs, buffers, trees: vec![], lookout: 0, reference: None })
    }

    /// Contenders whose trees are boxwood's, and these.
    pub(super) fn own_trees(&self) -> impl Iterator<Item = (&'a Contender, &Bvh)> {
        let contenders = self.plan.contenders_of(self.spec).iter();
        contenders.zip(&self.trees).filter_map(|(contender, tree)| match tree {
            Tree::Packed(bvh) => Some((contender, bvh)),
            Tree::Driver(_) => None,
        })
    }

    /// A picture of the first view, of `size` pixels, through `bvh`.
    pub(super) fn studio<'s>(&'s self, [width, height]: [u32; 2], bvh: &'s Bvh) -> Result<Studio<'s>> {
        let Self { device, scene, buffers, .. } = self;
        let subject = Subject { device, scene, buffers, bvh };
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
                let once = || contender.maker.make(self.device, &self.buffers, Timing::Outer);
                warm_up(self.plan.warm_ups, || once().map(|made| made.times.device_ms))?;
            }
            let made = contender.maker.make(self.device, &self.buffers, Timing::Kernels)?;
            if wanted {
                let row = self.row(contender, &made)?;
                open.push(Builds { contender, row, device_ms: vec![], wall_ms: vec![] });
            }
            self.trees.push(made.tree);
        }
        self.find_lookout()?;
        while !open.is_empty() {
            for builds in &mut open {
                progress(&format!("{}, {}: building", self.spec, builds.contender.name), rows);
                let made = builds.contender.maker.make(self.device, &self.buffers, Timing::Outer)?;
                builds.device_ms.push(made.times.device_ms);
                builds.wall_ms.push(made.wall_ms);
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

    fn find_lookout(&mut self) -> Result<()> {
        let packed = self.trees.iter().position(|tree| matches!(tree, Tree::Packed(_)));
        if packed.is_none() {
            let plain = Maker::Boxwood(Recipe::default());
            self.trees.push(plain.make(self.device, &self.buffers, Timing::Off)?.tree);
        }
        self.lookout = packed.unwrap_or(self.trees.len() - 1);
        Ok(())
    }

    /// All of a row but its times.
    fn row(&self, contender: &Contender, made: &Made) -> Result<BuildRow> {
        let survey = match (&contender.maker, &made.tree) {
            (Maker::Boxwood(recipe), Tree::Packed(bvh)) => Some(self.survey(recipe, bvh)?),
            _ => None,
        };
        Ok(BuildRow {
            scene: self.spec.to_owned(),
            builder: contender.name.clone(),
            triangles: self.scene.triangles.len(),
            build_ms: Spread::default(),
            build_wall_ms: Spread::default(),
            bvh_bytes: made.tree.bytes(),
            scratch_bytes: made.scratch_bytes,
            survey,
            kernels: by_kernel(&made.times.passes),
            explain: made.explain.clone(),
        })
    }

    fn survey(&self, recipe: &Recipe, bvh: &Bvh) -> Result<Survey> {
        let tree = bvh.read()?;
        let claims = Claims::of(bvh, recipe.collapse);
        let stats = validate(self.scene, &tree, &claims)
            .map_err(|source| BenchError::Tree { scene: self.scene.name.clone(), source })?;
        // A study of the binary tree, which is no part of what is built: one more build tells it.
        let mixed = if recipe.fit == Fit::Aabb {
            None
        } else {
            let stages = stages(self.device, &self.buffers, recipe)?.1;
            Some(mixed::measure(self.scene, &stages))
        };
        Ok(Survey {
            tree: stats,
            quality: quality::measure(&tree, &claims),
            tight: tight::measure(&tree, claims.anchor, &claims.bounds),
            mixed,
            excess: (self.plan.boxes > 0).then(|| excess::measure(&tree, claims.anchor, self.plan.boxes)),
            tree_hash: tree.hash(),
        })
    }
}
