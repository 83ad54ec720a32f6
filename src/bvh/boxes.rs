//! The boxes of a packed tree's level, and where they stand in the scene: what one looks at to see where boxes are
//! tight \[VEVERKOVA24\]. Differs: found top-down, so that every triangle lies in one box of every level.

use super::{Bvh, Child, HostTree, Volume};
use crate::abi::{Aabb, INVALID};
use glam::{DMat3, DVec3};

/// Which boxes of a packed tree. Its nodes have up to four children, so that a level is about two of a binary tree's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Those so many steps below the root, and the leaves' above them; 0: the scene's box.
    Depth(u32),
    /// All leaves'.
    Leaves,
}

/// A box of a tree, and what it holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeBox {
    /// What is in it.
    pub child: Child,
    /// Steps from the root.
    pub depth: u32,
    /// As rays meet it; the root's, which none tests, is the scene's box.
    pub volume: Volume,
}

impl HostTree {
    /// The boxes of `level`, in the order of the tree's triangles; `bounds` are the scene's, unit space. None where no
    /// triangle can be hit.
    pub fn boxes(&self, level: Level, bounds: &Aabb) -> Vec<NodeBox> {
        let Some(root) = self.nodes.get(self.root as usize).filter(|_| self.root != INVALID) else {
            return vec![];
        };
        // A scene of one leaf has a node with one child, and no level between them.
        let child = match self.children(root)[..] {
            [(leaf @ Child::Leaf { .. }, _)] => leaf,
            _ => Child::Node(self.root),
        };
        let corners = [bounds.lo, bounds.hi].map(|p| p.map(f64::from));
        let mut waiting = vec![NodeBox { child, depth: 0, volume: Volume { frame: None, corners } }];
        let mut found = vec![];
        while let Some(next) = waiting.pop() {
            match next.child {
                Child::Node(node) if level != Level::Depth(next.depth) => {
                    let below = self.children(&self.nodes[node as usize]).into_iter().rev();
                    let depth = next.depth + 1;
                    waiting.extend(below.map(|(child, volume)| NodeBox { child, depth, volume }));
                }
                Child::Node(_) | Child::Leaf { .. } => found.push(next),
            }
        }
        found
    }
}

/// A box that stands in the scene in any direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedBox {
    /// The corner where all its coordinates along its axes are least, scene units.
    pub origin: DVec3,
    /// Its axes, unit vectors, right-handed. At right angles, but for the rounding of a frame (10⁻⁷).
    pub axes: [DVec3; 3],
    /// Lengths of the edges along them, scene units; 0 where the box is flat.
    pub size: DVec3,
}

/// Corners of the six faces, by [`PlacedBox::corners`], counter-clockwise from outside: least and greatest along each
/// axis in turn.
pub const FACES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

impl PlacedBox {
    /// Where `volume` stands that is in unit space: scene coordinates · 2^`exponent` − `anchor`.
    pub fn new(volume: &Volume, exponent: i32, anchor: [f32; 3]) -> Self {
        // The inverse and not the transpose: what rays meet is where this very matrix, rounded, puts its planes.
        let out = volume.frame.map_or(DMat3::IDENTITY, |frame| {
            DMat3::from_cols_array_2d(&frame.rows.map(|row| row.to_array().map(f64::from)))
                .transpose()
                .inverse()
        });
        let [least, greatest] = volume.corners.map(DVec3::from_array);
        let scale = 2f64.powi(-exponent);
        let edge = |k: usize| out.col(k).length() * (greatest[k] - least[k]) * scale;
        Self {
            origin: (out * least + DVec3::from_array(anchor.map(f64::from))) * scale,
            axes: [0, 1, 2].map(|k| out.col(k).normalize()),
            size: DVec3::new(edge(0), edge(1), edge(2)),
        }
    }

    /// Where `volume` of `bvh` stands.
    pub fn of(bvh: &Bvh, volume: &Volume) -> Self {
        Self::new(volume, bvh.exponent, bvh.anchor)
    }

    /// The eight corners, scene units; bit k of a corner's number says that it is the far one along axis k.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let step = |k: usize| self.axes[k] * self.size[k] * (i >> k & 1) as f64;
            self.origin + step(0) + step(1) + step(2)
        })
    }

    /// Corners of the surface as a mesh has them.
    pub fn vertices(&self) -> [[f32; 3]; 8] {
        // A box on its grid may reach beyond the largest float.
        let limit = f64::from(f32::MAX);
        self.corners().map(|p| p.to_array().map(|x| x.clamp(-limit, limit) as f32))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bvh::frame::{Frame, words};

    #[test]
    fn faces_look_outward_and_close() {
        let corners = PlacedBox {
            origin: DVec3::ZERO,
            axes: DMat3::IDENTITY.to_cols_array_2d().map(DVec3::from),
            size: DVec3::new(1.0, 2.0, 3.0),
        }
        .corners();
        let mut edges = vec![];
        for (i, face) in FACES.iter().enumerate() {
            let [a, b, c, d] = face.map(|v| corners[v as usize]);
            let normal = (c - a).cross(d - b);
            let outward = (a + c) / 2.0 - DVec3::new(0.5, 1.0, 1.5);
            assert!(normal.dot(outward) > 0.0 && (b - a + d - a + a).distance(c) < 1e-12, "face {i}");
            assert_eq!(normal.normalize()[i / 2], if i % 2 == 0 { -1.0 } else { 1.0 }, "face {i}");
            edges.extend((0..4).map(|k| (face[k], face[(k + 1) % 4])));
        }
        // Each edge once in either direction.
        assert!(edges.iter().all(|(a, b)| edges.iter().filter(|e| **e == (*b, *a)).count() == 1));
    }

    #[test]
    fn placing_undoes_unit_space() {
        let (exponent, anchor) = (-4, [0.25, -3.0, 0.5]);
        for frame in [None, Some(Frame::of(words([300_000, -700_000, 868_000])))] {
            let volume = Volume { frame, corners: [[-0.5, 0.125, -0.25], [0.25, 0.5, 0.75]] };
            let placed = PlacedBox::new(&volume, exponent, anchor);
            for (i, corner) in placed.corners().into_iter().enumerate() {
                let unit = corner / 16.0 - DVec3::from_array(anchor.map(f64::from));
                let at = volume.within(unit.to_array());
                for k in 0..3 {
                    assert!((at[k] - volume.corners[i >> k & 1][k]).abs() < 1e-12, "corner {i}: {at:?}");
                }
            }
            let [x, y, z] = placed.axes;
            assert!(
                x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs()) < 1e-6
                    && x.cross(y).dot(z) > 0.999_999
            );
            let [a, b, c] = placed.size.to_array();
            let area = (a * b + b * c + c * a) / 256.0;
            assert!((area / volume.half_area() - 1.0).abs() < 1e-6, "{area}");
        }
    }
}
