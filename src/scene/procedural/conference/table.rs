//! Tables and what stands on them.

use glam::{DAffine3, DVec3};

use super::{Place, SEED};
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

/// The middle of table `i`'s place on the floor: two rows of six, filled from the middle of the room.
fn middle(i: u32) -> DVec3 {
    let (column, row) = ([2, 3, 1, 4, 0, 5][(i / 2 % 6) as usize], i % 2 + i / 12 * 2);
    DVec3::new(-5.0 + 2.0 * f64::from(column), 0.0, -0.5 + f64::from(row))
}

pub(super) fn table(pen: &mut Pen, place: &Place) {
    let middle = middle(place.number);
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

/// A glass, or for every third a microphone, flush with its table; seven or eight on each. Where there is no table
/// yet, they stand on the floor.
pub(super) fn glass(pen: &mut Pen, place: &Place) {
    let tables = place.tables.max(1);
    let (table, nth) = (place.number % tables, place.number / tables);
    let jitter = |k: u32| 0.1 * (u01(place.number, k, SEED + 9) - 0.5);
    let (column, row) = (f64::from(nth / 2), f64::from(nth % 2));
    let aside = DVec3::new(-0.76 + 0.38 * column + jitter(0), 0.0, -0.24 + 0.48 * row + jitter(1));
    let height = if place.tables > 0 { TOP } else { 0.0 };
    let foot = middle(table) + aside + DVec3::Y * height;
    let profile = if place.number.is_multiple_of(3) { &MICROPHONE } else { &DRINKING };
    pen.within(DAffine3::from_translation(foot), |pen| lathe(pen, profile, 24));
}
