//! Shadow rays: from what primary rays met to lights. Those to lights behind a triangle are not made, for it is unlit
//! without them.

use super::secondary::Surfaces;
use crate::abi::{Aabb, LIGHTS, RaysShadowArgs, SPEC_WG, ScanExclusiveArgs};
use crate::device::{Buffer, Device, Recorder, Result};
use crate::kernels;
use crate::trace::Batch;
use std::sync::Arc;

/// A light: a point, or a sphere of which each ray takes a point of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Centre, scene units.
    pub position: [f32; 3],
    /// 0 for a point, scene units.
    pub radius: f32,
}

impl Light {
    /// Four points above `bounds`, y up: over its corners, half its longest edge above its top.
    pub fn above(bounds: &Aabb) -> [Self; LIGHTS as usize] {
        let edges = (0..3).map(|k| f64::from(bounds.hi[k]) - f64::from(bounds.lo[k]));
        let height = f64::from(bounds.hi[1]) + 0.5 * edges.fold(0.0, f64::max);
        let limit = f64::from(f32::MAX);
        std::array::from_fn(|i| {
            let x = if i % 2 == 0 { bounds.lo[0] } else { bounds.hi[0] };
            let z = if i / 2 == 0 { bounds.lo[2] } else { bounds.hi[2] };
            Self { position: [x, height.clamp(-limit, limit) as f32, z], radius: 0.0 }
        })
    }
}

/// Buffers of a batch of shadow rays.
pub(super) struct Shadow {
    lights: Buffer<[f32; 4]>,
    /// Rays made by each workgroup.
    sums: Buffer<u32>,
    total: Buffer<u32>,
}

impl Shadow {
    /// For up to `most` rays to `lights`.
    pub fn new(device: &Arc<Device>, lights: &[Light], most: u32) -> Result<Self> {
        let spheres: Vec<[f32; 4]> =
            lights.iter().map(|l| [l.position[0], l.position[1], l.position[2], l.radius]).collect();
        Ok(Self {
            lights: Buffer::from_slice(device, "rays.lights", &spheres)?,
            sums: Buffer::new(device, "rays.facing", most.div_ceil(device.shape().workgroup) as usize)?,
            total: Buffer::new(device, "rays.made", 1)?,
        })
    }

    /// Records the rays from `surfaces` into `out`, without gaps, with t up to `length`.
    pub fn record(&self, rec: &mut Recorder, surfaces: &Surfaces, length: f32, out: &Batch) -> Result<()> {
        let shape = rec.device().shape().clone();
        let (constants, groups) = ([(SPEC_WG, shape.workgroup)], self.sums.len() as u32);
        let args = RaysShadowArgs {
            surfaces: surfaces.found.ptr(),
            points: surfaces.points.ptr(),
            taken: surfaces.taken.ptr(),
            lights: self.lights.ptr(),
            sums: self.sums.ptr_mut(),
            rays: out.rays.ptr_mut(),
            samples: surfaces.samples,
            limit: surfaces.limit,
            groups,
            t_max: length,
        };
        rec.dispatch(&kernels::RAYS_FACING, &constants, groups, args)?;
        rec.dispatch(
            &kernels::SCAN_EXCLUSIVE,
            &[(SPEC_WG, shape.single_workgroup)],
            1,
            ScanExclusiveArgs { sums: self.sums.ptr_mut(), total: self.total.ptr_mut(), count: groups },
        )?;
        rec.dispatch(&kernels::RAYS_SHADOW, &constants, groups, args)
    }

    /// Rays made.
    pub fn count(&self) -> Result<usize> {
        Ok(self.total.read()?[0] as usize)
    }
}
