//! A scene on the device, and a packed tree over it.

use super::frame::{Frame, is_oriented};
use super::orientation::{Corners, sample};
use crate::abi::{Aabb, INVALID, LEAF_BIT, Node, TRIANGLE_WORDS};
use crate::device::{Buffer, Device, Result};
use crate::scene::Scene;
use sha2::{Digest, Sha256};
use std::sync::Arc;

/// A scene's triangles on the device.
#[derive(Debug)]
pub struct SceneBuffers {
    /// Corners, nine floats a triangle, input order.
    pub triangles: Buffer<f32>,
    /// Whether all corners are finite.
    pub finite: bool,
    /// Some of the triangles, on the host: how they lie.
    pub sample: Vec<Corners>,
}

impl SceneBuffers {
    /// Uploads the corners of `scene`'s triangles.
    ///
    /// # Errors
    /// Not enough device memory, or a failed copy.
    pub fn upload(device: &Arc<Device>, scene: &Scene) -> Result<Self> {
        let count = scene.triangles.len();
        device.require_memory(&format!("a scene of {count} triangles"), scene_bytes(count))?;
        let corners: Vec<f32> = (0..count).flat_map(|t| scene.corners(t)).flatten().collect();
        let triangles = Buffer::from_slice(device, "scene.triangles", &corners)?;
        let finite = corners.iter().all(|x| x.is_finite());
        Ok(Self { triangles, finite, sample: sample(scene) })
    }

    /// Triangles.
    pub fn count(&self) -> usize {
        self.triangles.len() / 9
    }
}

/// Device memory of a scene: nine floats a triangle.
pub(super) fn scene_bytes(triangles: usize) -> u64 {
    36 * triangles as u64
}

/// Bits of a leaf reference that hold a count of up to `max_leaf`.
pub fn leaf_bits(max_leaf: u32) -> u32 {
    u32::BITS - (max_leaf - 1).leading_zeros()
}

/// A packed tree. Its boxes are in unit space: scene coordinates · 2^`exponent` − `anchor`.
#[derive(Debug)]
pub struct Bvh {
    /// Nodes in the order of the tree read left to right; empty where no triangle can be hit.
    pub nodes: Buffer<Node>,
    /// Triangles, [`TRIANGLE_WORDS`] each: corners · 2^`exponent`, input index.
    pub triangles: Buffer<u32>,
    /// Root's place in `nodes`; [`crate::abi::INVALID`] where there is none.
    pub root: u32,
    /// Bits of a leaf reference that hold its count less one.
    pub leaf_bits: u32,
    /// Levels of nodes, at most.
    pub depth: u32,
    /// Exponent of the scale to unit space.
    pub exponent: i32,
    /// What is subtracted after scaling.
    pub anchor: [f32; 3],
    /// Largest absolute box coordinate.
    pub reach: f32,
    /// Box of all triangles, unit space.
    pub bounds: Aabb,
    /// Expected cost of a ray that meets the scene's box, [c_T Σ_inner A + c_I Σ_leaf A n] / A (Wald07).
    pub sah: f64,
    /// Triangles in the tree.
    pub triangle_count: u32,
    /// Triangles that no ray can hit, and the tree leaves out.
    pub left_out: u32,
    /// Packed nodes whose boxes are oriented.
    pub oriented: u32,
    /// `nodes` as they were before some became oriented, where both are kept.
    pub axis_aligned: Option<Buffer<Node>>,
}

/// A packed tree read back.
#[derive(Debug, Clone)]
pub struct HostTree {
    /// As [`Bvh::nodes`].
    pub nodes: Vec<Node>,
    /// As [`Bvh::triangles`].
    pub triangles: Vec<u32>,
    /// As [`Bvh::root`].
    pub root: u32,
    /// As [`Bvh::leaf_bits`].
    pub leaf_bits: u32,
}

