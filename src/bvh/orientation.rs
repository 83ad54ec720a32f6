//! Which ways a scene's triangles lie: the few bases that most of them share \[VEVERKOVA24, future work\].
//! Differs: frames of triangles, not their edges and normals one by one; peaks are sought exactly, so that a rotated city
//! gets its rotation and not one near by, and how far one reaches depends on how sharp it is.
//! Additions, products, quotients and roots of f64 only, in one order: the same bases on every machine.

use super::bases::{frame_words, hash};
use crate::scene::Scene;
use glam::{DMat3, DQuat, DVec3};
use std::fmt;

/// Corners of a triangle, scene units.
pub type Corners = [[f32; 3]; 3];

/// Triangles looked at, at most.
const SAMPLE: usize = 1 << 13;
/// Bases, at most.
pub const MOST: u32 = 16;
/// Frames this near to the axes of the scene are along them, radians.
const ALIGNED: f64 = 1e-3;
/// A basis serves frames at least this near, radians.
const LEAST_REACH: f64 = 0.01;
/// And at most this near: of triangles that lie all ways the nearest of 16 bases is then 16.4° away in the mean, of 0.35
/// and 0.55 17.0°.
const MOST_REACH: f64 = 0.45;
/// Where the search for a peak begins, radians: about a bin.
const FIRST_RADIUS: f64 = 0.1;
/// Bins an axis of the domain of box orientations, within √2 − 1 of 0. Odd, so that no rotation lies inside one.
const BINS: usize = 17;
/// Once less of the weight than this is left, no basis is worth its while.
const LEAST_SHARE: f64 = 1.0 / 64.0;

/// A basis that triangles share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Basis {
    /// The words of its frame.
    pub frame: [u32; 2],
    /// Share of the sample that it serves, by the length of triangles' longest edges.
    pub share: f64,
}

/// How a sample of triangles lies.
#[derive(Debug, Clone, PartialEq)]
pub struct Orientations {
    /// Triangles that have a frame, not being points or lines.
    pub triangles: usize,
    /// Share of them that lies along the axes of the scene, by the length of their longest edges; of none, all.
    pub aligned: f64,
    /// What most of them share, 1 to [`MOST`]: the axes of the scene first where they count, then by weight.
    pub bases: Vec<Basis>,
}

/// At most 2¹³ of `scene`'s triangles, one of each of as many runs of equal length.
pub fn sample(scene: &Scene) -> Vec<Corners> {
    let all = scene.triangles.len();
    let count = all.min(SAMPLE);
    // Anywhere in its run, lest the stride be that of a repeated part.
    let place = |i: usize| {
        let [begin, end] = [i, i + 1].map(|i| (i as u128 * all as u128 / count as u128) as usize);
        begin + hash(i as u32) as usize % (end - begin)
    };
    (0..count).map(|i| scene.corners(place(i))).collect()
}

/// A triangle's frame and what it counts.
#[derive(Debug, Clone, Copy)]
struct Lying {
    frame: DQuat,
    weight: f64,
}

impl Orientations {
    /// Of a sample.
    pub fn of(sample: &[Corners]) -> Self {
        let mut left: Vec<Lying> = sample.iter().filter_map(lying).collect();
        let (triangles, total) = (left.len(), weight(&left));
        let aligned = left.iter().filter(|l| 2.0 * turn(l.frame) < ALIGNED);
        let mut found = Self { triangles, aligned: 1.0, bases: vec![] };
        if total > 0.0 {
            found.aligned = weight(aligned) / total;
        }
        if found.aligned >= LEAST_SHARE {
            found.serve(&mut left, DQuat::IDENTITY, LEAST_REACH, total);
        }
        while found.bases.len() < MOST as usize && weight(&left) > LEAST_SHARE * total {
            let (centre, reach) = peak(&left);
            found.serve(&mut left, centre, reach, total);
        }
        found
    }

    /// Words of the frames of the first `most` bases.
    pub fn frames(&self, most: u32) -> Vec<[u32; 2]> {
        self.bases.iter().take(most as usize).map(|b| b.frame).collect()
    }

