//! The catalogue of scenes: what breaks builders and tests of triangles.

use super::random::Random;
use super::shapes::{Corners, around_edge, around_vertex, ball, copies, houses, moved, nested, scene, soup};
use super::{Effort, Family};
use crate::bvh::{Morton, Recipe};
use crate::scene::Scene;
use glam::{DMat3, DVec3};
use std::f64::consts::FRAC_PI_4;

/// How much a ray of a scene may meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Load {
    /// Little, as in most scenes.
    Light,
    /// Hundreds of triangles that exact sums alone decide: no more rays than a quick run has.
    Doubtful,
    /// Hundreds of nodes: fewer rays.
    Deep,
    /// Every triangle there is: two rays of a set at most, of a million triangles one, and no walk but one.
    Full,
}

impl Load {
    /// Rays of a set at most.
    pub(super) fn most_rays(self, effort: Effort) -> usize {
        match self {
            Self::Light => usize::MAX,
            Self::Doubtful => Effort::Quick.rays(),
            Self::Deep => 24,
            Self::Full => effort.pick(2, 1),
        }
    }
}

/// A scene that is hard in one way.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// What it is hard for.
    pub family: Family,
    /// A word.
    pub name: &'static str,
    /// What is hard about it.
    pub why: &'static str,
    /// How much a ray may meet.
    pub load: Load,
    make: fn(&mut Random, Effort) -> Vec<Corners>,
}

/// The same, of another load.
const fn loaded(load: Load, case: Case) -> Case {
    Case { load, ..case }
}

const fn case(
    family: Family,
    name: &'static str,
    why: &'static str,
    make: fn(&mut Random, Effort) -> Vec<Corners>,
) -> Case {
    Case { family, name, why, load: Load::Light, make }
}

use Family::{Coordinates, Depth, Morton as Codes, Triangles};

