//! Arguments of what traces them.

use crate::abi::*;

abi! {
    /// Push constants of these kernels.
    TRACE:
    @kernel "trace/single" "trace/refill" "trace/persistent" "trace/packet"
    struct TraceArgs {
        /// Rays, scene space.
        rays: Ptr<Ray>,
        /// The packed tree.
        nodes: Ptr<Node>,
        /// Its triangles.
        triangles: Ptr<PackedTriangle>,
        /// Hits, one a ray.
        hits: PtrMut<Hit>,
        /// One a ray; not followed where SPEC_COUNT is 0.
        tests: PtrMut<Tests>,
        /// One a ray; not followed where SPEC_STEPS is 0.
        steps: PtrMut<Steps>,
        /// Rays that `trace/persistent` has taken: one number.
        next: PtrMut<u32>,
        /// Rays in the order in which they are taken; not followed where SPEC_ORDERED is 0.
        order: Ptr<u32>,
        /// Rays.
        count: u32,
        /// Root of the packed tree.
        root: u32,
        /// Exponent of the power of two that takes scene space to unit space.
        exponent: i32,
        /// Unit space is scene · 2^exponent − `anchor`.
        anchor: [f32; 3],
        /// Largest coordinate of the tree, unit space.
        reach: f32,
        /// Threads that a software driver deals workgroups to; 1 on a GPU.
        threads: u32,
    }
    @kernel "trace/binary"
    struct TraceBinaryArgs {
        /// Rays, scene space.
        rays: Ptr<Ray>,
        /// Nodes with axis-aligned boxes; not followed where there is none.
        aabbs: Ptr<AabbNode>,
        /// Nodes with oriented boxes, likewise.
        obbs: Ptr<ObbNode>,
        /// Triangles of the packed tree.
        triangles: Ptr<PackedTriangle>,
        /// Hits, one a ray.
        hits: PtrMut<Hit>,
        /// One a ray; not followed where SPEC_COUNT is 0.
        tests: PtrMut<Tests>,
        /// One a ray; not followed where SPEC_STEPS is 0.
        steps: PtrMut<Steps>,
        /// Not followed: rays are taken as they come.
        order: Ptr<u32>,
        /// Rays.
        count: u32,
        /// Root of the binary tree.
        root: u32,
        /// Exponent of the power of two that takes scene space to unit space.
        exponent: i32,
        /// Unit space is scene · 2^exponent − `anchor`.
        anchor: [f32; 3],
        /// Largest coordinate of the tree, unit space.
        reach: f32,
        /// Half over the largest R of a ray that oriented boxes are padded for: see `glsl/lib/binary.glsl`.
        half_over_reach: f32,
        /// Threads that a software driver deals workgroups to; 1 on a GPU.
        threads: u32,
    }
}
