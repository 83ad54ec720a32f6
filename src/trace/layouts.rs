//! Rays through binary trees whose nodes have the layouts of the literature \[VEVERKOVA24\], to be measured against the
//! packed tree's: one 64-byte node of up to four children that share a frame.
//!
//! | layout | node |
//! |---|---|
//! | [`Layout::Aabb`] | 64 bytes: two axis-aligned boxes |
//! | [`Layout::Obb`] | 112 bytes: two oriented boxes, each a 3 × 4 matrix |
//! | [`Layout::Mixed`] | 64 bytes where both boxes are axis-aligned; 112 where one is not, either of them behind a tag |
//!
//! Leaves are those of the packed tree, whose triangles they refer to: hits are the same. Differs from the seed's: children
//! are referred to by one number each, no parent and no range is kept.

use super::{Batch, Options, Precision, Query, stack_of};
use crate::abi::{
    AabbNode, LAYOUT_AABB, LAYOUT_MIXED, LAYOUT_OBB, LEAF_BIT, OBB_BIT, Obb, ObbNode, Ptr, PtrMut, SPEC_ANY,
    SPEC_COUNT, SPEC_LAYOUT, SPEC_LEAF_BITS, SPEC_ROBUST, SPEC_STACK, SPEC_WG, TraceBinaryArgs,
};
use crate::bvh::Bvh;
use crate::device::{Buffer, Device, Recorder, Result, Times, Timing};
use crate::kernels;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Padding of oriented boxes, in units of the largest coordinate difference between a ray's origin and the scene: derived
/// in `glsl/lib/binary.glsl`.
pub const PAD_OBB: f64 = 64.0 / 16_777_216.0;
/// Oriented boxes are padded for rays whose largest such difference is this many times the tree's largest coordinate.
pub const PADDED_REACHES: f32 = 4.0;

/// What the nodes of a binary tree are like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Axis-aligned boxes.
    Aabb,
    /// Oriented boxes, some of them along the axes.
    Obb,
    /// Oriented boxes only where they cost less.
    Mixed,
}

impl Layout {
    /// Every layout.
    pub const ALL: [Self; 3] = [Self::Aabb, Self::Obb, Self::Mixed];

    /// As reports have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Aabb => "aabb64",
            Self::Obb => "obb112",
            Self::Mixed => "mixed",
        }
    }

    fn constant(self) -> u32 {
        match self {
            Self::Aabb => LAYOUT_AABB,
            Self::Obb => LAYOUT_OBB,
            Self::Mixed => LAYOUT_MIXED,
        }
    }
}

/// A binary tree on the host, in unit space less the packed tree's anchor.
#[derive(Debug, Clone)]
pub struct HostBinary {
    /// What its nodes are like.
    pub layout: Layout,
    /// Nodes with axis-aligned boxes, parents first.
    pub aabbs: Vec<AabbNode>,
    /// Nodes with oriented ones, likewise.
    pub obbs: Vec<ObbNode>,
    /// Node, with [`OBB_BIT`] where it is one of `obbs`, or leaf, or [`crate::abi::INVALID`].
    pub root: u32,
    /// Levels of nodes.
    pub levels: u32,
}

/// A child's box.
#[derive(Debug, Clone, Copy)]
pub enum Volume {
    /// Least corner and greatest.
    Aabb([[f32; 3]; 2]),
    /// A matrix.
    Obb(Obb),
}

impl Volume {
    /// Whether `p`, unit space less the anchor, lies within: exactly, but for the rounding of f64.
    pub fn holds(&self, p: DVec3) -> bool {
        match self {
            Self::Aabb([lo, hi]) => {
                let [lo, hi] = [lo, hi].map(|c| Vec3::from_array(*c).as_dvec3());
                lo.cmple(p).all() && hi.cmpge(p).all()
            }
            Self::Obb(Obb { x, y, z }) => [x, y, z].into_iter().all(|row| {
                let [a, b, c, offset] = row.map(f64::from);
                (DVec3::new(a, b, c).dot(p) + offset).abs() <= 0.5
            }),
        }
    }
}