/// All of them.
pub const CASES: &[Case] = &[
    case(Triangles, "none", "no triangle at all: every ray misses", |_, _| vec![]),
    case(Triangles, "one", "a tree without an inner node", |r, _| soup(r, 1, 1.0)),
    case(Triangles, "two", "the least tree with an inner node", |r, _| soup(r, 2, 1.0)),
    case(Triangles, "points", "corners alike, nothing else: no triangle can be hit", |r, _| {
        copies((0..300).map(|_| r.point()), 0.0)
    }),
    case(Triangles, "zero-area", "two or three corners alike among good ones", zero_area),
    loaded(
        Load::Doubtful,
        case(Triangles, "collinear", "corners distinct, on a line: in the tree, never hit", collinear),
    ),
    case(Triangles, "damaged", "NaN and infinite corners among good ones", damaged),
    case(Triangles, "needles", "1 wide, a million long, in strips", needles),
    case(Triangles, "slivers", "a closed ball pressed to a millionth", |_, e| {
        moved(&ball(e.pick(12, 24)), |p| p * DVec3::new(1.0, 1.0, 1e-6))
    }),
    loaded(Load::Full, case(Triangles, "alike", "one triangle, ten thousand or a million times", alike)),
    case(Triangles, "opposite", "each triangle twice, the second wound the other way", |r, e| {
        let one = soup(r, e.pick(300, 1500), 0.3);
        one.iter().flat_map(|&[a, b, c]| [[a, b, c], [a, c, b]]).collect()
    }),
    loaded(
        Load::Doubtful,
        case(Triangles, "fan-vertex", "a thousand triangles around a vertex", |_, _| around_vertex(1000)),
    ),
    loaded(
        Load::Doubtful,
        case(Triangles, "fan-edge", "a thousand triangles around an edge", |_, _| around_edge(1000)),
    ),
    case(Triangles, "huge-tiny", "a ball of 1e6 and one of 1e-6 in its middle", |_, e| {
        let one = ball(e.pick(10, 20));
        [1e6, 1e-6].iter().flat_map(|s| moved(&one, |p| p * *s)).collect()
    }),
    case(Triangles, "stack", "triangles over each other in one plane: ties of t", |r, e| {
        moved(&soup(r, e.pick(200, 400), 0.8), |p| DVec3::new(p.x, p.y, 0.25))
    }),
    case(Triangles, "stack-ulp", "planes an ulp apart", stack_ulp),
    case(Triangles, "ball", "a closed mesh as modelled: no leak", |_, e| ball(e.pick(16, 40))),
    case(Triangles, "soup", "triangles by chance: what most scenes are like", |r, e| {
        soup(r, e.pick(800, 5000), 0.2)
    }),
    case(Coordinates, "moved-1e3", "a ball of 1 at 1e3", |_, e| away(e, 1e3)),
    case(Coordinates, "moved-1e4", "a ball of 1 at 1e4", |_, e| away(e, 1e4)),
    case(Coordinates, "moved-1e5", "a ball of 1 at 1e5", |_, e| away(e, 1e5)),
    case(Coordinates, "moved-1e6", "a ball of 1 at 1e6: a few dozen floats across", |_, e| away(e, 1e6)),
    case(Coordinates, "moved-1e7", "a ball of 1 at 1e7: two or three floats across", |_, e| away(e, 1e7)),
    case(Coordinates, "scaled-1e-37", "next to the least normal floats", |r, e| scaled(r, e, 1e-37)),
    case(Coordinates, "scaled-1e-30", "products of three coordinates vanish", |r, e| scaled(r, e, 1e-30)),
    case(Coordinates, "scaled-1e-20", "products of two coordinates vanish", |r, e| scaled(r, e, 1e-20)),
    case(Coordinates, "scaled-1e-10", "far below any absolute epsilon", |r, e| scaled(r, e, 1e-10)),
    case(Coordinates, "scaled-1e10", "far above any absolute epsilon", |r, e| scaled(r, e, 1e10)),
    case(Coordinates, "scaled-1e20", "products of two coordinates overflow", |r, e| scaled(r, e, 1e20)),
    case(Coordinates, "scaled-1e30", "products of three coordinates overflow", |r, e| scaled(r, e, 1e30)),
    case(Coordinates, "flt-max", "to ±3.4e38: extents overflow", |r, e| scaled(r, e, 2.8e38)),
    case(Coordinates, "denormal", "denormal coordinates beside small normal ones", |r, e| {
        scaled(r, e, 4e-38)
    }),
    case(Coordinates, "denormal-only", "all coordinates denormal, and so 0", |r, e| scaled(r, e, 1e-39)),
    case(Coordinates, "zeros", "±0 in every corner", zeros),
    case(Coordinates, "flat-x", "in a plane across x", |r, e| flat(r, e, DVec3::new(0.0, 1.0, 1.0))),
    case(Coordinates, "flat-y", "in a plane across y, at −0", |r, e| {
        flat(r, e, DVec3::new(1.0, -0.0, 1.0))
    }),
    case(Coordinates, "flat-z", "in a plane across z", |r, e| flat(r, e, DVec3::new(1.0, 1.0, 0.0))),
    case(Coordinates, "flat-yz", "on the x axis: boxes without area", |r, e| flat(r, e, DVec3::X)),
    case(Coordinates, "flat-xy", "on the z axis: boxes without area", |r, e| flat(r, e, DVec3::Z)),
    case(Coordinates, "nearly-flat", "a millionth as high as wide", |r, e| {
        flat(r, e, DVec3::new(1.0, 1e-6, 1.0))
    }),
    case(Coordinates, "tilted-flat", "in a plane across no axis", |r, e| {
        moved(&flat(r, e, DVec3::new(1.0, 1.0, 0.0)), |p| turn(0.3) * p)
    }),
    case(Coordinates, "turned-1e-7", "houses an ulp off the axes", |r, e| turned(r, e, 1e-7)),
    case(Coordinates, "turned-1e-3", "houses hardly off the axes", |r, e| turned(r, e, 1e-3)),
    case(Coordinates, "turned-45", "houses at 45°", |r, e| turned(r, e, FRAC_PI_4)),
    case(Coordinates, "turned-45-less", "houses an ulp off 45°", |r, e| turned(r, e, FRAC_PI_4 - 1e-7)),
    case(Coordinates, "houses", "houses along the axes", |r, e| turned(r, e, 0.0)),
    loaded(Load::Doubtful, case(Codes, "equal-centres", "all boxes about one point", equal_centres)),
    case(Codes, "two-codes", "two places, and nothing between", |r, e| {
        let places = (0..e.pick(600, 6000)).map(|i| DVec3::splat(if i % 2 == 0 { -1.0 } else { 1.0 }));
        copies(places, 1e-9).into_iter().map(|c| c.map(|p| p + 1e-3 * r.share() * DVec3::Z)).collect()
    }),
    case(Codes, "sorted", "in order already", |_, e| line(e)),
    case(Codes, "reversed", "in the opposite order", |_, e| {
        let mut line = line(e);
        line.reverse();
        line
    }),
    case(Codes, "collisions-63", "places nearer than 63 bits can tell, in eight corners", collisions),
    case(Codes, "lattice", "places on a grid, several triangles each", |_, e| {
        let at = |i: usize| DVec3::new((i % 8) as f64, (i / 8 % 8) as f64, (i / 64 % 8) as f64) / 4.0 - 1.0;
        copies((0..e.pick(1024, 8192)).map(at), 0.1)
    }),
    case(Depth, "halves", "each half as far from a corner as the one before", |_, e| {
        chain(e.pick(120, 240), 0.5)
    }),
    loaded(
        Load::Doubtful,
        case(Depth, "nearly-alike", "each a hundredth nearer than the one before", |_, e| {
            chain(e.pick(1000, 5000), 0.99)
        }),
    ),
    case(Depth, "code-chain", "each triangle parts at one more bit of its code", code_chain),
    loaded(
        Load::Deep,
        case(Depth, "nested", "each around all before it: a chain as long as the scene", |_, e| {
            nested(e.pick(700, 2300), 1.001)
        }),
    ),
    loaded(
        Load::Deep,
        case(Depth, "too-deep", "a chain longer than any stack: refused, and said so", |_, _| {
            nested(4400, 1.001)
        }),
    ),
];

