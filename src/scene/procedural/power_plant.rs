//! A power plant's insides: pipes, tubes and beams up to 90 m long whose triangles run their whole length (50:1 to
//! 500:1), and clusters of tiny parts, in one huge box. Less is a smaller hall; beyond one hall, halls side by side.
//!
//! A whole hall is 200 × 60 × 80 m with a corner at the origin; 16 floors on columns 10 m apart.

use glam::{DAffine3, DVec3};

use super::assembly::{Pen, Run, Units, assemble, shares};
use super::trig::cube_root;
use crate::scene::{Camera, Progress, Scene, SceneError};

mod pipes;
mod pump;
mod steel;

/// Triangles of one whole hall.
pub(super) const FULL: u64 = 12_698_880;
/// From floor to floor, metres.
const STOREY: f64 = 3.75;
/// Between columns, metres.
const BAY: f64 = 10.0;
const SEED: u32 = 0x9A4C;

/// The building.
#[derive(Debug, Clone, Copy)]
struct Hall {
    /// Between columns along x and z.
    bays: [u32; 2],
    floors: u32,
}

impl Hall {
    /// The hall for `count` triangles: as much smaller than a whole one along each axis as the cube root says.
    fn new(count: u64) -> Self {
        let part = cube_root((FULL as f64 / count.max(1) as f64).max(1.0));
        let scaled = |whole: f64, least: f64| (whole / part + 0.5).floor().max(least) as u32;
        Self { bays: [scaled(20.0, 2.0), scaled(8.0, 1.0)], floors: scaled(16.0, 3.0) }
    }

    fn size(self) -> DVec3 {
        let [x, z] = self.bays.map(|n| BAY * f64::from(n));
        DVec3::new(x, STOREY * f64::from(self.floors), z)
    }
}

/// One object of its kind.
struct Part {
    hall: Hall,
    /// Which hall.
    unit: u32,
    /// Its number in the hall, of `all`.
    number: u32,
    all: u32,
}

/// About `count` triangles, to the nearest beam of 44: every kind in proportion, in as many halls as it fills.
pub(super) fn generate(name: &str, count: u64, progress: Progress) -> Result<Scene, SceneError> {
    let size = hall(count).size();
    let [eye, target] = [DVec3::new(-0.3, 1.5, 2.5), DVec3::new(0.47, 0.42, 0.5)].map(|p| p * size);
    let [eye, target] = [eye, target].map(|p| p.as_vec3().to_array());
    let camera = Camera { eye, target, up: [0.0, 1.0, 0.0], fov_y: 45.0 };
    assemble(name, &runs(count), camera, progress)
}

fn units(count: u64) -> Units {
    Units::new(count, FULL, [240.0, 120.0])
}

fn hall(count: u64) -> Hall {
    Hall::new(count / u64::from(units(count).count()))
}

pub(super) fn runs(count: u64) -> Vec<Run> {
    let (units, hall) = (units(count), hall(count));
    let kinds = [
        (2080, pipes::PIPE, pipes::pipe as fn(&mut Pen, &Part)),
        (1200, pump::PUMP, pump::pump),
        (200, steel::GRATING, steel::grating),
        (400, steel::LADDER, steel::ladder),
        (2000, pipes::WALL_TUBE, pipes::wall_tube),
        (400, steel::HANDRAIL, steel::handrail),
        (20_000, steel::BEAM, steel::beam),
    ];
    let mut counts = shares(count, kinds.each_ref().map(|k| (k.0, k.1.triangles)));
    if counts.iter().all(|&n| n == 0) {
        counts[6] = 1;
    }
    let runs = kinds.into_iter().zip(counts).map(|((_, size, draw), count)| {
        Run::new(count, size, move |i, pen| {
            let (unit, number) = units.of(i);
            let part = Part { hall, unit, number, all: units.share(unit, count) };
            pen.within(DAffine3::from_translation(units.place(unit)), |pen| draw(pen, &part));
        })
    });
    runs.collect()
}
