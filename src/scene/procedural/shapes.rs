//! Tubes, turned profiles, boxes, beams, cushions and balls, for a [`Pen`]: anticlockwise from outside.

use glam::DVec3;

use super::assembly::{Pen, Size};
use super::trig::{circle, sin_cos};

/// The vector nearest to `last` that lies across the unit vector `d`: a frame handed on so rolls as little as it can.
pub(super) fn transported(last: DVec3, d: DVec3) -> DVec3 {
    let flat = last - d * last.dot(d);
    if flat.length_squared() > 1e-12 { flat.normalize() } else { d.any_orthonormal_vector() }
}

/// The sides between rings of `sides` vertices that start at vertex `first`, ring after ring.
pub(super) fn tube_sides(first: u32, sides: usize) -> impl Iterator<Item = [u32; 4]> {
    (0..).map(move |q| {
        let (ring, side) = (first + (q / sides * sides) as u32, q % sides);
        let (a, b) = (ring + side as u32, ring + ((side + 1) % sides) as u32);
        [a, b, b + sides as u32, a + sides as u32]
    })
}

/// Size of a [`tube`] or [`lathe`].
pub(super) const fn tube_size(points: usize, sides: usize) -> Size {
    Size { vertices: points * sides, triangles: 2 * (points - 1) * sides }
}

/// A tube about a path, open at its ends, `radius(k)` at point k. Neighbouring points must differ.
pub(super) fn tube(pen: &mut Pen, path: &[DVec3], sides: usize, radius: impl Fn(usize) -> f64) {
    let circle = circle(sides);
    let mut first = None;
    let mut x = DVec3::ZERO;
    for (k, &p) in path.iter().enumerate() {
        let step = |a: usize, b: usize| (path[b] - path[a]).normalize();
        let d = match k {
            0 => step(0, 1),
            k if k + 1 == path.len() => step(k - 1, k),
            k => (step(k - 1, k) + step(k, k + 1)).try_normalize().unwrap_or(step(k - 1, k)),
        };
        x = transported(x, d);
        let (y, r) = (d.cross(x), radius(k));
        for &(cos, sin) in &circle {
            let v = pen.vertex(p + (x * cos + y * sin) * r);
            first.get_or_insert(v);
        }
    }
    for side in tube_sides(first.unwrap_or(0), sides).take((path.len() - 1) * sides) {
        pen.quad(side);
    }
}

/// Size of a [`rod`].
pub(super) const fn rod_size(sides: usize) -> Size {
    tube_size(2, sides)
}

/// A straight tube, one quad a side.
pub(super) fn rod(pen: &mut Pen, ends: [DVec3; 2], radius: f64, sides: usize) {
    tube(pen, &ends, sides, |_| radius);
}

/// A profile of (radius, height) turned about the y axis, open at its ends. The outside is on the right of its way up.
pub(super) fn lathe(pen: &mut Pen, profile: &[(f64, f64)], sides: usize) {
    let circle = circle(sides);
    let mut first = None;
    for &(r, y) in profile {
        for &(cos, sin) in &circle {
            let v = pen.vertex(DVec3::new(r * cos, y, -r * sin));
            first.get_or_insert(v);
        }
    }
    for side in tube_sides(first.unwrap_or(0), sides).take((profile.len() - 1) * sides) {
        pen.quad(side);
    }
}

/// Size of a [`cylinder`].
pub(super) const fn cylinder_size(sides: usize) -> Size {
    Size { vertices: 2 * sides, triangles: 2 * sides + 2 * (sides - 2) }
}

/// An upright cylinder with a fan at each end, from height `low` to `high`.
pub(super) fn cylinder(pen: &mut Pen, radius: f64, [low, high]: [f64; 2], sides: usize) {
    let mut rings = [low, high].map(|y| {
        circle(sides)
            .into_iter()
            .map(|(cos, sin)| pen.vertex(DVec3::new(radius * cos, y, -radius * sin)))
            .collect::<Vec<_>>()
    });
    for side in tube_sides(rings[0][0], sides).take(sides) {
        pen.quad(side);
    }
    rings[0].reverse();
    for ring in rings {
        for pair in ring[1..].windows(2) {
            pen.triangle([ring[0], pair[0], pair[1]]);
        }
    }
}

/// Size of a [`cuboid`].
pub(super) const CUBOID: Size = Size { vertices: 8, triangles: 12 };

/// A box between two corners.
pub(super) fn cuboid(pen: &mut Pen, low: DVec3, high: DVec3) {
    // Corner c takes axis k from `high` where bit k of c is set.
    let v: [u32; 8] = std::array::from_fn(|c| {
        let bit = |k: usize| c >> k & 1 == 1;
        pen.vertex(DVec3::select(glam::BVec3::new(bit(0), bit(1), bit(2)), high, low))
    });
    for k in 0..3 {
        let (i, j, k) = (1 << ((k + 1) % 3), 1 << ((k + 2) % 3), 1 << k);
        pen.quad([v[0], v[j], v[i + j], v[i]]);
        pen.quad([v[k], v[k + i], v[k + i + j], v[k + j]]);
    }
}

/// Size of an [`i_beam`].
pub(super) const I_BEAM: Size = Size { vertices: 24, triangles: 44 };

