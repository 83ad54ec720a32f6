//! Scene bounds and Morton codes. Every build of `matrix` compares them too.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::assert_twin;
use crate::soup::{Corners, moved, random, scene};
use boxwood::abi::{MortonBoundsArgs, SPEC_ITEMS, SPEC_WG, SceneBounds, UNHITTABLE_KEY};
use boxwood::bvh::{Morton, Recipe, SceneBuffers};
use boxwood::device::{Buffer, Recorder, Timing};
use boxwood::kernels;
use boxwood::oracle::morton;
use proptest::prelude::*;

proptest! {
    #[test]
    fn reciprocal_is_good_to_two_ulps(bits in 0x0200_0000u32..0x7d00_0000) {
        let x = f32::from_bits(bits);
        let (r, exact) = (morton::reciprocal(x), 1.0 / f64::from(x));
        prop_assert!((f64::from(r) / exact - 1.0).abs() < 2.5e-7, "1/{x:e} = {r:e}");
    }

    #[test]
    fn codes_interleave_and_keep_order(a in -1f32..1.0, b in -1f32..1.0, axis in 0usize..3) {
        let at = |x: f32| -> Corners {
            let mut p = [0.0; 3];
            p[axis] = x;
            [p, p.map(|x| x + 1e-4), p.map(|x| x - 1e-4)]
        };
        let soup = scene(&[at(a), at(b), at(-1.0), at(1.0)]);
        let bounds = morton::bounds(&soup).0;
        let (short, long) = (morton::encode_30(&soup, &bounds), morton::encode_63(&soup, &bounds));
        prop_assert_eq!(short[0], long[0] >> 33);
        prop_assert!((a < b) == (long[0] < long[1]) || long[0] == long[1] || (a - b).abs() < 1e-5);
    }
}

#[test]
fn bounds_grow_from_any_start() {
    let device = quiet();
    for n in [1usize, 7, 9, 300, 5000] {
        let soup = scene(&random(n, 0.5, n as u64));
        let (expected, count) = morton::bounds(&soup);
        let triangles = SceneBuffers::upload(&device, &soup).unwrap().triangles;
        let bounds = Buffer::from_slice(&device, "bounds", &[SceneBounds::EMPTY]).unwrap();
        let shape = device.shape();
        let mut rec = Recorder::new(&device, Timing::Off).unwrap();
        let args =
            MortonBoundsArgs { triangles: triangles.ptr().cast(), bounds: bounds.ptr_mut(), count: n as u32 };
        let groups = (n as u32).div_ceil(shape.workgroup * shape.items);
        let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items)];
        rec.dispatch(&kernels::MORTON_BOUNDS, &constants, groups, args).unwrap();
        rec.submit().unwrap();
        let seen = bounds.read().unwrap()[0];
        let unordered = |key: u32| f32::from_bits(if key >> 31 != 0 { key & 0x7fff_ffff } else { !key });
        assert_eq!((seen.lo.map(unordered), seen.hi.map(unordered)), (expected.lo, expected.hi));
        assert_eq!((seen.hittable, count), (n as u32, n as u32));
    }
}

#[test]
fn codes_of_scenes_of_any_size_and_place() {
    let device = quiet();
    let soup = random(700, 0.2, 1);
    let huge = 1.6e38;
    for (scale, shift) in [
        (1.0f32, 0.0f32),
        (1e-30, 0.0),
        (1e-38, 0.0),
        (1e-44, 0.0),
        (1e30, 0.0),
        (huge, 0.0),
        (1.0, 1e6),
        (1.0, -3e7),
        (1e30, 1e36),
    ] {
        let soup = scene(&moved(&soup, |p| p.map(|x| x * scale + shift)));
        for morton in [Morton::Bits30, Morton::Bits63] {
            let recipe = Recipe { morton, ..Recipe::default() };
            assert_twin(&format!("· {scale:e} + {shift:e}"), &device, &soup, &recipe);
        }
    }
}

#[test]
fn codes_know_no_size() {
    let device = quiet();
    let codes = |corners: &[Corners]| {
        let soup = scene(corners);
        assert_twin("a size", &device, &soup, &Recipe { morton: Morton::Bits63, ..Recipe::default() });
        morton::encode_63(&soup, &morton::bounds(&soup).0)
    };
    // Multiples of 2⁻¹²: exact at each of these sizes.
    let soup = moved(&random(700, 0.2, 3), |p| p.map(|x| (x * 4096.0).round() / 4096.0));
    let plain = codes(&soup);
    for exponent in [-113, -90, -41, 61, 100, 127] {
        let sized = moved(&soup, |p| p.map(|x| x * 2f32.powi(exponent)));
        assert!(codes(&sized) == plain, "· 2^{exponent}");
    }
    // Tiny along two axes, and far out on the third.
    let far = |scale: f32| moved(&soup, |p| [p[0] * scale, 7.0, p[2] * scale]);
    assert!(codes(&far(2f32.powi(-90))) == codes(&far(1.0)));
}

#[test]
fn triangles_that_can_not_be_hit_come_last() {
    let soup = scene(&[[[f32::NAN; 3]; 3], random(1, 1.0, 2)[0], [[1.0; 3]; 3]]);
    let (bounds, hittable) = morton::bounds(&soup);
    assert_eq!(hittable, 1);
    let unhittable = u64::from(UNHITTABLE_KEY);
    assert_eq!(morton::encode_30(&soup, &bounds).iter().filter(|k| **k == unhittable).count(), 2);
    assert!(morton::encode_63(&soup, &bounds).iter().filter(|k| **k == unhittable << 32).count() == 2);
}
