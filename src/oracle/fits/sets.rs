//! Random point sets of fifteen kinds, such as nodes of trees hold. From + − × ÷ and square roots alone: the same on every
//! machine.

use glam::{DMat3, DVec3, Vec3};

/// A kind of point sets.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// Name.
    pub name: &'static str,
    /// What its sets are.
    pub what: &'static str,
    make: fn(&mut Random) -> Vec<DVec3>,
}

impl Kind {
    /// Points of the i-th set.
    pub fn points(&self, i: u32) -> Vec<Vec3> {
        (self.make)(&mut Random::new(u64::from(i) + 1)).into_iter().map(|p| p.as_vec3()).collect()
    }
}

macro_rules! kinds {
    ($( $name:literal, $what:literal, $make:expr; )*) => {
        /// All kinds.
        pub const KINDS: &[Kind] = &[ $( Kind { name: $name, what: $what, make: $make }, )* ];
    };
}

kinds! {
    "cube", "50 points in an upright cube", |r| r.many(50, Random::in_cube);
    "gauss", "50 points, normal of deviations 1, 0.3 and 0.05 along turned axes", |r| {
        let points = r.many(50, |r| r.normal() * DVec3::new(1.0, 0.3, 0.05));
        r.turned(points)
    };
    "sphere", "100 points on a sphere", |r| r.many(100, Random::direction);
    "triangle", "three points in a cube", |r| r.many(3, Random::in_cube);
    "thin triangle", "a turned triangle of base 1 and height 0.01", |r| {
        let top = DVec3::new(r.uniform(), 0.01, 0.0);
        r.turned(vec![DVec3::ZERO, DVec3::X, top])
    };
    "bent strip", "turned: four triangles, six vertices, in a strip that bends and twists a little", bent_strip;
    "box xyz 45°", "a box of random edges, turned by 45° about x, y and z", |r| {
        let turn = about(DVec3::Z) * about(DVec3::Y) * about(DVec3::X);
        r.solid(turn)
    };
    "box, random", "a box of random edges, turned", |r| {
        let turn = r.rotation();
        r.solid(turn)
    };
    "strand", "turned: a hair of eight triangular rings, 24 vertices, along a bent curve", strand;
    "curved sheet", "turned: a patch of 7 × 7 vertices, bent along both edges and twisted a little", curved_sheet;
    "cylinder", "turned: two rings of sixteen vertices, of random height", cylinder;
    "box, upright", "a box of random edges along the axes", |r| r.solid(DMat3::IDENTITY);
    "flat quad", "a turned rectangle of random edges", |r| {
        let size = r.edges();
        let corners = (0..4).map(|i| size * DVec3::new(f64::from(i & 1), f64::from(i >> 1), 0.0)).collect();
        r.turned(corners)
    };
    "box z 45°", "a box of random edges, turned by 45° about z", |r| r.solid(about(DVec3::Z));
    "beam", "a turned box of edges 1, 0.1 and 0.1", |r| {
        let corners = corners(DVec3::new(1.0, 0.1, 0.1));
        r.turned(corners)
    };
}

/// Corners of a box of these edges.
fn corners(size: DVec3) -> Vec<DVec3> {
    let of = |i: u32| size * DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    (0..8).map(of).collect()
}

/// The turn by 45° about an axis.
fn about(axis: DVec3) -> DMat3 {
    super::optimum::rotation(axis * (std::f64::consts::SQRT_2 - 1.0))
}

fn bent_strip(r: &mut Random) -> Vec<DVec3> {
    let width = 0.1 + 0.5 * r.uniform();
    let (mut at, mut along, mut across) = (DVec3::ZERO, DVec3::X, DVec3::Y * width);
    let mut points = vec![];
    for _ in 0..3 {
        points.extend([at, at + across]);
        at += along;
        along = (along + r.in_cube() * 0.5).normalize();
        across = (across + r.in_cube() * (0.28 * width)).normalize() * width;
    }
    r.turned(points)
}

