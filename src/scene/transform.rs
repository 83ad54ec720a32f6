//! A scene turned, scaled and moved: for what happens off the axes, far from the origin, and in the small.
//!
//! Every vertex p becomes `scale · Rz Ry Rx p + translate`: about the origin of the scene's coordinates, so that scaling
//! by a power of two changes no digit. Computed in f64 and rounded once, with the generators' own sine: the same bits
//! everywhere.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fmt;

use super::procedural::trig::about;
use super::{Camera, Scene, SceneError, Warning};

/// What to do to a scene: rotate, then scale, then translate. The default does nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Transform {
    /// Angles about x, y and z, degrees: about x first, the matrix is Rz Ry Rx. Multiples of 90° are exact.
    pub rotate: [f64; 3],
    /// Factor, above 0. Powers of two are exact.
    pub scale: f64,
    /// Way along x, y and z, scene units, after scaling.
    pub translate: [f64; 3],
}

impl Default for Transform {
    fn default() -> Self {
        Self { rotate: [0.0; 3], scale: 1.0, translate: [0.0; 3] }
    }
}

/// As it stands behind a scene's name: `rotated 45,45,45 scaled 0.001`.
impl fmt::Display for Transform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |[x, y, z]: [f64; 3]| format!("{x},{y},{z}");
        let parts = [
            (self.rotate != [0.0; 3]).then(|| format!("rotated {}", list(self.rotate))),
            (self.scale != 1.0).then(|| format!("scaled {}", self.scale)),
            (self.translate != [0.0; 3]).then(|| format!("translated {}", list(self.translate))),
        ];
        f.write_str(&parts.into_iter().flatten().collect::<Vec<_>>().join(" "))
    }
}

impl Transform {
    /// Whether it changes anything.
    pub fn is_identity(&self) -> bool {
        *self == Self::default()
    }

    /// `scene` transformed with its views, what was done added to its name. Vertices that are not finite stay as they
    /// are; a view's eye stops at the largest float.
    ///
    /// # Errors
    /// [`SceneError::Transform`] for numbers that make no sense, and where a finite vertex would not be finite any more.
    pub fn apply(&self, mut scene: Scene) -> Result<Scene, SceneError> {
        let fail = |what: String, fix: &'static str| SceneError::Transform {
            name: scene.name.clone(),
            transform: self.to_string(),
            what,
            fix,
        };
        if self.is_identity() {
            return Ok(scene);
        }
        if !self.rotate.iter().chain(&self.translate).all(|x| x.is_finite()) {
            return Err(fail("angles and lengths must be finite".to_owned(), "give plain numbers"));
        }
        if !(self.scale.is_finite() && self.scale > 0.0) {
            return Err(fail(format!("{} is no scale", self.scale), "give a finite number above 0"));
        }
        let matrix = self.matrix();
        let moved: Vec<DVec3> = scene.positions.par_iter().map(|p| self.point(&matrix, wide(*p))).collect();
        let lost = |i: &usize| {
            scene.positions[*i].iter().all(|x| x.is_finite())
                && !moved[*i].to_array().iter().all(|x| (*x as f32).is_finite())
        };
        if let Some(i) = (0..moved.len()).into_par_iter().find_first(|i| lost(i)) {
            let what = format!("vertex {i} overflows to {}", moved[i].as_vec3());
            return Err(fail(what, "the largest float is 3.4e38: scale by less or stay nearer"));
        }
        scene.warnings.extend(underflow(&moved));
        scene.positions.par_iter_mut().zip(&moved).for_each(|(p, m)| {
            if p.iter().all(|x| x.is_finite()) {
                *p = m.as_vec3().to_array();
            }
        });
        for view in &mut scene.views {
            *view = self.view(&matrix, view);
        }
        scene.name = format!("{} {self}", scene.name);
        Ok(scene)
    }

    /// Rz Ry Rx.
    pub(super) fn matrix(&self) -> DMat3 {
        let [x, y, z] = self.rotate.map(|degrees| degrees / 360.0);
        about(2, z) * about(1, y) * about(0, x)
    }

    fn point(&self, matrix: &DMat3, p: DVec3) -> DVec3 {
        *matrix * p * self.scale + DVec3::from_array(self.translate)
    }

    pub(super) fn view(&self, matrix: &DMat3, view: &Camera) -> Camera {
        let limit = DVec3::splat(f64::from(f32::MAX));
        let point = |p| self.point(matrix, wide(p)).clamp(-limit, limit).as_vec3().to_array();
        Camera {
            eye: point(view.eye),
            target: point(view.target),
            up: (*matrix * wide(view.up)).as_vec3().to_array(),
            fov_y: view.fov_y,
        }
    }
}

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

