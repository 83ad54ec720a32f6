//! Rays of the benchmark: the sets of one view of a scene, traced through every contender's tree in turn.

use super::kernels::add_kernels;
use super::plan::Key;
use super::run::{Progress, Stage};
use super::stats::{enough, warm_up};
use super::traces::Pace;
use super::tree::Tree;
use super::{Check, Contender, Coverage, KernelTime, Plan, RayKind, RayRow, RaySet, Result, Rows, Spread};
use crate::abi::{Hit, Ray};
use crate::bvh::Bvh;
use crate::device::{Buffer, Device, Timing};
use crate::oracle::compare::{self, Arithmetic, compare};
use crate::oracle::reference::Reference;
use crate::trace::rays::{SAMPLES, Secondary, View, primary, secondary};
use crate::trace::{BATCH, Batch, Boxes, Options, Precision, Query, RayOrder, Walk, trace};
use std::collections::HashMap;
use std::sync::Arc;

/// Rays of each set on which the reference itself is held against brute force.
const BRUTE_RAYS: usize = 16;

/// The memory for rays that all scenes share.
pub(super) struct Rays<'a> {
    device: &'a Arc<Device>,
    plan: &'a Plan,
    primaries: Batch,
    /// Secondary rays, and those of files.
    others: Batch,
    pace: Pace,
    /// How a contender traces a set of the scene at hand: found at the first view.
    chosen: HashMap<(String, usize, String), Options>,
}

/// A set of rays that some contenders still have to trace.
struct Open<'p> {
    set: &'p RaySet,
    cells: Vec<Cell>,
    /// Rays to be checked.
    sample: Vec<Ray>,
}

/// A contender's part in a set.
struct Cell {
    contender: usize,
    options: Options,
    row: RayRow,
    /// Hits of the rays to be checked.
    sample: Vec<Hit>,
    trace_ms: Vec<f64>,
}

/// What to trace a set with, untried.
fn untried(device: &Device, set: &RaySet) -> Options {
    let (query, coherent) = match set {
        RaySet::Made(kind) => (kind.query(), *kind == RayKind::Primary),
        RaySet::Aimed(_) => (Query::Closest, false),
        RaySet::File(file) => (file.query, false),
    };
    Options {
        query,
        precision: Precision::Robust,
        walk: Walk::untried(device, coherent),
        order: RayOrder::AsGiven,
        boxes: Boxes::Mixed,
    }
}

impl<'a> Rays<'a> {
    pub(super) fn new(device: &'a Arc<Device>, plan: &'a Plan) -> Result<Self> {
        let pace = Pace::default();
        let room = match plan.coverage {
            Coverage::All if device.info().is_cpu() => BATCH,
            Coverage::All => pace.chunk(),
            Coverage::Spans { rays, .. } => rays.max(SAMPLES as usize),
        };
        let primaries = Batch::new(device, plan.size[0] as usize * plan.size[1] as usize, false)?;
        let others = Batch::new(device, room, false)?;
        Ok(Self { device, plan, primaries, others, pace, chosen: HashMap::new() })
    }

    /// Traces what `rows` lacks of a view, from 1; of view 0, the rays of files.
    pub(super) fn trace_view(
        &mut self,
        stage: &Stage,
        view: usize,
        rows: &mut Rows,
        progress: Progress,
    ) -> Result<()> {
        let mut open = self.missing(stage, view, rows);
        if open.is_empty() {
            return Ok(());
        }
        if view > 0 {
            self.look(stage, view)?;
        }
        for set in &mut open {
            progress(&format!("{}: view {view}, {}: warming up, checking", stage.spec, set.set), rows);
            self.survey(stage, set)?;
        }
        while !open.is_empty() {
            for set in &mut open {
                progress(&format!("{}: view {view}, {}", stage.spec, set.set), rows);
                self.round(stage, set)?;
                let cells = std::mem::take(&mut set.cells);
                let (done, going) = cells.into_iter().partition(|c| enough(self.plan.runs, &c.trace_ms));
                set.cells = going;
                for Cell { row, trace_ms, .. } in done {
                    rows.push_rays(RayRow { trace_ms: Spread::of(&trace_ms), ..row })?;
                }
            }
            open.retain(|set| !set.cells.is_empty());
        }
        Ok(())
    }

