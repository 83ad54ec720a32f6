//! Bases of oriented discrete orientation polytopes: rotations fixed before the build. \[VEVERKOVA24, 4.2\]
//! Differs: each is kept as the words of a packed node's frame, so it is brought into the domain of least rotations that
//! every box has one of (components within √2 − 1, sum within 1), where the printed generators stay in one octant.

use super::directions::spanned;
use super::frame::{Frame, STEPS, words};
use crate::abi::Basis;
use glam::{DMat3, DVec3};

/// Where bases come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Generator {
    /// Rodrigues vectors on a grid of the unit cube, from 0: the first is no rotation.
    #[default]
    Grid,
    /// Random ones in the unit cube: no axis-aligned basis among them.
    Uniform,
    /// Random ones on the unit sphere: likewise.
    Sphere,
    /// No rotation, and points spread evenly over the domain of all box orientations.
    Zone,
    /// Those that pairs of DiTO's directions span, of a set of 12, 14, 20 or 26 extremal points.
    Dito(u32),
}

impl Generator {
    /// Every choice.
    pub const ALL: [Self; 8] = [
        Self::Grid,
        Self::Uniform,
        Self::Sphere,
        Self::Zone,
        Self::Dito(12),
        Self::Dito(14),
        Self::Dito(20),
        Self::Dito(26),
    ];

    /// As arguments and reports have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Uniform => "uniform",
            Self::Sphere => "sphere",
            Self::Zone => "zone",
            Self::Dito(12) => "dito12",
            Self::Dito(14) => "dito14",
            Self::Dito(20) => "dito20",
            Self::Dito(_) => "dito26",
        }
    }

    /// Bases that there are, where not as many as one wants.
    pub fn limit(self) -> Option<u32> {
        match self {
            Self::Grid | Self::Uniform | Self::Sphere | Self::Zone => None,
            Self::Dito(12) => Some(30),
            Self::Dito(20) => Some(90),
            Self::Dito(_) => Some(16),
        }
    }

    /// The greatest degree that asks for other bases than the one below: 8 at most.
    pub fn most_degree(self) -> u32 {
        let all = |degree: &u32| self.limit().is_some_and(|limit| degree.pow(3) >= limit);
        (1..8).find(all).unwrap_or(8)
    }
}

/// A set of bases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bases {
    /// Where they come from.
    pub generator: Generator,
    /// Degree D: there are D³, or as many as the generator has. 1–8, see [`Generator::most_degree`].
    pub degree: u32,
}

impl Bases {
    /// As arguments and reports have those of a degree; none knows where they come from.
    pub fn name(self) -> &'static str {
        const NAMES: [&str; 8] = ["odop1", "odop2", "odop3", "odop4", "odop5", "odop6", "odop7", "odop8"];
        NAMES[self.degree.clamp(1, 8) as usize - 1]
    }

    /// Whether its degree is one of those that [`Bases::degrees`] names.
    pub(super) fn is_in_range(self) -> bool {
        (1..=self.generator.most_degree()).contains(&self.degree)
    }

    /// Degrees that there are, for an error.
    pub(super) fn degrees(self) -> &'static str {
        match self.generator {
            Generator::Grid | Generator::Uniform | Generator::Sphere | Generator::Zone => "1 to 8",
            Generator::Dito(12) => "1 to 4: pairs of dito12's directions span 30 bases",
            Generator::Dito(20) => "1 to 5: pairs of dito20's directions span 90 bases",
            Generator::Dito(_) => "1 to 3: pairs of dito14's and dito26's directions span 16 bases",
        }
    }

    /// How many there are.
    pub fn count(self) -> u32 {
        self.generator.limit().map_or(self.degree.pow(3), |limit| limit.min(self.degree.pow(3)))
    }

    /// The words of their frames, the same ones first in all degrees of those of DiTO's; of no rotation \[0, 0\].
    pub fn frames(self) -> Vec<[u32; 2]> {
        let numbers = 0..self.count();
        match self.generator {
            Generator::Grid => numbers.map(|i| frame_words(self.on_grid(i))).collect(),
            Generator::Uniform => numbers.map(|i| frame_words(in_cube(i))).collect(),
            Generator::Sphere => numbers.map(|i| frame_words(on_sphere(i))).collect(),
            Generator::Zone => numbers.map(|i| frame_words(in_zone(i))).collect(),
            Generator::Dito(points) => {
                spanned(points).into_iter().zip(numbers).map(|(axes, _)| words_of_axes(axes)).collect()
            }
        }
    }

    /// Their axes, of unit length but for rounding, so that areas along them compare; of no rotation exactly the scene's.
    pub fn axes(self) -> Vec<Basis> {
        let axes = |words| {
            let frame = Frame::of(words);
            let over = 1.0 / frame.stretch();
            let [x, y, z] = frame.rows.map(|row| (row * over).to_array());
            Basis { x, y, z }
        };
        self.frames().into_iter().map(axes).collect()
    }

    /// The i-th Rodrigues vector of the grid.
    fn on_grid(self, i: u32) -> DVec3 {
        let d = self.degree;
        let [x, y, z] = [i % d, i / d % d, i / (d * d)].map(|k| f64::from(k) / f64::from(d));
        // Q = (I − A)(I + A)⁻¹ of the printed A is the rotation of this vector.
        DVec3::new(x, -y, z)
    }
}

/// The k-th random number of the i-th vector, from 0 to 1.
fn random(i: u32, k: u32) -> f64 {
    f64::from(hash(3 * i + k)) / 4_294_967_296.0
}

/// The i-th random Rodrigues vector in the unit cube.
fn in_cube(i: u32) -> DVec3 {
    DVec3::new(random(i, 0), -random(i, 1), random(i, 2))
}