impl HostBinary {
    /// The children of the node `reference`, and their boxes.
    pub fn children(&self, reference: u32) -> [(u32, Volume); 2] {
        if reference & OBB_BIT == 0 {
            let n = &self.aabbs[reference as usize];
            let volume = |b: &crate::abi::Aabb| Volume::Aabb([b.lo, b.hi]);
            return [(n.children[0], volume(&n.left)), (n.children[1], volume(&n.right))];
        }
        let n = &self.obbs[(reference & !OBB_BIT) as usize];
        let volume = |k: u32, b: Obb| match n.aligned >> k & 1 {
            0 => Volume::Obb(b),
            _ => Volume::Aabb([[b.x[0], b.x[1], b.x[2]], [b.x[3], b.y[0], b.y[1]]]),
        };
        [(n.children[0], volume(0, n.left)), (n.children[1], volume(1, n.right))]
    }

    /// Nodes.
    pub fn nodes(&self) -> usize {
        self.aabbs.len() + self.obbs.len()
    }

    /// Whether a child reference is a node's.
    pub fn is_node(reference: u32) -> bool {
        reference < LEAF_BIT
    }
}

/// A binary tree on the device.
#[derive(Debug)]
pub struct Binary {
    layout: Layout,
    aabbs: Buffer<AabbNode>,
    obbs: Buffer<ObbNode>,
    root: u32,
    levels: u32,
}

impl Binary {
    /// Uploads `tree`.
    ///
    /// # Errors
    /// Not enough device memory, or a failed copy.
    pub fn upload(device: &Arc<Device>, tree: &HostBinary) -> Result<Self> {
        Ok(Self {
            layout: tree.layout,
            aabbs: Buffer::from_slice(device, "layouts.aabbs", &tree.aabbs)?,
            obbs: Buffer::from_slice(device, "layouts.obbs", &tree.obbs)?,
            root: tree.root,
            levels: tree.levels,
        })
    }

    /// Nodes.
    pub fn nodes(&self) -> usize {
        self.aabbs.len() + self.obbs.len()
    }

    /// Bytes of its nodes.
    pub fn bytes(&self) -> u64 {
        (size_of::<AabbNode>() * self.aabbs.len() + size_of::<ObbNode>() * self.obbs.len()) as u64
    }

    /// Traces the rays of `batch` through this tree, which was made from `bvh`, an invocation a ray and as they come: of
    /// `options` only query and precision count. Counts tests where the batch has room for them.
    ///
    /// # Errors
    /// A failed Vulkan call.
    pub fn trace(
        &self,
        device: &Arc<Device>,
        bvh: &Bvh,
        batch: &Batch,
        options: Options,
        timing: Timing,
    ) -> Result<Times> {
        let shape = device.shape();
        let constants = [
            (SPEC_WG, shape.trace_workgroup),
            (SPEC_STACK, stack_of(self.levels)?),
            (SPEC_LEAF_BITS, bvh.leaf_bits),
            (SPEC_ANY, (options.query == Query::Any).into()),
            (SPEC_COUNT, batch.tests.is_some().into()),
            (SPEC_ROBUST, (options.precision == Precision::Robust).into()),
            (SPEC_LAYOUT, self.layout.constant()),
        ];
        let count = batch.count as u32;
        let args = TraceBinaryArgs {
            rays: batch.rays.ptr(),
            aabbs: self.aabbs.ptr(),
            obbs: self.obbs.ptr(),
            triangles: bvh.triangles.ptr().cast(),
            hits: batch.hits.ptr_mut(),
            tests: batch.tests.as_ref().map_or(PtrMut::new(0), Buffer::ptr_mut),
            steps: PtrMut::new(0),
            order: Ptr::new(0),
            count,
            root: self.root,
            exponent: bvh.exponent,
            anchor: bvh.anchor,
            reach: bvh.reach,
            half_over_reach: 0.5 / (PADDED_REACHES * bvh.reach),
            threads: shape.threads,
        };
        let mut rec = Recorder::new(device, timing)?;
        let groups = count.div_ceil(shape.trace_workgroup).next_multiple_of(shape.threads);
        rec.dispatch(&kernels::TRACE_BINARY, &constants, groups, args)?;
        rec.submit()
    }
}
