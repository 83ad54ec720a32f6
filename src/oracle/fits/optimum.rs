//! Near-optimal boxes: a fine search over all orientations in f64. Slow; never larger than what it is given.

use super::half_area;
use super::sets::Random;
use glam::{DMat3, DVec3};

/// Points of the search's grid an axis; odd: the middle one is no rotation.
const GRID: i32 = 19;
/// Starts of the grid that are refined.
const STARTS: usize = 30;
/// Smallest turn tried, rad.
const SMALLEST: f64 = 1e-6;

/// A search over the domain of all box orientations.
#[derive(Debug)]
pub struct Optimum {
    /// A grid over the domain: Rodrigues vectors and axes.
    grid: Vec<(DVec3, DMat3)>,
    /// Between neighbours, of a Rodrigues vector.
    spacing: f64,
}

impl Default for Optimum {
    fn default() -> Self {
        // The orientations of a box, each once: components within √2 − 1, their sum within 1.
        let reach = std::f64::consts::SQRT_2 - 1.0;
        let spacing = 2.0 * reach / f64::from(GRID - 1);
        let at = |i: i32| f64::from(i - GRID / 2) * spacing;
        let all =
            (0..GRID.pow(3)).map(|i| DVec3::new(at(i % GRID), at(i / GRID % GRID), at(i / (GRID * GRID))));
        let within = all.filter(|r| r.abs().element_sum() <= 1.0);
        Self { grid: within.map(|r| (r, rotation(r).transpose())).collect(), spacing }
    }
}

impl Optimum {
    /// Half area of the least box found around `points`, from the grid's best and from `starts`, axes as columns.
    pub fn half_area(&self, points: &[DVec3], starts: &[DMat3]) -> f64 {
        let mut ranked: Vec<(f64, usize)> =
            self.grid.iter().enumerate().map(|(i, (_, axes))| (half_area(axes, points), i)).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        // The best of each neighbourhood.
        let mut taken: Vec<DVec3> = vec![];
        let mut axes = starts.to_vec();
        for (_, i) in ranked {
            let (r, rotated) = self.grid[i];
            if taken.iter().all(|t| (*t - r).abs().max_element() > 1.5 * self.spacing) {
                taken.push(r);
                axes.push(rotated);
                if taken.len() == STARTS {
                    break;
                }
            }
        }
        axes.into_iter().map(|axes| self.refined(points, axes)).fold(f64::MAX, f64::min)
    }

    /// Half area of the least box that pattern search finds from `axes` on: turns about the axes of a random frame, other
    /// ones each round, for areas have creases along which fixed ones get stuck.
    fn refined(&self, points: &[DVec3], mut axes: DMat3) -> f64 {
        let mut random = Random::new(0);
        let mut least = half_area(&axes, points);
        let mut step = 2.0 * self.spacing;
        while step > SMALLEST {
            let frame = random.rotation();
            let turns =
                [frame.x_axis, -frame.x_axis, frame.y_axis, -frame.y_axis, frame.z_axis, -frame.z_axis];
            let before = least;
            for turn in turns {
                let turned = rotation(turn * (0.5 * step)) * axes;
                let area = half_area(&turned, points);
                if area < least {
                    (least, axes) = (area, turned);
                }
            }
            if least == before {
                step *= 0.5;
            }
        }
        least
    }
}

/// The rotation of a Rodrigues vector.
pub(super) fn rotation(r: DVec3) -> DMat3 {
    let (s, twice) = (1.0 - r.length_squared(), 2.0 * r);
    let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|e| e * s + twice * r.dot(e) + twice.cross(e));
    DMat3::from_cols(columns[0], columns[1], columns[2]) * (1.0 / (1.0 + r.length_squared()))
}
