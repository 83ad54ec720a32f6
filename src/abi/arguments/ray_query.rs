//! Arguments of what the device's own traversal answers.

use crate::abi::*;

abi! {
    /// Push constants of these kernels.
    RAY_QUERY:
    @kernel "ray_query/index"
    struct RayQueryIndexArgs {
        /// Triangles in the order in which they are given to the driver, by input index.
        triangles: Ptr<u32>,
        /// Their corners, three each: numbers of three floats of the scene.
        indices: PtrMut<u32>,
        /// Triangles.
        count: u32,
    }
    @kernel "ray_query/trace"
    struct RayQueryTraceArgs {
        /// Rays, scene space.
        rays: Ptr<Ray>,
        /// Hits, one a ray.
        hits: PtrMut<Hit>,
        /// Rays in the order in which they are taken; not followed where SPEC_ORDERED is 0.
        order: Ptr<u32>,
        /// Triangles in the order in which the driver has them, by input index; 0: that is the input's.
        triangles: Ptr<u32>,
        /// Address of the driver's structure.
        structure: [u32; 2],
        /// Rays.
        count: u32,
        /// Threads that a software driver deals workgroups to; 1 on a GPU.
        threads: u32,
    }
}