/// The section's ends, cut into triangles at its corners.
const I_BEAM_END: [[usize; 3]; 10] = [
    [0, 1, 2],
    [0, 2, 3],
    [0, 3, 10],
    [0, 10, 11],
    [3, 4, 9],
    [3, 9, 10],
    [6, 7, 8],
    [6, 8, 9],
    [6, 9, 4],
    [6, 4, 5],
];

/// A rolled beam of I section, `width` by `height`, with closed ends. Its web stands as upright as it can.
pub(super) fn i_beam(pen: &mut Pen, ends: [DVec3; 2], width: f64, height: f64) {
    let d = (ends[1] - ends[0]).normalize();
    let up = if d.y.abs() > 0.999 { DVec3::X } else { transported(DVec3::Y, d) };
    let (side, w, h) = (up.cross(d), width / 2.0, height / 2.0);
    let (web, flange) = (0.12 * w, 0.84 * h);
    let corners = [
        (-w, -h),
        (w, -h),
        (w, -flange),
        (web, -flange),
        (web, flange),
        (w, flange),
        (w, h),
        (-w, h),
        (-w, flange),
        (-web, flange),
        (-web, -flange),
        (-w, -flange),
    ];
    let [near, far] = ends.map(|p| corners.map(|(x, y)| pen.vertex(p + side * x + up * y)));
    for k in 0..12 {
        let next = (k + 1) % 12;
        pen.quad([near[k], near[next], far[next], far[k]]);
    }
    for [a, b, c] in I_BEAM_END {
        pen.triangle([near[a], near[c], near[b]]);
        pen.triangle([far[a], far[b], far[c]]);
    }
}

/// Size of a [`cushion`].
pub(super) const fn cushion_size(sides: usize, bands: usize) -> Size {
    Size { vertices: sides * (bands - 1) + 2, triangles: 2 * sides * (bands - 1) }
}

/// A superellipsoid of exponent 4: a box with round edges, `half` as large. Fans of `sides` at top and bottom.
pub(super) fn cushion(pen: &mut Pen, half: DVec3, sides: usize, bands: usize) {
    let root = |x: f64| if x < 0.0 { -(-x).sqrt() } else { x.sqrt() };
    let bottom = pen.vertex(-DVec3::Y * half);
    let mut rings = vec![];
    for band in 1..bands {
        let (sin, cos) = sin_cos(0.5 * band as f64 / bands as f64 - 0.25);
        for (c, s) in circle(sides) {
            rings.push(pen.vertex(half * DVec3::new(root(cos) * root(c), root(sin), -root(cos) * root(s))));
        }
    }
    let top = pen.vertex(DVec3::Y * half);
    for side in tube_sides(rings[0], sides).take((bands - 2) * sides) {
        pen.quad(side);
    }
    let last = rings.len() - sides;
    for i in 0..sides {
        let next = (i + 1) % sides;
        pen.triangle([bottom, rings[next], rings[i]]);
        pen.triangle([rings[last + i], rings[last + next], top]);
    }
}

/// Size of a [`facet`].
pub(super) const fn facet_size(n: usize) -> Size {
    Size { vertices: (n + 1) * (n + 2) / 2, triangles: n * n }
}

/// A triangle cut into n² equal ones, each vertex moved by `shape`. Facets that share an edge share its points' bits:
/// a point there is a sum of two terms, whichever comes first.
pub(super) fn facet(pen: &mut Pen, corners: [DVec3; 3], n: usize, shape: impl Fn(DVec3) -> DVec3) {
    let mut above: Vec<u32> = vec![];
    for row in 0..=n {
        let line: Vec<u32> = (0..=row)
            .map(|i| {
                let weights = [n - row, row - i, i].map(|w| w as f64);
                let sum = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
                pen.vertex(shape(sum / n as f64))
            })
            .collect();
        for (i, &a) in above.iter().enumerate() {
            pen.triangle([a, line[i], line[i + 1]]);
            if let Some(&b) = above.get(i + 1) {
                pen.triangle([a, line[i + 1], b]);
            }
        }
        above = line;
    }
}

/// Golden ratio.
const GOLDEN: f64 = 1.618_033_988_749_895;

/// Size of an [`icosphere`].
pub(super) const fn icosphere_size(n: usize) -> Size {
    let face = facet_size(n);
    Size { vertices: 20 * face.vertices, triangles: 20 * face.triangles }
}

/// A ball of radius 1: an icosahedron's faces, their edges cut in `n`.
pub(super) fn icosphere(pen: &mut Pen, n: usize) {
    // Corners (0, ±1, ±golden ratio) and their turns; edges are 2 long.
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let corner = |k: usize, (a, b): (f64, f64)| {
        let mut p = [0.0; 3];
        (p[(k + 1) % 3], p[(k + 2) % 3]) = (a, b * GOLDEN);
        DVec3::from_array(p)
    };
    let corners: Vec<DVec3> = (0..3).flat_map(|k| signs.map(|s| corner(k, s))).collect();
    let near = |a: DVec3, b: DVec3| a.distance_squared(b) < 4.5;
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1).filter(|(_, b)| near(a, **b)) {
            for &c in corners[j + 1..].iter().filter(|c| near(a, **c) && near(b, **c)) {
                let outwards = if a.dot(b.cross(c)) > 0.0 { [a, b, c] } else { [a, c, b] };
                facet(pen, outwards, n, DVec3::normalize);
            }
        }
    }
}
