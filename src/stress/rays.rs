//! The catalogue of rays, for any scene: what breaks tests of boxes and triangles.

use super::random::Random;
use crate::abi::Ray;
use crate::oracle::reference::Reference;
use glam::DVec3;

/// Rays that are hard in one way.
#[derive(Debug, Clone, Copy)]
pub struct RaySet {
    /// A word.
    pub name: &'static str,
    /// What is hard about them.
    pub why: &'static str,
    one: fn(&mut Ground, usize) -> Ray,
}

/// Rays that can hit nothing, whatever the test.
pub const NONSENSE: &str = "nonsense";

const fn set(name: &'static str, why: &'static str, one: fn(&mut Ground, usize) -> Ray) -> RaySet {
    RaySet { name, why, one }
}

/// All of them.
pub const SETS: &[RaySet] = &[
    set("through", "from outside, by chance", |g, _| {
        let (from, to) = (g.outside(), g.within());
        toward(from, to)
    }),
    set("vertices", "at vertices, from outside, inside, another vertex, and along an axis", vertices),
    set("edges", "at points of edges", |g, i| {
        let ([a, b, _], s) = (g.triangle(), g.random.of(&[0.25, 0.5, 0.7, 1e-6]));
        let from = g.somewhere(i);
        toward(from, a.lerp(b, s))
    }),
    set("along-edges", "along an edge, from beyond it, from its end, from its middle", |g, i| {
        let [a, b, _] = g.triangle();
        let from = a - (b - a) * [1.0, 0.0, -0.5, 16.0][i % 4];
        ray(from, b - a)
    }),
    set("in-planes", "in the plane of a triangle, through it", |g, i| {
        let [a, b, c] = g.triangle();
        let from = a + (b - a) * [-1.0, 2.0][i % 2] + (c - a) * g.random.unit();
        toward(from, (a + b + c) / 3.0)
    }),
    set("box-faces", "in the faces and along the edges of boxes", box_faces),
    set("plus-zero", "along an axis, the other components +0", |g, i| along_axis(g, i, 0.0)),
    set("minus-zero", "along an axis, the other components −0", |g, i| along_axis(g, i, -0.0)),
    set("denormal", "denormal components of directions and origins", denormal),
    set("lengths", "directions of any length that f32 has", lengths),
    set("surfaces", "from vertices, edges and points of surfaces", surfaces),
    set("inside", "from the middles and corners of boxes", |g, i| {
        let (lo, hi) = g.box_of(i);
        let from = [(lo + hi) / 2.0, lo, hi, lo.lerp(hi, g.random.share())][i / 2 % 4];
        ray(from, g.random.direction())
    }),
    set("far", "from 1e7, and from 1e3 to 1e7 scene sizes away", |g, i| {
        let away = [1e7, 1e3 * g.size, 1e5 * g.size, 1e7 * g.size][i % 4];
        let [a, b, c] = g.triangle();
        let (u, v) = (g.random.share(), g.random.share());
        let to = a + (b - a) * u + (c - a) * (v * (1.0 - u));
        let from = to + g.random.direction() * away;
        toward(from, to)
    }),
    set("ranges", "t_min and t_max at, just before and just after a hit, alike, crossed", ranges),
    set(NONSENSE, "NaN and infinity anywhere, no direction", nonsense),
];

impl RaySet {
    /// `count` rays over what `reference` answers for, the same for the same seed.
    pub fn rays(&self, reference: &Reference, count: usize, seed: u64) -> Vec<Ray> {
        let mut ground = Ground::new(reference, Random::new(seed, self.name));
        (0..count).map(|i| (self.one)(&mut ground, i)).collect()
    }
}

/// A scene as rays see it.
struct Ground<'r> {
    reference: &'r Reference<'r>,
    /// Corners of finite triangles, at most [`SAMPLE`] of them.
    triangles: Vec<[DVec3; 3]>,
    lo: DVec3,
    hi: DVec3,
    /// Length of the box's diagonal; above 0.
    size: f64,
    random: Random,
}

/// Triangles that rays are aimed at.
const SAMPLE: usize = 1 << 12;

