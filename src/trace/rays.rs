//! Ray sets made on the device: primary rays of a camera, and the ambient-occlusion and diffuse rays that leave what
//! they met. Order and batches are those of Aila09. Differs: origins are lifted by a bound on rounding, not by a fixed length, and
//! each device makes the same bits, for kernels only add and multiply.

use super::{BATCH, Batch, Query};
use crate::abi::{
    Aabb, Pair, RaysCountArgs, RaysPrimaryArgs, RaysSecondaryArgs, RaysSurfaceArgs, SPEC_ITEMS, SPEC_WG,
    ScanExclusiveArgs, Surface,
};
use crate::bvh::SceneBuffers;
use crate::device::{Buffer, Device, DeviceError, Recorder, Result, Times, Timing};
use crate::kernels;
use crate::scene::Camera;
use glam::DVec3;
use std::sync::Arc;

/// Side of the blocks in which pixels are taken, pixels.
const BLOCK: u32 = 8;
/// Largest width and height: a block's place takes 16 bits an axis.
const LARGEST_SIDE: u32 = BLOCK << 16;
/// Secondary rays a hit (the seed's number).
pub const SAMPLES: u32 = 32;
/// Most secondary rays a hit: their points travel in a command buffer.
pub const MOST_SAMPLES: u32 = 8192;
/// Length of ambient-occlusion rays by default, as a share of the diagonal of the scene's box.
pub const AO_SHARE: f32 = 0.05;
/// Primaries that one invocation looks at in turn, at least: sums of runs are scanned by a single workgroup.
const RUN: u32 = 32;

/// A picture to be taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Where from.
    pub camera: Camera,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl View {
    /// 1024 × 768 pixels, the size of Aila09.
    pub fn standard(camera: Camera) -> Self {
        Self { camera, width: 1024, height: 768 }
    }

    /// Pixels: primary rays.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// From the eye to the picture's top left corner, a pixel to the right, a pixel down. Square pixels. A camera
    /// that looks nowhere looks along −z; where `up` is no help, another axis is up.
    pub fn axes(&self) -> [DVec3; 3] {
        let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let Camera { eye, target, up, fov_y } = self.camera;
        let forward = (wide(target) - wide(eye)).normalize_or(DVec3::NEG_Z);
        let sideways = |up: DVec3| forward.cross(up.normalize_or_zero()).try_normalize();
        let right = [wide(up), DVec3::Y, DVec3::X].into_iter().find_map(sideways).unwrap_or(DVec3::X);
        let pixel = 2.0 * (f64::from(fov_y).to_radians() / 2.0).tan() / f64::from(self.height.max(1));
        let (across, down) = (right * pixel, forward.cross(right) * pixel);
        let corner = forward - across * (f64::from(self.width) / 2.0) - down * (f64::from(self.height) / 2.0);
        [corner, across, down]
    }
}

/// What secondary rays look for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SecondaryKind {
    /// Whether anything is near.
    Ao,
    /// What light comes from.
    Diffuse,
}

/// Secondary rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Secondary {
    /// What for.
    pub kind: SecondaryKind,
    /// Rays a hit, at most [`MOST_SAMPLES`]; 32 by default.
    pub samples: u32,
    /// Greatest t of each ray, scene units (directions are unit vectors); may be +inf.
    pub length: f32,
}

impl Secondary {
    /// 32 ambient-occlusion rays a hit, [`AO_SHARE`] of the diagonal of `bounds` long.
    pub fn ao(bounds: &Aabb) -> Self {
        let square: f64 = (0..3).map(|k| (f64::from(bounds.hi[k]) - f64::from(bounds.lo[k])).powi(2)).sum();
        let length = if square.is_finite() { AO_SHARE * square.sqrt() as f32 } else { f32::INFINITY };
        Self { kind: SecondaryKind::Ao, samples: SAMPLES, length }
    }

    /// 32 diffuse rays a hit, endless.
    pub fn diffuse() -> Self {
        Self { kind: SecondaryKind::Diffuse, samples: SAMPLES, length: f32::INFINITY }
    }

    /// What to ask of the tracer.
    pub fn query(&self) -> Query {
        match self.kind {
            SecondaryKind::Ao => Query::Any,
            SecondaryKind::Diffuse => Query::Closest,
        }
    }
}

