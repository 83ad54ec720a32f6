//! The benchmark: first a survey of each scene (warm-up, time by kernel, tests, checks), then rounds, each of which
//! builds and traces every scene once, so that what else the machine does meets all of them alike.

use super::choice::fastest_walk;
use super::stats::warm_up;
use super::traces::Pace;
use super::{
    Checking, Coverage, KernelTime, Plan, RayKind, Report, Result, SceneReport, SetReport, Spread,
    TestTotals, by_kernel,
};
use crate::abi::{Aabb, Hit, Ray};
use crate::bvh::{Built, Bvh, SceneBuffers, build};
use crate::device::{Buffer, Device, Timing};
use crate::oracle::compare::{self, Verdict, compare};
use crate::oracle::reference::Reference;
use crate::oracle::validate::{Claims, Stats, validate};
use crate::scene::Scene;
use crate::trace::rays::{SAMPLES, Secondary, View, primary, secondary};
use crate::trace::{BATCH, Batch, Options, Precision, Query, RayOrder, Walk, trace};
use std::sync::Arc;

/// Rays of each set on which the reference itself is held against brute force.
const BRUTE_RAYS: usize = 16;

/// Measures `scenes` by `plan`. `progress` is told of each step before it is taken: [`steps`] of them.
///
/// # Errors
/// A failed build or trace, or a tree that is not sound.
pub fn run(device: &Arc<Device>, scenes: &[Scene], plan: &Plan, progress: &dyn Fn(&str)) -> Result<Report> {
    let mut bench = Bench::new(device, plan)?;
    let mut cases = vec![];
    for scene in scenes {
        progress(&format!("{}: warming up, checking", scene.name));
        cases.push(bench.survey(scene)?);
    }
    for round in 1..=plan.runs {
        for case in &mut cases {
            progress(&format!("round {round} of {}: {}", plan.runs, case.scene.name));
            bench.round(case)?;
        }
    }
    Ok(Report {
        device: device.info().name.clone(),
        driver: device.info().driver.clone(),
        commit: env!("BOXWOOD_COMMIT"),
        runs: plan.runs,
        size: plan.size,
        coverage: plan.coverage,
        scenes: cases.into_iter().map(|case| case.report()).collect(),
    })
}

/// Steps that [`run`] takes.
pub fn steps(scenes: usize, plan: &Plan) -> usize {
    scenes * (1 + plan.runs)
}

/// A scene, and what has been found.
struct Case<'s> {
    scene: &'s Scene,
    buffers: SceneBuffers,
    bounds: Aabb,
    view: View,
    scratch_bytes: u64,
    bvh_bytes: u64,
    tree: Stats,
    tree_hash: String,
    kernels: Vec<KernelTime>,
    build_ms: Vec<f64>,
    build_wall_ms: Vec<f64>,
    sets: Vec<Set>,
}

/// A kind of rays in a scene.
struct Set {
    kind: RayKind,
    options: Options,
    rays: usize,
    hits: usize,
    tests: TestTotals,
    check: Option<Verdict>,
    trace_ms: Vec<f64>,
}

/// What to trace a kind of rays with, untried.
fn untried(device: &Device, kind: RayKind) -> Options {
    let query = if matches!(kind, RayKind::Ao | RayKind::Shadow) { Query::Any } else { Query::Closest };
    let walk = Walk::untried(device, kind == RayKind::Primary);
    Options { query, precision: Precision::Robust, walk, order: RayOrder::AsGiven }
}

/// The device and the memory for rays that all scenes share.
struct Bench<'a> {
    device: &'a Arc<Device>,
    plan: &'a Plan,
    primaries: Batch,
    secondaries: Batch,
    pace: Pace,
}

impl<'a> Bench<'a> {
    fn new(device: &'a Arc<Device>, plan: &'a Plan) -> Result<Self> {
        let pixels = plan.size[0] as usize * plan.size[1] as usize;
        let pace = Pace::default();
        let room = match plan.coverage {
            Coverage::All if device.info().is_cpu() => BATCH,
            Coverage::All => pace.chunk(),
            Coverage::Spans { rays, .. } => rays,
        };
        let primaries = Batch::new(device, pixels, false)?;
        Ok(Self { device, plan, primaries, secondaries: Batch::new(device, room, false)?, pace })
    }

