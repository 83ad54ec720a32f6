//! Ambient occlusion and shadows where the answer is known: all of it within a closed convex body, none over a plane.

#![allow(clippy::unwrap_used)]

use crate::gpu::{Quiet, quiet};
use crate::rays::Stage;
use crate::soup::sphere;
use boxwood::abi::{Hit, Ray};
use boxwood::bvh::{Fit, Recipe};
use boxwood::oracle::reference::Reference;
use boxwood::scene::{Camera, Scene};
use boxwood::trace::Batch;
use boxwood::trace::rays::{Light, Secondary, View};
use glam::{DQuat, DVec3};

/// Where a mesh is put: turned, scaled, then moved.
#[derive(Debug, Clone, Copy)]
struct Pose {
    turn: DQuat,
    scale: f64,
    shift: f64,
}

impl Pose {
    /// Scales from a thousandth to ten thousand, at the origin and far off, as far as single precision leaves of the mesh
    /// what it is: upright and turned.
    fn all() -> Vec<Self> {
        let tilted = DQuat::from_xyzw(0.3, -0.5, 0.2, 0.9).normalize();
        let places = [(1e-3, 0.0), (1.0, 0.0), (1e4, 0.0), (1e-3, 10.0), (1.0, 1e4), (1e4, 1e4)];
        let all = [DQuat::IDENTITY, tilted].into_iter();
        all.flat_map(|turn| places.map(|(scale, shift)| Self { turn, scale, shift })).collect()
    }

    fn point(&self, p: DVec3) -> [f32; 3] {
        (self.turn * p * self.scale + self.shift * DVec3::new(1.0, -0.7, 0.4)).as_vec3().to_array()
    }

    fn put(&self, scene: &Scene) -> Scene {
        let put = |p: &[f32; 3]| self.point(DVec3::from_array(p.map(f64::from)));
        Scene { positions: scene.positions.iter().map(put).collect(), ..scene.clone() }
    }

    /// From `eye` to `target`, both before they are put there. Fewer pixels where rays are dear: without 64-bit numbers.
    fn view(&self, device: &Quiet<'_>, eye: DVec3, target: DVec3) -> View {
        let up = (self.turn * DVec3::new(0.2, 1.0, 0.1)).as_vec3().to_array();
        let camera = Camera { eye: self.point(eye), target: self.point(target), up, fov_y: 100.0 };
        let [width, height] = if device.is_wide() { [72, 54] } else { [52, 39] };
        View { camera, width, height }
    }
}

/// Through axis-aligned boxes and through turned ones.
fn recipes() -> [Recipe; 2] {
    let plain = Recipe::default();
    [plain, Recipe { fit: Fit::Dito(14), oriented_cost: plain.collapse.node_cost, ..plain }]
}