    /// A basis at `centre`, and what lies within `reach` of it is done with.
    fn serve(&mut self, left: &mut Vec<Lying>, centre: DQuat, reach: f64, total: f64) {
        let mut served = 0.0;
        left.retain(|l| {
            let here = is_near(centre, l.frame, reach);
            served += if here { l.weight } else { 0.0 };
            !here
        });
        let least = least(centre);
        let frame = if 2.0 * turn(least) < ALIGNED { [0; 2] } else { frame_words(least.xyz() / least.w) };
        let share = if total > 0.0 { served / total } else { 0.0 };
        self.bases.push(Basis { frame, share });
    }
}

impl fmt::Display for Orientations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let served: f64 = self.bases.iter().map(|b| b.share).sum();
        write!(
            f,
            "{} bases serve {:.1} % of {} triangles; {:.1} % lie along the scene's axes",
            self.bases.len(),
            100.0 * served,
            self.triangles,
            100.0 * self.aligned
        )
    }
}

fn weight<'a>(all: impl IntoIterator<Item = &'a Lying>) -> f64 {
    all.into_iter().fold(0.0, |sum, l| sum + l.weight)
}

/// The frame of the least rectangle around a triangle with a side along one of its edges; of equal ones, as around a right
/// angle, the one of least perimeter.
fn lying(corners: &Corners) -> Option<Lying> {
    let p = corners.map(|c| DVec3::from_array(c.map(f64::from)));
    let edges = [p[1] - p[0], p[2] - p[1], p[0] - p[2]];
    let normal = edges[0].cross(edges[1]);
    let lengths = edges.map(DVec3::length);
    let (weight, area) = (lengths.into_iter().fold(0.0, f64::max), normal.length());
    // Of a thinner one rounding decides where the normal points.
    if !(area.is_finite() && area > 1e-7 * weight * weight) {
        return None;
    }
    let perimeter = |i: usize| {
        let apex = -edges[(i + 2) % 3].dot(edges[i]) / lengths[i];
        lengths[i].max(apex) - apex.min(0.0) + area / lengths[i]
    };
    let side = (1..3).fold(0, |best, i| if perimeter(i) < perimeter(best) { i } else { best });
    let (x, z) = (edges[side] / lengths[side], normal / area);
    // A frame takes points to its axes: the inverse of what takes the axes there.
    let frame = DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z)).conjugate();
    Some(Lying { frame: least(frame), weight })
}

/// Of the 24 rotations to the same axes in another order or of other signs the least: its w is greatest.
fn least(q: DQuat) -> DQuat {
    // Within an eighth of a turn none of the others, a quarter turn and more apart, is.
    if q.w.abs() > 0.924 {
        return if q.w < 0.0 { -q } else { q };
    }
    let greatest = |v: &[f64]| (1..v.len()).fold(0, |a, b| if v[b].abs() > v[a].abs() { b } else { a });
    let unit = |k: usize| DVec3::from_array(std::array::from_fn(|i| f64::from(u8::from(i == k))));
    let first = greatest(&[q.w, q.x, q.y, q.z]);
    let q = match first {
        0 => q,
        k => DQuat::from_vec4((-unit(k - 1)).extend(0.0)) * q,
    };
    let q = if q.w < 0.0 { -q } else { q };
    let second = greatest(&q.xyz().to_array());
    let signs = q.xyz().signum();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let two = (q.w + q.xyz()[second].abs()) * half;
    let four = (q.w + q.xyz().abs().element_sum()) * 0.5;
    if q.w >= two && q.w >= four {
        q
    } else if two >= four {
        DQuat::from_vec4((unit(second) * signs * -half).extend(half)) * q
    } else {
        DQuat::from_vec4((signs * -0.5).extend(0.5)) * q
    }
}

/// The least rotation from one frame to the other.
fn between(from: DQuat, to: DQuat) -> DQuat {
    least(to * from.conjugate())
}