    /// Everything about a scene that is measured once.
    fn survey<'s>(&mut self, scene: &'s Scene) -> Result<Case<'s>> {
        let device = self.device;
        let buffers = SceneBuffers::upload(device, scene)?;
        let recipe = &self.plan.recipe;
        warm_up(|| build(device, &buffers, recipe, Timing::Outer).map(|b| b.times.device_ms))?;
        let built = build(device, &buffers, &self.plan.recipe, Timing::Kernels)?;
        let Built { bvh, times, scratch_bytes, .. } = &built;
        let tree = bvh.read()?;
        let stats = validate(scene, &tree, &Claims::of(bvh, self.plan.recipe.collapse))
            .map_err(|source| super::BenchError::Tree { scene: scene.name.clone(), source })?;
        let [width, height] = self.plan.size;
        let mut case = Case {
            scene,
            buffers,
            bounds: scene.bounds(),
            view: View { camera: scene.view(), width, height },
            scratch_bytes: *scratch_bytes,
            bvh_bytes: bvh.bytes(),
            tree: stats,
            tree_hash: tree.hash(),
            kernels: by_kernel(&times.passes),
            build_ms: vec![],
            build_wall_ms: vec![],
            sets: vec![],
        };
        primary(device, &case.view, &mut self.primaries, Timing::Off)?;
        trace(device, bvh, &self.primaries, untried(device, RayKind::Primary), Timing::Off)?;
        let reference = match self.plan.checking {
            Checking::Off => None,
            Checking::Sample { .. } => Some(Reference::new(scene)),
        };
        for kind in self.plan.kinds.clone() {
            let set = self.survey_set(&case, bvh, kind, reference.as_ref())?;
            case.sets.push(set);
        }
        Ok(case)
    }

    /// Counts and checks the rays of one kind, which warms up as well.
    fn survey_set(
        &mut self,
        case: &Case,
        bvh: &Bvh,
        kind: RayKind,
        reference: Option<&Reference>,
    ) -> Result<Set> {
        let device = self.device;
        self.find_pace(case, bvh, kind)?;
        let mut options = untried(device, kind);
        // Primary rays are in order as they come.
        let orders = if kind == RayKind::Primary { &[RayOrder::AsGiven][..] } else { &RayOrder::ALL };
        let mut chosen = false;
        let mut set = Set {
            kind,
            options,
            rays: 0,
            hits: 0,
            tests: TestTotals::default(),
            check: None,
            trace_ms: vec![],
        };
        let sample = match self.plan.checking {
            Checking::Off => 0,
            Checking::Sample { rays } => rays,
        };
        let parts = match (kind, self.plan.coverage) {
            (RayKind::Primary, _) => 1,
            (_, Coverage::Spans { count, .. }) => count,
            // As many as there would be if every primary hit.
            (_, Coverage::All) => {
                (self.primaries.count * SAMPLES as usize).div_ceil(self.secondaries.rays.len())
            }
        };
        let (mut rays, mut hits): (Vec<Ray>, Vec<Hit>) = (vec![], vec![]);
        self.each_batch(case, bvh, kind, |batch| {
            if !chosen {
                options = fastest_walk(device, bvh, batch, options, orders)?.options;
                warm_up(|| trace(device, bvh, batch, options, Timing::Outer).map(|times| times.device_ms))?;
                chosen = true;
            }
            // Each ray alone: what the tree costs, whichever walk is fastest.
            batch.tests = Some(Buffer::new(device, "trace.tests", batch.rays.len())?);
            trace(
                device,
                bvh,
                batch,
                Options { walk: Walk::Single, order: RayOrder::AsGiven, ..options },
                Timing::Off,
            )?;
            set.tests.add(batch)?;
            batch.tests = None;
            trace(device, bvh, batch, options, Timing::Off)?;
            let found = batch.hits.read_first(batch.count)?;
            set.rays += found.len();
            set.hits += found.iter().filter(|h| h.is_hit()).count();
            let stride = (batch.count * parts).div_ceil(sample.max(1)).max(1);
            if rays.len() < sample {
                rays.extend(batch.rays.read_first(batch.count)?.iter().step_by(stride));
                hits.extend(found.iter().step_by(stride));
            }
            Ok(())
        })?;
        set.options = options;
        set.check = reference.map(|reference| {
            let query = match options.query {
                Query::Closest => compare::Query::Closest,
                Query::Any => compare::Query::Any,
            };
            compare(reference, &rays, &hits, query).sample_brute(reference, &rays, BRUTE_RAYS)
        });
        Ok(set)
    }

    /// On a GPU that is to trace all secondary rays: makes batches as large as it traces in half a second.
    fn find_pace(&mut self, case: &Case, bvh: &Bvh, kind: RayKind) -> Result<()> {
        let Some(rays) = kind.secondary(&case.bounds) else { return Ok(()) };
        if self.device.info().is_cpu() || self.plan.coverage != Coverage::All {
            return Ok(());
        }
        secondary(self.device, &case.buffers, &self.primaries, &rays, 0, &mut self.secondaries, Timing::Off)?;
        if self.secondaries.count > 0 {
            let times =
                trace(self.device, bvh, &self.secondaries, untried(self.device, kind), Timing::Outer)?;
            self.pace.learn(self.secondaries.count, &times);
        }
        if self.pace.chunk() != self.secondaries.rays.len() {
            self.secondaries = Batch::new(self.device, self.pace.chunk(), false)?;
        }
        Ok(())
    }

    /// Gives `each` the batches of one kind, rays made but not traced. Primaries are there and traced.
    fn each_batch(
        &mut self,
        case: &Case,
        bvh: &Bvh,
        kind: RayKind,
        mut each: impl FnMut(&mut Batch) -> Result<()>,
    ) -> Result<()> {
        let Some(rays) = kind.secondary(&case.bounds) else { return each(&mut self.primaries) };
        debug_assert_eq!(bvh.triangle_count as usize + bvh.left_out as usize, case.scene.triangles.len());
        let pixels = self.primaries.count;
        match self.plan.coverage {
            Coverage::All => {
                let mut start = 0;
                while start < pixels {
                    start += self.leave(case, &rays, start)?.max(1);
                    if self.secondaries.count > 0 {
                        each(&mut self.secondaries)?;
                    }
                }
            }
            Coverage::Spans { count, .. } => {
                for span in 0..count {
                    self.leave(case, &rays, span * pixels / count)?;
                    if self.secondaries.count > 0 {
                        each(&mut self.secondaries)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Makes the secondary rays of the primaries from `start` on; returns how many primaries it took.
    fn leave(&mut self, case: &Case, rays: &Secondary, start: usize) -> Result<usize> {
        let (from, to) = (&self.primaries, &mut self.secondaries);
        Ok(secondary(self.device, &case.buffers, from, rays, start, to, Timing::Off)?.0)
    }

    /// Builds a scene and traces its rays once.
    fn round(&mut self, case: &mut Case) -> Result<()> {
        let device = self.device;
        let built = build(device, &case.buffers, &self.plan.recipe, Timing::Outer)?;
        case.build_ms.push(built.times.device_ms);
        case.build_wall_ms.push(built.wall_ms);
        let bvh = &built.bvh;
        primary(device, &case.view, &mut self.primaries, Timing::Off)?;
        let primaries = case.sets.iter().find(|set| set.kind == RayKind::Primary);
        let options = primaries.map_or(untried(device, RayKind::Primary), |set| set.options);
        let first = trace(device, bvh, &self.primaries, options, Timing::Outer)?;
        for i in 0..case.sets.len() {
            let Set { kind, options, .. } = case.sets[i];
            let mut ms = 0.0;
            match kind {
                RayKind::Primary => ms = first.device_ms,
                RayKind::Ao | RayKind::Diffuse | RayKind::Shadow => {
                    self.each_batch(case, bvh, kind, |batch| {
                        ms += trace(device, bvh, batch, options, Timing::Outer)?.device_ms;
                        Ok(())
                    })?
                }
            }
            case.sets[i].trace_ms.push(ms);
        }
        Ok(())
    }
}

impl Case<'_> {
    fn report(self) -> SceneReport {
        let set = |s: Set| {
            let trace_ms = Spread::of(&s.trace_ms);
            let rays = s.rays.max(1) as f64;
            SetReport {
                kind: s.kind,
                kernel: s.options.walk.kernel_name(),
                rays: s.rays,
                hits: s.hits,
                trace_ms,
                mrays_s: trace_ms.rate(s.rays),
                boxes_per_ray: s.tests.boxes as f64 / rays,
                triangles_per_ray: s.tests.triangles as f64 / rays,
                check: s.check,
            }
        };
        SceneReport {
            scene: self.scene.name.clone(),
            triangles: self.scene.triangles.len(),
            build_ms: Spread::of(&self.build_ms),
            build_wall_ms: Spread::of(&self.build_wall_ms),
            bvh_bytes: self.bvh_bytes,
            scratch_bytes: self.scratch_bytes,
            tree: self.tree,
            tree_hash: self.tree_hash,
            kernels: self.kernels,
            sets: self.sets.into_iter().map(set).collect(),
        }
    }
}
