//! Arguments of what makes and sorts rays.

use crate::abi::*;

abi! {
    /// Push constants of these kernels.
    RAYS:
    @kernel "raysort/bounds"
    struct RaysortBoundsArgs {
        /// Rays.
        rays: Ptr<Ray>,
        /// One; lo at the greatest and hi at the least ordered integer.
        bounds: PtrMut<OrderedBounds>,
        /// Rays.
        count: u32,
    }
    @kernel "raysort/keys"
    struct RaysortKeysArgs {
        /// Rays.
        rays: Ptr<Ray>,
        /// One, from `raysort/bounds`.
        bounds: Ptr<OrderedBounds>,
        /// Codes of 24 bits, [`UNORDERED_KEY`] for a ray that has none.
        keys: PtrMut<u32>,
        /// 0, 1, 2, …
        order: PtrMut<u32>,
        /// Rays.
        count: u32,
    }
    @kernel "rays/primary"
    struct RaysPrimaryArgs {
        /// Whole 8×8 blocks in Morton order, x | y << 16.
        blocks: Ptr<u32>,
        /// Rays.
        rays: PtrMut<Ray>,
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Origin of all rays.
        eye: [f32; 3],
        /// From the eye to the picture's top left corner.
        corner: [f32; 3],
        /// From a pixel to the next in its row.
        across: [f32; 3],
        /// From a row to the next.
        down: [f32; 3],
    }
    @kernel "rays/count"
    struct RaysCountArgs {
        /// Primaries.
        rays: Ptr<Ray>,
        /// What they met.
        hits: Ptr<Hit>,
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// Surfaces under each run of primaries.
        sums: PtrMut<u32>,
        /// First primary.
        start: u32,
        /// Behind the last.
        end: u32,
    }
    @kernel "rays/surface"
    struct RaysSurfaceArgs {
        /// Primaries.
        rays: Ptr<Ray>,
        /// What they met.
        hits: Ptr<Hit>,
        /// Corners, nine floats a triangle.
        triangles: Ptr<Pair>,
        /// Surfaces before each run of primaries.
        sums: Ptr<u32>,
        /// Surfaces in all; the primary before which `limit` was reached.
        taken: PtrMut<u32>,
        /// The first `limit` of them.
        surfaces: PtrMut<Surface>,
        /// First primary.
        start: u32,
        /// Behind the last.
        end: u32,
        /// Surfaces wanted.
        limit: u32,
    }
    @kernel "rays/secondary"
    struct RaysSecondaryArgs {
        /// Surfaces that rays leave.
        surfaces: Ptr<Surface>,
        /// Points of the unit square, 24-bit fixed point, one a sample.
        points: Ptr<Pair>,
        /// From `rays/surface`.
        taken: Ptr<u32>,
        /// Rays.
        rays: PtrMut<Ray>,
        /// Rays a surface.
        samples: u32,
        /// Surfaces wanted.
        limit: u32,
        /// Greatest t.
        t_max: f32,
    }
    @kernel "rays/facing" "rays/shadow"
    struct RaysShadowArgs {
        /// Surfaces that rays leave.
        surfaces: Ptr<Surface>,
        /// Points of the unit square, 24-bit fixed point, one a sample.
        points: Ptr<Pair>,
        /// From `rays/surface`.
        taken: Ptr<u32>,
        /// [`LIGHTS`] of them: centre and radius.
        lights: Ptr<[f32; 4]>,
        /// Rays made a workgroup; then the sum of those before.
        sums: PtrMut<u32>,
        /// Rays.
        rays: PtrMut<Ray>,
        /// Rays a surface, at most.
        samples: u32,
        /// Surfaces wanted.
        limit: u32,
        /// Workgroups.
        groups: u32,
        /// Greatest t.
        t_max: f32,
    }
}