/// The i-th random one on the unit sphere.
fn on_sphere(i: u32) -> DVec3 {
    let (z, turn) = (2.0 * random(i, 0) - 1.0, std::f64::consts::TAU * random(i, 1));
    let radius = (1.0 - z * z).sqrt();
    DVec3::new(radius * turn.cos(), radius * turn.sin(), z)
}

/// The i-th of the points of the Halton sequence of bases 2, 3 and 5 that lie in the domain; the 0th is 0.
fn in_zone(i: u32) -> DVec3 {
    let reach = 2.0 * (std::f64::consts::SQRT_2 - 1.0);
    let point = |n| DVec3::new(inverse(n, 2), inverse(n, 3), inverse(n, 5)) - 0.5;
    let mut within = (1..).map(point).map(|p| p * reach).filter(|p| p.abs().element_sum() <= 1.0);
    match i {
        0 => DVec3::ZERO,
        _ => within.nth(i as usize - 1).unwrap_or(DVec3::ZERO),
    }
}

/// The radical inverse of n.
fn inverse(mut n: u32, base: u32) -> f64 {
    let (mut sum, mut place) = (0.0, 1.0);
    while n > 0 {
        place /= f64::from(base);
        sum += place * f64::from(n % base);
        n /= base;
    }
    sum
}

/// 32 bits that look random, the same everywhere \[PCG\].
pub(super) fn hash(n: u32) -> u32 {
    let state = n.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    word >> 22 ^ word
}

/// The words of the rotation to axes like those of Rodrigues vector `r`, in an order and of signs that make it least.
pub(super) fn frame_words(r: DVec3) -> [u32; 2] {
    // Rows of the rotation, scaled by 1 + r·r.
    let (s, twice) = (1.0 - r.length_squared(), 2.0 * r);
    let cross = [[0.0, -twice.z, twice.y], [twice.z, 0.0, -twice.x], [-twice.y, twice.x, 0.0]];
    let row = |i: usize| {
        DVec3::from_array(std::array::from_fn(|k| {
            f64::from(u8::from(i == k)) * s + twice[i] * r[k] + cross[i][k]
        })) / (1.0 + r.length_squared())
    };
    words_of_axes([row(0), row(1), row(2)])
}

/// Likewise to these axes, of unit length.
fn words_of_axes(axes: [DVec3; 3]) -> [u32; 2] {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let turned = orders.map(|order: [usize; 3]| {
        let axis = |k: usize| axes[order[k]] * axes[order[k]][k].signum();
        DMat3::from_cols(axis(0), axis(1), axis(2)).transpose()
    });
    let trace = |m: &DMat3| m.x_axis.x + m.y_axis.y + m.z_axis.z;
    let least = turned.iter().fold(turned[0], |a, b| if trace(b) > trace(&a) + 1e-12 { *b } else { a });
    let over = 1.0 / (1.0 + trace(&least));
    let vector = DVec3::new(
        least.y_axis.z - least.z_axis.y,
        least.z_axis.x - least.x_axis.z,
        least.x_axis.y - least.y_axis.x,
    ) * over;
    words(vector.to_array().map(|x| (x * f64::from(STEPS)).round() as i32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn all() -> impl Iterator<Item = Bases> {
        Generator::ALL.into_iter().flat_map(|generator| {
            (1..=generator.most_degree()).map(move |degree| Bases { generator, degree })
        })
    }

    #[test]
    fn bases_are_distinct_and_in_the_domain() {
        for bases in all() {
            let frames = bases.frames();
            assert_eq!(frames.len(), bases.count() as usize);
            assert_eq!(frames.iter().collect::<HashSet<_>>().len(), frames.len(), "{bases:?}");
            for words in frames {
                let r = Frame::of(words).rodrigues.abs();
                assert!(r.max_element() < 0.414_22 && r.element_sum() < 1.000_01, "{bases:?} {r}");
            }
        }
    }

    #[test]
    fn grid_and_zone_begin_with_no_rotation() {
        for bases in all() {
            let first = bases.frames()[0];
            let identity =
                matches!(bases.generator, Generator::Grid | Generator::Zone | Generator::Dito(14 | 26));
            assert_eq!(first == [0; 2], identity, "{bases:?}");
        }
    }

    #[test]
    fn degrees_end_where_bases_do() {
        let most = Generator::ALL.map(Generator::most_degree);
        assert_eq!(most, [8, 8, 8, 8, 4, 3, 5, 3]);
        for points in [12, 14, 20, 26] {
            assert_eq!(Generator::Dito(points).limit(), Some(spanned(points).len() as u32));
        }
    }

    #[test]
    fn axes_are_of_unit_length() {
        for bases in all() {
            for (basis, words) in bases.axes().iter().zip(bases.frames()) {
                for (k, axis) in [basis.x, basis.y, basis.z].into_iter().enumerate() {
                    let length = DVec3::from_array(axis.map(f64::from)).length();
                    assert!((length - 1.0).abs() < 3e-7, "{bases:?}: {length}");
                    assert!(words != [0; 2] || (0..3).all(|i| axis[i] == f32::from(u8::from(i == k))));
                }
            }
        }
    }

    #[test]
    fn turning_axes_about_changes_no_frame() {
        // A quarter turn about z, then a little about x: the same boxes as the little alone in turned axes.
        let little = DVec3::new(0.1, 0.0, 0.0);
        assert_eq!(frame_words(little), words([209_715, 0, 0]));
        assert_eq!(frame_words(DVec3::new(0.0, 0.0, 1.0)), [0; 2], "a quarter turn");
    }
}