/// Whether the least rotation from one frame to the other is below `radius`, as sines go; quicker than to find it.
fn is_near(from: DQuat, to: DQuat, radius: f64) -> bool {
    let [a, b, c, d] = (to * from.conjugate()).to_array().map(f64::abs);
    let (first, second) = (a.max(b), c.max(d));
    let two = (first + second).max(a + b).max(c + d);
    let w = first.max(second).max(two * std::f64::consts::FRAC_1_SQRT_2).max((a + b + c + d) * 0.5);
    1.0 - w * w < 0.25 * radius * radius
}

/// Sine of half the angle.
fn turn(q: DQuat) -> f64 {
    q.xyz().length()
}

/// Where most of `left`, which holds something, lies, and how far a basis there reaches.
fn peak(left: &[Lying]) -> (DQuat, f64) {
    let mut bins = vec![0.0; BINS * BINS * BINS];
    for l in left {
        bins[bin(l.frame)] += l.weight;
    }
    let fullest = (1..bins.len()).fold(0, |a, b| if bins[b] > bins[a] { b } else { a });
    let within: Vec<Lying> = left.iter().copied().filter(|l| bin(l.frame) == fullest).collect();
    let mut centre = mean(within[0].frame, &within).0;
    let mut radius = FIRST_RADIUS;
    let near = |centre, radius, all: &[Lying]| -> Vec<Lying> {
        all.iter().copied().filter(|l| is_near(centre, l.frame, radius)).collect()
    };
    let mut around = near(centre, radius, left);
    while radius > 4e-6 {
        let (moved, weight) = mean(centre, &around);
        let nearer = near(moved, 0.25 * radius, &around);
        // A peak is what keeps half its weight in a quarter of the radius, a 64th of the room.
        let (sharper, kept) = mean(moved, &nearer);
        if kept < 0.5 * weight {
            break;
        }
        (centre, around, radius) = (sharper, nearer, 0.25 * radius);
    }
    (centre, (5.0 * radius).clamp(LEAST_REACH, MOST_REACH))
}

/// The mean of `all`, which are near `centre`, and their weight; `centre` where there is none.
fn mean(centre: DQuat, all: &[Lying]) -> (DQuat, f64) {
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for l in all {
        sum += l.weight * between(centre, l.frame).xyz();
        weight += l.weight;
    }
    if weight <= 0.0 {
        return (centre, 0.0);
    }
    let off = sum / weight;
    let w = (1.0 - off.length_squared()).max(0.0).sqrt();
    ((DQuat::from_vec4(off.extend(w)) * centre).normalize(), weight)
}

