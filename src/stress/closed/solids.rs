//! Closed meshes of which is known where their insides are and where a ray from within leaves them. By + − × ÷ and square
//! roots alone: the same on every machine.

use super::blocks::Blocks;
use super::shots::ON_AXIS;
use crate::scene::Scene;
use glam::{DMat3, DQuat, DVec3};
use std::collections::HashMap;

/// A ball that surely lies within a solid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    /// Its centre, of f32 coordinates.
    pub centre: DVec3,
    /// Scene units.
    pub radius: f64,
}

/// What is known of a solid's surface.
#[derive(Debug, Clone)]
pub(super) enum Surface {
    /// All of it is seen from everywhere in the one ball: every triangle's plane lies at least `depth` from its centre, twice
    /// the radius, with the centre behind. Seams may lie off it by `seam`.
    Star { depth: f64, seam: f64 },
    /// It may hide behind itself.
    Winding,
}

/// A closed mesh.
#[derive(Debug, Clone)]
pub struct Solid {
    /// What it is.
    pub name: &'static str,
    /// Its triangles, anticlockwise from outside.
    pub scene: Scene,
    pub(super) balls: Vec<Ball>,
    pub(super) surface: Surface,
    /// Where it is made of blocks that lie along the axes.
    pub(super) blocks: Option<Blocks>,
    /// Whether its triangles lie along no axis, so that turned boxes pay.
    pub(super) turned: bool,
    /// Longest edge of its box, scene units.
    pub(super) scale: f64,
    /// Vertices that lines along an axis through a ball meet: ball, axis, vertex.
    pub(super) on_axes: Vec<(u32, u8, u32)>,
    /// Triangles around each vertex: where they start in `around`.
    starts: Vec<u32>,
    around: Vec<u32>,
}

/// Vertices and triangles in the making.
type Mesh = (Vec<DVec3>, Vec<[u32; 3]>);

impl Solid {
    /// All of them.
    pub fn all() -> Vec<Self> {
        let about = |mesh: &Mesh, centre: DVec3, size: f64| -> Mesh {
            (mesh.0.iter().map(|p| centre + *p * size).collect(), mesh.1.clone())
        };
        let turn = turn();
        let turned = |mesh: &Mesh| -> Mesh { (mesh.0.iter().map(|p| turn * *p).collect(), mesh.1.clone()) };
        let (fine, coarse) = (sphere(4), sphere(3));
        let far = DVec3::new(1e4, -2e5, 1e6);
        let (seams, fillers) = seamed(&coarse);
        let (cube, stairs) = (Blocks::cube(16), Blocks::ball(16));
        let upright = |name, blocks: Blocks| Self {
            blocks: Some(blocks.clone()),
            turned: false,
            ..Self::star(name, blocks.mesh(), DVec3::ZERO, 0)
        };
        let round = |name, mesh, centre| Self::star(name, mesh, centre, 0);
        vec![
            round("sphere", fine.clone(), DVec3::ZERO),
            round("globe", globe(32, 64), DVec3::ZERO),
            round("tiny sphere", about(&coarse, DVec3::ZERO, 1e-30), DVec3::ZERO),
            round("huge sphere", about(&coarse, DVec3::ZERO, 1e30), DVec3::ZERO),
            round("far sphere", about(&fine, far, 1e3), far),
            round("needles", needles(&fine), DVec3::ZERO),
            round("slivers", globe(4, 512), DVec3::ZERO),
            Self::star("seams", seams, DVec3::ZERO, fillers),
            upright("cube", cube.clone()),
            upright("stairs", stairs.clone()),
            round("turned cube", turned(&cube.mesh()), DVec3::ZERO),
            round("turned stairs", turned(&stairs.mesh()), DVec3::ZERO),
            Self::tube("torus", &torus_path(64), 0.25, 32, turn),
            Self::tube("knot", &knot_path(256), 0.12, 16, turn),
        ]
    }

    /// Of a mesh that is seen all from around `centre`, but for its last `fillers` triangles, which close seams.
    fn star(name: &'static str, mesh: Mesh, centre: DVec3, fillers: usize) -> Self {
        let scene = scene(&mesh);
        let seen = scene.triangles.len() - fillers;
        let depth = (0..seen).map(|i| depth(&scene, i, centre)).fold(f64::INFINITY, f64::min);
        // A filler's middle corner was put upon the edge of the other two and rounded, as they were.
        let seam = (seen..scene.triangles.len()).map(|i| {
            let [a, b, m] = scene.corners(i).map(wide);
            m.distance(a.midpoint(b))
        });
        let surface = Surface::Star { depth, seam: 4.0 * seam.fold(0.0, f64::max) };
        Self::new(name, scene, vec![Ball { centre, radius: 0.5 * depth }], surface)
    }

