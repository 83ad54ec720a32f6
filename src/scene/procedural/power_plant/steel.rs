//! Columns, beams and braces; gratings, ladders and handrails. Nothing is cut along its length.

use glam::{DAffine3, DVec3};

use super::{BAY, Hall, Part, SEED, STOREY};
use crate::scene::procedural::assembly::{Pen, Size};
use crate::scene::procedural::noise::h32;
use crate::scene::procedural::shapes::{CUBOID, I_BEAM, cuboid, i_beam, rod, rod_size};
use crate::scene::procedural::trig::about;

pub(super) const BEAM: Size = I_BEAM;

/// Where column line (column, row) meets floor `floor`.
fn joint(column: u32, floor: u32, row: u32) -> DVec3 {
    DVec3::new(BAY * f64::from(column), STOREY * f64::from(floor), BAY * f64::from(row))
}

/// How many beams a hall has room for along x and z.
fn girders(hall: Hall) -> [u32; 2] {
    let [x, z] = hall.bays;
    [x * (z + 1) * hall.floors, (x + 1) * z * hall.floors]
}

/// Ends of beam `k` of those along x, then those along z.
fn girder(hall: Hall, k: u32) -> [DVec3; 2] {
    let ([x, z], [along_x, _]) = (hall.bays, girders(hall));
    if k < along_x {
        let (column, k) = (k % x, k / x);
        let (row, floor) = (k % (z + 1), k / (z + 1) + 1);
        return [joint(column, floor, row), joint(column + 1, floor, row)];
    }
    let k = k - along_x;
    let (row, k) = (k % z, k / z);
    let (column, floor) = (k % (x + 1), k / (x + 1) + 1);
    [joint(column, floor, row), joint(column, floor, row + 1)]
}

/// A column, a girder, a brace at 45°, or one of the roof's purlins, which take what the others leave. Where beams are
/// too few for all places, they are spread over them.
pub(super) fn beam(pen: &mut Pen, part: &Part) {
    let (hall, [x, z]) = (part.hall, part.hall.bays);
    let columns = (x + 1) * (z + 1) * hall.floors;
    let girders: u32 = girders(hall).iter().sum();
    let braces = 2 * girders;
    let places = columns + girders + braces;
    let mut k = part.number;
    if part.all < places {
        k = (u64::from(k) * u64::from(places) / u64::from(part.all)) as u32;
    }
    if k < columns {
        let (column, k) = (k % (x + 1), k / (x + 1));
        let (row, floor) = (k % (z + 1), k / (z + 1));
        return i_beam(pen, [joint(column, floor, row), joint(column, floor + 1, row)], 0.4, 0.4);
    }
    k -= columns;
    if k < girders {
        return i_beam(pen, girder(hall, k), 0.2, 0.4);
    }
    k -= girders;
    if k < braces {
        let [p, q] = girder(hall, k / 2);
        let (from, to) = if k.is_multiple_of(2) { (p, q) } else { (q, p) };
        let reach = 2.5;
        let ends = [from - DVec3::Y * reach, from + (to - from) * (reach / BAY)];
        return i_beam(pen, ends, 0.12, 0.12);
    }
    k -= braces;
    let size = hall.size();
    let x = size.x * (f64::from(k) + 0.5) / f64::from(part.all - places);
    let y = size.y + 0.3;
    i_beam(pen, [DVec3::new(x, y, 0.0), DVec3::new(x, y, size.z)], 0.1, 0.2);
}

/// Words of hash for an object of a kind.
fn dice(part: &Part, kind: u32) -> impl Fn(u32) -> u32 {
    let key = h32(part.number, part.unit, SEED + 16 + kind);
    move |k| h32(key, k, SEED + 20)
}

/// Bars of a grating each way.
const BARS: u32 = 60;
pub(super) const GRATING: Size =
    Size { vertices: 2 * BARS as usize * CUBOID.vertices, triangles: 2 * BARS as usize * CUBOID.triangles };

/// A square of 3 m, one of nine in a bay: bars of 4 mm both ways, as high as each other.
pub(super) fn grating(pen: &mut Pen, part: &Part) {
    let (dice, [x, z], floors) = (dice(part, 0), part.hall.bays, part.hall.floors);
    let bay = joint(dice(0) % x, 1 + dice(1) % floors, dice(2) % z);
    let part = |k: u32| 0.5 + 3.0 * f64::from(dice(k) % 3);
    let corner = bay + DVec3::new(part(3), 0.2, part(4));
    for k in 0..BARS {
        let at = 3.0 * f64::from(k) / f64::from(BARS);
        cuboid(pen, corner + DVec3::X * at, corner + DVec3::new(at + 0.004, 0.03, 3.0));
        cuboid(pen, corner + DVec3::Z * at, corner + DVec3::new(3.0, 0.03, at + 0.004));
    }
}

const RUNGS: u32 = 30;
pub(super) const LADDER: Size = Size {
    vertices: 2 * CUBOID.vertices + RUNGS as usize * rod_size(8).vertices,
    triangles: 2 * CUBOID.triangles + RUNGS as usize * rod_size(8).triangles,
};

/// Nine metres up beside a column.
pub(super) fn ladder(pen: &mut Pen, part: &Part) {
    let (dice, [x, z], floors) = (dice(part, 1), part.hall.bays, part.hall.floors);
    let foot = joint(dice(0) % (x + 1), dice(1) % (floors - 2), dice(2) % (z + 1));
    let turn = about(1, 0.25 * f64::from(dice(3) % 4));
    // Ladders at one column stand one above the other only by chance: each a little aside.
    let aside = 0.4 + 0.1 * f64::from(dice(4) % 8);
    pen.within(DAffine3::from_mat3_translation(turn, foot), |pen| {
        for x in [-0.25, 0.23] {
            cuboid(pen, DVec3::new(x, 0.0, aside), DVec3::new(x + 0.02, 9.0, aside + 0.06));
        }
        for k in 0..RUNGS {
            let middle = DVec3::new(0.0, 0.3 * f64::from(k) + 0.2, aside + 0.03);
            rod(pen, [middle - DVec3::X * 0.23, middle + DVec3::X * 0.23], 0.012, 8);
        }
    });
}

const POSTS: u32 = 20;
pub(super) const HANDRAIL: Size = Size {
    vertices: (3 + POSTS as usize) * rod_size(8).vertices,
    triangles: (3 + POSTS as usize) * rod_size(8).triangles,
};

/// Three rails along a girder, each of one piece.
pub(super) fn handrail(pen: &mut Pen, part: &Part) {
    let [p, q] = girder(part.hall, dice(part, 2)(0) % girders(part.hall).iter().sum::<u32>());
    let (foot, way) = (p + DVec3::Y * 0.2, q - p);
    for y in [0.4, 0.75, 1.1] {
        rod(pen, [foot + DVec3::Y * y, foot + way + DVec3::Y * y], 0.02, 8);
    }
    for k in 0..POSTS {
        let post = foot + way * ((f64::from(k) + 0.5) / f64::from(POSTS));
        rod(pen, [post, post + DVec3::Y * 1.1], 0.015, 8);
    }
}
