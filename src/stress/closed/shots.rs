//! Rays from within solids, each with the range of t in which it must hit.
//!
//! Why the range is sure. Of a surface that is seen all from the ray's origin O, let g(x) = 1 on it and g(s x) = s g(x),
//! x from O. On a triangle g is linear, with a gradient of 1 over the distance of its plane from O, so that
//! |g(x + δ) − g(x)| ≤ |δ| / ρ, ρ the least of those distances. A ray's direction is rounded: at the t at which it should
//! be at its aim A, on the surface, it passes by at δ. What it hits it hits at t / g(A + δ), and 1 − |δ|/ρ ≤ g ≤ 1 + |δ|/ρ.
//! Of a surface that hides behind itself nothing is known of what may come before the aim; if the triangles around the aim
//! face away, ρ from O, the ray goes no further than through them.

use super::blocks::Blocks;
use super::solids::{Ball, Solid, Surface, wide};
use crate::abi::Ray;
use crate::trace::Query;
use crate::trace::rays::mixed;
use glam::{DVec3, IVec3, Vec3};

/// What rays go by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// From anywhere within, at vertices.
    Vertices,
    /// From anywhere within, at points of edges.
    Edges,
    /// Along an axis, the other two components 0 of either sign: through vertices, and through or along edges.
    Axes,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Vertices, Self::Edges, Self::Axes];

    /// As reports have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertices => "vertices",
            Self::Edges => "edges",
            Self::Axes => "axes",
        }
    }
}

/// A ray and what is known of its hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shot {
    pub ray: Ray,
    /// Least t of the surface; 0 where it may hide behind itself.
    pub least: f64,
    /// Greatest t of the surface.
    pub most: f64,
}

impl Shot {
    /// As `query` is asked it: where t is not told, what lies behind the surface must not count.
    pub fn asked(self, query: Query) -> Self {
        let t_max = match query {
            Query::Closest => f32::INFINITY,
            Query::Any => (self.most as f32).next_up(),
        };
        Self { ray: Ray { t_max, ..self.ray }, ..self }
    }
}

/// f32's unit roundoff.
const U: f64 = 1.0 / 16_777_216.0;
/// Relative error of the t that is reported: rounded, and scaled back.
const T: f64 = 4.0 * U;
/// How often another aim is tried where triangles around it don't face away.
const TRIES: usize = 64;
/// How far from a ball's centre a line along an axis through it may pass, in radii.
pub(super) const ON_AXIS: f64 = 0.9;
/// Triangles around an aim face away if the ray meets their planes at this sine at least.
const FACING: f64 = 0.05;

/// Random words of one ray, by SplitMix64.
struct Words(u64);

impl Words {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed(self.0)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    /// From 0 to 1.
    fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn flips(&mut self) -> bool {
        self.next() & 1 == 1
    }

    /// 0 of either sign.
    fn zero(&mut self) -> f32 {
        if self.flips() { 0.0 } else { -0.0 }
    }

    /// The length of a direction in a scene of size `scale`: a power of two, or not.
    fn length(&mut self, scale: f64) -> f64 {
        let power = 2f64.powi(self.below(17) as i32 - 8);
        if self.flips() { power * scale } else { (1.0 + self.share()) * scale }
    }

    /// Along an axis.
    fn along(&mut self, axis: usize, length: f32) -> Vec3 {
        let mut direction = Vec3::new(self.zero(), self.zero(), self.zero());
        direction[axis] = length;
        direction
    }

    /// Within a ball of radius 1 about 0; often on its axes or in its middle.
    fn within(&mut self) -> DVec3 {
        let keep = self.next() % 16;
        loop {
            let p = DVec3::new(self.share(), self.share(), self.share()) * 2.0 - 1.0;
            if p.length() < 0.95 {
                // The middle, the three axes; else as it is.
                return match keep {
                    0 => DVec3::ZERO,
                    k @ 1..=3 => DVec3::AXES[k as usize - 1] * p,
                    _ => p,
                };
            }
        }
    }
}

/// Makes the rays of a kind from within a solid.
pub(super) struct Shots<'a> {
    solid: &'a Solid,
    kind: Kind,
    seed: u64,
}

/// A vertex, or a point of an edge.
#[derive(Clone, Copy)]
struct Aim {
    point: DVec3,
    vertex: u32,
    /// The edge's other end.
    end: Option<u32>,
}

impl<'a> Shots<'a> {
    /// By `seed`.
    pub fn new(solid: &'a Solid, kind: Kind, seed: u64) -> Self {
        Self { solid, kind, seed }
    }

    /// Ray `index` of them, the same for the same seed.
    pub fn shot(&self, index: u64) -> Shot {
        let mut words = Words(mixed(self.seed ^ mixed(index)));
        match (self.kind, &self.solid.blocks) {
            (Kind::Axes, Some(blocks)) if words.flips() => self.through_blocks(blocks, &mut words),
            (Kind::Axes, _) => self.along_axis(&mut words),
            (Kind::Vertices | Kind::Edges, _) => self.aimed(&mut words),
        }
    }

    /// Towards a vertex or a point of an edge.
    fn aimed(&self, words: &mut Words) -> Shot {
        let ball = self.solid.balls[words.below(self.solid.balls.len())];
        let eye = wide((ball.centre + words.within() * ball.radius).as_vec3().to_array());
        self.tried(|| {
            let corners = self.solid.scene.triangles[words.below(self.solid.scene.triangles.len())];
            let first = words.below(3);
            let (vertex, end) = (corners[first], corners[(first + 1) % 3]);
            let aim = match self.kind {
                Kind::Edges => self.on_edge(vertex, end, words.share()),
                Kind::Vertices | Kind::Axes => self.at_vertex(vertex),
            };
            self.to_aim(&ball, eye, (aim.point - eye).as_vec3(), 1.0, &aim)
        })
    }