    /// Of a tube of `radius` around a closed path.
    fn tube(name: &'static str, path: &[DVec3], radius: f64, sides: usize, turn: DMat3) -> Self {
        let path: Vec<DVec3> = path.iter().map(|p| turn * *p).collect();
        // Half the radius is within even where the path bends and rings lean on each other.
        let ball = |p: &DVec3| Ball { centre: wide(p.as_vec3().to_array()), radius: 0.5 * radius };
        let balls = path.iter().map(ball).collect();
        Self::new(name, scene(&tube(&path, radius, sides)), balls, Surface::Winding)
    }

    fn new(name: &'static str, scene: Scene, balls: Vec<Ball>, surface: Surface) -> Self {
        let (starts, around) = triangles_around(&scene);
        let bounds = scene.bounds();
        let scale = (0..3).map(|k| f64::from(bounds.hi[k]) - f64::from(bounds.lo[k])).fold(0.0, f64::max);
        let (blocks, turned, on_axes) = (None, true, vec![]);
        let mut solid = Self { name, scene, balls, surface, blocks, turned, scale, on_axes, starts, around };
        solid.on_axes = solid.find_on_axes();
        solid
    }

    fn find_on_axes(&self) -> Vec<(u32, u8, u32)> {
        let mut found = vec![];
        for (b, ball) in (0..).zip(&self.balls) {
            for (v, p) in (0..).zip(&self.scene.positions) {
                let off = wide(*p) - ball.centre;
                for axis in 0..3u8 {
                    let mut across = off;
                    across[usize::from(axis)] = 0.0;
                    if across.length() < ON_AXIS * ball.radius {
                        found.push((b, axis, v));
                    }
                }
            }
        }
        found
    }

    /// Triangles around vertex `v`.
    pub(super) fn around(&self, v: u32) -> &[u32] {
        &self.around[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }

    /// How far triangle `i`'s plane lies before `eye`, which sees its back.
    pub(super) fn depth(&self, i: u32, eye: DVec3) -> f64 {
        depth(&self.scene, i as usize, eye)
    }
}

pub(super) fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

fn depth(scene: &Scene, i: usize, eye: DVec3) -> f64 {
    let [a, b, c] = scene.corners(i).map(wide);
    // Levelled, for the squares of tiny edges would be denormal even in f64.
    let size = (b - a).abs().max_element();
    ((b - a) / size).cross((c - a) / size).normalize().dot(a - eye)
}

fn scene((positions, triangles): &Mesh) -> Scene {
    let positions = positions.iter().map(|p| p.as_vec3().to_array()).collect();
    Scene { positions, triangles: triangles.clone(), ..Scene::default() }
}

fn triangles_around(scene: &Scene) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0; scene.positions.len() + 1];
    scene.triangles.iter().flatten().for_each(|v| starts[*v as usize + 1] += 1);
    (1..starts.len()).for_each(|i| starts[i] += starts[i - 1]);
    let mut next = starts.clone();
    let mut around = vec![0; 3 * scene.triangles.len()];
    for (i, triangle) in (0..).zip(&scene.triangles) {
        for v in triangle {
            around[next[*v as usize] as usize] = i;
            next[*v as usize] += 1;
        }
    }
    (starts, around)
}

/// A rotation about no axis of theirs.
fn turn() -> DMat3 {
    DMat3::from_quat(DQuat::from_xyzw(0.3, -0.5, 0.2, 0.9).normalize())
}

/// A ball of unit radius: an octahedron whose triangles are cut in four so many times. Its six corners lie on the axes.
fn sphere(cuts: u32) -> Mesh {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut points = vec![x, -x, y, -y, z, -z];
    let mut triangles = vec![];
    for (i, j, k) in [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4)] {
        triangles.extend([[i, j, k], [j, i, k + 1]]);
    }
    for _ in 0..cuts {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        let cut = |[a, b, c]: [u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(cut).collect();
    }
    (points, triangles)
}