impl Case {
    /// Family and name.
    pub fn title(&self) -> String {
        format!("{}/{}", self.family.name(), self.name)
    }

    /// The scene: the same for the same seed.
    pub fn scene(&self, effort: Effort, seed: u64) -> Scene {
        let corners = (self.make)(&mut Random::new(seed, self.name), effort);
        Scene { name: self.name.to_owned(), ..scene(&corners) }
    }

    /// Codes to order its triangles by, and largest leaves, besides the default.
    pub(super) fn variants(&self, effort: Effort) -> Vec<(Morton, u32)> {
        let usual = Recipe::default().collapse.max_leaf;
        match (self.family, effort) {
            (Codes, _) => Morton::ALL.map(|morton| (morton, usual)).to_vec(),
            (Depth, Effort::Whole) => [usual, 1].map(|leaf| (Morton::Auto, leaf)).to_vec(),
            (_, Effort::Whole) if self.load != Load::Full => {
                vec![(Morton::Auto, usual), (Morton::Auto, 1), (Morton::Ext4, 64)]
            }
            _ => vec![(Morton::Auto, usual)],
        }
    }
}

fn zero_area(r: &mut Random, e: Effort) -> Vec<Corners> {
    let mut corners = soup(r, e.pick(600, 3000), 0.3);
    for (i, [a, b, c]) in corners.iter_mut().enumerate() {
        match i % 4 {
            0 => *b = *a,
            1 => *c = *b,
            2 => (*b, *c) = (*a, *a),
            _ => {}
        }
    }
    corners
}

fn collinear(r: &mut Random, e: Effort) -> Vec<Corners> {
    let good = soup(r, e.pick(200, 1000), 0.3);
    let bent = moved(&good, |p| p.x * DVec3::new(1.0, 2.0, -1.0));
    // Halves and quarters of what f32 has exactly stay on the line.
    let straight = good.iter().map(|&[a, b, _]| {
        let (a, b) = (a.as_vec3().as_dvec3(), b.as_vec3().as_dvec3());
        [a, (a + b) / 2.0, b]
    });
    bent.into_iter().chain(straight).chain(good.iter().copied().step_by(8)).collect()
}

fn damaged(r: &mut Random, e: Effort) -> Vec<Corners> {
    let mut corners = soup(r, e.pick(600, 3000), 0.3);
    for i in (0..corners.len()).step_by(3) {
        let wrong = r.of(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e39]);
        corners[i][r.below(3)][r.below(3)] = wrong;
    }
    corners
}

fn needles(r: &mut Random, e: Effort) -> Vec<Corners> {
    let mut corners = vec![];
    for _ in 0..e.pick(40, 200) {
        let (from, along) = (r.point(), r.direction());
        let across = along.any_orthonormal_vector() * 1e-6;
        // A strip of four that share their long edges.
        let at = |k: usize| from + across * (k / 2) as f64 + along * (k % 2) as f64;
        corners.extend((0..4).map(|k| [at(k), at(k + 1), at(k + 2)]));
    }
    corners
}

