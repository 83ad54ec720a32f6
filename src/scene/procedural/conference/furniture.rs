//! Chairs and lamps.

use glam::{DAffine3, DVec3};

use super::{Place, ROOM, SEED};
use crate::scene::procedural::assembly::{Pen, Size};
use crate::scene::procedural::noise::u01;
use crate::scene::procedural::shapes::{CUBOID, cuboid, cushion, cushion_size, lathe, tube, tube_size};
use crate::scene::procedural::trig::{about, sin_cos};

const CUSHION: (usize, usize) = (32, 20);
const LEG: (usize, usize) = (17, 12);
const ARMREST: (usize, usize) = (25, 8);

/// Two cushions, four legs, two armrests.
pub(super) const CHAIR: Size = {
    let cushion = cushion_size(CUSHION.0, CUSHION.1);
    let (leg, arm) = (tube_size(LEG.0, LEG.1), tube_size(ARMREST.0, ARMREST.1));
    Size {
        vertices: 2 * cushion.vertices + 4 * leg.vertices + 2 * arm.vertices,
        triangles: 2 * cushion.triangles + 4 * leg.triangles + 2 * arm.triangles,
    }
};

/// A chair: two of three in two rows along the tables, facing them; every third by a wall, turned at random.
pub(super) fn chair(pen: &mut Pen, place: &Place) {
    let i = place.number;
    let side = |odd: u32| if odd.is_multiple_of(2) { 1.0 } else { -1.0 };
    let (turns, place) = if i % 3 < 2 {
        let s = side(i % 3);
        let row = f64::from(i / 3);
        (if s > 0.0 { 0.5 } else { 0.0 }, DVec3::new(-5.74 + 0.82 * row, 0.0, s * 1.45))
    } else {
        let (s, row) = (side(i / 3), f64::from(i / 6));
        (u01(i, 0, SEED + 8), DVec3::new(-5.4 + 1.8 * row, 0.0, s * 3.1))
    };
    pen.within(DAffine3::from_mat3_translation(about(1, turns), place), chair_facing_z);
}

fn chair_facing_z(pen: &mut Pen) {
    let (seat, back) = (DVec3::new(0.25, 0.045, 0.24), DVec3::new(0.24, 0.28, 0.04));
    let (sides, bands) = CUSHION;
    let at = DAffine3::from_translation;
    pen.within(at(DVec3::new(0.0, 0.46, 0.0)), |pen| cushion(pen, seat, sides, bands));
    let lean = about(0, -10.0 / 360.0);
    let behind = DAffine3::from_mat3_translation(lean, DVec3::new(0.0, 0.8, -0.27));
    pen.within(behind, |pen| cushion(pen, back, sides, bands));
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        // Out from under the seat, round a bend, down to the floor.
        let points: Vec<DVec3> = curve(LEG.0)
            .map(|(t, sin, cos)| {
                let out = 0.1 + 0.13 * sin + 0.03 * t;
                DVec3::new(x * out, 0.42 - 0.42 * (0.25 * (1.0 - cos) + 0.75 * t * t), z * out)
            })
            .collect();
        tube(pen, &points, LEG.1, |_| 0.014);
    }
    for x in [-1.0, 1.0] {
        let points: Vec<DVec3> = curve(ARMREST.0)
            .map(|(t, sin, cos)| DVec3::new(x * 0.28, 0.44 + 0.22 * sin + 0.02 * t, 0.2 * cos - 0.22 * t))
            .collect();
        tube(pen, &points, ARMREST.1, |_| 0.018);
    }
}

/// So many points from 0 to 1, and sine and cosine of as much of a quarter turn.
fn curve(points: usize) -> impl Iterator<Item = (f64, f64, f64)> {
    (0..points).map(move |k| {
        let t = k as f64 / (points - 1) as f64;
        let (sin, cos) = sin_cos(0.25 * t);
        (t, sin, cos)
    })
}

/// A box and eight louvres.
pub(super) const LAMP: Size = Size { vertices: 9 * CUBOID.vertices, triangles: 9 * CUBOID.triangles };

/// A ceiling lamp, of ten by four.
pub(super) fn lamp(pen: &mut Pen, place: &Place) {
    let i = place.number;
    let (column, row) = (f64::from(i * 3 % 10), f64::from(i / 10));
    let middle = DVec3::new(-6.25 + column / 0.72, ROOM.y - 0.06, -3.3 + 2.2 * row);
    let box_half = DVec3::new(0.3, 0.03, 0.14);
    cuboid(pen, middle - box_half, middle + box_half);
    for k in 0..8 {
        let louvre = middle + DVec3::new(-0.28 + 0.08 * f64::from(k), -0.05, 0.0);
        let half = DVec3::new(0.0005, 0.02, 0.13);
        cuboid(pen, louvre - half, louvre + half);
    }
}

const SHADE: [(f64, f64); 9] = [
    (0.17, -0.12),
    (0.168, -0.08),
    (0.16, -0.04),
    (0.145, 0.0),
    (0.12, 0.035),
    (0.09, 0.06),
    (0.05, 0.08),
    (0.012, 0.09),
    (0.012, 0.6),
];
/// A shade and its stem.
pub(super) const LAMPSHADE: Size = tube_size(SHADE.len(), 32);

/// A lampshade, of twenty by four that hang over the room.
pub(super) fn lampshade(pen: &mut Pen, place: &Place) {
    let i = place.number;
    let (column, row) = (f64::from(i * 7 % 20), f64::from(i / 20));
    let place = DVec3::new(-6.65 + 0.7 * column, ROOM.y - 0.6, -2.7 + 1.8 * row);
    pen.within(DAffine3::from_translation(place), |pen| lathe(pen, &SHADE, 32));
}