/// Points of the unit circle from x to y, a power of two of them: between each two, the one in the middle.
fn circle(sides: usize) -> Vec<(f64, f64)> {
    let mut points = vec![(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
    while points.len() < sides {
        let between = |i: usize| {
            let (p, q): ((f64, f64), (f64, f64)) = (points[i], points[(i + 1) % points.len()]);
            let (x, y) = (p.0 + q.0, p.1 + q.1);
            let length = (x * x + y * y).sqrt();
            [p, (x / length, y / length)]
        };
        points = (0..points.len()).flat_map(between).collect();
    }
    points
}

/// A ball cut along meridians and parallels; `sides` and twice `bands` powers of two. Fans of `sides` triangles close it.
fn globe(bands: usize, sides: usize) -> Mesh {
    let (meridian, parallel) = (circle(2 * bands), circle(sides));
    let mut points = vec![DVec3::Z, -DVec3::Z];
    for (z, r) in &meridian[1..bands] {
        points.extend(parallel.iter().map(|(x, y)| DVec3::new(r * x, r * y, *z)));
    }
    let at = |band: usize, side: usize| match band {
        0 => 0,
        b if b == bands => 1,
        b => (2 + (b - 1) * sides + side % sides) as u32,
    };
    let mut triangles = vec![];
    for band in 0..bands {
        for side in 0..sides {
            let [a, b] = [at(band, side), at(band + 1, side)];
            let [d, c] = [at(band, side + 1), at(band + 1, side + 1)];
            triangles.extend([[a, b, c], [a, c, d]].into_iter().filter(|t| t[0] != t[2] && t[1] != t[2]));
        }
    }
    (points, triangles)
}

/// Every third vertex or so, but for those on the axes, pulled out to thirty times its distance.
fn needles((points, triangles): &Mesh) -> Mesh {
    let pulled = |(i, p): (usize, &DVec3)| if i >= 6 && i % 3 == 0 { *p * 30.0 } else { *p };
    (points.iter().enumerate().map(pulled).collect(), triangles.clone())
}

/// Cuts each edge on one of its sides only, and closes the seam by a triangle of its ends and its middle: as good as no
/// area. Returns how many of those, at the end, there are.
fn seamed((points, triangles): &Mesh) -> (Mesh, usize) {
    let mut points: Vec<DVec3> = points.iter().map(|p| wide(p.as_vec3().to_array())).collect();
    let (mut cut, mut fillers) = (vec![], vec![]);
    for [a, b, c] in triangles {
        let mut outline = vec![];
        for (p, q) in [(*a, *b), (*b, *c), (*c, *a)] {
            outline.push(p);
            if p < q {
                let m = points.len() as u32;
                points.push(points[p as usize].midpoint(points[q as usize]));
                outline.push(m);
                fillers.push([p, q, m]);
            }
        }
        let centre = points.len() as u32;
        points.push((points[*a as usize] + points[*b as usize] + points[*c as usize]) / 3.0);
        cut.extend((0..outline.len()).map(|i| [outline[i], outline[(i + 1) % outline.len()], centre]));
    }
    let count = fillers.len();
    cut.extend(fillers);
    ((points, cut), count)
}

/// A closed tube around a closed path.
fn tube(path: &[DVec3], radius: f64, sides: usize) -> Mesh {
    let n = path.len();
    let circle = circle(sides);
    let mut points = vec![];
    for i in 0..n {
        let along = (path[(i + 1) % n] - path[(i + n - 1) % n]).normalize();
        // The way to the middle never lies along these paths, so that the frame closes.
        let x = (path[i] - along * path[i].dot(along)).normalize();
        let y = along.cross(x);
        points.extend(circle.iter().map(|(cos, sin)| path[i] + (x * *cos + y * *sin) * radius));
    }
    let at = |ring: usize, side: usize| (ring % n * sides + side % sides) as u32;
    let quads = (0..n).flat_map(|ring| (0..sides).map(move |side| (ring, side)));
    let triangles = quads.flat_map(|(ring, side)| {
        let [a, b] = [at(ring, side), at(ring, side + 1)];
        let [d, c] = [at(ring + 1, side), at(ring + 1, side + 1)];
        [[a, b, c], [a, c, d]]
    });
    (points, triangles.collect())
}

fn torus_path(points: usize) -> Vec<DVec3> {
    circle(points).into_iter().map(|(x, y)| DVec3::new(x, y, 0.0)).collect()
}

/// A trefoil.
fn knot_path(points: usize) -> Vec<DVec3> {
    let circle = circle(points);
    let at = |i: usize| circle[i % points];
    let point = |i: usize| {
        let r = 1.0 + 0.4 * at(3 * i).0;
        DVec3::new(r * at(2 * i).0, r * at(2 * i).1, 0.5 * at(3 * i).1)
    };
    (0..points).map(point).collect()
}
