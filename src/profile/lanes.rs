//! How full subgroups are as they walk a tree.

use crate::abi::{Hit, Node, PackedTriangle, Ray, Steps};
use crate::bench::RayKind;
use crate::bvh::Bvh;
use crate::device::{Device, Result, Timing, Traffic};
use crate::trace::{Batch, Options, RayOrder, Walk, trace};
use std::sync::Arc;

/// Steps of subgroups, and the lanes that had part in them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Active {
    /// Steps, of all subgroups.
    pub steps: u64,
    /// Lanes active, summed over the steps.
    pub lanes: u64,
}

impl Active {
    /// Lanes a step in the mean; none where there was no step.
    pub fn mean(&self) -> Option<f64> {
        (self.steps > 0).then(|| self.lanes as f64 / self.steps as f64)
    }
}

/// Active lanes a step, of one walk. A step is one node, or one triangle, that a subgroup goes through at once: an
/// iteration of the innermost loop over nodes or over a leaf's triangles. Active are the lanes whose ray visits the node
/// or tests the triangle; of packets, which take every ray everywhere, those whose ray meets a child of the node, or still
/// looks for a hit. Counted by variants of the kernels, with no time taken.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Lanes {
    /// Kind of rays.
    pub rays: &'static str,
    /// The walk's kernel.
    pub kernel: &'static str,
    /// Whether rays were sorted.
    pub sorted: bool,
    /// Lanes of a subgroup.
    pub subgroup: u32,
    /// Rays.
    pub count: usize,
    /// Steps over nodes.
    pub nodes: Active,
    /// Steps over triangles.
    pub triangles: Active,
    #[serde(skip)]
    walk: Walk,
}

impl Lanes {
    /// Traces `batch`, which has room for steps, and counts them.
    ///
    /// # Errors
    /// A failed Vulkan call.
    pub fn count(
        device: &Arc<Device>,
        bvh: &Bvh,
        batch: &Batch,
        kind: RayKind,
        options: Options,
    ) -> Result<Self> {
        trace(device, bvh, batch, options, Timing::Off)?;
        let steps = batch.steps.as_ref().map_or(Ok(vec![]), |steps| steps.read_first(batch.count))?;
        let sum = |part: fn(&Steps) -> u32, step: fn(&Steps) -> u32| Active {
            steps: steps.iter().map(|s| u64::from(step(s))).sum(),
            lanes: steps.iter().map(|s| u64::from(part(s))).sum(),
        };
        Ok(Self {
            rays: kind.name(),
            kernel: options.walk.kernel_name(),
            sorted: options.order == RayOrder::Sorted,
            subgroup: device.info().subgroup_size,
            count: batch.count,
            nodes: sum(|s| s.nodes, |s| s.node_steps),
            triangles: sum(|s| s.triangles, |s| s.triangle_steps),
            walk: options.walk,
        })
    }

    /// What its rays ask of memory: each the nodes and triangles that it goes through, a packet its own once; a ray, its
    /// place where they are sorted, and a hit.
    pub fn traffic(&self) -> Traffic {
        let [nodes, triangles] = match self.walk {
            Walk::Packet => [self.nodes.steps, self.triangles.steps],
            Walk::Single | Walk::Refill | Walk::Persistent => [self.nodes.lanes, self.triangles.lanes],
        };
        let ray = size_of::<Ray>() + if self.sorted { size_of::<u32>() } else { 0 };
        let tree = nodes * size_of::<Node>() as u64 + triangles * size_of::<PackedTriangle>() as u64;
        Traffic { read: tree + (self.count * ray) as u64, written: (self.count * size_of::<Hit>()) as u64 }
    }
}
