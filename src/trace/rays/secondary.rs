//! Rays that leave what primary rays met: ambient occlusion, diffuse, shadow.

use super::sampler::Sampler;
use super::shadow::{Light, Shadow};
use crate::abi::{
    Aabb, LIGHTS, Pair, RaysCountArgs, RaysSecondaryArgs, RaysSurfaceArgs, SPEC_ITEMS, SPEC_WG,
    ScanExclusiveArgs, Surface,
};
use crate::bvh::SceneBuffers;
use crate::device::{Buffer, Device, DeviceError, Recorder, Result, Times, Timing};
use crate::kernels;
use crate::trace::{BATCH, Batch, Query};
use std::ops::Range;
use std::sync::Arc;

/// Secondary rays a hit (the seed's number).
pub const SAMPLES: u32 = 32;
/// Most secondary rays a hit: their points travel in a command buffer.
pub const MOST_SAMPLES: u32 = 8192;
/// Length of ambient-occlusion rays by default, as a share of the diagonal of the scene's box.
pub const AO_SHARE: f32 = 0.05;
/// Primaries that one invocation looks at in turn, at least: sums of runs are scanned by a single workgroup.
const RUN: u32 = 32;

/// Rays that a batch of secondary rays holds by default: 2^20, as Aila09.
pub const SECONDARY_BATCH: usize = BATCH;

/// What secondary rays look for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SecondaryKind {
    /// Whether anything is near.
    Ao,
    /// What light comes from.
    Diffuse,
    /// Whether anything is before these lights: a sample goes to each in turn, none to a light behind the triangle.
    Shadow([Light; LIGHTS as usize]),
}

/// Secondary rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Secondary {
    /// What for.
    pub kind: SecondaryKind,
    /// Rays a hit, at most [`MOST_SAMPLES`]; 32 by default, and of shadow rays one a light.
    pub samples: u32,
    /// Greatest t of each ray, in lengths of its direction: scene units where directions are unit vectors; 1 for shadow
    /// rays, whose directions reach to the light. May be +inf.
    pub length: f32,
    /// Where in the unit square.
    pub sampler: Sampler,
}

impl Secondary {
    /// 32 ambient-occlusion rays a hit, [`AO_SHARE`] of the diagonal of `bounds` long.
    pub fn ao(bounds: &Aabb) -> Self {
        let square: f64 = (0..3).map(|k| (f64::from(bounds.hi[k]) - f64::from(bounds.lo[k])).powi(2)).sum();
        let length = if square.is_finite() { AO_SHARE * square.sqrt() as f32 } else { f32::INFINITY };
        Self { kind: SecondaryKind::Ao, samples: SAMPLES, length, sampler: Sampler::default() }
    }

    /// 32 diffuse rays a hit, endless.
    pub fn diffuse() -> Self {
        Self {
            kind: SecondaryKind::Diffuse,
            samples: SAMPLES,
            length: f32::INFINITY,
            sampler: Sampler::default(),
        }
    }

    /// A shadow ray from each hit to each of `lights`.
    pub fn shadow(lights: [Light; LIGHTS as usize]) -> Self {
        Self {
            kind: SecondaryKind::Shadow(lights),
            samples: LIGHTS,
            length: 1.0,
            sampler: Sampler::default(),
        }
    }

    /// What to ask of the tracer.
    pub fn query(&self) -> Query {
        match self.kind {
            SecondaryKind::Ao | SecondaryKind::Shadow(_) => Query::Any,
            SecondaryKind::Diffuse => Query::Closest,
        }
    }
}

/// Makes secondary rays of `kind` into `out`: `samples` for each traced primary that hit a triangle, none for one that
/// missed or whose triangle has no normal. Takes primaries from `start` on, in order, as many as their rays fit;
/// returns how many it took. [`Batch::count`] of `out` becomes the number of rays: 0 only where no hit is left, or where
/// no light is before any. There is room for `samples` rays a hit, though shadow rays may be fewer: of the lights behind
/// its triangle, as the primary saw it, a hit has none.
///
/// Rays start at the hit point, lifted by a bound on what this point's rounding, and tracing from it, may do (derived in
/// `glsl/rays/surface.glsl`), to the side that the primary came from, with t from 0 to `length`.
///
/// # Errors
/// Too many samples for `out` or for [`MOST_SAMPLES`]; not enough device memory; a failed Vulkan call.
pub fn secondary(
    device: &Arc<Device>,
    scene: &SceneBuffers,
    primaries: &Batch,
    kind: &Secondary,
    start: usize,
    out: &mut Batch,
    timing: Timing,
) -> Result<(usize, Times)> {
    out.count = 0;
    let left = primaries.count.saturating_sub(start);
    let most = out.rays.len().min(MOST_SAMPLES as usize);
    if kind.samples as usize > most {
        let (wanted, limit) = (kind.samples.into(), most as u64);
        return Err(DeviceError::Limit { what: "secondary rays a hit".into(), wanted, limit });
    }
    if left == 0 || kind.samples == 0 {
        return Ok((left, Times::default()));
    }
    let surfaces = Surfaces::new(device, kind, start, primaries.count, out.rays.len())?;
    let shadow = match kind.kind {
        SecondaryKind::Ao | SecondaryKind::Diffuse => None,
        SecondaryKind::Shadow(lights) => Some(Shadow::new(device, &lights, surfaces.most_rays())?),
    };
    let mut rec = Recorder::new(device, timing)?;
    surfaces.record(&mut rec, scene, primaries)?;
    match &shadow {
        None => surfaces.leave(&mut rec, kind, out)?,
        Some(shadow) => shadow.record(&mut rec, &surfaces, kind.length, out)?,
    }
    let times = rec.submit()?;
    let taken = surfaces.taken.read()?;
    out.count = match &shadow {
        None => (taken[0].min(surfaces.limit) * kind.samples) as usize,
        Some(shadow) => shadow.count()?,
    };
    Ok((taken[1] as usize - start, times))
}

