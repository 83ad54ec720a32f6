//! Twin of `glsl/lib/binary.glsl`: nodes of a binary tree.

use super::ray::inverse_of;
use super::{MISSED, Nodes, Setup, Space, Tests, V3};
use crate::abi::Obb;
use crate::bvh::raw::{greatest_of, least_of};
use crate::trace::layouts::{HostBinary, PADDED_REACHES, Volume};

/// A binary tree, and how far away rays may start for its oriented boxes to be as they are.
#[derive(Debug, Clone, Copy)]
pub struct BinaryNodes<'a> {
    tree: &'a HostBinary,
    half_over_reach: f32,
}

/// What sorts a child: the bits of the t where the ray enters.
fn key_of(e: V3, l: V3, s: &Setup, limit: f32) -> i32 {
    let enter = greatest_of(greatest_of(e[0], e[1]), greatest_of(e[2], s.begin));
    let leave = least_of(least_of(l[0], l[1]), least_of(l[2], limit));
    if enter <= leave { enter.to_bits() as i32 } else { MISSED }
}

fn meet_aabb(s: &Setup, [lo, hi]: [V3; 2], limit: f32) -> i32 {
    let plane = |k: usize, near: bool| if (s.inverse[k] < 0.0) == near { hi[k] } else { lo[k] };
    let enter3 = std::array::from_fn(|k| plane(k, true) * s.inverse[k] + s.near[k]);
    key_of(enter3, std::array::from_fn(|k| plane(k, false) * s.inverse[k] + s.far[k]), s, limit)
}

impl<'a> BinaryNodes<'a> {
    /// Of `tree`, in unit space `space`.
    pub fn new(tree: &'a HostBinary, space: &Space) -> Self {
        Self { tree, half_over_reach: 0.5 / (PADDED_REACHES * space.reach) }
    }

    fn meet_obb(&self, s: &Setup, b: &Obb, limit: f32) -> i32 {
        let rows = [b.x, b.y, b.z];
        let turned = |p: V3| rows.map(|r| r[0] * p[0] + (r[1] * p[1] + r[2] * p[2]));
        let (turned_origin, inverse) = (turned(s.moved), inverse_of(turned(s.unturned)));
        let half = greatest_of(0.5, s.walk_reach * self.half_over_reach);
        let centre: V3 = std::array::from_fn(|k| -(turned_origin[k] + rows[k][3]) * inverse[k]);
        let reach = inverse.map(|x| half * x.abs());
        let enter3 = std::array::from_fn(|k| centre[k] - reach[k]);
        key_of(enter3, std::array::from_fn(|k| centre[k] + reach[k]), s, limit)
    }
}

impl Nodes for BinaryNodes<'_> {
    fn root(&self) -> u32 {
        self.tree.root
    }

    fn met(&self, s: &Setup, node: u32, limit: f32, tests: &mut Tests) -> Vec<(i32, u32)> {
        let children = self.tree.children(node);
        let mut keys = children.map(|(child, volume)| match volume {
            Volume::Aabb(corners) => {
                tests.boxes += 1;
                (meet_aabb(s, corners, limit), child)
            }
            Volume::Obb(b) => {
                tests.oriented += 1;
                (self.meet_obb(s, &b, limit), child)
            }
        });
        if keys[1].0 < keys[0].0 {
            keys.swap(0, 1);
        }
        keys.into_iter().rev().filter(|(key, _)| *key < MISSED).collect()
    }
}
