//! Traces rays through a packed tree: nearest hit, any hit, and either with tests counted.

mod coherence;
pub mod layouts;
pub mod rays;
pub mod raysort;

pub use coherence::is_coherent;

use crate::abi::{
    Hit, Ptr, PtrMut, Ray, SPEC_ANY, SPEC_COUNT, SPEC_FEW, SPEC_ITEMS, SPEC_LEAF_BITS, SPEC_ORDERED,
    SPEC_ORIENTED, SPEC_ROBUST, SPEC_STACK, SPEC_STEPS, SPEC_WG, Steps, Tests, TraceArgs, WIDTH,
};
use crate::bvh::Bvh;
use crate::device::{Buffer, Device, DeviceError, Recorder, Result, Times, Timing};
use crate::kernels::{self, Kernel};
use raysort::Raysort;
use std::sync::{Arc, Mutex, PoisonError};

/// Rays that one dispatch takes at most (the seed's batch).
pub const BATCH: usize = 1 << 20;
/// Largest stack: beyond it a tree is refused, never traced wrongly.
pub const MAX_STACK: u32 = 4096;

/// What to find.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Query {
    /// The nearest hit with t, triangle, u, v.
    #[default]
    Closest,
    /// Whether there is a hit: no t, u, v.
    Any,
}

/// Which triangle test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// Watertight, with exact signs \[WOOP13\].
    #[default]
    Robust,
    /// Möller–Trumbore \[MOLLER97\]: leaks at edges and vertices.
    Fast,
}

impl Precision {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Robust, Self::Fast];

    /// As typed and reported.
    pub fn name(self) -> &'static str {
        match self {
            Self::Robust => "robust",
            Self::Fast => "fast",
        }
    }
}

/// How to trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// What to find.
    pub query: Query,
    /// Which triangle test.
    pub precision: Precision,
    /// Which kernel.
    pub walk: Walk,
    /// In which order.
    pub order: RayOrder,
    /// Through which boxes.
    pub boxes: Boxes,
}

/// Through which boxes of a tree that keeps both: either gives the same hits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Boxes {
    /// Oriented where they cost less.
    #[default]
    Mixed,
    /// Axis-aligned ones, where the tree has kept them: turning a ray may take longer than what it saves.
    AxisAligned,
}

impl Boxes {
    /// As reports have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mixed => "mixed",
            Self::AxisAligned => "axis-aligned",
        }
    }

    /// Those that `bvh` has.
    pub fn of(bvh: &Bvh) -> &'static [Self] {
        if bvh.axis_aligned.is_some() { &[Self::Mixed, Self::AxisAligned] } else { &[Self::Mixed] }
    }
}

/// In which order rays are taken. Either gives the same hits, in the order of the rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RayOrder {
    /// As they come.
    #[default]
    AsGiven,
    /// By origin and direction, sorted on the device in the same submit: see [`raysort`].
    Sorted,
}

impl RayOrder {
    /// Both.
    pub const ALL: [RayOrder; 2] = [RayOrder::AsGiven, RayOrder::Sorted];
}

/// How rays share a subgroup. All give the same hits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Walk {
    /// An invocation walks the tree with one ray.
    #[default]
    Single,
    /// An invocation takes another ray when it is done with one: for rays that have little in common.
    Refill,
    /// As many invocations as the device runs at once take rays until there are none, and put leaves off until the
    /// whole subgroup has some \[AILA09\]: for rays that take unlike long.
    Persistent,
    /// A subgroup walks the tree together: for rays that go much the same way, on devices where fetching a node for
    /// each lane is dear.
    Packet,
}

impl Walk {
    /// Every walk. Packets come last.
    pub const ALL: [Walk; 4] = [Walk::Single, Walk::Refill, Walk::Persistent, Walk::Packet];

    /// Those that may pay on `device`.
    pub fn all(device: &Device) -> &'static [Walk] {
        if device.shape().packets { &Self::ALL } else { &Self::ALL[..3] }
    }

    /// What to take untried, by whether neighbouring rays go much the same way.
    pub fn untried(device: &Device, coherent: bool) -> Self {
        if coherent && device.shape().packets { Walk::Packet } else { Walk::Single }
    }

    fn kernel(self) -> &'static Kernel<TraceArgs> {
        match self {
            Walk::Single => &kernels::TRACE_SINGLE,
            Walk::Refill => &kernels::TRACE_REFILL,
            Walk::Persistent => &kernels::TRACE_PERSISTENT,
            Walk::Packet => &kernels::TRACE_PACKET,
        }
    }

    /// The kernel's name.
    pub fn kernel_name(self) -> &'static str {
        self.kernel().name
    }
}

/// Rays and their results on the device.
#[derive(Debug)]
pub struct Batch {
    /// Rays.
    pub rays: Buffer<Ray>,
    /// One hit a ray.
    pub hits: Buffer<Hit>,
    /// One a ray where tests are counted.
    pub tests: Option<Buffer<Tests>>,
    /// One a ray where steps are counted: see [`Batch::count_steps`].
    pub steps: Option<Buffer<Steps>>,
    /// Rays taken so far, for [`Walk::Persistent`].
    next: Buffer<u32>,
    /// Rays in use.
    pub count: usize,
    /// From the first time that rays are sorted on.
    raysort: Mutex<Option<Raysort>>,
}

