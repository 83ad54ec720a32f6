//! Where a scene is looked at from. No trigonometry here: the default views are the same bits on every machine.

use crate::abi::Aabb;

/// A pinhole camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position, scene units.
    pub eye: [f32; 3],
    /// Point looked at.
    pub target: [f32; 3],
    /// Upward direction, any length, not along the view.
    pub up: [f32; 3],
    /// Vertical field of view, degrees.
    pub fov_y: f32,
}

/// Field of view of the default views, degrees.
const FOV_Y: f32 = 45.0;
/// sin of half of [`FOV_Y`].
const SIN_HALF_FOV: f64 = 0.382_683_432_365_089_8;
/// From the target to the eye, any length, right, above, in front: three-quarter views from the front, from the right
/// behind and from the left behind, a low one from the left in front, and one from above.
const AROUND: [[f64; 3]; 5] =
    [[0.6, 0.45, 1.0], [1.0, 0.45, -0.6], [-0.6, 0.45, -1.0], [-1.0, 0.1, 0.6], [0.25, 1.4, 0.35]];

impl Camera {
    /// A three-quarter view, y up, whose picture holds the bounding sphere of `bounds` in its height.
    /// Empty bounds and single points get the view of a unit box around them (or around the origin).
    pub fn default_for(bounds: &Aabb) -> Self {
        Self::from_direction(bounds, AROUND[0])
    }

    /// Five views around `bounds`, the first one that of [`Camera::default_for`], all from its distance.
    pub fn five_for(bounds: &Aabb) -> [Self; 5] {
        AROUND.map(|direction| Self::from_direction(bounds, direction))
    }

    /// From the middle of `bounds` along `direction`, as far as the whole sphere is seen.
    fn from_direction(bounds: &Aabb, direction: [f64; 3]) -> Self {
        let mut middle = [0.0f64; 3];
        let mut square = 0.0;
        if (0..3).all(|k| bounds.lo[k] <= bounds.hi[k]) {
            for (k, m) in middle.iter_mut().enumerate() {
                *m = (f64::from(bounds.lo[k]) + f64::from(bounds.hi[k])) / 2.0;
                let half = (f64::from(bounds.hi[k]) - f64::from(bounds.lo[k])) / 2.0;
                square += half * half;
            }
        }
        let radius = if square > 0.0 { square.sqrt() } else { 0.75f64.sqrt() };
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let distance = radius / SIN_HALF_FOV;
        // Bounds near the largest float would put the eye at infinity.
        let limit = f64::from(f32::MAX);
        let at = |k: usize| (middle[k] + direction[k] / length * distance).clamp(-limit, limit) as f32;
        Self {
            eye: [at(0), at(1), at(2)],
            target: middle.map(|x| x as f32),
            up: [0.0, 1.0, 0.0],
            fov_y: FOV_Y,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_views_are_finite_distinct_and_outside() {
        let boxes = [
            ([0.0; 3], [1.0, 2.0, 3.0]),
            ([5.0; 3], [5.0; 3]),
            ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]),
            ([-f32::MAX; 3], [f32::MAX; 3]),
        ];
        for (lo, hi) in boxes {
            let views = Camera::five_for(&Aabb { lo, hi });
            assert_eq!(views[0], Camera::default_for(&Aabb { lo, hi }));
            for (i, c) in views.iter().enumerate() {
                assert!(c.eye.iter().chain(&c.target).all(|x| x.is_finite()), "{c:?}");
                let outside = (0..3).any(|k| c.eye[k] > hi[k] || c.eye[k] < lo[k] || hi[k] == f32::MAX);
                assert!(outside, "the eye is inside: {c:?}");
                assert!(hi[0] == f32::MAX || views[..i].iter().all(|v| v.eye != c.eye), "twice: {c:?}");
            }
        }
    }
}