/// Vertices that lose digits because they come too near to 0.
fn underflow(moved: &[DVec3]) -> Option<Warning> {
    let small = |x: f64| x != 0.0 && x.abs() < f64::from(f32::MIN_POSITIVE);
    let lost = |p: &DVec3| p.to_array().into_iter().any(small);
    let first = moved.par_iter().position_first(lost)?;
    let count = moved.par_iter().filter(|p| lost(p)).count() as u64;
    let what = "vertices with a coordinate below the smallest normal float, which lose digits".to_owned();
    Some(Warning { what, count, first: format!("vertex {first}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(positions: Vec<[f32; 3]>) -> Scene {
        let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Scene { name: "s".to_owned(), positions, triangles, ..Scene::default() }
    }

    fn rotated(rotate: [f64; 3]) -> Transform {
        Transform { rotate, ..Transform::default() }
    }

    #[test]
    fn turns_about_x_first() {
        let turned = rotated([90.0, 0.0, 90.0]).apply(scene(vec![[1.0, 2.0, 3.0]; 3])).unwrap();
        // About x: (1, -3, 2); then about z: (3, 1, 2).
        assert_eq!((turned.positions[0], turned.name.as_str()), ([3.0, 1.0, 2.0], "s rotated 90,0,90"));
        let corners = vec![[0.3, -7.1, 2.9], [4.4, 0.0, -1.0], [1.0, 1.0, 1.0]];
        let full = rotated([360.0, -720.0, 0.0]).apply(scene(corners.clone())).unwrap();
        assert_eq!(full.positions, corners);
    }

    #[test]
    fn rotates_then_scales_then_translates() {
        let all = Transform { rotate: [0.0, 90.0, 0.0], scale: 2.0, translate: [10.0, 0.0, 0.0] };
        let view = Camera { eye: [1.0, 0.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0], fov_y: 30.0 };
        let before = Scene { views: vec![view], ..scene(vec![[0.0, 5.0, 3.0]; 3]) };
        let after = all.apply(before).unwrap();
        assert_eq!(after.positions[0], [16.0, 10.0, 0.0]);
        let turned =
            Camera { eye: [10.0, 0.0, -2.0], target: [10.0, 0.0, 0.0], up: [1.0, 0.0, 0.0], fov_y: 30.0 };
        assert_eq!(after.views, [turned]);
        assert_eq!(after.name, "s rotated 0,90,0 scaled 2 translated 10,0,0");
    }

    #[test]
    fn overflow_is_an_error_and_underflow_a_warning() {
        let corners = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 1e30], [f32::NAN, f32::INFINITY, 0.0]];
        let scaled = |scale| Transform { scale, ..Transform::default() }.apply(scene(corners.clone()));
        let error = scaled(1e10).unwrap_err().to_string();
        assert!(error.contains("s scaled 10000000000: vertex 1 overflows"), "{error}");
        let odd = scaled(2.0).unwrap().positions[2];
        assert!(odd[0].is_nan() && odd[1] == f32::INFINITY, "{odd:?}");
        let small = scaled(1e-38).unwrap();
        assert_eq!((small.warnings[0].count, small.warnings[0].first.as_str()), (1, "vertex 0"));
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(scaled(bad).unwrap_err().to_string().contains("above 0"), "{bad}");
        }
        let far = Transform { translate: [0.0, f64::INFINITY, 0.0], ..Transform::default() };
        assert!(far.apply(scene(corners)).unwrap_err().to_string().contains("finite"));
    }
}
