//! Process pipes in bundles of sixteen, and the tubes that line a boiler.

use glam::{DAffine3, DVec3};

use super::{Part, SEED};
use crate::scene::procedural::assembly::{Pen, Size};
use crate::scene::procedural::noise::{h32, u01};
use crate::scene::procedural::shapes::{lathe, tube, tube_size};
use crate::scene::procedural::trig::{about, upright};

/// Sides of a pipe.
const SIDES: usize = 16;
/// Straight runs of a pipe; a bend between any two.
const RUNS: usize = 6;
/// Segments of a pipe's bend.
const BEND: usize = 8;
/// Pipes of a bundle.
const BUNDLE: u32 = 16;
/// Profile of a flange, in radii of its pipe.
const FLANGE: [(f64, f64); 7] =
    [(1.01, -0.3), (1.4, -0.3), (1.4, -0.05), (1.25, 0.0), (1.4, 0.05), (1.4, 0.3), (1.01, 0.3)];

/// A tube with two flanges on every run.
pub(super) const PIPE: Size = {
    let (tube, flange) = (tube_size(bent_points(RUNS, BEND), SIDES), tube_size(FLANGE.len(), SIDES));
    Size {
        vertices: tube.vertices + 2 * RUNS * flange.vertices,
        triangles: tube.triangles + 2 * RUNS * flange.triangles,
    }
};

/// Points of a [`bent`] line.
const fn bent_points(runs: usize, bend: usize) -> usize {
    2 + (runs - 1) * (bend + 1)
}

/// A line through corners, each rounded off from `reach` before it to `reach` behind it in `bend` segments.
fn bent(corners: &[DVec3], reach: f64, bend: usize) -> Vec<DVec3> {
    let mut points = vec![corners[0]];
    for c in corners.windows(3) {
        let before = c[1] - (c[1] - c[0]).normalize() * reach;
        let behind = c[1] + (c[2] - c[1]).normalize() * reach;
        points.extend((0..=bend).map(|k| {
            let t = k as f64 / bend as f64;
            before * ((1.0 - t) * (1.0 - t)) + c[1] * (2.0 * t * (1.0 - t)) + behind * (t * t)
        }));
    }
    points.push(corners[corners.len() - 1]);
    points
}

/// A pipe: its bundle's route, moved aside by its place of four by four.
pub(super) fn pipe(pen: &mut Pen, part: &Part) {
    let i = part.number;
    let key = h32(i / BUNDLE, part.unit, SEED);
    let thick = u01(key, 0, SEED + 1);
    let radius = 0.05 + 0.35 * thick * thick * thick;
    let corners = route(key, part.hall.size());
    // Pipes keep three radii apart whichever axis they run along, for no two lanes differ along one axis alone.
    let (row, column) = (f64::from(i % BUNDLE / 4), f64::from(i % 4));
    let lane = DVec3::new(row, row + column, column) * (3.0 * radius);
    pen.within(slant(key, &corners) * DAffine3::from_translation(lane), |pen| {
        tube(pen, &bent(&corners, 4.0 * radius, BEND), SIDES, |_| radius);
        for run in corners.windows(2) {
            let way = run[1] - run[0];
            let (length, d) = (way.length(), way.normalize());
            let turn = upright(d) * radius;
            for at in [6.0 * radius, length - 6.0 * radius] {
                let pose = DAffine3::from_mat3_translation(turn, run[0] + d * at);
                pen.within(pose, |pen| lathe(pen, &FLANGE, SIDES));
            }
        }
    });
}

/// Corners of a bundle's route: six runs of 5 to 90 m along the axes, within the hall.
fn route(key: u32, hall: DVec3) -> [DVec3; RUNS + 1] {
    let u = |k: u32| u01(key, k, SEED + 2);
    let mut p = [hall.x * u(0), hall.y * u(1), hall.z * u(2)];
    let mut axis = if u(3) < 0.7 { 0 } else { 2 };
    let mut corners = [DVec3::from_array(p); RUNS + 1];
    for (k, corner) in corners.iter_mut().enumerate().skip(1) {
        let roll = |j: u32| u(4 * k as u32 + j);
        let wanted = if axis == 1 { 5.0 + 15.0 * roll(0) } else { 5.0 + 85.0 * roll(0) };
        let room = hall[axis] - p[axis];
        let forth = if wanted <= room.min(p[axis]) { roll(1) < 0.5 } else { room > p[axis] };
        p[axis] += if forth { wanted.min(room) } else { -wanted.min(p[axis]) };
        *corner = DVec3::from_array(p);
        // On along another axis, upwards less often.
        axis = match axis {
            1 => 2 * usize::from(roll(2) < 0.4),
            level if roll(2) < 0.4 => 2 - level,
            _ => 1,
        };
    }
    corners
}

/// Of a hundred bundles, 85 stand on the axes, 8 are turned by 45° about y, and 7 inclined by 5° to 10°.
fn slant(key: u32, corners: &[DVec3]) -> DAffine3 {
    let turn = match u01(key, 0, SEED + 3) {
        u if u < 0.85 => return DAffine3::IDENTITY,
        u if u < 0.93 => about(1, 0.125),
        _ => about(2, (5.0 + 5.0 * u01(key, 1, SEED + 3)) / 360.0),
    };
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    DAffine3::from_translation(middle) * DAffine3::from_mat3(turn) * DAffine3::from_translation(-middle)
}

/// Sides of a boiler's tube, and segments of its bends.
const WALL_SIDES: usize = 8;
const WALL_BEND: usize = 6;
/// Radius of a boiler's tube, metres; its neighbours touch it.
const WALL_RADIUS: f64 = 0.03;
/// The middle of the boiler's floor, in sizes of the hall.
const BOILER: DVec3 = DVec3::new(0.73, 0.0, 0.5);
/// A tube's corners, by how far inwards of the wall in its half widths, and how high in heights of the hall: a hopper,
/// a wall, a nose, a roof.
const WALL: [(f64, f64); 6] = [(0.6, 0.05), (0.0, 0.22), (0.0, 0.55), (0.23, 0.62), (0.23, 0.82), (0.8, 0.9)];

pub(super) const WALL_TUBE: Size = tube_size(bent_points(WALL.len() - 1, WALL_BEND), WALL_SIDES);

/// A tube of the boiler's four walls, which are as wide as their tubes make them.
pub(super) fn wall_tube(pen: &mut Pen, part: &Part) {
    let (wall, place, hall) = (part.number % 4, part.number / 4, part.hall.size());
    let half = f64::from(part.all.div_ceil(4)) * WALL_RADIUS;
    let across = (2.0 * f64::from(place) + 1.0) * WALL_RADIUS - half;
    let corners = WALL.map(|(inwards, y)| DVec3::new(across, y * hall.y, half * (1.0 - inwards)));
    let pose = DAffine3::from_mat3_translation(about(1, 0.25 * f64::from(wall)), BOILER * hall);
    // The lowest run is 1.9 m high at least.
    pen.within(pose, |pen| tube(pen, &bent(&corners, 0.3, WALL_BEND), WALL_SIDES, |_| WALL_RADIUS));
}
