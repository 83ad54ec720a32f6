//! What contenders build and trace: boxwood's packed trees, and structures of the device's driver.

use super::Result;
use super::choice::{Trial, fastest, fastest_walk};
use super::plan::Maker;
use crate::bvh::{self, Bvh, SceneBuffers};
use crate::device::{self, Device, Times, Timing};
use crate::kernels;
use crate::oracle::compare::Arithmetic;
use crate::ray_query;
use crate::trace::{Batch, Boxes, Options, RayOrder, Walk, trace};
use std::sync::Arc;

/// A contender's tree.
pub(super) enum Tree {
    Packed(Bvh),
    /// Opaque: no tests to count, one kernel, one test for triangles.
    Driver(ray_query::Structure),
}

/// A tree and what it took.
pub(super) struct Made {
    pub(super) tree: Tree,
    pub(super) times: Times,
    pub(super) wall_ms: f64,
    pub(super) scratch_bytes: u64,
    pub(super) explain: Vec<String>,
}

impl Maker {
    /// Builds a tree of `scene`.
    pub(super) fn make(&self, device: &Arc<Device>, scene: &SceneBuffers, timing: Timing) -> Result<Made> {
        Ok(match self {
            Self::Boxwood(recipe) => {
                let bvh::Built { bvh, times, wall_ms, scratch_bytes, explain } =
                    bvh::build(device, scene, recipe, timing)?;
                Made { tree: Tree::Packed(bvh), times, wall_ms, scratch_bytes, explain }
            }
            Self::Driver(order) => {
                let ray_query::Built { structure, times, wall_ms, scratch_bytes, explain } =
                    ray_query::build(device, scene, *order, timing)?;
                Made { tree: Tree::Driver(structure), times, wall_ms, scratch_bytes, explain }
            }
        })
    }
}

impl Tree {
    /// Bytes of device memory that tracing needs.
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Packed(bvh) => bvh.bytes(),
            Self::Driver(structure) => structure.bytes(),
        }
    }

    /// Traces `batch`; of `options` a driver takes the query and the order alone.
    pub(super) fn trace(
        &self,
        device: &Arc<Device>,
        batch: &Batch,
        options: Options,
        timing: Timing,
    ) -> device::Result<Times> {
        match self {
            Self::Packed(bvh) => trace(device, bvh, batch, options, timing),
            Self::Driver(structure) => {
                ray_query::trace(device, structure, batch, options.query, options.order, timing)
            }
        }
    }

    /// `options` with what the first of `batch` is traced fastest with, in one of `orders`.
    pub(super) fn fastest(
        &self,
        device: &Arc<Device>,
        batch: &mut Batch,
        options: Options,
        orders: &[RayOrder],
    ) -> Result<Options> {
        let choice = match self {
            Self::Packed(bvh) => fastest_walk(device, bvh, batch, options, orders)?,
            Self::Driver(_) => {
                let (walk, boxes, ms) = (Walk::Single, Boxes::Mixed, f64::INFINITY);
                let trials = orders.iter().map(|&order| Trial { walk, order, boxes, ms }).collect();
                let run =
                    |batch: &Batch, options| Ok(self.trace(device, batch, options, Timing::Outer)?.device_ms);
                fastest(trials, batch, options, orders, &run)?
            }
        };
        Ok(choice.options)
    }

    /// What its hits claim, traced with `options`.
    pub(super) fn arithmetic(&self, options: &Options) -> Arithmetic {
        match self {
            Self::Packed(_) => options.precision.into(),
            Self::Driver(_) => Arithmetic::Rounded,
        }
    }

    /// The kernel that traces it with `options`.
    pub(super) fn kernel_name(&self, options: &Options) -> &'static str {
        match self {
            Self::Packed(_) => options.walk.kernel_name(),
            Self::Driver(_) => kernels::RAY_QUERY_TRACE.name,
        }
    }
}