/// An n × n lattice of squares at z = 0 from −1 to 1, seen anticlockwise from above.
fn plane(n: u32) -> Scene {
    let at = |i: u32| i as f32 * 2.0 / n as f32 - 1.0;
    let positions = (0..(n + 1) * (n + 1)).map(|i| [at(i % (n + 1)), at(i / (n + 1)), 0.0]).collect();
    let square = |i: u32| {
        let a = i / n * (n + 1) + i % n;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    Scene { positions, triangles: (0..n * n).flat_map(square).collect(), ..Scene::default() }
}

/// A closed cube from −1 to 1, each side of n × n squares.
fn cube(n: u32) -> Scene {
    let side = plane(n);
    let mut scene = Scene::default();
    for k in 0..3 {
        for far in [1.0, -1.0f32] {
            let first = scene.positions.len() as u32;
            let put = |p: &[f32; 3]| {
                let mut q = [0.0; 3];
                [q[k], q[(k + 1) % 3], q[(k + 2) % 3]] = [far, p[0] * far, p[1]];
                q
            };
            scene.positions.extend(side.positions.iter().map(put));
            scene.triangles.extend(side.triangles.iter().map(|t| t.map(|v| v + first)));
        }
    }
    scene
}

/// Of the rays, of which there are some, those that don't get away; how many there are.
fn shaded(device: &Quiet<'_>, stage: &Stage, primaries: &Batch, kind: &Secondary) -> (Vec<Ray>, usize) {
    let rays = stage.spawn(device, primaries, kind, 1 << 20);
    assert!(rays.len() > 1000, "{} rays", rays.len());
    let hits = stage.hits(device, &rays);
    (rays.iter().zip(&hits).filter(|r| r.1.is_hit()).map(|r| *r.0).collect(), rays.len())
}

/// Primaries that met something; all of them, if need be.
fn met(primaries: &Batch) -> usize {
    primaries.hits.read_first(primaries.count).unwrap().iter().filter(|h: &&Hit| h.is_hit()).count()
}

/// Whether `p` lies behind all planes of a convex body, exactly.
fn is_within(body: &Scene, p: [f32; 3]) -> bool {
    let wide = |p: [f32; 3]| DVec3::from_array(p.map(f64::from));
    (0..body.triangles.len()).all(|i| {
        let [a, b, c] = body.corners(i).map(wide);
        (b - a).cross(c - a).dot(wide(p) - a) <= 0.0
    })
}

#[test]
fn within_a_closed_body_all_is_occluded() {
    let device = quiet();
    for (what, body) in [("sphere", sphere(24, [0.0; 3], 1.0)), ("box", cube(1)), ("cut box", cube(12))] {
        for pose in Pose::all() {
            for recipe in recipes() {
                let stage = Stage::by(&device, pose.put(&body), &recipe);
                // The diagonal of a cube, and twice as far; and of any length. Axis-aligned boxes and turned
                // ones have them from different eyes.
                let mut lengths = [(7.0 * pose.scale) as f32, f32::INFINITY];
                if recipe.fit != Fit::Aabb {
                    lengths.reverse();
                }
                let looks = [
                    ([0.1, -0.2, 0.3], [1.0, 0.4, 0.2], lengths[0]),
                    ([-0.3, 0.2, 0.0], [-0.4, -0.3, -1.0], lengths[1]),
                ];
                for (eye, target, length) in looks {
                    let view = pose.view(&device, eye.into(), target.into());
                    let primaries = stage.look(&device, &view);
                    assert_eq!(met(&primaries), view.pixels(), "{what}, {pose:?}");
                    let kind = Secondary { length, ..Secondary::ao(&stage.scene.bounds()) };
                    let rays = stage.spawn(&device, &primaries, &kind, 1 << 20);
                    let hits = stage.hits(&device, &rays);
                    let open: Vec<&Ray> =
                        rays.iter().zip(&hits).filter(|r| !r.1.is_hit()).map(|r| r.0).collect();
                    let what = format!("{what}, {pose:?}, {:?}, rays of {length}", recipe.fit);
                    // A hit within the rounding of its coordinates from another side, an edge of a turned box far off,
                    // may have its origin beyond that side; no other ray gets out.
                    let within = open.iter().filter(|r| is_within(&stage.scene, r.origin)).count();
                    assert!(within == 0, "{what}: {within} of {} rays", rays.len());
                    let share = open.len() as f64 / rays.len() as f64;
                    assert!(rays.len() == 32 * view.pixels() && share < 1e-3, "{what}: openness {share}");
                    assert!(open.is_empty() || pose.shift > 0.0, "{what}: openness {share}");
                }
            }
        }
    }
}

#[test]
fn over_a_plane_nothing_is() {
    let device = quiet();
    let tilted = DQuat::from_xyzw(0.1, 0.25, -0.05, 1.0).normalize();
    let mut poses = Pose::all();
    poses.extend([(1e-20, 0.0), (1e20, 0.0), (1.0, 1e5)].map(|(scale, shift)| Pose {
        turn: tilted,
        scale,
        shift,
    }));
    for pose in poses {
        for recipe in recipes() {
            let stage = Stage::by(&device, pose.put(&plane(64)), &recipe);
            let reference = Reference::new(&stage.scene);
            for eye in [[0.1, 0.2, 0.8], [0.9, -0.7, 0.2]] {
                let primaries =
                    stage.look(&device, &pose.view(&device, eye.into(), DVec3::new(0.1, 0.0, -0.5)));
                let met = met(&primaries);
                assert!(met > 1000, "{pose:?}: {met} primaries hit");
                for kind in [Secondary::ao(&stage.scene.bounds()), Secondary::diffuse()] {
                    let (shaded, of) = shaded(&device, &stage, &primaries, &kind);
                    let what =
                        format!("{pose:?}, {:?}, {kind:?}: {} of {of} shaded", recipe.fit, shaded.len());
                    // Far off for its size, rounding has bent the plane: what is in the way of a ray is there in f64 too.
                    let bent = pose.shift > 100.0 * pose.scale;
                    assert!(shaded.iter().all(|ray| bent && reference.any(ray)), "{what}");
                    assert!(shaded.len() * 100 < of, "{what}");
                }
                // Lights above: each hit sees all four. Below: none does, and no ray is made.
                let lights = |height: f64| {
                    let places = [[0.3, 0.4], [-0.9, 0.1], [0.0, 0.0], [2.0, -3.0]];
                    places.map(|[x, y]| Light { position: pose.point(DVec3::new(x, y, height)), radius: 0.0 })
                };
                let above = Secondary::shadow(lights(1.5));
                let rays = stage.spawn(&device, &primaries, &above, 1 << 20);
                let dark = stage.hits(&device, &rays).iter().filter(|h| h.is_hit()).count();
                assert_eq!((rays.len(), dark), (4 * met, 0), "{pose:?}, {:?}", recipe.fit);
                let rays = stage.spawn(&device, &primaries, &Secondary::shadow(lights(-1.5)), 1 << 20);
                assert_eq!(rays.len(), 0, "{pose:?}: rays to lights behind the plane");
            }
        }
    }
}

#[test]
fn under_a_roof_it_is_dark() {
    let device = quiet();
    // A roof above the plane, and lights above the roof: small enough that each line to them crosses it.
    let mut scene = plane(32);
    let first = scene.positions.len() as u32;
    let roof = plane(7);
    scene.positions.extend(roof.positions.iter().map(|[x, y, _]| [8.0 * x, 8.0 * y, 1.0]));
    scene.triangles.extend(roof.triangles.iter().map(|t| t.map(|v| v + first)));
    for pose in Pose::all() {
        let stage = Stage::new(&device, pose.put(&scene));
        let primaries =
            stage.look(&device, &pose.view(&device, DVec3::new(0.1, 0.2, 0.8), DVec3::new(0.1, 0.0, -0.5)));
        let lights = [[0.3, 0.4], [-0.9, 0.1], [0.0, 0.0], [2.0, -3.0]];
        let lights = lights.map(|[x, y]| Light { position: pose.point(DVec3::new(x, y, 1.5)), radius: 0.0 });
        let rays = stage.spawn(&device, &primaries, &Secondary::shadow(lights), 1 << 20);
        let lit = stage.hits(&device, &rays).iter().filter(|h| !h.is_hit()).count();
        assert!(rays.len() > 1000, "{pose:?}: {} rays", rays.len());
        assert_eq!(lit, 0, "{pose:?}: of {} rays", rays.len());
    }
}
