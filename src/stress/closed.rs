//! Rays from within closed meshes, aimed where triangles meet: none may get out. What each must hit is known from how the
//! mesh was made, and a share of them the f64 reference judges besides.

mod blocks;
mod shots;
mod solids;

pub use shots::Kind;
pub use solids::Solid;

use self::shots::{Shot, Shots};
use crate::abi::{Hit, INVALID, Ray};
use crate::bvh::{self, BuildError, Bvh, Fit, Method, Recipe, SceneBuffers};
use crate::device::{Device, DeviceError, Timing};
use crate::oracle::compare::{self, Arithmetic, compare};
use crate::oracle::reference::Reference;
use crate::trace::rays::mixed;
use crate::trace::{Batch, Boxes, Options, Precision, Query, RayOrder, Walk, trace};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;

/// Rays of a submit: no watchdog ends so few.
const CHUNK: usize = 1 << 17;
/// One in so many rays is judged by the reference as well.
const JUDGED: usize = 16;
/// Faulty rays that a row keeps.
const EXAMPLES: usize = 3;

/// What to trace.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Rays in all, dealt out evenly.
    pub rays: u64,
    /// Through the trees of these. Where boxes are turned, they are at any gain in area: more of them are tested.
    pub builders: Vec<Method>,
    /// Other numbers, other rays.
    pub seed: u64,
    /// Within these.
    pub solids: Vec<Solid>,
    /// By this triangle test.
    pub precision: Precision,
}

/// How a ray can be wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Fault {
    /// It hits nothing.
    Miss,
    /// It hits behind the surface around it.
    Leak,
    /// It hits before that, or no query could have written the record.
    Other,
}

/// A faulty ray.
#[derive(Debug, Clone, Serialize)]
pub struct Example {
    /// What was wrong.
    pub fault: Fault,
    /// Kernel, query, order and boxes.
    pub way: String,
    /// Origin, t_min, direction, t_max.
    pub ray: [f32; 8],
    /// What was told: t, not finite is `null` in JSON.
    pub t: f32,
    /// And the triangle.
    pub triangle: u32,
    /// Between these t lies the surface; infinite where it isn't known, `null` in JSON.
    pub surface: [f64; 2],
}

/// Rays of a kind from within a solid, through one tree.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The solid.
    pub mesh: &'static str,
    /// Its triangles.
    pub triangles: usize,
    /// The builder, as typed.
    pub builder: &'static str,
    /// Nodes of the tree, and those of them that are oriented.
    pub nodes: usize,
    /// Likewise.
    pub oriented: u32,
    /// The kind.
    pub kind: Kind,
    /// Rays.
    pub rays: u64,
    /// Rays that hit nothing.
    pub misses: u64,
    /// Rays that hit behind the surface.
    pub leaks: u64,
    /// Rays with another fault.
    pub others: u64,
    /// Rays that the f64 reference judged.
    pub judged: u64,
    /// Those of them that it contradicts, rounding no excuse.
    pub contradicted: u64,
    /// Device time, ms, without copies.
    pub device_ms: f64,
    /// The first faulty rays.
    pub examples: Vec<Example>,
}

impl Row {
    /// Rays with any fault.
    pub fn faults(&self) -> u64 {
        self.misses + self.leaks + self.others + self.contradicted
    }

    /// Millions of rays a second of device time.
    pub fn mrays_s(&self) -> f64 {
        if self.device_ms > 0.0 { self.rays as f64 / self.device_ms / 1e3 } else { 0.0 }
    }
}

/// A run that can't be done.
#[derive(Debug, thiserror::Error)]
pub enum ClosedError {
    /// A build failed.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The rays would prove nothing of oriented boxes.
    #[error("no node of the tree of {builder} over the {solid} is oriented: the rays would prove nothing")]
    NotOriented {
        /// Which builder.
        builder: &'static str,
        /// Which mesh.
        solid: &'static str,
    },
}

/// What a run tells while it goes on.
#[derive(Debug)]
pub enum Step<'a> {
    /// So many more rays are done.
    Traced(u64),
    /// A row is done: all rows so far, it last.
    Done(&'a [Row]),
}

