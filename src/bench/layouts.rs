//! Node layouts against each other: rays through the packed tree and through binary trees of the same leaves, in turn.

use super::stats::{WARM_UPS, warm_up};
use super::{Coverage, RayKind, Result, Spread, TestTotals};
use crate::abi::{Hit, Ray};
use crate::bvh::{Bvh, Fit, Recipe, SceneBuffers, build, stages};
use crate::device::{Device, Timing};
use crate::oracle::layouts::BinaryTree;
use crate::scene::Scene;
use crate::trace::layouts::{Binary, Layout};
use crate::trace::rays::{View, primary, secondary};
use crate::trace::{Batch, Options, Query, Walk, trace};
use std::sync::Arc;

/// A tree in one of the layouts.
#[derive(Debug)]
struct Contender<'a> {
    name: &'static str,
    nodes: usize,
    bytes: u64,
    /// With the triangles; a packed contender's nodes as well.
    bvh: &'a Bvh,
    binary: Option<Binary>,
}

/// What a layout's nodes take.
#[derive(Debug, Clone, serde::Serialize)]
pub struct LayoutSize {
    /// Which.
    pub layout: &'static str,
    /// Nodes.
    pub nodes: usize,
    /// Bytes of all nodes.
    pub bytes: u64,
    /// Corners of triangles outside a box above them: 0, or the layout is not sound. Of the binary ones; packed trees are
    /// `boxwood build --check`'s.
    pub outside: Option<usize>,
}

/// How a layout does with one kind of rays.
#[derive(Debug, Clone, serde::Serialize)]
pub struct LayoutRow {
    /// Which.
    pub layout: &'static str,
    /// Kind of rays.
    pub rays: &'static str,
    /// How many.
    pub count: usize,
    /// Tests of all of them.
    #[serde(flatten)]
    pub tests: TestTotals,
    /// Device time of one run, ms.
    pub trace_ms: Spread,
    /// Time of the default's over its own, medians.
    pub speed: f64,
    /// Hits that are not those of the default, bit for bit: 0, or something is wrong.
    pub differing: usize,
}

/// Node layouts of one scene, measured; the first is the default.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Layouts {
    /// One a layout.
    pub sizes: Vec<LayoutSize>,
    /// One a kind of rays and layout.
    pub rows: Vec<LayoutRow>,
}

/// What to measure layouts with.
#[derive(Debug, Clone)]
pub struct LayoutPlan {
    /// How to build; the binary trees are of the same builder.
    pub recipe: Recipe,
    /// Primary rays, and where secondary ones leave from.
    pub view: View,
    /// Kinds of rays.
    pub kinds: Vec<RayKind>,
    /// Secondary rays of a kind at most.
    pub sample: usize,
    /// Timed runs of each, in turn.
    pub runs: usize,
}

/// Measures every layout over `scene`. `progress` is told what is being done.
///
/// # Errors
/// A failed build or trace.
pub fn measure_layouts(
    device: &Arc<Device>,
    scene: &Scene,
    plan: &LayoutPlan,
    progress: &dyn Fn(&str),
) -> Result<Layouts> {
    progress("building");
    let buffers = SceneBuffers::upload(device, scene)?;
    let packed = build(device, &buffers, &plan.recipe, Timing::Off)?.bvh;
    // The same binary tree: fits come after it.
    let (plain, stages) = stages(device, &buffers, &Recipe { fit: Fit::Aabb, ..plan.recipe })?;
    let plain = plain.bvh;
    progress("fitting boxes on the host");
    let tree = BinaryTree::new(&stages, &plain.read()?, plain.anchor, plain.reach);
    let mut contenders = vec![Contender::packed("packed", &packed)];
    if plan.recipe.fit != Fit::Aabb {
        contenders.push(Contender::packed("packed-aabb", &plain));
    }
    let mut outside = vec![None; contenders.len()];
    for layout in Layout::ALL {
        let made = tree.packed(layout, &plan.recipe);
        outside.push(Some(tree.outside(&made)));
        contenders.push(Contender::binary(layout.name(), &plain, Binary::upload(device, &made)?));
    }
    let sizes = contenders.iter().zip(outside).map(|(c, outside)| LayoutSize {
        layout: c.name,
        nodes: c.nodes,
        bytes: c.bytes,
        outside,
    });
    let mut layouts = Layouts { sizes: sizes.collect(), rows: vec![] };
    for kind in &plan.kinds {
        progress(&format!("{} rays", kind.name()));
        let rays = rays(device, scene, &buffers, &plain, plan, *kind)?;
        layouts.rows.extend(race(device, &contenders, *kind, &rays, plan.runs)?);
    }
    Ok(layouts)
}