impl<'r> Ground<'r> {
    fn new(reference: &'r Reference<'r>, random: Random) -> Self {
        let scene = reference.scene();
        let step = scene.triangles.len().div_ceil(SAMPLE).max(1);
        let corners = |i: usize| scene.corners(i).map(|p| DVec3::from_array(p.map(f64::from)));
        let finite = |c: &[DVec3; 3]| c.iter().all(|p| p.is_finite());
        let triangles: Vec<_> =
            (0..scene.triangles.len()).step_by(step).map(corners).filter(finite).collect();
        let points = triangles.as_flattened();
        let (mut lo, mut hi) = (DVec3::NEG_ONE, DVec3::ONE);
        if let Some(&first) = points.first() {
            (lo, hi) = points.iter().fold((first, first), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
        }
        let size = (hi - lo).length();
        let size = if size > 0.0 { size } else { 1.0 };
        Self { reference, triangles, lo, hi, size, random }
    }

    /// In the scene's box.
    fn within(&mut self) -> DVec3 {
        let share = DVec3::new(self.random.share(), self.random.share(), self.random.share());
        self.lo + (self.hi - self.lo) * share
    }

    /// Up to two sizes from the middle.
    fn outside(&mut self) -> DVec3 {
        let away = self.size * (0.6 + 1.4 * self.random.share());
        (self.lo + self.hi) / 2.0 + self.random.direction() * away
    }

    /// A triangle of the scene, its corners in some order; any where there is none.
    fn triangle(&mut self) -> [DVec3; 3] {
        if self.triangles.is_empty() {
            return [self.within(), self.within(), self.within()];
        }
        let mut corners = self.random.of(&self.triangles);
        corners.rotate_left(self.random.below(3));
        corners
    }

    /// The `i`th kind of origin.
    fn somewhere(&mut self, i: usize) -> DVec3 {
        match i % 3 {
            0 => self.outside(),
            1 => self.within(),
            _ => self.triangle()[0],
        }
    }

    /// The box of a triangle, and every other time the scene's.
    fn box_of(&mut self, i: usize) -> (DVec3, DVec3) {
        if i.is_multiple_of(2) {
            return (self.lo, self.hi);
        }
        let [a, b, c] = self.triangle();
        (a.min(b).min(c), a.max(b).max(c))
    }
}

/// A ray without limits. A direction that f32 has no numbers for is scaled; an origin is moved to the largest of them.
fn ray(origin: DVec3, direction: DVec3) -> Ray {
    let most = f64::from(f32::MAX);
    let origin = origin.clamp(DVec3::splat(-most), DVec3::splat(most)).as_vec3();
    let longest = direction.abs().max_element();
    let over = if (1e-30..1e30).contains(&longest) || longest == 0.0 { 1.0 } else { 1.0 / longest };
    Ray {
        origin: origin.to_array(),
        t_min: 0.0,
        direction: (direction * over).as_vec3().to_array(),
        t_max: f32::INFINITY,
    }
}

/// From `from`, as f32 has it, to `to`.
fn toward(from: DVec3, to: DVec3) -> Ray {
    let at = DVec3::from_array(ray(from, DVec3::Z).origin.map(f64::from));
    ray(at, to - at)
}

fn vertices(g: &mut Ground, i: usize) -> Ray {
    let to = g.triangle()[0];
    if i % 4 == 3 {
        let axis = DVec3::AXES[g.random.below(3)] * g.random.of(&[1.0, -1.0]);
        return toward(to - axis * (g.size * g.random.of(&[0.5, 1.0, 2.0])), to);
    }
    let from = g.somewhere(i);
    toward(from, to)
}

/// Along axis `i`, forth and back, `zero` in the others: through vertices, edges, and by chance.
fn along_axis(g: &mut Ground, i: usize, zero: f32) -> Ray {
    let [a, b, c] = g.triangle();
    let through = [a, (a + b) / 2.0, (a + b + c) / 3.0, g.within()][i / 6 % 4];
    axis_ray(g, i, through, zero)
}

fn axis_ray(g: &mut Ground, i: usize, through: DVec3, zero: f32) -> Ray {
    let (axis, sign) = (i % 3, if (i / 3).is_multiple_of(2) { 1.0 } else { -1.0 });
    let mut from = through;
    from[axis] = (g.lo[axis] + g.hi[axis]) / 2.0 - sign * g.size * g.random.of(&[0.0, 1.0]);
    let mut one = ray(from, DVec3::Z);
    one.direction = [zero; 3];
    one.direction[axis] = sign as f32;
    one
}

fn box_faces(g: &mut Ground, i: usize) -> Ray {
    let (lo, hi) = g.box_of(i);
    let (i, mut through) = (i / 2, g.within());
    // On a face; every other time on an edge.
    let (face, other) = ((i + 1) % 3, (i + 2) % 3);
    through[face] = g.random.of(&[lo[face], hi[face]]);
    if g.random.below(2) == 0 {
        through[other] = g.random.of(&[lo[other], hi[other]]);
    }
    let zero = g.random.of(&[0.0, -0.0]);
    axis_ray(g, i, through, zero)
}

fn denormal(g: &mut Ground, i: usize) -> Ray {
    let mut one = match i % 3 {
        0 => toward(g.outside(), g.within()),
        1 => vertices(g, 0),
        _ => vertices(g, 3),
    };
    let least = f32::from_bits(1);
    let tiny = |r: &mut Random| f32::from_bits(1 + r.below(1 << 23) as u32) * r.of(&[1.0, -1.0]);
    let k = g.random.below(3);
    match i / 3 % 5 {
        0 => one.direction = one.direction.map(|x| (f64::from(x) / g.size * 1e-39) as f32),
        1 => one.direction[k] = tiny(&mut g.random),
        2 => one.origin[k] = tiny(&mut g.random),
        3 => one.direction = [0.0, 1.0, 2.0].map(|j| if j == k as f32 { least } else { 0.0 }),
        _ => (one.t_min, one.t_max) = (least, f32::MAX),
    }
    one
}

fn lengths(g: &mut Ground, i: usize) -> Ray {
    let mut one = if i.is_multiple_of(2) { vertices(g, i / 2) } else { toward(g.outside(), g.within()) };
    let longest = one.direction.iter().fold(0.0, |m: f32, x| m.max(x.abs()));
    let wanted = [1e-37, 1e-30, 1e-12, 1.0, 1e12, 1e30, f32::MAX, 1.7e38][i / 2 % 8];
    one.direction = one.direction.map(|x| (f64::from(x) / f64::from(longest) * f64::from(wanted)) as f32);
    one
}

fn surfaces(g: &mut Ground, i: usize) -> Ray {
    let [a, b, c] = g.triangle();
    let (u, v) = (g.random.share(), g.random.share());
    let from = [a, a.lerp(b, u), a + (b - a) * u + (c - a) * (v * (1.0 - u)), (a + b + c) / 3.0][i % 4];
    match i / 4 % 3 {
        0 => ray(from, g.random.direction()),
        1 => {
            let to = g.triangle()[0];
            toward(from, to)
        }
        // Off the surface it starts from.
        _ => ray(from, (b - a).normalize_or(DVec3::X).cross((c - a).normalize_or(DVec3::Y))),
    }
}

fn ranges(g: &mut Ground, i: usize) -> Ray {
    let one = match i / 12 % 3 {
        0 => vertices(g, i),
        1 => along_axis(g, i, 0.0),
        _ => toward(g.outside(), g.within()),
    };
    let t = g.reference.closest(&one).map_or(1.0, |hit| hit.t as f32);
    let (before, after) = (t.next_down(), t.next_up());
    let (t_min, t_max) = [
        (t, t),
        (before, before),
        (after, after),
        (t, f32::INFINITY),
        (after, f32::INFINITY),
        (0.0, t),
        (0.0, before),
        (before, after),
        (after, before),
        (f32::NEG_INFINITY, f32::INFINITY),
        (f32::NEG_INFINITY, -0.0),
        (0.0, 0.0),
    ][i % 12];
    Ray { t_min, t_max, ..one }
}

fn nonsense(g: &mut Ground, i: usize) -> Ray {
    let plain = toward(g.outside(), g.within());
    let mut words: [f32; 8] = bytemuck::cast(plain);
    match i % 28 {
        24 => (words[4], words[5], words[6]) = (0.0, -0.0, 0.0),
        25 => words = [f32::NAN; 8],
        26 => (words[3], words[7]) = (f32::INFINITY, f32::MAX),
        27 => words[7] = f32::NEG_INFINITY,
        // The limits of the range may be infinite.
        n if n % 8 == 3 || n % 8 == 7 => words[n % 8] = f32::NAN,
        n => words[n % 8] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][n / 8],
    }
    bytemuck::cast(words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::brute;
    use crate::stress::{CASES, Effort};

    #[test]
    fn rays_are_what_their_sets_say() {
        for case in CASES.iter().filter(|c| ["none", "points", "soup", "flt-max"].contains(&c.name)) {
            let scene = case.scene(Effort::Quick, 1);
            let reference = Reference::new(&scene);
            for set in SETS {
                let rays = set.rays(&reference, 84, 1);
                assert_eq!(rays.len(), 84);
                assert_eq!(
                    bytemuck::cast_slice::<Ray, u8>(&rays),
                    bytemuck::cast_slice::<Ray, u8>(&set.rays(&reference, 84, 1))
                );
                let can_hit = rays.iter().filter(|r| brute::Ray64::new(r).is_some()).count();
                match set.name {
                    NONSENSE => assert_eq!(can_hit, 0),
                    // A range that is crossed is empty; beyond the largest floats there is no origin.
                    "ranges" => {
                        let least = if case.name == "flt-max" { 28 } else { 60 };
                        assert!((least..=77).contains(&can_hit), "{}: {can_hit}", case.name)
                    }
                    // From a vertex to itself is no direction: a triangle that is a point gives none in many sets.
                    _ if case.name == "points" => {}
                    name if case.name == "flt-max" => {
                        assert!(can_hit >= 28, "{}, {name}: {can_hit}", case.name)
                    }
                    name => assert!(can_hit >= 80, "{}, {name}: {can_hit}", case.name),
                }
            }
        }
    }

    #[test]
    fn sets_hit_what_they_are_aimed_at() {
        for name in ["ball", "soup", "houses"] {
            let scene = CASES.iter().find(|c| c.name == name).map(|c| c.scene(Effort::Quick, 1));
            let scene = scene.unwrap_or_default();
            let reference = Reference::new(&scene);
            for set in SETS.iter().filter(|s| s.name != NONSENSE) {
                let rays = set.rays(&reference, 120, 1);
                let hits = rays.iter().filter(|r| reference.any(r)).count();
                let least = match set.name {
                    "vertices" | "edges" | "surfaces" | "inside" | "plus-zero" | "minus-zero" => 30,
                    // What is flat is not met edge-on.
                    _ => 1,
                };
                assert!(hits >= least, "{name}, {}: {hits} of 120 hit", set.name);
            }
        }
    }
}
