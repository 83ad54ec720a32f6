//! Twin of `glsl/lib/node.glsl`: nodes of a packed tree.

use super::ray::{PAD_ORIENTED, inverse_of};
use super::{MISSED, Nodes, Setup, V3};
use crate::abi::{INVALID, Node, ORIENTED_BIT, Tests};
use crate::bvh::HostTree;
use crate::bvh::frame::Frame;
use crate::bvh::raw::{greatest_of, least_of};
use glam::Vec3;

/// The ray in a node's frame: its t stays.
fn turn(s: &Setup, f: &Frame) -> Setup {
    let into = |p: V3| f.within(Vec3::from_array(p)).to_array();
    let (o, inverse) = (into(s.moved), inverse_of(into(s.unturned)));
    let pad = PAD_ORIENTED * f.stretch() * s.walk_reach;
    Setup {
        inverse,
        near: std::array::from_fn(|k| -o[k] * inverse[k] - pad * inverse[k].abs()),
        far: std::array::from_fn(|k| -o[k] * inverse[k] + pad * inverse[k].abs()),
        ..*s
    }
}

fn in_frame(n: &Node) -> bool {
    n.exponents & ORIENTED_BIT != 0
}

/// What sorts the children of a node: the bits of the t where the ray enters, the low two the child's number.
fn meet_children(s: &Setup, n: &Node, limit: f32) -> [i32; 4] {
    let turned;
    let s = if in_frame(n) {
        turned = turn(s, &Frame::of(n.frame));
        &turned
    } else {
        s
    };
    let exponent = |k: usize| n.exponents >> (8 * k) & 0xff;
    let stride: V3 = std::array::from_fn(|k| f32::from_bits(exponent(k) << 23) * s.inverse[k]);
    let near: V3 = std::array::from_fn(|k| n.origin[k] * s.inverse[k] + s.near[k]);
    let far: V3 = std::array::from_fn(|k| n.origin[k] * s.inverse[k] + s.far[k]);
    std::array::from_fn(|slot| {
        let plane = |k: usize, near: bool| {
            let planes = if (s.inverse[k] < 0.0) == near { n.hi[k] } else { n.lo[k] };
            (planes >> (8 * slot) & 0xff) as f32
        };
        let e: V3 = std::array::from_fn(|k| plane(k, true) * stride[k] + near[k]);
        let l: V3 = std::array::from_fn(|k| plane(k, false) * stride[k] + far[k]);
        let enter = greatest_of(greatest_of(e[0], e[1]), greatest_of(e[2], s.begin));
        let leave = least_of(least_of(l[0], l[1]), least_of(l[2], limit));
        let met = enter <= leave && n.children[slot] != INVALID;
        (if met { enter.to_bits() as i32 } else { MISSED }) & !3 | slot as i32
    })
}

impl Nodes for HostTree {
    fn root(&self) -> u32 {
        self.root
    }

    fn met(&self, s: &Setup, node: u32, limit: f32, tests: &mut Tests) -> Vec<(i32, u32)> {
        let n = &self.nodes[node as usize];
        let boxes = n.children.iter().filter(|child| **child != INVALID).count() as u32;
        *(if in_frame(n) { &mut tests.oriented } else { &mut tests.boxes }) += boxes;
        let mut keys = meet_children(s, n, limit);
        keys.sort_unstable();
        let met = keys.iter().rev().filter(|key| **key < MISSED);
        met.map(|key| (*key, n.children[(key & 3) as usize])).collect()
    }
}