    /// Sets of a view, and the contenders whose rows are missing.
    fn missing(&self, stage: &Stage, view: usize, rows: &Rows) -> Vec<Open<'a>> {
        let plan = self.plan;
        let sets = plan.rays.iter().filter(|set| set.is_of_views() == (view > 0));
        let cells = |set: &RaySet| {
            let key = |builder: &str| Key {
                scene: stage.spec.to_owned(),
                builder: builder.to_owned(),
                rays: Some((view, set.to_string())),
            };
            let contenders = plan.contenders_of(stage.spec).iter().enumerate();
            let missing = contenders.filter(|(_, c)| !rows.has(&key(&c.name)));
            let options = untried(self.device, set);
            let cell = |(contender, c): (usize, &Contender)| {
                let options = Options { precision: c.precision, ..options };
                Cell::new(stage.spec, &c.name, contender, view, set, options)
            };
            missing.map(cell).collect()
        };
        let open = sets.map(|set| Open { set, cells: cells(set), sample: vec![] });
        open.filter(|set| !set.cells.is_empty()).collect()
    }

    /// Makes the primary rays of a view and finds what they hit: any tree tells the same.
    fn look(&mut self, stage: &Stage, view: usize) -> Result<()> {
        let [width, height] = self.plan.size;
        let camera = stage.scene.views_or_default()[view - 1];
        primary(self.device, &View { camera, width, height }, &mut self.primaries, Timing::Off)?;
        let options = untried(self.device, &RaySet::Made(RayKind::Primary));
        stage.trees[stage.lookout].trace(self.device, &self.primaries, options, Timing::Off)?;
        Ok(())
    }

    /// Counts and checks the rays of a set, which warms up as well.
    fn survey(&mut self, stage: &Stage, open: &mut Open) -> Result<()> {
        let device = self.device;
        self.find_pace(stage, open)?;
        let wanted = self.plan.check;
        let parts = self.parts(open.set);
        let mut chosen = std::mem::take(&mut self.chosen);
        let warm_ups = self.plan.warm_ups;
        // Primary rays are in order as they come.
        let primary = matches!(open.set, RaySet::Made(RayKind::Primary));
        let orders = if primary { &[RayOrder::AsGiven][..] } else { self.plan.orders };
        let mut first = true;
        self.each_batch(stage, open.set, |batch| {
            let stride = (batch.count * parts).div_ceil(wanted.max(1)).max(1);
            let sampled = open.sample.len() < wanted;
            if sampled {
                open.sample.extend(batch.rays.read_first(batch.count)?.iter().step_by(stride));
            }
            for cell in &mut open.cells {
                let tree = &stage.trees[cell.contender];
                if first {
                    let key = (stage.spec.to_owned(), cell.contender, open.set.to_string());
                    cell.options = match chosen.get(&key) {
                        Some(options) => *options,
                        None => tree.fastest(device, batch, cell.options, orders)?,
                    };
                    chosen.insert(key, cell.options);
                    let once = || tree.trace(device, batch, cell.options, Timing::Outer);
                    warm_up(warm_ups, || once().map(|times| times.device_ms))?;
                }
                let found = cell.count(device, tree, batch)?;
                if sampled {
                    cell.sample.extend(found.iter().step_by(stride));
                }
            }
            first = false;
            Ok(())
        })?;
        self.chosen = chosen;
        for cell in &mut open.cells {
            let tree = &stage.trees[cell.contender];
            cell.row.kernel = tree.kernel_name(&cell.options).to_owned();
            cell.row.sorted = cell.options.order == RayOrder::Sorted;
            if let Tree::Packed(_) = tree {
                cell.row.boxes = Some(cell.options.boxes.name().to_owned());
            }
            cell.row.cost_per_ray = cell.row.tests.map(|t| stage.costs.per_ray(&t, cell.row.rays));
            cell.row.check = stage.reference.as_ref().map(|reference| {
                let claimed = tree.arithmetic(&cell.options);
                Check::from(&judge(reference, &open.sample, &cell.sample, cell.options.query, claimed))
            });
        }
        Ok(())
    }

    /// Batches that a set comes in, about.
    fn parts(&self, set: &RaySet) -> usize {
        match (set, self.plan.coverage) {
            (RaySet::Made(RayKind::Primary), _) => 1,
            (RaySet::Aimed(_), _) => self.plan.aimed.div_ceil(self.others.rays.len()).max(1),
            (RaySet::File(file), _) => file.rays.len().div_ceil(self.others.rays.len()).max(1),
            (_, Coverage::Spans { count, .. }) => count,
            // As many as there would be if every primary hit.
            (_, Coverage::All) => (self.primaries.count * SAMPLES as usize).div_ceil(self.others.rays.len()),
        }
    }

    /// Traces a set once with each contender that isn't done with it.
    fn round(&mut self, stage: &Stage, open: &mut Open) -> Result<()> {
        let device = self.device;
        let mut ms = vec![0.0; open.cells.len()];
        self.each_batch(stage, open.set, |batch| {
            for (cell, ms) in open.cells.iter().zip(&mut ms) {
                let tree = &stage.trees[cell.contender];
                *ms += tree.trace(device, batch, cell.options, Timing::Outer)?.device_ms;
            }
            Ok(())
        })?;
        for (cell, ms) in open.cells.iter_mut().zip(ms) {
            cell.trace_ms.push(ms);
        }
        Ok(())
    }

    /// On a GPU that is to trace all secondary rays: makes batches as large as it traces in half a second.
    fn find_pace(&mut self, stage: &Stage, open: &Open) -> Result<()> {
        let RaySet::Made(kind) = open.set else { return Ok(()) };
        let Some(rays) = kind.secondary(&stage.scene.bounds()) else { return Ok(()) };
        if self.device.info().is_cpu() || self.plan.coverage != Coverage::All {
            return Ok(());
        }
        self.leave(stage, &rays, 0)?;
        if self.others.count > 0 {
            let options = untried(self.device, open.set);
            let once = |tree: &Tree| tree.trace(self.device, &self.others, options, Timing::Outer);
            let times = stage.trees.iter().map(once).collect::<crate::device::Result<Vec<_>>>()?;
            // None may take too long.
            if let Some(slowest) = times.iter().max_by(|a, b| a.device_ms.total_cmp(&b.device_ms)) {
                self.pace.learn(self.others.count, slowest);
            }
        }
        if self.pace.chunk() != self.others.rays.len() {
            self.others = Batch::new(self.device, self.pace.chunk(), false)?;
        }
        Ok(())
    }

    /// Gives `each` the batches of a set, rays made but not traced. Primaries are there and traced.
    fn each_batch(
        &mut self,
        stage: &Stage,
        set: &RaySet,
        mut each: impl FnMut(&mut Batch) -> Result<()>,
    ) -> Result<()> {
        let kind = match set {
            RaySet::Made(kind) => kind,
            RaySet::Aimed(aimed) => {
                return self.each_part(&aimed.rays(stage.scene, self.plan.aimed), each);
            }
            RaySet::File(file) => return self.each_part(&file.rays, each),
        };
        let Some(rays) = kind.secondary(&stage.scene.bounds()) else { return each(&mut self.primaries) };
        let pixels = self.primaries.count;
        match self.plan.coverage {
            Coverage::All => {
                let mut start = 0;
                while start < pixels {
                    start += self.leave(stage, &rays, start)?.max(1);
                    if self.others.count > 0 {
                        each(&mut self.others)?;
                    }
                }
            }
            Coverage::Spans { count, .. } => {
                for span in 0..count {
                    self.leave(stage, &rays, span * pixels / count)?;
                    if self.others.count > 0 {
                        each(&mut self.others)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Gives `each` batches of rays that the host has.
    fn each_part(&mut self, rays: &[Ray], mut each: impl FnMut(&mut Batch) -> Result<()>) -> Result<()> {
        for part in rays.chunks(self.others.rays.len()) {
            self.others.set(part)?;
            each(&mut self.others)?;
        }
        Ok(())
    }

    /// Makes the secondary rays of the primaries from `start` on; returns how many primaries it took.
    fn leave(&mut self, stage: &Stage, rays: &Secondary, start: usize) -> Result<usize> {
        let (from, to) = (&self.primaries, &mut self.others);
        Ok(secondary(self.device, &stage.buffers, from, rays, start, to, Timing::Off)?.0)
    }
}

impl Cell {
    fn new(
        scene: &str,
        builder: &str,
        contender: usize,
        view: usize,
        set: &RaySet,
        options: Options,
    ) -> Self {
        let row = RayRow {
            scene: scene.to_owned(),
            builder: builder.to_owned(),
            view,
            set: set.to_string(),
            kernel: String::new(),
            sorted: false,
            boxes: None,
            precision: options.precision.name().to_owned(),
            rays: 0,
            hits: 0,
            trace_ms: Spread::default(),
            tests: None,
            cost_per_ray: None,
            kernels: Vec::<KernelTime>::new(),
            check: None,
        };
        Self { contender, options, row, sample: vec![], trace_ms: vec![] }
    }

    /// Traces a batch twice, with tests counted, where they can be, and with a stamp a kernel; returns its hits.
    fn count(&mut self, device: &Arc<Device>, tree: &Tree, batch: &mut Batch) -> Result<Vec<Hit>> {
        if let Tree::Packed(bvh) = tree {
            self.count_tests(device, bvh, batch)?;
        }
        let times = tree.trace(device, batch, self.options, Timing::Kernels)?;
        add_kernels(&mut self.row.kernels, &times.passes);
        let found = batch.hits.read_first(batch.count)?;
        self.row.rays += found.len();
        self.row.hits += found.iter().filter(|h| h.is_hit()).count();
        Ok(found)
    }

    fn count_tests(&mut self, device: &Arc<Device>, bvh: &Bvh, batch: &mut Batch) -> Result<()> {
        // Each ray alone: what the tree costs, whichever walk is fastest.
        batch.tests = Some(Buffer::new(device, "trace.tests", batch.rays.len())?);
        let alone = Options { walk: Walk::Single, order: RayOrder::AsGiven, ..self.options };
        trace(device, bvh, batch, alone, Timing::Off)?;
        self.row.tests.get_or_insert_default().add(batch)?;
        batch.tests = None;
        Ok(())
    }
}

fn judge(
    reference: &Reference,
    rays: &[Ray],
    hits: &[Hit],
    query: Query,
    claimed: Arithmetic,
) -> compare::Verdict {
    let query = match query {
        Query::Closest => compare::Query::Closest,
        Query::Any => compare::Query::Any,
    };
    compare(reference, rays, hits, query, claimed).sample_brute(reference, rays, BRUTE_RAYS)
}
