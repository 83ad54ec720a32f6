//! How near each way to fit a box comes to the least one: over random point sets of several kinds, by how much the half
//! area of its box around all points is larger. The methods are those of \[VEVERKOVA24\] as the kernels' twins have them,
//! with frames rounded as nodes hold them; areas in f64.

mod optimum;
mod sets;

pub use optimum::Optimum;
pub use sets::{KINDS, Kind};

use super::dito::{candidates, fitted, frame_words, improved, kept};
use crate::bvh::frame::Frame;
use crate::bvh::{Bases, Directions, Generator};
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// A way to fit a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Axis-aligned.
    Aabb,
    /// DiTO from so many extremal points.
    Dito(u32),
    /// Likewise along these directions.
    Along(u32, Directions),
    /// The least of the boxes of fixed bases.
    Odop(Bases),
    /// DiTO's candidates from so many extremal points, each measured on all points.
    Exact(u32),
    /// DiTO from so many extremal points, then local search on the same.
    Searched(u32),
}

const fn odop(generator: Generator, degree: u32) -> Method {
    Method::Odop(Bases { generator, degree })
}

impl Method {
    /// All that the table has.
    pub const ALL: [Self; 26] = [
        Self::Aabb,
        Self::Dito(12),
        Self::Dito(14),
        Self::Dito(20),
        Self::Dito(26),
        odop(Generator::Grid, 2),
        odop(Generator::Grid, 3),
        odop(Generator::Grid, 4),
        odop(Generator::Grid, 5),
        odop(Generator::Zone, 2),
        odop(Generator::Zone, 3),
        odop(Generator::Zone, 4),
        odop(Generator::Zone, 5),
        Self::Along(14, Directions::Grid),
        Self::Along(14, Directions::Uniform),
        Self::Along(14, Directions::Sphere),
        Self::Along(14, Directions::Zone),
        Self::Along(26, Directions::Grid),
        Self::Along(26, Directions::Sphere),
        Self::Along(26, Directions::Zone),
        odop(Generator::Dito(14), 3),
        odop(Generator::Dito(12), 4),
        odop(Generator::Dito(20), 5),
        Self::Exact(14),
        Self::Searched(14),
        Self::Searched(26),
    ];

    /// As tables have it.
    pub fn name(self) -> String {
        match self {
            Self::Aabb => "aabb".into(),
            Self::Dito(points) => format!("dito{points}"),
            Self::Along(points, directions) => format!("dito{points} {}", directions.name()),
            Self::Odop(Bases { generator: Generator::Grid, degree }) => format!("odop{degree}"),
            Self::Odop(Bases { generator, degree }) => format!("odop{degree} {}", generator.name()),
            Self::Exact(points) => format!("dito{points} exact"),
            Self::Searched(points) => format!("dito{points} searched"),
        }
    }

    /// Frames of which that of the least box around `all` is taken, as nodes of trees take none where it doesn't pay; local
    /// search takes so many evaluations.
    fn frames(self, all: &[Vec3], evaluations: u32) -> Vec<[u32; 2]> {
        let points = |count| kept(all, &Directions::Book.of(count));
        match self {
            Self::Aabb => vec![[0; 2]],
            Self::Dito(count) => vec![[0; 2], fitted(&points(count))],
            Self::Along(count, directions) => vec![[0; 2], fitted(&kept(all, &directions.of(count)))],
            Self::Odop(bases) => bases.frames(),
            Self::Exact(count) => {
                let points = points(count);
                let moved: Vec<Vec3> = points.iter().map(|p| *p - points[0]).collect();
                candidates(&moved).into_iter().map(frame_words).collect()
            }
            Self::Searched(count) => {
                let points = points(count);
                vec![[0; 2], improved(fitted(&points), &points, evaluations)]
            }
        }
    }
}

/// What to measure.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Sets of each kind, 1 at least.
    pub sets: u32,
    /// Evaluations of local search.
    pub evaluations: u32,
}

/// Excess of half area over the near-optimal box's, per cent.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Excess {
    /// Over the sets.
    pub mean: f64,
    /// Of the worst set.
    pub max: f64,
}

/// A kind of sets, and how each of [`Method::ALL`] does.
#[derive(Debug, Clone)]
pub struct Row {
    /// The kind.
    pub kind: Kind,
    /// In the order of [`Method::ALL`].
    pub excess: Vec<Excess>,
}

/// Measures every method on every kind: the same on every machine and with any number of threads.
pub fn measure(settings: Settings) -> Vec<Row> {
    let optimum = Optimum::default();
    let row = |kind: &Kind| {
        let of_set = |i| excesses(&optimum, &kind.points(i), settings.evaluations);
        let all: Vec<Vec<f64>> = (0..settings.sets).into_par_iter().map(of_set).collect();
        let excess = (0..Method::ALL.len()).map(|m| {
            let of_method = || all.iter().map(|set| set[m]);
            Excess {
                mean: of_method().sum::<f64>() / f64::from(settings.sets),
                max: of_method().fold(0.0, f64::max),
            }
        });
        Row { kind: *kind, excess: excess.collect() }
    };
    KINDS.iter().map(row).collect()
}

/// Of each method, per cent.
fn excesses(optimum: &Optimum, points: &[Vec3], evaluations: u32) -> Vec<f64> {
    let all: Vec<DVec3> = points.iter().map(|p| p.as_dvec3()).collect();
    let least = |m: Method| {
        let frames = m.frames(points, evaluations).into_iter().map(axes_of);
        frames.map(|axes| (half_area(&axes, &all), axes)).reduce(|a, b| if b.0 < a.0 { b } else { a })
    };
    let found: Vec<(f64, DMat3)> = Method::ALL.into_iter().filter_map(least).collect();
    let starts: Vec<DMat3> = found.iter().map(|f| f.1).collect();
    let best = optimum.half_area(&all, &starts);
    found.iter().map(|(area, _)| 100.0 * (area / best - 1.0)).collect()
}

/// Axes of a node's frame, unit vectors as columns.
fn axes_of(words: [u32; 2]) -> DMat3 {
    let r = Frame::of(words).rodrigues.as_dvec3();
    optimum::rotation(r).transpose()
}

/// Half area of the box along orthonormal axes, the columns.
fn half_area(axes: &DMat3, points: &[DVec3]) -> f64 {
    let (mut lo, mut hi) = (DVec3::MAX, DVec3::MIN);
    for p in points {
        let x = axes.transpose_mul_vec3(*p);
        lo = lo.min(x);
        hi = hi.max(x);
    }
    let size = hi - lo;
    size.x * (size.y + size.z) + size.y * size.z
}