/// Bits 0, 2, 4, … of the result are those of `x`.
fn spread(x: u32) -> u64 {
    (0..16).map(|bit| u64::from(x >> bit & 1) << (2 * bit)).sum()
}

/// Whole blocks by the Morton code of their place, x | y << 16.
fn block_order(width: u32, height: u32) -> Vec<u32> {
    let (columns, rows) = (width / BLOCK, height / BLOCK);
    let mut blocks: Vec<u32> = (0..rows).flat_map(|y| (0..columns).map(move |x| x | y << 16)).collect();
    blocks.sort_by_cached_key(|b| spread(b & 0xffff) | spread(b >> 16) << 1);
    blocks
}

/// The pixel, y · width + x, of each primary ray: 8×8 blocks in Morton order, Morton order in each, then the strip to
/// their right by rows, then the strip below by columns.
pub fn pixel_order(width: u32, height: u32) -> Vec<u32> {
    let (whole_x, whole_y) = (width - width % BLOCK, height - height % BLOCK);
    let even_bits = |m: u32| m & 1 | m >> 1 & 2 | m >> 2 & 4;
    let block = |b: u32| {
        (0..64).map(move |m| ((b & 0xffff) * BLOCK + even_bits(m), (b >> 16) * BLOCK + even_bits(m >> 1)))
    };
    let blocks = block_order(width, height).into_iter().flat_map(block);
    let right = (0..whole_y).flat_map(|y| (whole_x..width).map(move |x| (x, y)));
    let below = (0..width).flat_map(|x| (whole_y..height).map(move |y| (x, y)));
    blocks.chain(right).chain(below).map(|(x, y)| y * width + x).collect()
}

/// Makes the primary rays of `view`: one a pixel, in the order of [`pixel_order`], unit directions, t from 0 to ∞.
///
/// # Errors
/// More pixels than `batch` holds; a failed Vulkan call.
pub fn primary(device: &Arc<Device>, view: &View, batch: &mut Batch, timing: Timing) -> Result<Times> {
    let (pixels, room) = (view.pixels(), batch.rays.len());
    if pixels > room {
        let (wanted, limit) = (pixels as u64, room as u64);
        return Err(DeviceError::Limit { what: "primary rays in a batch".into(), wanted, limit });
    }
    let side = view.width.max(view.height);
    if side >= LARGEST_SIDE {
        let (wanted, limit) = (side.into(), LARGEST_SIDE.into());
        return Err(DeviceError::Limit { what: "pixels in a row or column".into(), wanted, limit });
    }
    batch.count = pixels;
    let blocks = Buffer::from_slice(device, "rays.blocks", &block_order(view.width, view.height))?;
    let [corner, across, down] = view.axes().map(|v| v.as_vec3().to_array());
    let mut rec = Recorder::new(device, timing)?;
    let workgroup = device.shape().trace_workgroup;
    rec.dispatch(
        &kernels::RAYS_PRIMARY,
        &[(SPEC_WG, workgroup)],
        (pixels as u32).div_ceil(workgroup),
        RaysPrimaryArgs {
            blocks: blocks.ptr(),
            rays: batch.rays.ptr_mut(),
            width: view.width,
            height: view.height,
            eye: view.camera.eye,
            corner,
            across,
            down,
        },
    )?;
    rec.submit()
}

/// The `index`th point of Halton's sequence in bases 2 and 3 (Halton60), 24-bit fixed point, rounded down.
fn halton(index: u32) -> Pair {
    let inverse = |base: u64| {
        let (mut rest, mut digits, mut scale) = (u64::from(index), 0, 1);
        while rest > 0 {
            digits = digits * base + rest % base;
            scale *= base;
            rest /= base;
        }
        ((digits << 24) / scale) as u32
    };
    [inverse(2), inverse(3)]
}