impl<'a> Contender<'a> {
    fn packed(name: &'static str, bvh: &'a Bvh) -> Self {
        Self { name, nodes: bvh.nodes.len(), bytes: bvh.nodes.bytes(), bvh, binary: None }
    }

    fn binary(name: &'static str, bvh: &'a Bvh, binary: Binary) -> Self {
        Self { name, nodes: binary.nodes(), bytes: binary.bytes(), bvh, binary: Some(binary) }
    }

    /// Traces `batch`, each ray alone; device time, ms.
    fn trace(&self, device: &Arc<Device>, batch: &Batch, query: Query) -> Result<f64> {
        let options = Options { query, walk: Walk::Single, ..Options::default() };
        let times = match &self.binary {
            None => trace(device, self.bvh, batch, options, Timing::Outer)?,
            Some(binary) => binary.trace(device, self.bvh, batch, options, Timing::Outer)?,
        };
        Ok(times.device_ms)
    }
}

/// The rays of a kind: all primaries of the view, or a sample of the secondaries that leave them.
fn rays(
    device: &Arc<Device>,
    scene: &Scene,
    buffers: &SceneBuffers,
    bvh: &Bvh,
    plan: &LayoutPlan,
    kind: RayKind,
) -> Result<Vec<Ray>> {
    let mut primaries = Batch::new(device, plan.view.pixels(), false)?;
    primary(device, &plan.view, &mut primaries, Timing::Off)?;
    let Some(leaving) = kind.secondary(&scene.bounds()) else { return Ok(primaries.rays.read()?) };
    trace(device, bvh, &primaries, Options::default(), Timing::Off)?;
    let (places, most) = match Coverage::sample(plan.sample) {
        Coverage::Spans { count, rays } => (count, rays.max(leaving.samples as usize)),
        Coverage::All => (1, primaries.count * leaving.samples as usize),
    };
    let mut part = Batch::new(device, most, false)?;
    let mut rays = vec![];
    for place in 0..places {
        let start = place * primaries.count / places;
        secondary(device, buffers, &primaries, &leaving, start, &mut part, Timing::Off)?;
        rays.extend(part.rays.read_first(part.count)?);
    }
    Ok(rays)
}

/// Traces `rays` through all contenders in turn.
fn race(
    device: &Arc<Device>,
    contenders: &[Contender<'_>],
    kind: RayKind,
    rays: &[Ray],
    runs: usize,
) -> Result<Vec<LayoutRow>> {
    // A view of nothing leaves no ray.
    if rays.is_empty() {
        return Ok(vec![]);
    }
    let query = kind.query();
    let mut counting = Batch::new(device, rays.len(), true)?;
    counting.set(rays)?;
    let mut surveys = vec![];
    for contender in contenders {
        contender.trace(device, &counting, query)?;
        let mut tests = TestTotals::default();
        tests.add(&counting)?;
        surveys.push((tests, counting.hits.read_first(rays.len())?));
    }
    let mut batch = counting;
    batch.tests = None;
    for contender in contenders {
        warm_up(WARM_UPS, || contender.trace(device, &batch, query))?;
    }
    let mut times = vec![vec![]; contenders.len()];
    for _ in 0..runs {
        for (contender, times) in contenders.iter().zip(&mut times) {
            times.push(contender.trace(device, &batch, query)?);
        }
    }
    let times: Vec<Spread> = times.iter().map(|times| Spread::of(times)).collect();
    let row =
        |(contender, (trace_ms, (tests, hits))): (&Contender<'_>, (&Spread, &(TestTotals, Vec<Hit>)))| {
            let differ = |(a, b): &(&Hit, &Hit)| bytemuck::bytes_of(*a) != bytemuck::bytes_of(*b);
            LayoutRow {
                layout: contender.name,
                rays: kind.name(),
                count: rays.len(),
                tests: *tests,
                trace_ms: *trace_ms,
                speed: if trace_ms.median > 0.0 { times[0].median / trace_ms.median } else { 0.0 },
                differing: hits.iter().zip(&surveys[0].1).filter(differ).count(),
            }
        };
    Ok(contenders.iter().zip(times.iter().zip(&surveys)).map(row).collect())
}