fn alike(r: &mut Random, e: Effort) -> Vec<Corners> {
    vec![soup(r, 1, 1.0)[0]; e.pick(10_000, 1_000_000)]
}

fn stack_ulp(r: &mut Random, e: Effort) -> Vec<Corners> {
    let ulp = f64::from(f32::EPSILON);
    let layer = |i: usize, c: &Corners| c.map(|p| DVec3::new(p.x, p.y, 1.0 + i as f64 * ulp));
    soup(r, e.pick(200, 400), 0.9).iter().enumerate().map(|(i, c)| layer(i, c)).collect()
}

fn away(e: Effort, by: f64) -> Vec<Corners> {
    moved(&ball(e.pick(12, 30)), |p| p + DVec3::new(by, -by, 0.7 * by))
}

/// A ball and a soup around it.
fn scaled(r: &mut Random, e: Effort, by: f64) -> Vec<Corners> {
    let mut corners = moved(&ball(e.pick(8, 20)), |p| 0.5 * p);
    corners.extend(soup(r, e.pick(200, 1000), 0.2));
    moved(&corners, |p| p * by)
}

fn zeros(r: &mut Random, e: Effort) -> Vec<Corners> {
    let mut zero = || r.of(&[0.0, -0.0]);
    let triangle = |i: usize| {
        let x = (i % 13) as f64 - 6.0;
        match i % 8 {
            // Spikes along z, of no area.
            0 => [1.0, 2.0, 3.0].map(|k| DVec3::new(zero(), zero(), k * 1e-12 * (i + 1) as f64)),
            _ => [
                DVec3::new(zero(), zero(), x),
                DVec3::new(x, zero(), x + 1.0),
                DVec3::new(zero(), x + 0.5, zero()),
            ],
        }
    };
    (0..e.pick(500, 2500)).map(triangle).collect()
}

fn flat(r: &mut Random, e: Effort, keep: DVec3) -> Vec<Corners> {
    moved(&soup(r, e.pick(500, 2500), 0.15), |p| p * keep)
}

fn turn(angle: f64) -> DMat3 {
    DMat3::from_rotation_z(angle) * DMat3::from_rotation_x(angle)
}

fn turned(r: &mut Random, e: Effort, angle: f64) -> Vec<Corners> {
    moved(&houses(r, e.pick(6, 16)), |p| turn(angle) * p)
}

fn equal_centres(r: &mut Random, e: Effort) -> Vec<Corners> {
    let around = |_| {
        // The box of p, −p and what lies within it is centred at 0.
        let p = r.direction() * r.share();
        [p, -p, DVec3::new(p.x, -p.y, p.z * r.unit())]
    };
    (0..e.pick(500, 3000)).map(around).collect()
}

/// Along the x axis, where order of place is order of code.
fn line(e: Effort) -> Vec<Corners> {
    let n = e.pick(1000, 10_000);
    copies((0..n).map(|i| DVec3::X * i as f64), 0.8)
}

fn collisions(r: &mut Random, e: Effort) -> Vec<Corners> {
    let corner = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64);
    let near = |i: usize| corner(i) + 1e-8 * r.point();
    copies((0..e.pick(800, 8000)).map(near).collect::<Vec<_>>(), 1e-6)
}

/// Each at `ratio` of the place of the one before, and of its size.
fn chain(n: usize, ratio: f64) -> Vec<Corners> {
    let link = |i: usize| {
        let s = ratio.powi(i as i32 % 120);
        [DVec3::splat(s), DVec3::splat(1.1 * s), DVec3::new(1.1 * s, s, 1.2 * s)]
    };
    (0..n).map(link).collect()
}

/// At 2⁻ᵏ along one axis after the other: a code's bits from the first to the last.
fn code_chain(_: &mut Random, e: Effort) -> Vec<Corners> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let place = |i: usize| axes[i % 3] * 0.5f64.powi((i / 3 % 21) as i32);
    let places = (0..e.pick(63, 1000)).map(place).chain([DVec3::ZERO, DVec3::ONE]);
    copies(places.collect::<Vec<_>>(), 1e-9)
}
