//! Twin of `glsl/lib/distant.glsl`: rays from so far away that integers alone tell what they meet.

use super::V3;
use super::digits::exact_sum;
use super::ray::scaled;
use crate::oracle::morton::Space;

/// Rays from here and beyond are distant.
pub(super) const DISTANT: f32 = 4_294_967_296.0;

/// A distant ray, each vector as given.
#[derive(Debug, Clone, Copy)]
pub(super) struct Far {
    /// Unit scale · 2^−`scale`.
    pub origin: V3,
    /// Unscaled direction.
    pub line: V3,
    /// `line` is `scaled_line` · 2 to this power.
    pub exponent: i32,
    pub scaled_line: V3,
    pub scale: usize,
}

/// Where its walk begins, moved.
#[derive(Debug, Clone, Copy)]
pub(super) struct Begin {
    pub at: V3,
    /// t of the scene, counted as `Setup::t_min` is.
    pub t: f32,
    /// Whether it passes the scene by.
    pub aside: bool,
}

impl Far {
    /// Of the ray's own numbers, and of what they are in unit space.
    pub(super) fn new([o, d]: [V3; 2], [unit_o, scaled_line]: [V3; 2], exponent: i32, space: &Space) -> Self {
        let scale = space.exponent.max(0);
        let origin = if scale > 0 { o } else { unit_o };
        Self { origin, line: d, exponent, scaled_line, scale: scale as usize }
    }

    /// t here = t in lengths of `line` · 2 to this power: a fourth, which can't overflow.
    pub(super) fn shift(&self) -> i32 {
        self.exponent - self.scale as i32 - 2
    }

    /// The walk begins on the plane of the largest component, z, 2 before the anchor.
    pub(super) fn begin(&self, anchor: V3, z: usize) -> Begin {
        let (o, d, along) = (self.origin, self.line, self.scaled_line);
        let mut t = 0.0;
        let mut off = [0.0; 3];
        for k in 0..3 {
            let former = [(o[k], d[z], self.scale, false), (anchor[k], d[z], 0, true)];
            let latter = [(o[z], d[k], self.scale, true), (anchor[z], d[k], 0, false)];
            let sum = exact_sum(former.into_iter().chain(latter.into_iter().filter(|_| k != z)));
            let quotient = (sum.value.hi + sum.value.lo) / along[z];
            if k == z {
                t = -scaled(quotient / along[z], sum.exponent - 2 * self.exponent + self.shift());
            } else {
                off[k] = scaled(quotient, (sum.exponent - self.exponent).min(60));
            }
        }
        let aside = off.iter().any(|x| x.abs() > 4.0);
        let back = 2.0 / along[z].abs();
        Begin { at: std::array::from_fn(|k| off[k] - along[k] * back), t, aside }
    }
}

impl Begin {
    /// Whether the scene is surely out of this range of t.
    pub(super) fn is_out_of(&self, t_min: f32, t_max: f32) -> bool {
        let slack = self.t.abs() * (1.0 / 1_048_576.0);
        self.t + slack < t_min || self.t - slack > t_max
    }
}