    /// Along an axis, through a vertex or, but for rounding, a point of an edge.
    fn along_axis(&self, words: &mut Words) -> Shot {
        self.tried(|| {
            let (ball, axis, vertex) = self.solid.on_axes[words.below(self.solid.on_axes.len())];
            let (ball, axis) = (self.solid.balls[ball as usize], usize::from(axis));
            let across = |p: DVec3| {
                let mut off = p - ball.centre;
                off[axis] = 0.0;
                off.length() / ball.radius
            };
            let mut aim = self.at_vertex(vertex);
            if words.flips() {
                let around = self.solid.around(vertex);
                let corners = self.solid.scene.triangles[around[words.below(around.len())] as usize];
                let other = corners[words.below(3)];
                let mut share = words.share();
                while other != vertex && across(aim.point) < ON_AXIS && aim.end.is_none() {
                    let on = self.on_edge(vertex, other, share);
                    if across(on.point) < ON_AXIS {
                        aim = on;
                    }
                    // The vertex is near enough, so this ends.
                    share *= 0.5;
                }
            }
            let mut eye = aim.point;
            let room = (1.0 - across(aim.point).powi(2)).sqrt() * ball.radius;
            eye[axis] = ball.centre[axis] + 0.95 * room * (2.0 * words.share() - 1.0);
            let eye = wide(eye.as_vec3().to_array());
            let length = words.length(self.solid.scale);
            let way = aim.point[axis] - eye[axis];
            let direction = words.along(axis, (length.copysign(way)) as f32);
            let t = way / f64::from(direction[axis]);
            self.to_aim(&ball, eye, direction, t, &aim)
        })
    }

    /// Along an axis through blocks: between them, along their edges, through their corners or along diagonals of their
    /// sides, exactly.
    fn through_blocks(&self, blocks: &Blocks, words: &mut Words) -> Shot {
        self.tried(|| {
            let (axis, ahead) = (words.below(3), words.flips());
            let half = IVec3::from_array([(); 3].map(|()| words.below(blocks.halves() as usize + 1) as i32));
            let ends = blocks.ends(half, axis, ahead)?;
            let eye = DVec3::from_array(std::array::from_fn(|k| {
                // Anywhere within a block; a side of one stays where it is.
                let moved = if half[k] % 2 == 1 && words.flips() { 1.9 * (words.share() - 0.5) } else { 0.0 };
                blocks.coordinate(f64::from(half[k]) + moved)
            }));
            let eye = eye.as_vec3();
            let length = words.length(1.0) as f32;
            let direction = words.along(axis, if ahead { length } else { -length });
            let t = |end: f64| (end - f64::from(eye[axis])) / f64::from(direction[axis]);
            let [least, most] = [t(ends[0]) * (1.0 - T), t(ends[1]) * (1.0 + T)];
            Some(Shot { ray: ray(eye, direction), least, most })
        })
    }

    /// The first ray that `make` makes; one of unknown hit where none can be had.
    fn tried(&self, mut make: impl FnMut() -> Option<Shot>) -> Shot {
        let unknown = || {
            let ray = ray(self.solid.balls[0].centre.as_vec3(), Vec3::X);
            Shot { ray, least: 0.0, most: f64::INFINITY }
        };
        (0..TRIES).find_map(|_| make()).unwrap_or_else(unknown)
    }

    fn place(&self, v: u32) -> DVec3 {
        wide(self.solid.scene.positions[v as usize])
    }

    fn at_vertex(&self, vertex: u32) -> Aim {
        Aim { point: self.place(vertex), vertex, end: None }
    }

    fn on_edge(&self, vertex: u32, end: u32, share: f64) -> Aim {
        Aim { point: self.place(vertex).lerp(self.place(end), share), vertex, end: Some(end) }
    }

    /// The ray from `eye`, in `ball`, that should be at `aim` at `t`; none where triangles around it don't face away.
    fn to_aim(&self, ball: &Ball, eye: DVec3, direction: Vec3, t: f64, aim: &Aim) -> Option<Shot> {
        let beside = (eye + direction.as_dvec3() * t - aim.point).length();
        let (depth, seam) = match self.solid.surface {
            Surface::Star { depth, seam } => (depth - eye.distance(ball.centre), seam),
            Surface::Winding => (self.depth_around(aim, eye), 0.0),
        };
        let share = (beside + seam) / depth;
        let known = match self.solid.surface {
            Surface::Star { .. } => share < 0.5,
            Surface::Winding => depth > FACING * aim.point.distance(eye),
        };
        let least = match self.solid.surface {
            Surface::Star { .. } => t / (1.0 + share) * (1.0 - T),
            Surface::Winding => 0.0,
        };
        let most = t / (1.0 - share) * (1.0 + T);
        known.then_some(Shot { ray: ray(eye.as_vec3(), direction), least, most })
    }

    /// How far `eye` lies behind the planes of the triangles around an aim.
    fn depth_around(&self, aim: &Aim, eye: DVec3) -> f64 {
        let has = |i: u32, v: u32| self.solid.scene.triangles[i as usize].contains(&v);
        let around = self.solid.around(aim.vertex).iter();
        let around = around.filter(|i| aim.end.is_none_or(|end| has(**i, end)));
        around.map(|i| self.solid.depth(*i, eye)).fold(f64::INFINITY, f64::min)
    }
}

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    let (origin, direction) = (origin.to_array(), direction.to_array());
    Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
}