impl Batch {
    /// Room for `capacity` rays; `counting` adds room for their tests.
    ///
    /// # Errors
    /// Not enough device memory.
    pub fn new(device: &Arc<Device>, capacity: usize, counting: bool) -> Result<Self> {
        Ok(Self {
            rays: Buffer::new(device, "trace.rays", capacity)?,
            hits: Buffer::new(device, "trace.hits", capacity)?,
            tests: if counting { Some(Buffer::new(device, "trace.tests", capacity)?) } else { None },
            steps: None,
            next: Buffer::new(device, "trace.next", 1)?,
            count: 0,
            raysort: Mutex::new(None),
        })
    }

    /// Makes room for steps, which are counted from now on, by variants of the kernels as for tests.
    ///
    /// # Errors
    /// Not enough device memory.
    pub fn count_steps(&mut self, device: &Arc<Device>) -> Result<()> {
        self.steps = Some(Buffer::new(device, "trace.steps", self.rays.len())?);
        Ok(())
    }

    /// Uploads `rays`, at most as many as there is room for.
    ///
    /// # Errors
    /// A failed copy; too many rays.
    pub fn set(&mut self, rays: &[Ray]) -> Result<()> {
        self.count = rays.len();
        self.rays.write(rays)
    }

    /// Records the sort of the rays; their order.
    pub(crate) fn sort(&self, rec: &mut Recorder) -> Result<Ptr<u32>> {
        let mut raysort = self.raysort.lock().unwrap_or_else(PoisonError::into_inner);
        let raysort = match &mut *raysort {
            Some(r) if r.capacity() >= self.count => r,
            none => none.insert(Raysort::new(rec.device(), self.rays.len())?),
        };
        raysort.record(rec, self.rays.ptr(), self.count as u32)
    }
}

/// Entries that a ray's stack may need in `bvh`: beyond [`MAX_STACK`] it is refused. A node on the way down leaves all its
/// children but one, and what waits holds a triangle at least.
pub fn stack_entries(bvh: &Bvh) -> u32 {
    bvh.depth.saturating_mul(WIDTH - 1).min(bvh.triangle_count)
}

/// A stack for no more than `entries`. In steps, so that few pipelines are made; drivers may fill a stack with zeros for
/// every ray.
///
/// # Errors
/// [`DeviceError::Limit`] for more entries than any stack has.
fn stack_of(entries: u32) -> Result<u32> {
    if entries > MAX_STACK {
        let (wanted, limit) = (entries.into(), MAX_STACK.into());
        return Err(DeviceError::Limit { what: "entries of a ray's stack".into(), wanted, limit });
    }
    Ok(entries.next_multiple_of(32).max(64))
}

/// Traces the rays of `batch`; counts tests where it has room for them.
///
/// # Errors
/// A failed Vulkan call.
pub fn trace(
    device: &Arc<Device>,
    bvh: &Bvh,
    batch: &Batch,
    options: Options,
    timing: Timing,
) -> Result<Times> {
    let mut rec = Recorder::new(device, timing)?;
    record(&mut rec, bvh, batch, options)?;
    rec.submit()
}

fn record(rec: &mut Recorder, bvh: &Bvh, batch: &Batch, options: Options) -> Result<()> {
    let device = rec.device().clone();
    let shape = device.shape();
    let items = if options.walk == Walk::Refill { shape.refill } else { 1 };
    let (nodes, oriented) = match (options.boxes, &bvh.axis_aligned) {
        (Boxes::AxisAligned, Some(nodes)) => (nodes, false),
        _ => (&bvh.nodes, bvh.oriented > 0),
    };
    let constants = [
        (SPEC_WG, shape.trace_workgroup),
        (SPEC_ITEMS, items),
        (SPEC_STACK, stack_of(stack_entries(bvh))?),
        (SPEC_LEAF_BITS, bvh.leaf_bits),
        (SPEC_ANY, (options.query == Query::Any).into()),
        (SPEC_COUNT, batch.tests.is_some().into()),
        (SPEC_STEPS, batch.steps.is_some().into()),
        (SPEC_ROBUST, (options.precision == Precision::Robust).into()),
        (SPEC_FEW, shape.persistent_few),
        (SPEC_ORDERED, (options.order == RayOrder::Sorted).into()),
        (SPEC_ORIENTED, oriented.into()),
    ];
    let order = match options.order {
        RayOrder::AsGiven => Ptr::new(0),
        RayOrder::Sorted => batch.sort(rec)?,
    };
    let count = batch.count as u32;
    let filled = count.div_ceil(items * shape.trace_workgroup);
    let groups = if options.walk == Walk::Persistent {
        rec.fill(&batch.next, 1, 0);
        filled.min(shape.persistent_groups)
    } else {
        // Dealing workgroups out in turn wants as many of them as threads divide.
        filled.next_multiple_of(shape.threads)
    };
    let args = TraceArgs {
        rays: batch.rays.ptr(),
        nodes: nodes.ptr(),
        triangles: bvh.triangles.ptr().cast(),
        hits: batch.hits.ptr_mut(),
        tests: batch.tests.as_ref().map_or(PtrMut::new(0), Buffer::ptr_mut),
        steps: batch.steps.as_ref().map_or(PtrMut::new(0), Buffer::ptr_mut),
        next: batch.next.ptr_mut(),
        order,
        count,
        root: bvh.root,
        exponent: bvh.exponent,
        anchor: bvh.anchor,
        reach: bvh.reach,
        threads: shape.threads,
    };
    rec.dispatch(options.walk.kernel(), &constants, groups, args)
}