/// Surfaces under primaries, and what leaves them.
pub(super) struct Surfaces {
    /// The first [`Self::limit`] of them.
    pub found: Buffer<Surface>,
    /// How many there are in all; the primary before which the limit was reached.
    pub taken: Buffer<u32>,
    /// One a sample.
    pub points: Buffer<Pair>,
    /// Surfaces wanted.
    pub limit: u32,
    /// Rays a surface.
    pub samples: u32,
    sums: Buffer<u32>,
    /// Primaries.
    range: Range<u32>,
    sequence: Vec<Pair>,
}

impl Surfaces {
    /// Of primaries from `start` to `end`, as many as have their rays within `room`.
    fn new(device: &Arc<Device>, kind: &Secondary, start: usize, end: usize, room: usize) -> Result<Self> {
        let samples = kind.samples as usize;
        let limit = (room / samples).min(end - start);
        Ok(Self {
            found: Buffer::new(device, "rays.surfaces", limit)?,
            taken: Buffer::new(device, "rays.taken", 2)?,
            points: Buffer::new(device, "rays.points", samples)?,
            limit: limit as u32,
            samples: kind.samples,
            sums: Buffer::new(device, "rays.sums", (end - start).div_ceil(run_length(device) as usize))?,
            range: start as u32..end as u32,
            sequence: (0..kind.samples).map(|i| kind.sampler.point(i)).collect(),
        })
    }

    /// Rays that leave them at most.
    pub fn most_rays(&self) -> u32 {
        self.limit * self.samples
    }

    /// Records their search.
    fn record(&self, rec: &mut Recorder, scene: &SceneBuffers, primaries: &Batch) -> Result<()> {
        let shape = rec.device().shape().clone();
        let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, run_length(rec.device()))];
        let runs = self.sums.len() as u32;
        let groups = runs.div_ceil(shape.workgroup);
        let (rays, hits) = (primaries.rays.ptr(), primaries.hits.ptr());
        let triangles = scene.triangles.ptr().cast();
        let (sums, Range { start, end }) = (self.sums.ptr_mut(), self.range.clone());
        rec.update(&self.points, &self.sequence);
        rec.dispatch(
            &kernels::RAYS_COUNT,
            &constants,
            groups,
            RaysCountArgs { rays, hits, triangles, sums, start, end },
        )?;
        rec.dispatch(
            &kernels::SCAN_EXCLUSIVE,
            &[(SPEC_WG, shape.single_workgroup)],
            1,
            ScanExclusiveArgs { sums, total: self.taken.ptr_mut(), count: runs },
        )?;
        rec.dispatch(
            &kernels::RAYS_SURFACE,
            &constants,
            groups,
            RaysSurfaceArgs {
                rays,
                hits,
                triangles,
                sums: self.sums.ptr(),
                taken: self.taken.ptr_mut(),
                surfaces: self.found.ptr_mut(),
                start,
                end,
                limit: self.limit,
            },
        )
    }

    /// Records rays about their normals.
    fn leave(&self, rec: &mut Recorder, kind: &Secondary, out: &Batch) -> Result<()> {
        let workgroup = rec.device().shape().trace_workgroup;
        rec.dispatch(
            &kernels::RAYS_SECONDARY,
            &[(SPEC_WG, workgroup)],
            self.most_rays().div_ceil(workgroup),
            RaysSecondaryArgs {
                surfaces: self.found.ptr(),
                points: self.points.ptr(),
                taken: self.taken.ptr(),
                rays: out.rays.ptr_mut(),
                samples: self.samples,
                limit: self.limit,
                t_max: kind.length,
            },
        )
    }
}

/// Primaries that one invocation looks at in turn.
fn run_length(device: &Device) -> u32 {
    device.shape().items.max(RUN)
}
