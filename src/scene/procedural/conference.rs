//! A conference room: walls of two triangles as large as the scene among blinds 1 mm thick, books lying flush on their
//! boards, chairs of many small round faces. Rays start inside and all hit. Beyond one room, rooms side by side.
//!
//! A room is 15 × 4 × 9 m about the middle of its floor: shelves along its low z, windows along its high z.

use glam::{DAffine3, DVec3};

use super::assembly::{Pen, Run, Units, assemble, shares};
use super::noise::{h32, u01};
use super::shapes::{CUBOID, cuboid};
use super::trig::about;
use crate::scene::{Camera, Progress, Scene, SceneError};

mod furniture;
mod table;

/// Triangles of one whole room.
pub(super) const FULL: u64 = 336_668;
/// Half of the room's length, its height, half of its depth.
const ROOM: DVec3 = DVec3::new(7.5, 4.0, 4.5);
const SEED: u32 = 0xC0FE;

/// About `count` triangles, to the nearest box of 12: furniture in proportion, in as many rooms as it fills.
pub(super) fn generate(name: &str, count: u64, progress: Progress) -> Result<Scene, SceneError> {
    let camera = Camera { eye: [-6.6, 2.6, 3.4], target: [0.6, 0.9, -0.6], up: [0.0, 1.0, 0.0], fov_y: 65.0 };
    assemble(name, &runs(count), camera, progress)
}

pub(super) fn runs(count: u64) -> Vec<Run> {
    let units = Units::new(count, FULL, [2.0 * ROOM.x + 0.5, 2.0 * ROOM.z + 0.5]);
    let rooms = u64::from(units.count()) * CUBOID.triangles as u64;
    let kinds = [
        (44, furniture::CHAIR, furniture::chair as fn(&mut Pen, &Place)),
        (90, table::GLASS, table::glass),
        (80, furniture::LAMPSHADE, furniture::lampshade),
        (12, table::TABLE, table::table),
        (40, furniture::LAMP, furniture::lamp),
        (960, CUBOID, book),
        (600, CUBOID, frame),
        (240, CUBOID, wall_slat),
        (96, CUBOID, board),
        (320, CUBOID, blind_slat),
    ];
    let counts = shares(count.saturating_sub(rooms), kinds.each_ref().map(|k| (k.0, k.1.triangles)));
    // Tables and boards, by their order above.
    let (tables, boards) = (counts[3], counts[8]);
    let walls = Run::new(u64::from(units.count()), CUBOID, move |i, pen| {
        pen.within(DAffine3::from_translation(units.place(i)), walls);
    });
    let furniture = kinds.into_iter().zip(counts).map(|((_, size, draw), count)| {
        Run::new(count, size, move |i, pen| {
            let (unit, number) = units.of(i);
            let [tables, boards] = [tables, boards].map(|n| units.share(unit, n));
            let place = Place { number, unit, tables, boards };
            pen.within(DAffine3::from_translation(units.place(unit)), |pen| draw(pen, &place));
        })
    });
    std::iter::once(walls).chain(furniture).collect()
}

/// One object of its kind in a room.
struct Place {
    number: u32,
    /// Which room.
    unit: u32,
    /// What the room has for others to stand on.
    tables: u32,
    boards: u32,
}

/// Floor, ceiling and four walls, seen from inside.
fn walls(pen: &mut Pen) {
    // A box whose x runs backwards is inside out.
    cuboid(pen, DVec3::new(ROOM.x, 0.0, -ROOM.z), DVec3::new(-ROOM.x, ROOM.y, ROOM.z));
}

/// A panel of the ceiling, 30 by 20 of them, flush with it; few are spread over all of it.
fn frame(pen: &mut Pen, place: &Place) {
    let i = place.number * 233;
    let (column, row) = (f64::from(i % 30), f64::from(i / 30 % 20));
    let low = DVec3::new(-ROOM.x + 0.5 * column + 0.01, ROOM.y - 0.02, -ROOM.z + 0.45 * row + 0.01);
    let high = DVec3::new(low.x + 0.48, ROOM.y, low.z + 0.43);
    cuboid(pen, low, high);
}

/// A slat of the two end walls, floor to ceiling, its back flush with the wall.
fn wall_slat(pen: &mut Pen, place: &Place) {
    let i = place.number;
    let z = -ROOM.z + 0.075 * f64::from(i * 53 / 2 % 120) + 0.015;
    let (low, high) = (DVec3::new(0.0, 0.0, z), DVec3::new(0.02, ROOM.y, z + 0.045));
    let wall = DVec3::X * if i.is_multiple_of(2) { -ROOM.x } else { ROOM.x - 0.02 };
    cuboid(pen, low + wall, high + wall);
}

/// Width of a shelf, metres.
const SHELF: f64 = 0.9;

/// The low x, high y, low z corner of board `i`; shelves take turns, so that few boards are in all of them.
fn board_top(i: u32) -> DVec3 {
    let (shelf, level) = (i % 16, i / 16);
    DVec3::new(-7.2 + SHELF * f64::from(shelf), 0.1 + 0.42 * f64::from(level), -ROOM.z)
}

fn board(pen: &mut Pen, place: &Place) {
    let top = board_top(place.number);
    cuboid(pen, top + DVec3::new(0.005, -0.02, 0.0), top + DVec3::new(SHELF - 0.005, 0.0, 0.3));
}

/// A book: ten on each board, half of them upright, flush with the board, half leaning by up to 8°. Where there is no
/// board yet, books lie about where the first would be.
fn book(pen: &mut Pen, place: &Place) {
    let key = h32(place.number, place.unit, SEED);
    let u = |k: u32| u01(key, k, SEED + 1);
    let boards = place.boards.max(1);
    let (board, place) = (place.number % boards, place.number / boards);
    let left = board_top(board) + DVec3::new(0.03 + 0.083 * f64::from(place), 0.0, 0.02 * u(0));
    let (thick, high, deep) = (0.02 + 0.03 * u(1), 0.22 + 0.1 * u(2), 0.16 + 0.1 * u(3));
    let lean = if u(4) < 0.5 { 0.0 } else { (16.0 * u(5) - 8.0) / 360.0 };
    pen.within(DAffine3::from_mat3_translation(about(2, lean), left), |pen| {
        cuboid(pen, DVec3::ZERO, DVec3::new(thick, high, deep));
    });
}

/// A slat of the blinds: eight windows of forty, 1 mm thick, turned by 30°.
fn blind_slat(pen: &mut Pen, place: &Place) {
    let i = place.number;
    let (window, slat) = (f64::from(i % 8), f64::from(i / 8));
    let middle = DVec3::new(-6.475 + 1.85 * window, 1.0 + 0.06 * slat, ROOM.z - 0.1);
    pen.within(DAffine3::from_mat3_translation(about(0, 30.0 / 360.0), middle), |pen| {
        let half = DVec3::new(0.8, 0.0005, 0.03);
        cuboid(pen, -half, half);
    });
}
