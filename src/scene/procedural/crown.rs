//! A crown: smooth bands, filigree of scrolls, and cut gems half sunk in the metal at every angle. Dense clusters on a
//! thin ring about an empty middle; flat facets cut into coplanar triangles; surfaces that cross.
//! Beyond one crown, crowns side by side.
//!
//! The ring lies in the xz plane about the y axis, with a radius of 1.

use glam::{DAffine3, DVec3};

use super::assembly::{Pen, Run, Size, Units, assemble, shares};
use super::noise::{h32, u01};
use super::shapes::{icosphere, icosphere_size, tube_sides, tube_size};
use super::trig::{about, any_rotation, circle, sin_cos};
use crate::scene::{Camera, Progress, Scene, SceneError};

pub(super) mod gem;
mod scroll;

/// Triangles of one whole crown.
pub(super) const FULL: u64 = 3_520_512;
/// Bands of a crown: height, half height, half thickness.
const BANDS: [(f64, f64, f64); 4] =
    [(0.0, 0.05, 0.05), (0.14, 0.085, 0.022), (0.28, 0.05, 0.04), (0.38, 0.025, 0.03)];
/// Cells of a whole crown's band along and around.
const BAND: (u64, u64) = (1024, 64);
const GEMS: u64 = 1400;
const BEADS: u64 = 200;
const SEED: u32 = 0xC40A;

/// About `count` triangles, to the nearest 24: gems and beads in proportion, scrolls for the rest, the last one cut
/// short. A crown that is not whole has all of its bands, of coarser cells.
pub(super) fn generate(name: &str, count: u64, progress: Progress) -> Result<Scene, SceneError> {
    let camera = Camera { eye: [1.1, 1.7, 2.4], target: [0.0, 0.3, 0.1], up: [0.0, 1.0, 0.0], fov_y: 50.0 };
    assemble(name, &runs(count), camera, progress)
}

pub(super) fn runs(count: u64) -> Vec<Run> {
    let units = Units::new(count, FULL, [3.0; 2]);
    let crowns = u64::from(units.count());
    let (along, around) = band_cells(count / crowns);
    let band_size = Size { vertices: along * around, triangles: 2 * along * around };
    let bands = if band_size.triangles == 0 { 0 } else { crowns * BANDS.len() as u64 };
    // What the bands took more or less than their share, the others have less or more.
    let rest = count.saturating_sub(bands * band_size.triangles as u64);
    let segment = scroll::SEGMENT_TRIANGLES;
    let kinds = [(GEMS, gem::SIZE.triangles), (BEADS, BEAD.triangles), (scroll::SEGMENTS, segment)];
    let [gems, beads, segments] = shares(rest, kinds);
    let segments = if bands + gems + beads == 0 { segments.max(1) } else { segments };
    let (scrolls, last) = (segments / scroll::LENGTH as u64, segments as usize % scroll::LENGTH);
    let placed = move |i: u32, pen: &mut Pen, draw: &dyn Fn(&mut Pen, u32, u32)| {
        let (unit, i) = units.of(i);
        pen.within(DAffine3::from_translation(units.place(unit)), |pen| draw(pen, i, unit));
    };
    vec![
        Run::new(bands, band_size, move |i, pen| {
            placed(i, pen, &|pen, i, _| band(pen, BANDS[i as usize % BANDS.len()], along, around));
        }),
        Run::new(gems, gem::SIZE, move |i, pen| {
            placed(i, pen, &|pen, i, unit| set_gem(pen, i, unit, units.share(unit, scrolls)));
        }),
        Run::new(beads, BEAD, move |i, pen| {
            placed(i, pen, &|pen, i, unit| bead(pen, i, units.share(unit, beads)));
        }),
        Run::new(scrolls, tube_size(scroll::LENGTH + 1, scroll::SIDES), move |i, pen| {
            placed(i, pen, &|pen, i, _| scroll::draw(pen, i, scroll::LENGTH));
        }),
        Run::new(u64::from(last > 0), tube_size(last + 1, scroll::SIDES), move |_, pen| {
            placed(scrolls as u32, pen, &|pen, i, _| scroll::draw(pen, i, last));
        }),
    ]
}

/// Cells of a band along and around, where a crown has `count` triangles; none where they would be too many for it.
fn band_cells(count: u64) -> (usize, usize) {
    let part = (count as f64 / FULL as f64).sqrt().min(1.0);
    let cells = |whole: u64, least: u64| ((whole as f64 * part + 0.5).floor() as u64).max(least);
    let (along, around) = (cells(BAND.0, 16), cells(BAND.1, 4));
    if 2 * along * around * BANDS.len() as u64 > count { (0, 0) } else { (along as usize, around as usize) }
}

/// A ring about the y axis, its section an ellipse.
fn band(pen: &mut Pen, (y, high, thick): (f64, f64, f64), along: usize, around: usize) {
    let section = circle(around);
    let mut vertices = Vec::with_capacity(along * around);
    for (cos, sin) in circle(along) {
        for &(c, s) in &section {
            let r = 1.0 + thick * c;
            vertices.push(pen.vertex(DVec3::new(r * cos, y + high * s, r * sin)));
        }
    }
    // As a tube's sides whose last ring is the first again.
    for side in tube_sides(0, around).take(along * around) {
        pen.quad(side.map(|v| vertices[v as usize % vertices.len()]));
    }
}

/// A point of the metal and the way out of it, by hash: two of three on a band's outside, the others on one of the
/// crown's first so many scrolls.
fn setting(key: u32, scrolls: u32) -> (DVec3, DVec3) {
    let u = |k: u32| u01(key, k, SEED + 1);
    let choice = |k: u32| h32(key, k, SEED + 2);
    if scrolls > 0 && choice(0).is_multiple_of(3) {
        return scroll::point(choice(1) % scrolls, u(0));
    }
    let (y, high, thick) = BANDS[choice(2) as usize % BANDS.len()];
    let ((sin, cos), (s, c)) = (sin_cos(u(1)), sin_cos(0.36 * (u(2) - 0.5)));
    let outward = DVec3::new(c * cos, s, c * sin);
    (DVec3::new((1.0 + thick * c) * cos, y + high * s, (1.0 + thick * c) * sin), outward)
}

/// Gem `i`: turned at random, set a third to a half deep.
fn set_gem(pen: &mut Pen, i: u32, unit: u32, scrolls: u32) {
    let key = h32(i, unit, SEED);
    let (p, outward) = setting(key, scrolls);
    let small = u01(key, 8, SEED + 1);
    let size = 0.01 + 0.05 * small * small;
    let p = p + outward * (size * (0.3 * u01(key, 9, SEED + 1)));
    let turn = any_rotation(key, 10, SEED + 1) * size;
    pen.within(DAffine3::from_mat3_translation(turn, p), gem::brilliant);
}

/// Cuts of a bead's edges.
const BEAD_CUTS: usize = 8;
const BEAD: Size = icosphere_size(BEAD_CUTS);

/// Bead `i` of `all`: side by side on the uppermost band.
fn bead(pen: &mut Pen, i: u32, all: u32) {
    let radius = 0.0147;
    let turn = about(1, f64::from(i) / f64::from(all));
    let place = DAffine3::from_mat3_translation(turn * radius, turn * DVec3::new(1.0, 0.412, 0.0));
    pen.within(place, |pen| icosphere(pen, BEAD_CUTS));
}
