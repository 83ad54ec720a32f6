//! Tables and what stands on them.

use glam::{DAffine3, DVec3};

use super::SEED;
use crate::scene::procedural::assembly::{Pen, Size};
use crate::scene::procedural::noise::u01;
use crate::scene::procedural::shapes::{CUBOID, cuboid, cylinder, cylinder_size, lathe, tube_size};

/// Height of the tables' tops, metres.
const TOP: f64 = 0.74;

/// A slab on four legs of 24 sides.
pub(super) const TABLE: Size = {
    let leg = cylinder_size(24);
    Size { vertices: CUBOID.vertices + 4 * leg.vertices, triangles: CUBOID.triangles + 4 * leg.triangles }
};

/// Table `i`, of two rows of six.
pub(super) fn table(pen: &mut Pen, i: u32) {
    let (column, row) = (f64::from(i % 6), f64::from(i / 6));
    let middle = DVec3::new(-5.0 + 2.0 * column, 0.0, -0.5 + row);
    pen.within(DAffine3::from_translation(middle), |pen| {
        cuboid(pen, DVec3::new(-0.99, TOP - 0.03, -0.49), DVec3::new(0.99, TOP, 0.49));
        for (x, z) in [(-0.9, -0.4), (0.9, -0.4), (-0.9, 0.4), (0.9, 0.4)] {
            let leg = DAffine3::from_translation(DVec3::new(x, 0.0, z));
            pen.within(leg, |pen| cylinder(pen, 0.025, [0.0, TOP - 0.03], 24));
        }
    });
}

/// Outside from the foot up, and inside down again.
const DRINKING: [(f64, f64); 13] = [
    (0.0005, 0.0),
    (0.033, 0.0),
    (0.034, 0.002),
    (0.008, 0.008),
    (0.004, 0.03),
    (0.004, 0.08),
    (0.02, 0.095),
    (0.034, 0.12),
    (0.032, 0.17),
    (0.0305, 0.17),
    (0.032, 0.12),
    (0.018, 0.097),
    (0.0005, 0.09),
];
/// A foot, a stem, a head.
const MICROPHONE: [(f64, f64); 13] = [
    (0.0005, 0.0),
    (0.06, 0.0),
    (0.06, 0.015),
    (0.05, 0.022),
    (0.006, 0.026),
    (0.004, 0.15),
    (0.004, 0.3),
    (0.012, 0.305),
    (0.017, 0.32),
    (0.017, 0.345),
    (0.013, 0.36),
    (0.006, 0.367),
    (0.0005, 0.368),
];

/// A [`DRINKING`] glass or a [`MICROPHONE`], 24 sides.
pub(super) const GLASS: Size = tube_size(DRINKING.len(), 24);

/// Glass `i`, or every third a microphone, in two rows, flush with the tables; few are spread over all of them.
pub(super) fn glass(pen: &mut Pen, i: u32) {
    let (row, place) = (f64::from(i % 2), f64::from(i / 2 * 17 % 45));
    let jitter = |k: u32| 0.08 * (u01(i, k, SEED + 9) - 0.5);
    let place = DVec3::new(-5.8 + 0.263 * place + jitter(0), TOP, -0.62 + 1.24 * row + jitter(1));
    let profile = if i.is_multiple_of(3) { &MICROPHONE } else { &DRINKING };
    pen.within(DAffine3::from_translation(place), |pen| lathe(pen, profile, 24));
}
