//! Directions along which DiTO takes extremal points: those of the book \[LARSSON11\], or axes of generated bases instead;
//! and the other way round, bases that the book's directions span \[VEVERKOVA24, future work\].

use super::frame::along;
use super::{Bases, Generator};
use glam::{DVec3, Vec3};

/// (√5 − 1) / 2.
const A: f32 = 0.618_034;
const B: f32 = 1.618_034;

/// Where directions come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Directions {
    /// The book's: of the icosahedron's and the dodecahedron's corners, or of the cube's faces, corners and edges.
    #[default]
    Book,
    /// Axes of bases on the grid.
    Grid,
    /// Of random ones in the unit cube.
    Uniform,
    /// Of random ones on the unit sphere.
    Sphere,
    /// Of bases spread evenly over the domain of all box orientations.
    Zone,
}

impl Directions {
    /// Every choice.
    pub const ALL: [Self; 5] = [Self::Book, Self::Grid, Self::Uniform, Self::Sphere, Self::Zone];

    /// As arguments and reports have it.
    pub fn name(self) -> &'static str {
        match self.generator() {
            None => "book",
            Some(generator) => generator.name(),
        }
    }

    /// What makes them, where they aren't the book's.
    pub fn generator(self) -> Option<Generator> {
        match self {
            Self::Book => None,
            Self::Grid => Some(Generator::Grid),
            Self::Uniform => Some(Generator::Uniform),
            Self::Sphere => Some(Generator::Sphere),
            Self::Zone => Some(Generator::Zone),
        }
    }

    /// Those of a set of `points` extremal points, 12, 14, 20 or 26: half as many, of any length.
    pub fn of(self, points: u32) -> Vec<Vec3> {
        match self.generator() {
            None => book(points),
            Some(generator) => generated(generator, points as usize / 2),
        }
    }
}

fn book(points: u32) -> Vec<Vec3> {
    let v = Vec3::new;
    let mut all = match points {
        12 => {
            return vec![
                v(0., 1., A),
                v(0., 1., -A),
                v(1., A, 0.),
                v(-1., A, 0.),
                v(A, 0., 1.),
                v(A, 0., -1.),
            ];
        }
        20 => {
            let golden = [v(0., A, B), v(0., A, -B), v(A, B, 0.), v(A, -B, 0.), v(B, 0., A), v(B, 0., -A)];
            let corners = [v(1., 1., 1.), v(1., 1., -1.), v(1., -1., 1.), v(1., -1., -1.)];
            return [&golden[..], &corners].concat();
        }
        _ => vec![Vec3::X, Vec3::Y, Vec3::Z],
    };
    all.extend([v(1., 1., 1.), v(1., 1., -1.), v(1., -1., 1.), v(1., -1., -1.)]);
    if points == 26 {
        all.extend([
            v(1., 1., 0.),
            v(1., -1., 0.),
            v(1., 0., 1.),
            v(1., 0., -1.),
            v(0., 1., 1.),
            v(0., 1., -1.),
        ]);
    }
    all
}

/// So many of the 24 axes of the generator's eight bases of degree 2, each the farthest from those before: many of the
/// first would lie in one plane.
fn generated(generator: Generator, count: usize) -> Vec<Vec3> {
    let bases = Bases { generator, degree: 2 }.axes();
    let axes: Vec<Vec3> = bases.iter().flat_map(|b| [b.x, b.y, b.z]).map(Vec3::from_array).collect();
    let mut chosen = vec![];
    for _ in 0..count {
        // Cosine of the angle to the nearest, whichever way it points.
        let near = |d: Vec3| chosen.iter().map(|c| along(*c, d).abs()).fold(0.0, f32::max);
        let farthest = axes.iter().copied().reduce(|a, b| if near(b) < near(a) { b } else { a });
        chosen.extend(farthest);
    }
    chosen
}

/// Axes of the frames that pairs of the book's directions span, each frame once: one axis along the first, one at right
/// angles to both.
pub(super) fn spanned(points: u32) -> Vec<[DVec3; 3]> {
    let directions = book(points);
    let mut frames: Vec<[DVec3; 3]> = vec![];
    for (i, first) in directions.iter().enumerate() {
        for second in directions.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, d)| d) {
            let x = first.as_dvec3().normalize();
            let z = x.cross(second.as_dvec3()).normalize();
            let frame = [x, z.cross(x), z];
            if frames.iter().all(|f| !alike(f, &frame)) {
                frames.push(frame);
            }
        }
    }
    frames
}

/// Whether both have the same axes, in any order and of any sign.
fn alike(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let nearest = |axis: &DVec3| b.iter().map(|o| o.dot(*axis).abs()).fold(0.0, f64::max);
    a.iter().all(|axis| nearest(axis) > 1.0 - 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [u32; 4] = [12, 14, 20, 26];

    #[test]
    fn directions_are_half_as_many_and_apart() {
        for directions in Directions::ALL {
            for points in POINTS {
                let all = directions.of(points);
                assert_eq!(all.len(), points as usize / 2);
                for (i, a) in all.iter().enumerate() {
                    for b in &all[..i] {
                        let cosine = a.normalize().dot(b.normalize()).abs();
                        assert!(cosine < 0.96, "{directions:?}, {points}: {a} and {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn spanned_frames_are_rotations_along_directions() {
        for points in POINTS {
            let directions = book(points);
            for frame in spanned(points) {
                let [x, y, z] = frame;
                assert!((x.cross(y).dot(z) - 1.0).abs() < 1e-12, "{points}: {frame:?}");
                let kept = |d: &Vec3| d.as_dvec3().normalize().dot(x) > 1.0 - 1e-12;
                assert!(directions.iter().any(kept), "{points}: {frame:?}");
            }
        }
        // The upright one, half a quarter turn about each axis, and three about each of the cube's four diagonals.
        assert_eq!(POINTS.map(|points| spanned(points).len()), [30, 16, 90, 16]);
    }
}