fn strand(r: &mut Random) -> Vec<DVec3> {
    let (mut at, mut along) = (DVec3::ZERO, DVec3::X);
    let mut bend = r.in_cube() * 0.4;
    let mut points = vec![];
    for _ in 0..8 {
        let side = along.cross(DVec3::Z).normalize() * 0.012;
        let other = along.cross(side);
        // Corners of a regular triangle.
        let high = 0.75f64.sqrt();
        points.extend([at + side, at - side * 0.5 + other * high, at - side * 0.5 - other * high]);
        at += along * (1.0 / 7.0);
        along = (along + bend).normalize();
        bend += r.in_cube() * 0.01;
    }
    r.turned(points)
}

fn curved_sheet(r: &mut Random) -> Vec<DVec3> {
    let size = r.edges();
    let bends = r.in_cube() * DVec3::new(0.4, 0.4, 0.025);
    let point = |i: u32| {
        let [x, y] = [i % 7, i / 7].map(|k| f64::from(k) / 6.0 - 0.5);
        DVec3::new(x * size.x, y * size.y, bends.x * x * x + bends.y * y * y + bends.z * x * y)
    };
    r.turned((0..49).map(point).collect())
}

fn cylinder(r: &mut Random) -> Vec<DVec3> {
    let height = 0.5 + 4.0 * r.uniform();
    let point = |i: u32| {
        let (x, y) = on_circle(i / 2);
        DVec3::new(x, y, height * f64::from(i % 2))
    };
    r.turned((0..32).map(point).collect())
}

/// The i-th of sixteen points around a circle.
fn on_circle(i: u32) -> (f64, f64) {
    let (c, s) = ((0.5 + 0.5 * 0.5f64.sqrt()).sqrt(), (0.5 - 0.5 * 0.5f64.sqrt()).sqrt());
    (0..i).fold((1.0, 0.0), |(x, y), _| (c * x - s * y, s * x + c * y))
}

/// SplitMix64.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed << 32)
    }

    /// From 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn many(&mut self, count: usize, make: impl Fn(&mut Self) -> DVec3) -> Vec<DVec3> {
        (0..count).map(|_| make(self)).collect()
    }

    /// Of edge 2, about 0.
    fn in_cube(&mut self) -> DVec3 {
        let [x, y, z] = [(); 3].map(|()| 2.0 * self.uniform() - 1.0);
        DVec3::new(x, y, z)
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let p = self.in_cube();
            if (1e-4..=1.0).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }

    /// Normal to a good likeness: of each component the sum of twelve uniform numbers.
    fn normal(&mut self) -> DVec3 {
        let [x, y, z] = [(); 3].map(|()| (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0);
        DVec3::new(x, y, z)
    }

    /// Any rotation, each as likely, from a point of the ball in four dimensions.
    pub(super) fn rotation(&mut self) -> DMat3 {
        loop {
            let [x, y, z, w] = [(); 4].map(|()| 2.0 * self.uniform() - 1.0);
            let square = x * x + y * y + z * z + w * w;
            if (1e-4..=1.0).contains(&square) && w.abs() > 1e-6 {
                return super::optimum::rotation(DVec3::new(x, y, z) / w);
            }
        }
    }

    /// Turned at random.
    fn turned(&mut self, points: Vec<DVec3>) -> Vec<DVec3> {
        let turn = self.rotation();
        points.into_iter().map(|p| turn * p).collect()
    }

    /// Edges of a box.
    fn edges(&mut self) -> DVec3 {
        let [x, y, z] = [(); 3].map(|()| 0.1 + 0.9 * self.uniform());
        DVec3::new(x, y, z)
    }

    /// Corners of a box of random edges, turned so.
    fn solid(&mut self, turn: DMat3) -> Vec<DVec3> {
        corners(self.edges()).into_iter().map(|p| turn * p).collect()
    }
}
