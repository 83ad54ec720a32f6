//! Ray sets made on the device: primary rays of a camera, and the ambient-occlusion, diffuse and shadow rays that leave
//! what they met. Order and batches are those of Aila09. Differs: origins are lifted by a bound on rounding, not by a fixed length, and
//! each device makes the same bits, for kernels only add and multiply.

mod aimed;
mod file;
mod sampler;
mod secondary;
mod shadow;

pub use aimed::Aimed;
pub use file::{RayFileError, parse};
pub use sampler::Sampler;
pub(crate) use sampler::mixed;
pub use secondary::{AO_SHARE, MOST_SAMPLES, SAMPLES, SECONDARY_BATCH, Secondary, SecondaryKind, secondary};
pub use shadow::Light;

use super::Batch;
use crate::abi::{RaysPrimaryArgs, SPEC_WG};
use crate::device::{Buffer, Device, DeviceError, Recorder, Result, Times, Timing};
use crate::kernels;
use crate::scene::Camera;
use glam::DVec3;
use std::sync::Arc;

/// Side of the blocks in which pixels are taken, pixels.
const BLOCK: u32 = 8;
/// Largest width and height: a block's place takes 16 bits an axis.
const LARGEST_SIDE: u32 = BLOCK << 16;
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
}
