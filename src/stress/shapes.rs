//! Shapes that scenes of the catalogue are made of, in f64; rounded once, so that what shares a corner shares its bits.

use super::random::Random;
use crate::scene::Scene;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Three corners.
pub(super) type Corners = [DVec3; 3];

/// A scene of triangles that share no index.
pub(super) fn scene(corners: &[Corners]) -> Scene {
    let triangles = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let positions = corners.as_flattened().iter().map(|p| p.as_vec3().to_array()).collect();
    Scene { positions, triangles, ..Scene::default() }
}

/// Each corner moved by `f`.
pub(super) fn moved(corners: &[Corners], f: impl Fn(DVec3) -> DVec3) -> Vec<Corners> {
    corners.iter().map(|c| c.map(&f)).collect()
}

/// `n` triangles of edge about `size` in a cube of edge 2.
pub(super) fn soup(random: &mut Random, n: usize, size: f64) -> Vec<Corners> {
    let triangle = |_| {
        let at = random.point();
        [(); 3].map(|()| at + size * random.point())
    };
    (0..n).map(triangle).collect()
}

/// A closed sphere of radius 1.
pub(super) fn ball(rings: usize) -> Vec<Corners> {
    let around = 2 * rings;
    let at = |ring: usize, i: usize| match ring {
        0 => DVec3::Z,
        r if r == rings => DVec3::NEG_Z,
        r => {
            let (theta, phi) = (PI * r as f64 / rings as f64, TAU * (i % around) as f64 / around as f64);
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        }
    };
    let quad = |ring: usize, i: usize| {
        let [a, b, c, d] = [at(ring, i), at(ring + 1, i), at(ring + 1, i + 1), at(ring, i + 1)];
        [[a, b, c], [a, c, d]].into_iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
    };
    (0..rings).flat_map(|ring| (0..around).flat_map(move |i| quad(ring, i))).collect()
}

/// `n` × `n` houses on a square of edge 2: all faces along the axes, many in common planes.
pub(super) fn houses(random: &mut Random, n: usize) -> Vec<Corners> {
    let step = 2.0 / n as f64;
    let mut corners = vec![];
    for i in 0..n * n {
        let lo = DVec3::new(step * (i % n) as f64 - 1.0, step * (i / n) as f64 - 1.0, 0.0);
        let hi = lo + DVec3::new(0.75 * step, 0.75 * step, 0.25 * (1 + random.below(6)) as f64);
        corners.extend(cuboid(lo, hi));
    }
    corners
}

/// Twelve triangles.
fn cuboid(lo: DVec3, hi: DVec3) -> Vec<Corners> {
    let at = |bits: usize| {
        let side = |k: usize| if bits >> k & 1 == 0 { lo[k] } else { hi[k] };
        DVec3::new(side(0), side(1), side(2))
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    faces.into_iter().flat_map(halves).map(|t| t.map(at)).collect()
}

/// A cone of `n` triangles around a vertex.
pub(super) fn around_vertex(n: usize) -> Vec<Corners> {
    let rim = |i: usize| {
        let a = TAU * (i % n) as f64 / n as f64;
        DVec3::new(a.cos(), a.sin(), 0.125)
    };
    (0..n).map(|i| [DVec3::ZERO, rim(i), rim(i + 1)]).collect()
}

/// `n` triangles that share an edge, like the pages of a book.
pub(super) fn around_edge(n: usize) -> Vec<Corners> {
    let (a, b) = (DVec3::new(-0.3, 0.2, -1.0), DVec3::new(0.25, -0.1, 1.0));
    let page = |i: usize| {
        let angle = TAU * i as f64 / n as f64;
        [a, b, DVec3::new(angle.cos(), angle.sin(), 0.1)]
    };
    (0..n).map(page).collect()
}

/// Triangles about the z axis, each around the ones before it, `grow` times as large.
pub(super) fn nested(n: usize, grow: f64) -> Vec<Corners> {
    let one = |s: f64| [DVec3::new(-s, -s, 0.0), DVec3::new(s, -s, 0.0), DVec3::new(0.0, s, 0.0)];
    (0..n).map(|i| one(grow.powi(i as i32))).collect()
}

/// A copy of a small triangle at each of `places`.
pub(super) fn copies(places: impl IntoIterator<Item = DVec3>, size: f64) -> Vec<Corners> {
    let small = [DVec3::new(-1.0, -0.5, -0.75), DVec3::new(1.0, -0.25, 0.5), DVec3::new(0.25, 0.5, 0.75)];
    places.into_iter().map(|at| small.map(|p| at + size * p)).collect()
}
