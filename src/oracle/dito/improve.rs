//! Twin of `glsl/dito/improve.comp`: local search for a smaller box.

use super::{along, extent, frame_words, from_first};
use crate::bvh::frame::Frame;
use crate::bvh::raw::{greatest_of, least_of};
use crate::oracle::morton::reciprocal;
use glam::Vec3;

/// The first turns' tangent of half the angle: 0.1 rad.
const STEP: f32 = 0.05;

/// Words of the frame of a smaller box around `points` than that of the frame of `words`, where pattern search of so many
/// evaluations finds one.
pub fn improved(words: [u32; 2], points: &[Vec3], evaluations: u32) -> [u32; 2] {
    let points = from_first(points);
    let frame = Frame::of(words);
    let over = reciprocal(frame.stretch());
    let mut rows = frame.rows.map(|axis| axis * over);
    let bounds = extent(rows, &points);
    let mut sizes = Vec3::from_array(std::array::from_fn(|k| bounds.hi[k] - bounds.lo[k]));
    let area_of = |s: Vec3| s.x * (s.y + s.z) + s.y * s.z;
    let mut least_area = area_of(sizes);
    let mut step = STEP;
    let mut improved = false;
    let mut failed = 0;
    for _ in 0..evaluations {
        let turned = turned(rows, step);
        let tried = Vec3::new(sizes.x, width(turned[1], &points), width(turned[2], &points));
        let area = area_of(tried);
        if area < least_area {
            (least_area, sizes, rows) = (area, tried, turned);
            (improved, failed) = (true, 0);
            continue;
        }
        failed += 1;
        step = -step;
        // Both ways failed: the next axis.
        if failed % 2 == 0 {
            rows = [rows[1], rows[2], rows[0]];
            sizes = Vec3::new(sizes.y, sizes.z, sizes.x);
        }
        if failed == 6 {
            (step, failed) = (step * 0.5, 0);
        }
    }
    if improved { frame_words(rows) } else { words }
}

/// Turned about the first axis by the angle of tangent `t` of its half.
fn turned([x, y, z]: [Vec3; 3], t: f32) -> [Vec3; 3] {
    let over = reciprocal(1.0 + t * t);
    let (c, s) = ((1.0 - t * t) * over, (t + t) * over);
    [x, y * c + z * s, z * c - y * s]
}

/// How far points reach along an axis.
fn width(axis: Vec3, points: &[Vec3]) -> f32 {
    let (mut lo, mut hi) = (f32::MAX, f32::MIN);
    for p in points {
        let x = along(axis, *p);
        lo = least_of(lo, x);
        hi = greatest_of(hi, x);
    }
    hi - lo
}
