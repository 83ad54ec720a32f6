//! Frames of oriented nodes on the host: the twin of `glsl/lib/{frame,within}.glsl`, to the same bits.

use glam::Vec3;

/// Steps of a component of a Rodrigues vector a unit.
pub const STEPS: f32 = 2_097_152.0;

/// A rotation from unit space to a node's axes, scaled by [`Frame::stretch`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Rodrigues vector: axis times the tangent of half the angle; 0 where there is no rotation.
    pub rodrigues: Vec3,
    /// Rows of the matrix.
    pub rows: [Vec3; 3],
}

/// Whether the words of a node are those of a rotation.
pub fn is_oriented(words: [u32; 2]) -> bool {
    words != [0; 2]
}

/// The words of a Rodrigues vector in steps, each of 21 bits.
pub fn words(steps: [i32; 3]) -> [u32; 2] {
    let [x, y, z] = steps.map(|s| s as u32 & 0x1f_ffff);
    [x | y << 21, y >> 11 | z << 10]
}

impl Frame {
    /// What the words of a node mean.
    pub fn of([low, high]: [u32; 2]) -> Self {
        let steps = [low << 11, (low >> 21 | high << 11) << 11, high << 1].map(|bits| bits as i32 >> 11);
        let r = Vec3::from_array(steps.map(|s| s as f32)) * (1.0 / STEPS);
        let (square, twice) = (r * r, r * 2.0);
        let s = 1.0 - (square.x + square.y + square.z);
        let (xy, xz, yz) = (twice.x * r.y, twice.x * r.z, twice.y * r.z);
        let rows = [
            Vec3::new(s + twice.x * r.x, xy - twice.z, xz + twice.y),
            Vec3::new(xy + twice.z, s + twice.y * r.y, yz - twice.x),
            Vec3::new(xz - twice.y, yz + twice.x, s + twice.z * r.z),
        ];
        Self { rodrigues: r, rows }
    }

    /// How much larger lengths are in it: 1 + r·r, below 1.52.
    pub fn stretch(&self) -> f32 {
        let square = self.rodrigues * self.rodrigues;
        1.0 + (square.x + square.y + square.z)
    }

    /// A point in it.
    pub fn within(&self, p: Vec3) -> Vec3 {
        Vec3::from_array(self.rows.map(|axis| along(axis, p)))
    }

    /// Likewise in f64, for the same matrix.
    pub fn within_exactly(&self, p: [f64; 3]) -> [f64; 3] {
        self.rows.map(|axis| (0..3).map(|k| f64::from(axis[k]) * p[k]).sum())
    }
}

/// A point's coordinate along an axis.
pub fn along(axis: Vec3, p: Vec3) -> f32 {
    let product = axis * p;
    product.x + product.y + product.z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_keep_their_steps() {
        for steps in [[0, 0, 0], [1, -1, 868_000], [-868_000, 5, -7], [1_048_575, -1_048_575, 1]] {
            let r = Frame::of(words(steps)).rodrigues;
            assert_eq!(r.to_array().map(|x| (x * STEPS) as i32), steps);
        }
        assert!(!is_oriented(words([0; 3])) && is_oriented(words([0, 0, -1])));
    }

    #[test]
    fn rows_are_orthogonal_and_as_long_as_the_stretch() {
        let f = Frame::of(words([300_000, -700_000, 868_000]));
        for (i, a) in f.rows.iter().enumerate() {
            for (j, b) in f.rows.iter().enumerate() {
                let wanted = if i == j { f.stretch() * f.stretch() } else { 0.0 };
                assert!((along(*a, *b) - wanted).abs() < 1e-6, "{i} {j}");
            }
        }
        // A rotation, not a reflection.
        assert!(f.rows[0].cross(f.rows[1]).dot(f.rows[2]) > 0.0);
    }
}
