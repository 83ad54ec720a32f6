//! Filigree: sixteen arms rise from the upper band, each of twelve scrolls to its left and right.

use glam::DVec3;

use crate::scene::procedural::assembly::Pen;
use crate::scene::procedural::shapes::tube;
use crate::scene::procedural::trig::sin_cos;

/// Arms of a crown.
pub(super) const ARMS: u32 = 16;
/// Scrolls of an arm.
const SCROLLS: u32 = 12;
/// Segments of a scroll.
pub(super) const LENGTH: usize = 128;
/// Sides of a scroll.
pub(super) const SIDES: usize = 12;
/// Segments of a whole crown's scrolls.
pub(super) const SEGMENTS: u64 = (ARMS * SCROLLS) as u64 * LENGTH as u64;
/// Triangles of a segment.
pub(super) const SEGMENT_TRIANGLES: usize = 2 * SIDES;

/// A point of an arm at `t` of its height, 0 to 1, and the way outwards: it leans out, and in again at its tip.
fn arm(number: f64, t: f64) -> (DVec3, DVec3) {
    let (sin, cos) = sin_cos(number / f64::from(ARMS));
    let outward = DVec3::new(cos, 0.0, sin);
    (outward * (1.0 + 0.3 * t - 0.25 * t * t * t) + DVec3::Y * (0.4 + 0.5 * t), outward)
}

/// A spiral in an arm's face, that starts at the arm and winds inwards.
struct Scroll {
    stem: DVec3,
    outward: DVec3,
    up: DVec3,
    right: DVec3,
    size: f64,
}

impl Scroll {
    /// Arms take turns, so that few scrolls go all round; they grow smaller towards the tip.
    fn new(i: u32) -> Self {
        let (number, nth) = (f64::from(i % ARMS), i / ARMS);
        let side = if nth.is_multiple_of(2) { 1.0 } else { -1.0 };
        let t = (f64::from(nth / 2) + 0.5) / 6.0;
        let (stem, outward) = arm(number, t);
        let (above, _) = arm(number, t + 0.01);
        let up = (above - stem).normalize();
        let right = up.cross(outward).normalize() * side;
        Self { stem, outward, up, right, size: 0.085 * (1.0 - 0.5 * t) }
    }

    /// The middle of the wire at `s` of its length.
    fn at(&self, s: f64) -> DVec3 {
        let (sin, cos) = sin_cos(2.25 * s - 0.5);
        let r = self.size * (1.0 - 0.85 * s);
        let flat = self.right * (self.size + r * cos) + self.up * (r * sin);
        self.stem + flat + self.outward * (0.01 + 0.02 * s)
    }

    fn radius(&self, s: f64) -> f64 {
        self.size * (0.13 - 0.08 * s)
    }
}

/// A point on the outside of scroll `i` at `s` of its length, and the way outwards.
pub(super) fn point(i: u32, s: f64) -> (DVec3, DVec3) {
    let scroll = Scroll::new(i);
    (scroll.at(s) + scroll.outward * scroll.radius(s), scroll.outward)
}

/// The first `segments` of scroll `i`.
pub(super) fn draw(pen: &mut Pen, i: u32, segments: usize) {
    let scroll = Scroll::new(i);
    let along = |k: usize| k as f64 / LENGTH as f64;
    let points: Vec<DVec3> = (0..=segments).map(|k| scroll.at(along(k))).collect();
    tube(pen, &points, SIDES, |k| scroll.radius(along(k)));
}