/// Result of a run.
pub type Result<T> = std::result::Result<T, ClosedError>;

/// Traces what `plan` says, every walk in turn; a row a solid, builder and kind.
///
/// # Errors
/// [`ClosedError`]. Rays that get out are none: see [`Row::faults`].
pub fn run(device: &Arc<Device>, plan: &Plan, told: &dyn Fn(Step)) -> Result<Vec<Row>> {
    let count = (plan.solids.len() * plan.builders.len() * Kind::ALL.len()) as u64;
    let mut batch = Batch::new(device, CHUNK, false)?;
    let mut rows = vec![];
    for solid in &plan.solids {
        let buffers = SceneBuffers::upload(device, &solid.scene)?;
        let reference = Reference::new(&solid.scene);
        for method in &plan.builders {
            let bvh = bvh::build(device, &buffers, &recipe(method), Timing::Off)?.bvh;
            if solid.turned && method.fit != Fit::Aabb && bvh.oriented == 0 {
                return Err(ClosedError::NotOriented { builder: method.name, solid: solid.name });
            }
            warm_up(device, &bvh, plan.precision, &mut batch)?;
            for kind in Kind::ALL {
                let at = rows.len() as u64;
                let rays = plan.rays / count + u64::from(at < plan.rays % count);
                let mut row = Row::new(solid, method, &bvh, kind);
                let shots = Shots::new(solid, kind, mixed(plan.seed ^ mixed(at)));
                let run = Run { device, bvh: &bvh, reference: &reference, shots, told };
                run.fill(&mut row, rays, plan.precision, &mut batch)?;
                rows.push(row);
                told(Step::Done(&rows));
            }
        }
    }
    Ok(rows)
}

/// A recipe of `method` that turns boxes wherever that makes them smaller.
fn recipe(method: &Method) -> Recipe {
    let recipe = Recipe { builder: method.builder, fit: method.fit, ..Recipe::default() };
    Recipe { oriented_cost: recipe.collapse.node_cost, ..recipe }
}

/// All ways to trace through `bvh`: either query by every walk, and rays sorted.
fn ways(bvh: &Bvh, precision: Precision) -> Vec<Options> {
    let plain = Options { precision, ..Options::default() };
    let mut ways = vec![];
    for boxes in Boxes::of(bvh) {
        for query in [Query::Closest, Query::Any] {
            ways.extend(Walk::ALL.map(|walk| Options { query, walk, boxes: *boxes, ..plain }));
        }
    }
    ways.push(Options { walk: Walk::Refill, order: RayOrder::Sorted, ..plain });
    ways
}

/// Traces a ray each way: drivers compile at a kernel's first dispatch.
fn warm_up(device: &Arc<Device>, bvh: &Bvh, precision: Precision, batch: &mut Batch) -> Result<()> {
    batch.set(&[Ray { origin: [0.0; 3], t_min: 0.0, direction: [1.0; 3], t_max: 1.0 }])?;
    for options in ways(bvh, precision) {
        trace(device, bvh, batch, options, Timing::Off)?;
    }
    Ok(())
}

/// Rays of one row.
struct Run<'a> {
    device: &'a Arc<Device>,
    bvh: &'a Bvh,
    reference: &'a Reference<'a>,
    shots: Shots<'a>,
    told: &'a dyn Fn(Step),
}