/// Which bin of the domain of box orientations a least rotation lies in.
fn bin(q: DQuat) -> usize {
    let r = q.xyz() / q.w;
    let place = |x: f64| {
        let reach = std::f64::consts::SQRT_2 - 1.0;
        ((x / reach * 0.5 + 0.5) * BINS as f64).clamp(0.0, BINS as f64 - 1.0) as usize
    };
    (place(r.z) * BINS + place(r.y)) * BINS + place(r.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::frame::Frame;

    fn rotation(i: u32) -> DQuat {
        let part = |k| f64::from(hash(4 * i + k)) / f64::from(u32::MAX) - 0.5;
        DQuat::from_xyzw(part(0), part(1), part(2), part(3)).normalize()
    }

    /// The 24 rotations that take axes to axes.
    fn group() -> Vec<DQuat> {
        let turns = [DVec3::X, DVec3::Y, DVec3::Z]
            .map(|axis| DQuat::from_axis_angle(axis, std::f64::consts::FRAC_PI_2));
        let mut all = vec![DQuat::IDENTITY];
        for i in 0.. {
            if i == all.len() {
                break;
            }
            for t in turns {
                let next = (t * all[i]).normalize();
                if all.iter().all(|q| q.dot(next).abs() < 0.999) {
                    all.push(next);
                }
            }
        }
        all
    }

    #[test]
    fn least_rotations_are_the_least_of_24() {
        let group = group();
        assert_eq!(group.len(), 24);
        for i in 0..2000 {
            let q = rotation(i);
            let found = least(q);
            let best = group.iter().map(|g| (*g * q).w.abs()).fold(0.0, f64::max);
            assert!((found.w - best).abs() < 1e-12 && (found.length() - 1.0).abs() < 1e-12, "{q}");
            let same = group.iter().map(|g| (*g * q).dot(found).abs()).fold(0.0, f64::max);
            assert!(same > 1.0 - 1e-12, "{q} became {found}, which has other axes");
        }
    }

    /// Both halves of a rectangle of the frame that `q` takes the axes to.
    fn rectangle(q: DQuat, a: f64, b: f64, at: f64) -> [Corners; 2] {
        let corner = |x: f64, y: f64| (q * DVec3::new(x * a, y * b, at)).as_vec3().to_array();
        let [p, r, s, t] = [corner(0., 0.), corner(1., 0.), corner(1., 1.), corner(0., 1.)];
        [[p, r, s], [p, s, t]]
    }

    #[test]
    fn rectangles_have_the_frame_of_their_sides() {
        for i in 0..500 {
            let q = rotation(i);
            for triangle in rectangle(q, 1.0, 0.3, 2.0) {
                let words = Orientations::of(&[triangle]).bases[0].frame;
                let frame = Frame::of(words);
                for axis in frame.rows {
                    let axis = axis.as_dvec3().normalize();
                    let off = [DVec3::X, DVec3::Y, DVec3::Z].map(|e| (q * e).cross(axis).length());
                    assert!(off.into_iter().fold(1.0, f64::min) < 2e-6, "{off:?}");
                }
            }
        }
    }

    #[test]
    fn peaks_are_told_from_what_is_spread() {
        let spread = |n: u32| (0..n).flat_map(|i| rectangle(rotation(i), 1.0, 0.7, 0.1));
        let wide = Orientations::of(&spread(3000).collect::<Vec<_>>());
        assert!(wide.bases.len() == MOST as usize && wide.aligned < 0.01, "{wide:?}");
        let covered: f64 = wide.bases.iter().map(|b| b.share).sum();
        assert!(covered > 0.5, "{covered}");
        // Three sharp ones among a third that is spread.
        let sharp = [5000, 5001, 5002].map(rotation);
        let mixed: Vec<Corners> = (0..3000)
            .flat_map(|i| rectangle(sharp[i % 3], 1.0, 0.5, i as f64 * 1e-3))
            .chain(spread(1500))
            .collect();
        let bases = Orientations::of(&mixed).bases;
        for q in sharp {
            let off = |b: &&Basis| {
                let r = Frame::of(b.frame).rodrigues.as_dvec3();
                let frame = DQuat::from_vec4(r.extend(1.0)).normalize();
                turn(between(q.conjugate(), frame))
            };
            let near = bases[..3].iter().map(|b| off(&b)).fold(1.0, f64::min);
            assert!(near < 1e-6, "{near} from a peak: {bases:?}");
        }
    }

    #[test]
    fn half_a_quarter_turn_is_one_basis() {
        // On the rim of the domain, where rounding puts frames on both sides.
        let turned = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_4);
        let all: Vec<Corners> =
            (0..100).flat_map(|i| rectangle(turned, 1.0 + f64::from(i), 3.0, 0.3 * f64::from(i))).collect();
        let found = Orientations::of(&all);
        assert_eq!(found.bases.len(), 1, "{found:?}");
        assert!(found.bases[0].share > 0.999_999 && found.aligned == 0.0);
    }

    #[test]
    fn points_and_lines_have_no_frame() {
        let flat = [
            [[1.0; 3]; 3],
            [[0.0; 3], [1.0; 3], [2.0; 3]],
            [[f32::NAN; 3]; 3],
            [[3e38, 0.0, 0.0], [0.0, -3e38, 0.0], [0.0; 3]],
        ];
        let found = Orientations::of(&flat);
        assert_eq!((found.triangles, found.aligned), (1, 1.0));
        let none = Orientations::of(&[]);
        assert_eq!((none.triangles, none.aligned), (0, 1.0));
        assert_eq!(none.frames(MOST), [[0; 2]]);
    }
}
