//! Solids of unit blocks on a grid: all their coordinates are powers of two times small integers, so that rays along the
//! axes pass through vertices and along edges exactly.

use glam::{DVec3, IVec3};
use std::collections::HashMap;

/// Blocks of a grid of `n` × `n` × `n` from −1 to 1. Along each axis the blocks of a row follow each other.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    n: i32,
    filled: Vec<bool>,
}

impl Blocks {
    /// All of them.
    pub fn cube(n: i32) -> Self {
        Self::of(n, |_| true)
    }

    /// Those within the ball that touches the grid's sides.
    pub fn ball(n: i32) -> Self {
        Self::of(n, |p| (2 * p - (n - 1)).length_squared() <= n * n)
    }

    fn of(n: i32, filled: impl Fn(IVec3) -> bool) -> Self {
        let place = |i: i32| IVec3::new(i % n, i / n % n, i / n / n);
        Self { n, filled: (0..n * n * n).map(|i| filled(place(i))).collect() }
    }

    fn is_filled(&self, p: IVec3) -> bool {
        let within = p.cmpge(IVec3::ZERO).all() && p.cmplt(IVec3::splat(self.n)).all();
        within && self.filled[((p.z * self.n + p.y) * self.n + p.x) as usize]
    }

    /// The boundary: two triangles a block's side.
    pub fn mesh(&self) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let (mut points, mut triangles) = (vec![], vec![]);
        let mut numbers = HashMap::new();
        let mut number = |p: IVec3| {
            *numbers.entry(p).or_insert_with(|| {
                points.push(p.as_dvec3() * 2.0 / f64::from(self.n) - 1.0);
                points.len() as u32 - 1
            })
        };
        for i in 0..self.n * self.n * self.n {
            let p = IVec3::new(i % self.n, i / self.n % self.n, i / self.n / self.n);
            for k in 0..3 {
                let [along, u, v] = [0, 1, 2].map(|j| IVec3::AXES[(k + j) % 3]);
                for ahead in [false, true] {
                    let beside = if ahead { p + along } else { p - along };
                    if !self.is_filled(p) || self.is_filled(beside) {
                        continue;
                    }
                    let q = if ahead { p + along } else { p };
                    let [a, b, c, d] = [q, q + u, q + u + v, q + v].map(&mut number);
                    triangles.extend(if ahead { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
                }
            }
        }
        (points, triangles)
    }

    /// Between what values of coordinate `axis` a ray leaves the solid that starts within it at `origin`, in half blocks
    /// from the grid's low corner, towards greater coordinates or smaller: where the first and the last of the blocks that
    /// it touches end. None where the origin isn't within.
    pub fn ends(&self, origin: IVec3, axis: usize, ahead: bool) -> Option<[f64; 2]> {
        // Of an even coordinate two blocks are touched.
        let touched = |half: i32| [(half - 1).div_euclid(2), half.div_euclid(2)];
        let [us, vs, ws] = [0, 1, 2].map(|j| touched(origin[(axis + j) % 3]));
        let end = |u: i32, v: i32, w: i32| {
            let mut p = IVec3::ZERO;
            [p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]] = [u, v, w];
            let step = if ahead { IVec3::AXES[axis] } else { -IVec3::AXES[axis] };
            if !self.is_filled(p) {
                return None;
            }
            while self.is_filled(p + step) {
                p += step;
            }
            Some(p[axis] + i32::from(ahead))
        };
        let mut ends = [i32::MAX, i32::MIN];
        for u in us {
            for v in vs {
                for w in ws {
                    let e = end(u, v, w)?;
                    ends = [ends[0].min(e), ends[1].max(e)];
                }
            }
        }
        let [least, most] = ends.map(|e| f64::from(e) * 2.0 / f64::from(self.n) - 1.0);
        Some(if ahead { [least, most] } else { [most, least] })
    }

    /// Half blocks along an axis.
    pub fn halves(&self) -> i32 {
        2 * self.n
    }

    /// A coordinate in half blocks, scene units.
    pub fn coordinate(&self, half: f64) -> f64 {
        half / f64::from(self.n) - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_end_where_blocks_do() {
        // Of a ball of 4: the middle 2 × 2 rows are four long, those beside two.
        let ball = Blocks::ball(4);
        let middle = IVec3::splat(4);
        for axis in 0..3 {
            assert_eq!(ball.ends(middle, axis, true), Some([1.0, 1.0]));
            assert_eq!(ball.ends(middle, axis, false), Some([-1.0, -1.0]));
        }
        // Between a long row and a short one.
        let between = IVec3::new(4, 6, 4);
        assert_eq!(ball.ends(between, 0, true), Some([0.5, 1.0]));
        assert_eq!(ball.ends(between, 2, false), Some([-0.5, -1.0]));
        // Half of what it touches is outside.
        assert_eq!(ball.ends(IVec3::new(4, 8, 4), 0, true), None);
        let cube = Blocks::cube(4);
        assert_eq!(cube.ends(IVec3::new(1, 5, 7), 1, true), Some([1.0, 1.0]));
        assert_eq!((cube.mesh().0.len(), cube.mesh().1.len()), (98, 192));
    }
}
