//! Pumps: turned housings and bolts, thousands of small triangles in a cluster on a floor.

use glam::{DAffine3, DVec3};

use super::{BAY, Part, SEED, STOREY};
use crate::scene::procedural::assembly::{Pen, Size};
use crate::scene::procedural::noise::h32;
use crate::scene::procedural::shapes::{CUBOID, cuboid, lathe, tube_size};
use crate::scene::procedural::trig::{about, circle, upright};

const SIDES: usize = 16;
/// Pumps of a cluster, in rows of five.
const CLUSTER: u32 = 20;

// Radius and place along the shaft, metres; the volute's middle is at 0.
const MOTOR: [(f64, f64); 17] = [
    (0.05, 0.2),
    (0.26, 0.2),
    (0.26, 0.24),
    (0.2, 0.26),
    (0.2, 0.34),
    (0.27, 0.35),
    (0.27, 0.44),
    (0.24, 0.45),
    (0.24, 0.54),
    (0.27, 0.55),
    (0.27, 0.64),
    (0.24, 0.65),
    (0.24, 0.74),
    (0.27, 0.75),
    (0.27, 0.9),
    (0.2, 0.96),
    (0.02, 0.97),
];
const VOLUTE: [(f64, f64); 13] = [
    (0.1, -0.17),
    (0.2, -0.17),
    (0.3, -0.155),
    (0.36, -0.12),
    (0.4, -0.08),
    (0.42, -0.04),
    (0.43, 0.0),
    (0.42, 0.04),
    (0.4, 0.08),
    (0.36, 0.12),
    (0.3, 0.155),
    (0.2, 0.2),
    (0.05, 0.2),
];
const INLET: [(f64, f64); 10] = [
    (0.1, -0.5),
    (0.22, -0.5),
    (0.22, -0.46),
    (0.15, -0.45),
    (0.13, -0.4),
    (0.12, -0.35),
    (0.12, -0.25),
    (0.14, -0.2),
    (0.18, -0.18),
    (0.2, -0.16),
];
const OUTLET: [(f64, f64); 10] = [
    (0.2, 0.3),
    (0.16, 0.36),
    (0.13, 0.4),
    (0.12, 0.45),
    (0.12, 0.55),
    (0.13, 0.6),
    (0.15, 0.64),
    (0.21, 0.65),
    (0.21, 0.7),
    (0.1, 0.7),
];
/// Bolts of the flanges at motor, inlet and outlet: how many, radius of their circle, place along its axis.
const BOLTS: [(usize, f64, f64); 3] = [(16, 0.23, 0.25), (12, 0.185, -0.445), (12, 0.18, 0.635)];
const FEET: usize = 4;

pub(super) const PUMP: Size = {
    let boxes = BOLTS[0].0 + BOLTS[1].0 + BOLTS[2].0 + FEET;
    let points = [MOTOR.len(), VOLUTE.len(), INLET.len(), OUTLET.len()];
    let mut size = Size { vertices: boxes * CUBOID.vertices, triangles: boxes * CUBOID.triangles };
    let mut k = 0;
    while k < points.len() {
        let part = tube_size(points[k], SIDES);
        size.vertices += part.vertices;
        size.triangles += part.triangles;
        k += 1;
    }
    size
};

/// A pump, of 0.4 to 1.1 times its size, on one of the lower floors.
pub(super) fn pump(pen: &mut Pen, part: &Part) {
    let bays = part.hall.bays;
    let clusters = part.all.div_ceil(CLUSTER);
    let (cluster, place) = (part.number % clusters, part.number / clusters);
    let dice = |k: u32| h32(h32(cluster, part.unit, SEED + 24), k, SEED + 25);
    let unit = |k: u32| f64::from(dice(k) >> 8) / f64::from(1 << 24);
    let bay = DVec3::new(f64::from(dice(0) % bays[0]), 0.0, f64::from(dice(1) % bays[1])) * BAY;
    let scale = 0.4 + 0.7 * unit(2);
    let grid = DVec3::new(f64::from(place % 5), 0.0, f64::from(place / 5)) * (1.9 * scale);
    let floor = DVec3::Y * (STOREY * f64::from(dice(3) % part.hall.floors.min(5)) + 0.2 + 0.5 * scale);
    let turn = about(1, 0.25 * f64::from(dice(4) % 4)) * scale;
    let pose = DAffine3::from_mat3_translation(turn, bay + DVec3::new(1.0, 0.0, 1.0) + grid + floor);
    pen.within(pose, draw);
}

/// A pump about its shaft, the x axis; its feet 0.5 m below.
fn draw(pen: &mut Pen) {
    let shaft = DAffine3::from_mat3(upright(DVec3::X));
    pen.within(shaft, |pen| {
        lathe(pen, &MOTOR, SIDES);
        lathe(pen, &VOLUTE, SIDES);
        lathe(pen, &INLET, SIDES);
        bolts(pen, BOLTS[0]);
        bolts(pen, BOLTS[1]);
    });
    lathe(pen, &OUTLET, SIDES);
    bolts(pen, BOLTS[2]);
    for (x, z) in [(-0.12, -0.25), (-0.12, 0.2), (0.7, -0.25), (0.7, 0.2)] {
        cuboid(pen, DVec3::new(x, -0.5, z), DVec3::new(x + 0.2, -0.2, z + 0.05));
    }
}

/// Bolts on a circle about the y axis.
fn bolts(pen: &mut Pen, (count, radius, y): (usize, f64, f64)) {
    for (cos, sin) in circle(count) {
        let middle = DVec3::new(radius * cos, y, radius * sin);
        let half = DVec3::new(0.012, 0.03, 0.012);
        cuboid(pen, middle - half, middle + half);
    }
}
