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
        let [short, long] = [Morton::Bits30, Morton::Bits63].map(|m| morton::encode(&soup, &bounds, m));
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
        for morton in Morton::ALL {
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
        [Morton::Bits63, Morton::Ext4, Morton::Ext7].map(|morton| {
            assert_twin("a size", &device, &soup, &Recipe { morton, ..Recipe::default() });
            morton::encode(&soup, &morton::bounds(&soup).0, morton)
        })
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
    for morton in Morton::ALL {
        let behind = u64::from(UNHITTABLE_KEY) << if morton::is_wide(morton) { 32 } else { 0 };
        let codes = morton::encode(&soup, &bounds, morton);
        assert_eq!([0, 2].map(|i| codes[i]), [behind; 2], "{morton:?}");
        assert!(codes[1] < behind, "{morton:?}");
    }
}

/// Bits of `code` at the places, from the top, where `of_size` is `wanted`.
fn bits(code: u64, of_size: impl Fn(u32) -> bool, wanted: bool) -> Vec<u64> {
    (0..63).filter(|place| of_size(*place) == wanted).map(|place| code >> (62 - place) & 1).collect()
}

#[test]
fn extended_codes_are_codes_with_sizes_between() {
    // Cubes' corners as triangles, so that boxes are cubes: edge 2⁻ᵏ of a scene of edge 1.
    let cube = |at: f32, edge: f32| [[at; 3], [at + edge, at, at], [at + edge; 3]];
    let mut corners: Vec<Corners> = (0..20).map(|k| cube(0.0, 0.5f32.powi(k))).collect();
    corners.extend((0..2000).map(|i| cube(i as f32 * 4.5e-4, (i % 97) as f32 * 1e-3 + 1e-6)));
    let soup = scene(&corners);
    let bounds = morton::bounds(&soup).0;
    let plain = morton::encode(&soup, &bounds, Morton::Bits63);
    for (morton, axis_bits, size_bits, every) in [(Morton::Ext4, 16, 15, 4), (Morton::Ext7, 18, 9, 7)] {
        let is_size = |place: u32| place % every == every - 1;
        let (mut before, mut sizes) = (u64::MAX, 0);
        for (i, (code, plain)) in morton::encode(&soup, &bounds, morton).iter().zip(&plain).enumerate() {
            let places = bits(*code, is_size, false);
            assert_eq!(places, bits(*plain, |_| false, false)[..3 * axis_bits], "{morton:?}, triangle {i}");
            let bits = bits(*code, is_size, true);
            assert_eq!(bits.len(), size_bits);
            let size = bits.iter().fold(0, |size, bit| size << 1 | bit);
            if let (0..20, k) = (i, i as u32) {
                let expected = (1u64 << size_bits >> k).min((1 << size_bits) - 1);
                // Off by the reciprocal's rounding where the size is a whole number.
                assert!(size == expected || size + 1 == expected, "{morton:?}: {size}, not {expected}");
                assert!(size <= before, "{morton:?}: sizes fall with the edge");
                before = size;
            }
            sizes |= size;
        }
        assert!(sizes.count_ones() as usize == size_bits, "{morton:?}: every bit of size is used");
    }
}
