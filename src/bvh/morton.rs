//! Scene bounds and Morton codes \[MORTON66, KARRAS12\], with the triangles' size among their bits \[VINKLER17\].
//! Differs from the latter: the axes' bits take turns, whatever the scene's proportions, and those of all axes come
//! before one of size, so that a triangle has it where it is larger than a cell of the bits above.

use super::{Build, BuildError, Result};
use crate::abi::{
    Aabb, CODE_30, CODE_63, MortonBoundsArgs, MortonEncodeArgs, PtrMut, SPEC_ITEMS, SPEC_WG, SceneBounds,
};
use crate::device::{Buffer, Recorder};
use crate::kernels;

/// A Morton code for each triangle.
pub(super) struct Codes {
    pub keys: Buffer<u32>,
    /// Low words of codes that have two.
    pub low_keys: Option<Buffer<u32>>,
    pub order: Buffer<u32>,
    /// Bits that differ between the keys of triangles that can be hit.
    pub live: u32,
    pub low_live: u32,
    /// Triangles that can be hit.
    pub hittable: u32,
    /// Which codes: [`CODE_30`] and those that follow it.
    code: u32,
    bounds: Buffer<SceneBounds>,
}

/// From scene space to unit space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Space {
    pub exponent: i32,
    pub scale: f32,
    pub anchor: [f32; 3],
    /// Largest absolute coordinate in unit space.
    pub reach: f32,
}

/// A float from its ordered integer: the inverse of `ordered` in `glsl/lib/ordered.glsl`.
fn unordered(key: u32) -> f32 {
    f32::from_bits(if key & 0x8000_0000 != 0 { key & 0x7fff_ffff } else { !key })
}

/// Bounds of the scene alone, as its unit space.
pub(super) fn bounds(build: &mut Build<'_>) -> Result<Space> {
    let bounds = build.buffer::<SceneBounds>("morton.bounds", 1)?;
    let mut rec = build.recorder()?;
    record_bounds(build, &mut rec, &bounds)?;
    build.run(rec)?;
    space(&bounds.read()?[0])
}

fn record_bounds(build: &Build<'_>, rec: &mut Recorder, bounds: &Buffer<SceneBounds>) -> Result<()> {
    let n = build.scene.count() as u32;
    let shape = build.device.shape();
    rec.update(bounds, &[SceneBounds::EMPTY]);
    rec.dispatch(
        &kernels::MORTON_BOUNDS,
        &[(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items)],
        n.div_ceil(shape.workgroup * shape.items),
        MortonBoundsArgs {
            triangles: build.scene.triangles.ptr().cast(),
            bounds: bounds.ptr_mut(),
            count: n,
        },
    )?;
    Ok(())
}

/// Bounds of the scene, then the codes of the recipe; 30-bit ones where it leaves the choice.
pub(super) fn encode(build: &mut Build<'_>) -> Result<(Codes, Space)> {
    let n = build.scene.count();
    let bounds = build.buffer::<SceneBounds>("morton.bounds", 1)?;
    let code = build.recipe.morton.code();
    let mut codes = Codes {
        keys: build.buffer("sort.keys", n)?,
        low_keys: if code == CODE_30 { None } else { Some(build.buffer("sort.low_keys", n)?) },
        order: build.buffer("sort.order", n)?,
        live: 0,
        low_live: 0,
        hittable: 0,
        code,
        bounds,
    };
    let mut rec = build.recorder()?;
    record_bounds(build, &mut rec, &codes.bounds)?;
    let space = finish(build, rec, &mut codes)?;
    Ok((codes, space))
}

/// Encodes anew with 63 bits.
pub(super) fn widen(build: &mut Build<'_>, codes: &mut Codes) -> Result<()> {
    codes.code = CODE_63;
    codes.low_keys = Some(build.buffer("sort.low_keys", build.scene.count())?);
    let rec = build.recorder()?;
    finish(build, rec, codes)?;
    Ok(())
}

/// Records `morton/encode`, runs all and reads what the codes have in common.
fn finish(build: &mut Build<'_>, mut rec: Recorder, codes: &mut Codes) -> Result<Space> {
    let n = build.scene.count() as u32;
    let shape = build.device.shape().clone();
    rec.dispatch(
        &kernels::MORTON_ENCODE,
        &[(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items)],
        n.div_ceil(shape.workgroup * shape.items),
        MortonEncodeArgs {
            triangles: build.scene.triangles.ptr().cast(),
            bounds: codes.bounds.ptr_mut(),
            keys: codes.keys.ptr_mut(),
            low_keys: codes.low_keys.as_ref().map_or(PtrMut::new(0), Buffer::ptr_mut),
            order: codes.order.ptr_mut(),
            count: n,
            code: codes.code,
        },
    )?;
    build.run(rec)?;
    let seen = codes.bounds.read()?[0];
    codes.live = seen.ones & seen.zeros;
    codes.low_live = seen.low_ones & seen.low_zeros;
    codes.hittable = seen.hittable;
    if seen.hittable < n {
        // The key of those that can't be hit sorts them to the end.
        codes.live |= crate::abi::UNHITTABLE_KEY;
    }
    space(&seen)
}

/// Unit space of a scene: the longest edge between ½ and 1, the centre at 0.
///
/// # Errors
/// [`BuildError::TooFar`] where a coordinate overflows there.
fn space(seen: &SceneBounds) -> Result<Space> {
    let bounds = Aabb { lo: seen.lo.map(unordered), hi: seen.hi.map(unordered) };
    if seen.hittable == 0 {
        return Ok(Space { exponent: 0, scale: 1.0, anchor: [0.0; 3], reach: 0.0 });
    }
    let (lo, hi) = (bounds.lo.map(f64::from), bounds.hi.map(f64::from));
    let longest = (0..3).map(|k| hi[k] - lo[k]).fold(0.0, f64::max);
    // A triangle that can be hit has distinct corners, so `longest` is above 0.
    let exponent = (-(longest.log2().floor() as i32) - 1).clamp(-126, 126);
    let scale = 2f64.powi(exponent);
    // + 0: never −0, whichever of −0 and +0 the driver's minimum takes.
    let anchor: [f32; 3] = std::array::from_fn(|k| ((lo[k] + hi[k]) * 0.5 * scale) as f32 + 0.0);
    // Of coordinates that differ, none is 2²⁵ times as large as what they differ by: only those of a plane overflow.
    if let Some(k) = (0..3).find(|&k| !anchor[k].is_finite()) {
        return Err(BuildError::TooFar {
            axis: ['x', 'y', 'z'][k],
            at: bounds.lo[k],
            longest: longest as f32,
        });
    }
    let reach = (0..3)
        .flat_map(|k| [lo[k], hi[k]].map(|x| (x * scale - f64::from(anchor[k])).abs()))
        .fold(0.0, f64::max);
    Ok(Space { exponent, scale: scale as f32, anchor, reach: reach as f32 * 1.000_001 })
}