impl Bvh {
    /// Bytes of device memory that tracing needs.
    pub fn bytes(&self) -> u64 {
        self.nodes.bytes() + self.triangles.bytes() + self.axis_aligned.as_ref().map_or(0, Buffer::bytes)
    }

    /// Reads the tree back.
    ///
    /// # Errors
    /// A failed copy.
    pub fn read(&self) -> Result<HostTree> {
        Ok(HostTree {
            nodes: self.nodes.read()?,
            triangles: self.triangles.read()?,
            root: self.root,
            leaf_bits: self.leaf_bits,
        })
    }
}

/// A child of a packed node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Child {
    /// Another node.
    Node(u32),
    /// A leaf.
    Leaf {
        /// First triangle.
        first: u32,
        /// Triangles.
        count: u32,
    },
}

/// What a child reference means, where leaves hold their size in so many bits.
pub(super) fn child_of(reference: u32, leaf_bits: u32) -> Child {
    if reference & LEAF_BIT == 0 {
        return Child::Node(reference);
    }
    let low = 31 - leaf_bits;
    let count = ((reference & !LEAF_BIT) >> low) + 1;
    Child::Leaf { first: reference & ((1 << low) - 1), count }
}

/// A child's box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    /// The node's rotation; none: the box is axis-aligned.
    pub frame: Option<Frame>,
    /// Its corners, least first: unit space, or the frame's.
    pub corners: [[f64; 3]; 2],
}

impl Volume {
    /// A point of unit space as its corners are.
    pub fn within(&self, p: [f64; 3]) -> [f64; 3] {
        self.frame.map_or(p, |f| f.within_exactly(p))
    }

    /// Half the surface area, unit space.
    pub fn half_area(&self) -> f64 {
        let e: [f64; 3] = std::array::from_fn(|k| self.corners[1][k] - self.corners[0][k]);
        let stretch = self.frame.map_or(1.0, |f| f64::from(f.stretch()));
        (e[0] * e[1] + e[1] * e[2] + e[2] * e[0]) / (stretch * stretch)
    }
}

impl HostTree {
    /// What a child reference means.
    pub fn child(&self, reference: u32) -> Child {
        child_of(reference, self.leaf_bits)
    }

    /// The children of `node` and their boxes.
    pub fn children(&self, node: &Node) -> Vec<(Child, Volume)> {
        let frame = is_oriented(node.frame).then(|| Frame::of(node.frame));
        let plane = |planes: [u32; 3], slot: usize, k: usize| {
            let step = 2f64.powi((node.exponents >> (8 * k) & 0xff) as i32 - 127);
            f64::from(node.origin[k]) + f64::from(planes[k] >> (8 * slot) & 0xff) * step
        };
        let corner = |planes, slot| std::array::from_fn(|k| plane(planes, slot, k));
        let there = (0..).zip(node.children).filter(|(_, child)| *child != INVALID);
        let volume = |slot| Volume { frame, corners: [corner(node.lo, slot), corner(node.hi, slot)] };
        there.map(|(slot, c)| (self.child(c), volume(slot))).collect()
    }

    /// Corners of a triangle of the tree, unit scale.
    pub fn corners(&self, triangle: usize) -> [[f32; 3]; 3] {
        let word = |k: usize| f32::from_bits(self.triangles[triangle * TRIANGLE_WORDS as usize + k]);
        std::array::from_fn(|c| std::array::from_fn(|k| word(3 * c + k)))
    }

    /// Input index of a triangle of the tree.
    pub fn input_index(&self, triangle: usize) -> u32 {
        self.triangles[triangle * TRIANGLE_WORDS as usize + 9]
    }

    /// SHA-256 of the tree's bytes, in hexadecimal.
    pub fn hash(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(bytemuck::cast_slice(&self.nodes));
        hash.update(bytemuck::cast_slice(&self.triangles));
        hash.update(self.root.to_le_bytes());
        hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
    }
}
