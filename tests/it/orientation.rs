//! How scenes lie: the bases of their own.

#![allow(clippy::unwrap_used)]

use crate::soup::{named, sphere};
use boxwood::bvh::Orientations;
use boxwood::bvh::frame::Frame;
use boxwood::bvh::orientation::{MOST, sample};
use boxwood::scene::{Scene, Transform};
use glam::{DMat3, DVec3};

fn of(scene: &Scene) -> Orientations {
    Orientations::of(&sample(scene))
}

/// The greatest angle between an axis of the frame and the nearest of `axes`, radians.
fn off(words: [u32; 2], axes: &DMat3) -> f64 {
    let frame = Frame::of(words);
    let rows = frame.rows.map(|row| row.as_dvec3().normalize());
    let sine = |row: DVec3| axes.to_cols_array_2d().map(|a| row.cross(DVec3::from_array(a)).length());
    rows.map(|row| sine(row).into_iter().fold(1.0, f64::min)).into_iter().fold(0.0, f64::max)
}

/// What `rotate` takes the axes to.
fn axes(rotate: [f64; 3]) -> DMat3 {
    let [x, y, z] = rotate.map(f64::to_radians);
    DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x)
}

#[test]
fn a_city_has_one_basis() {
    for name in ["city:2k", "city:50k", "city:200k"] {
        let found = of(&named(name));
        assert_eq!(found.frames(MOST), [[0; 2]], "{name}: {found:?}");
        assert!(found.aligned > 0.999, "{name}: {found}");
    }
}

#[test]
fn a_turned_citys_rotation_is_found() {
    for rotate in [[45.0, 45.0, 45.0], [10.0, -20.0, 70.0], [0.0, 0.0, 45.0], [1.0, 0.0, 0.0]] {
        for (scale, translate) in [(1.0, [0.0; 3]), (0.001, [0.003, -0.002, 0.001])] {
            let city = Transform { rotate, scale, translate }.apply(named("city:50k")).unwrap();
            let found = of(&city);
            assert!(found.aligned < 0.01 && found.bases.len() <= 2, "{rotate:?}: {found:?}");
            let near = found.bases.iter().map(|b| off(b.frame, &axes(rotate))).fold(1.0, f64::min);
            assert!(near < 2f64.powi(-18), "{rotate:?}, {scale}: {near} off; {found:?}");
        }
    }
}

#[test]
fn what_lies_all_ways_has_many() {
    // A sphere's quads lie two ways of three: along its meridians.
    for (scene, least) in [(named("hairball:20k"), MOST), (sphere(60, [0.5; 3], 1.0), 8)] {
        let found = of(&scene);
        let frames = found.frames(MOST);
        assert!(frames.len() >= least as usize && found.aligned < 0.1, "{found:?}");
        assert!((1..frames.len()).all(|i| !frames[..i].contains(&frames[i])), "{found:?}");
    }
}

#[test]
fn a_sample_stays_small() {
    let city = named("city:200k");
    assert_eq!(sample(&city).len(), 1 << 13);
    let few = named("city:2k");
    assert_eq!(sample(&few), (0..few.triangles.len()).map(|i| few.corners(i)).collect::<Vec<_>>());
}