impl Run<'_> {
    /// Traces `count` rays, as many each way.
    fn fill(&self, row: &mut Row, count: u64, precision: Precision, batch: &mut Batch) -> Result<()> {
        let ways = ways(self.bvh, precision);
        let of = ways.len() as u64;
        for (w, options) in (0..).zip(ways) {
            let (mut start, end) = (count * w / of, count * (w + 1) / of);
            while start < end {
                let next = end.min(start + CHUNK as u64);
                let shots = &self.shots;
                let shots: Vec<Shot> =
                    (start..next).into_par_iter().map(|i| shots.shot(i).asked(options.query)).collect();
                self.trace(row, &shots, options, batch)?;
                (self.told)(Step::Traced(next - start));
                start = next;
            }
        }
        Ok(())
    }

    /// Traces and judges one batch.
    fn trace(&self, row: &mut Row, shots: &[Shot], options: Options, batch: &mut Batch) -> Result<()> {
        let rays: Vec<Ray> = shots.iter().map(|s| s.ray).collect();
        batch.set(&rays)?;
        row.device_ms += trace(self.device, self.bvh, batch, options, Timing::Outer)?.device_ms;
        let hits = batch.hits.read_first(rays.len())?;
        let triangles = row.triangles;
        let judged = shots.par_iter().zip(&hits).enumerate();
        let faults: Vec<(usize, Fault)> = judged
            .filter_map(|(i, (shot, hit))| Some((i, fault(shot, hit, options.query, triangles)?)))
            .collect();
        row.rays += rays.len() as u64;
        for (i, fault) in faults {
            match fault {
                Fault::Miss => row.misses += 1,
                Fault::Leak => row.leaks += 1,
                Fault::Other => row.others += 1,
            }
            if row.examples.len() < EXAMPLES {
                row.examples.push(Example::new(fault, options, &shots[i], &hits[i]));
            }
        }
        self.judge(row, &rays, &hits, options.query);
        Ok(())
    }

    /// Has the reference judge a share of a batch.
    fn judge(&self, row: &mut Row, rays: &[Ray], hits: &[Hit], query: Query) {
        let rays: Vec<Ray> = rays.iter().step_by(JUDGED).copied().collect();
        let hits: Vec<Hit> = hits.iter().step_by(JUDGED).copied().collect();
        let query = match query {
            Query::Closest => compare::Query::Closest,
            Query::Any => compare::Query::Any,
        };
        let v = compare(self.reference, &rays, &hits, query, Arithmetic::Exact);
        row.judged += rays.len() as u64;
        row.contradicted +=
            (v.malformed + v.missed_stable + v.false_stable + v.leaked_stable + v.wrong_triangle_stable)
                as u64;
    }
}

/// What is wrong with a hit.
fn fault(shot: &Shot, hit: &Hit, query: Query, triangles: usize) -> Option<Fault> {
    if hit.t == f32::INFINITY && hit.triangle == INVALID {
        return Some(Fault::Miss);
    }
    match query {
        // That it is no leak, t_max has seen to.
        Query::Any => (hit.t != 0.0).then_some(Fault::Other),
        Query::Closest => {
            let t = f64::from(hit.t);
            let inside = [hit.u, hit.v, 1.0 - hit.u - hit.v].iter().all(|w| (-1e-3..=1.001).contains(w));
            if !inside || hit.triangle as usize >= triangles || !t.is_finite() || t < shot.least {
                Some(Fault::Other)
            } else {
                (t > shot.most).then_some(Fault::Leak)
            }
        }
    }
}

impl Row {
    fn new(solid: &Solid, method: &Method, bvh: &Bvh, kind: Kind) -> Self {
        Self {
            mesh: solid.name,
            triangles: solid.scene.triangles.len(),
            builder: method.name,
            nodes: bvh.nodes.len(),
            oriented: bvh.oriented,
            kind,
            rays: 0,
            misses: 0,
            leaks: 0,
            others: 0,
            judged: 0,
            contradicted: 0,
            device_ms: 0.0,
            examples: vec![],
        }
    }
}

impl Example {
    fn new(fault: Fault, options: Options, shot: &Shot, hit: &Hit) -> Self {
        let query = match options.query {
            Query::Closest => "closest",
            Query::Any => "any",
        };
        let order = match options.order {
            RayOrder::AsGiven => "as given",
            RayOrder::Sorted => "sorted",
        };
        let (kernel, boxes) = (options.walk.kernel_name(), options.boxes.name());
        Self {
            fault,
            way: format!("{kernel}, {query}, {order}, {boxes} boxes"),
            ray: bytemuck::cast(shot.ray),
            t: hit.t,
            triangle: hit.triangle,
            surface: [shot.least, shot.most],
        }
    }
}

#[cfg(test)]
mod tests;