/// Makes secondary rays of `kind` into `out`: `samples` for each traced primary that hit a triangle, none for one that
/// missed or whose triangle has no normal. Takes primaries from `start` on, in order, as many as their rays fit;
/// returns how many it took. [`Batch::count`] of `out` becomes the number of rays: 0 only where no hit is left.
///
/// Rays start at the hit point, lifted by 2⁻¹⁸ of the triangle's largest coordinate to the side that the primary came
/// from (see `glsl/rays/surface.glsl` for the bound), with t from 0 to `length`.
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
    let limit = (out.rays.len() / kind.samples as usize).min(left);
    let shape = device.shape();
    let items = shape.items.max(RUN);
    let runs = left.div_ceil(items as usize);
    let groups = (runs as u32).div_ceil(shape.workgroup);
    let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, items)];
    let (start, end, limit) = (start as u32, primaries.count as u32, limit as u32);
    let surfaces = Buffer::<Surface>::new(device, "rays.surfaces", limit as usize)?;
    let sums = Buffer::<u32>::new(device, "rays.sums", runs)?;
    let taken = Buffer::<u32>::new(device, "rays.taken", 2)?;
    let points = Buffer::<Pair>::new(device, "rays.points", kind.samples as usize)?;
    let sequence: Vec<Pair> = (1..=kind.samples).map(halton).collect();
    let (rays, hits) = (primaries.rays.ptr(), primaries.hits.ptr());
    let triangles = scene.triangles.ptr().cast();

    let mut rec = Recorder::new(device, timing)?;
    rec.update(&points, &sequence);
    rec.dispatch(
        &kernels::RAYS_COUNT,
        &constants,
        groups,
        RaysCountArgs { rays, hits, triangles, sums: sums.ptr_mut(), start, end },
    )?;
    rec.dispatch(
        &kernels::SCAN_EXCLUSIVE,
        &[(SPEC_WG, shape.single_workgroup)],
        1,
        ScanExclusiveArgs { sums: sums.ptr_mut(), total: taken.ptr_mut(), count: runs as u32 },
    )?;
    rec.dispatch(
        &kernels::RAYS_SURFACE,
        &constants,
        groups,
        RaysSurfaceArgs {
            rays,
            hits,
            triangles,
            sums: sums.ptr(),
            taken: taken.ptr_mut(),
            surfaces: surfaces.ptr_mut(),
            start,
            end,
            limit,
        },
    )?;
    rec.dispatch(
        &kernels::RAYS_SECONDARY,
        &[(SPEC_WG, shape.trace_workgroup)],
        (limit * kind.samples).div_ceil(shape.trace_workgroup),
        RaysSecondaryArgs {
            surfaces: surfaces.ptr(),
            points: points.ptr(),
            taken: taken.ptr(),
            rays: out.rays.ptr_mut(),
            samples: kind.samples,
            limit,
            t_max: kind.length,
        },
    )?;
    let times = rec.submit()?;
    let taken = taken.read()?;
    out.count = (taken[0].min(limit) * kind.samples) as usize;
    Ok(((taken[1] - start) as usize, times))
}

/// Rays that a batch of secondary rays holds by default: 2^20, as Aila09.
pub const SECONDARY_BATCH: usize = BATCH;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_go_by_blocks() {
        let order = pixel_order(17, 10);
        // Within the first block: Z by Z.
        assert_eq!(order[..8], [0, 1, 17, 18, 2, 3, 19, 20]);
        // The second block, then the strip at the right, then the one below, by columns.
        assert_eq!(order[64..66], [8, 9]);
        assert_eq!(order[128..130], [16, 33]);
        assert_eq!(order[136..139], [8 * 17, 9 * 17, 8 * 17 + 1]);
    }

    #[test]
    fn blocks_go_by_morton_code() {
        assert_eq!(block_order(24, 24), [0, 1, 0x10000, 0x10001, 2, 0x10002, 0x20000, 0x20001, 0x20002]);
    }

    #[test]
    fn every_pixel_once() {
        for (width, height) in [(0, 0), (1, 1), (7, 9), (8, 8), (33, 20), (64, 1), (1, 64), (100, 75)] {
            let mut order = pixel_order(width, height);
            order.sort_unstable();
            assert_eq!(order, (0..width * height).collect::<Vec<_>>(), "{width} × {height}");
        }
    }

    #[test]
    fn halton_points() {
        let share = |p: Pair| p.map(|x| f64::from(x) / f64::from(1 << 24));
        for (index, u, v) in [(1, 1.0 / 2.0, 1.0 / 3.0), (2, 1.0 / 4.0, 2.0 / 3.0), (5, 5.0 / 8.0, 7.0 / 9.0)]
        {
            let p = share(halton(index));
            assert!((p[0] - u).abs() < 1e-7 && (p[1] - v).abs() < 1e-7, "{index}: {p:?}");
        }
    }
}
