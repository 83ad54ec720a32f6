//! What boxwood's own trees are held against: the driver's acceleration structure over the same triangles, and its
//! traversal by VK_KHR_ray_query. Both are opaque: no nodes to look at, no tests to count, and hits by the driver's own
//! idea of edges. The first thing that differs between drivers is whether they sort triangles at all, so structures are
//! built over the mesh's order and over Morton's.

use crate::abi::{Ptr, RayQueryIndexArgs, RayQueryTraceArgs, SPEC_ANY, SPEC_ORDERED, SPEC_WG};
use crate::bvh::{BuildError, Ordered, SceneBuffers, morton_order};
use crate::device::{Acceleration, Buffer, Device, Recorder, Result, Times, Timing, Triangles};
use crate::kernels;
use crate::trace::{Batch, Query, RayOrder};
use std::sync::Arc;
use std::time::Instant;

/// The order in which the driver is given triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TriangleOrder {
    /// The mesh's, whatever that is.
    Mesh,
    /// Along the Morton curve: neighbours in space follow each other.
    Morton,
}

impl TriangleOrder {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Mesh, Self::Morton];

    /// As reports have a structure over it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mesh => "ray-query",
            Self::Morton => "ray-query-morton",
        }
    }
}

/// The driver's structure over a scene.
#[derive(Debug)]
pub struct Structure {
    acceleration: Acceleration,
    /// Input indices of its triangles; none where they are in the mesh's order.
    triangles: Option<Buffer<u32>>,
}

impl Structure {
    /// Bytes of device memory that tracing needs.
    pub fn bytes(&self) -> u64 {
        self.acceleration.bytes() + self.triangles.as_ref().map_or(0, Buffer::bytes)
    }
}

/// A structure and what it took.
#[derive(Debug)]
pub struct Built {
    /// The structure.
    pub structure: Structure,
    /// Device times of all submits, putting the triangles into order included.
    pub times: Times,
    /// Wall time of the whole build, ms.
    pub wall_ms: f64,
    /// Most device memory held at once beside the scene and the structure, bytes.
    pub scratch_bytes: u64,
    /// What was done, a sentence each.
    pub explain: Vec<String>,
}

/// Has the driver build its structure over `scene`.
///
/// # Errors
/// [`BuildError::Device`]: [`crate::device::DeviceError::Lacking`] without ray queries,
/// [`crate::device::DeviceError::Limit`] for more triangles than the driver takes, not enough memory, a failed call.
pub fn build(
    device: &Arc<Device>,
    scene: &SceneBuffers,
    order: TriangleOrder,
    timing: Timing,
) -> std::result::Result<Built, BuildError> {
    device.require_ray_query()?;
    let start = Instant::now();
    let before = device.track_memory();
    let mut times = Times::default();
    let mut explain = vec![];
    let listed = match order {
        TriangleOrder::Morton => {
            let Ordered { triangles, count, times: taken, explain: said } =
                morton_order(device, scene, timing)?;
            times.append(taken);
            explain.extend(said);
            explain.push(
                "the driver was given the triangles in Morton order; sorting is part of the build".into(),
            );
            Some((triangles, count))
        }
        TriangleOrder::Mesh if scene.finite => {
            explain.push("the driver was given the triangles in the mesh's order".into());
            None
        }
        TriangleOrder::Mesh => {
            // Vulkan leaves open what a driver does with a corner that is not finite.
            let finite = finite(scene)?;
            explain.push(
                "triangles that are not finite were left out, by the host: that is in the wall time alone"
                    .into(),
            );
            Some((Buffer::from_slice(device, "ray_query.triangles", &finite)?, finite.len() as u32))
        }
    };
    let mut rec = Recorder::new(device, timing)?;
    let count = listed.as_ref().map_or(scene.count() as u32, |(_, count)| *count);
    let indices = match &listed {
        None => None,
        Some((triangles, _)) => Some(index(&mut rec, triangles, count)?),
    };
    let triangles = Triangles { corners: &scene.triangles, indices: indices.as_ref(), count };
    let acceleration = Acceleration::record(&mut rec, &triangles)?;
    times.append(rec.submit()?);
    drop(indices);
    let wall_ms = start.elapsed().as_secs_f64() * 1e3;
    let structure = Structure { acceleration, triangles: listed.map(|(triangles, _)| triangles) };
    let scratch_bytes = device.peak_memory().saturating_sub(before + structure.bytes());
    explain.push("built by the driver for fast tracing, not compacted: VK_KHR_acceleration_structure".into());
    Ok(Built { structure, times, wall_ms, scratch_bytes, explain })
}

/// Triangles whose corners are finite.
fn finite(scene: &SceneBuffers) -> Result<Vec<u32>> {
    let corners = scene.triangles.read()?;
    let triangles = (0..).zip(corners.chunks_exact(9));
    Ok(triangles.filter(|(_, c)| c.iter().all(|x| x.is_finite())).map(|(t, _)| t).collect())
}

/// Records the corners' numbers of the first `count` of `triangles`.
fn index(rec: &mut Recorder, triangles: &Buffer<u32>, count: u32) -> Result<Buffer<u32>> {
    let device = rec.device().clone();
    let workgroup = device.shape().trace_workgroup;
    let indices = Buffer::new(&device, "ray_query.indices", 3 * count as usize)?;
    let args = RayQueryIndexArgs { triangles: triangles.ptr(), indices: indices.ptr_mut(), count };
    rec.dispatch(&kernels::RAY_QUERY_INDEX, &[(SPEC_WG, workgroup)], count.div_ceil(workgroup), args)?;
    Ok(indices)
}

/// Traces the rays of `batch` through `structure`, in `order`; hits are as [`crate::trace::trace`] writes them. Rays that
/// begin below t = 0 begin at 0.
///
/// # Errors
/// A failed Vulkan call.
pub fn trace(
    device: &Arc<Device>,
    structure: &Structure,
    batch: &Batch,
    query: Query,
    order: RayOrder,
    timing: Timing,
) -> Result<Times> {
    let mut rec = Recorder::new(device, timing)?;
    let shape = device.shape();
    let constants = [
        (SPEC_WG, shape.trace_workgroup),
        (SPEC_ANY, (query == Query::Any).into()),
        (SPEC_ORDERED, (order == RayOrder::Sorted).into()),
    ];
    let count = batch.count as u32;
    let groups = count.div_ceil(shape.trace_workgroup).next_multiple_of(shape.threads);
    let args = RayQueryTraceArgs {
        rays: batch.rays.ptr(),
        hits: batch.hits.ptr_mut(),
        order: match order {
            RayOrder::AsGiven => Ptr::new(0),
            RayOrder::Sorted => batch.sort(&mut rec)?,
        },
        triangles: structure.triangles.as_ref().map_or(Ptr::new(0), Buffer::ptr),
        structure: structure.acceleration.address()?,
        count,
        threads: shape.threads,
    };
    rec.dispatch(&kernels::RAY_QUERY_TRACE, &constants, groups, args)?;
    rec.submit()
}
