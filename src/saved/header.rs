//! The first bytes of a file: what the tree is, in numbers, and how large each section is.

use super::error::Fault;
use crate::abi::{Aabb, INVALID, Node, TRIANGLE_WORDS};
use crate::bvh::Bvh;

/// What a file of a tree begins with: a byte beyond ASCII, and line ends that copying as text would change.
pub(super) const MAGIC: [u8; 12] = *b"\x89boxwood\r\n\x1a\n";
/// Version of the format: counts up with every change.
pub const VERSION: u32 = 1;
/// Reads otherwise where bytes were swapped.
const ORDER: u32 = 0x0102_0304;
/// Bytes of the header.
pub(super) const HEADER: usize = 136;
/// Bytes that each section begins with: its name and its length.
pub(super) const HEAD: usize = 16;
/// Bytes of the checksum.
pub(super) const CHECKSUM: usize = 32;
/// Longest text, bytes.
pub(super) const MOST_TEXT: u64 = 1 << 20;
/// Bytes of a node.
const NODE: u64 = size_of::<Node>() as u64;
/// Bytes of a triangle.
const TRIANGLE: u64 = TRIANGLE_WORDS as u64 * 4;

/// A tree in numbers; but for the counts as [`Bvh`] has them.
#[derive(Debug, Clone, Copy)]
pub struct Header {
    /// Nodes.
    pub nodes: u64,
    /// Nodes as they were before some became oriented: as many, or 0 where these are not kept.
    pub axis_aligned: u64,
    /// Triangles.
    pub triangles: u64,
    /// Bytes of the text.
    pub text: u64,
    /// Root.
    pub root: u32,
    /// Bits of a leaf's size.
    pub leaf_bits: u32,
    /// Levels at most.
    pub depth: u32,
    /// Exponent of the scale to unit space.
    pub exponent: i32,
    /// What is subtracted after scaling.
    pub anchor: [f32; 3],
    /// Largest absolute box coordinate.
    pub reach: f32,
    /// Box of all triangles.
    pub bounds: Aabb,
    /// SAH cost.
    pub sah: f64,
    /// Triangles that the tree leaves out.
    pub left_out: u32,
    /// Oriented nodes.
    pub oriented: u32,
}

/// Numbers of a fixed place.
struct Fields<'b>(&'b [u8]);

impl Fields<'_> {
    /// The next `N` bytes; zeros where there are none, which no header lacks.
    fn next<const N: usize>(&mut self) -> [u8; N] {
        let mut out = [0; N];
        if let Some((bytes, rest)) = self.0.split_first_chunk::<N>() {
            (out, self.0) = (*bytes, rest);
        }
        out
    }
    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.next())
    }
    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.next())
    }
    fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.next())
    }
}

impl Header {
    /// Of `bvh`, with a text of so many bytes.
    pub(super) fn of(bvh: &Bvh, text: u64) -> Self {
        let Bvh { root, leaf_bits, depth, exponent, anchor, reach, bounds, sah, left_out, oriented, .. } =
            *bvh;
        Self {
            nodes: bvh.nodes.len() as u64,
            axis_aligned: bvh.axis_aligned.as_ref().map_or(0, |nodes| nodes.len() as u64),
            triangles: bvh.triangle_count.into(),
            text,
            root,
            leaf_bits,
            depth,
            exponent,
            anchor,
            reach,
            bounds,
            sah,
            left_out,
            oriented,
        }
    }

    /// Triangles of the scene.
    pub fn scene_triangles(&self) -> u64 {
        self.triangles.saturating_add(self.left_out.into())
    }

    /// Bytes of each section behind its head. Of a file of the right length none overflows.
    pub(super) fn lengths(&self) -> [u64; 5] {
        let nodes = |count: u64| count.saturating_mul(NODE);
        let triangles = self.triangles.saturating_mul(TRIANGLE);
        [self.text, nodes(self.nodes), nodes(self.axis_aligned), triangles, CHECKSUM as u64]
    }

    /// Bytes of the whole file: at most, where they would not fit 64 bits, which no file has.
    fn file_bytes(&self) -> u64 {
        let heads = (HEADER + 5 * HEAD) as u64;
        self.lengths().into_iter().fold(heads, u64::saturating_add)
    }

    /// Bytes of device memory that the tree takes.
    pub(super) fn device_bytes(&self) -> u64 {
        let [_, nodes, kept, triangles, _] = self.lengths();
        nodes.saturating_add(kept).saturating_add(triangles)
    }

    pub(super) fn to_bytes(self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        for word in [VERSION, ORDER, HEADER as u32, NODE as u32, TRIANGLE_WORDS] {
            out.extend(word.to_le_bytes());
        }
        for count in [self.nodes, self.axis_aligned, self.triangles, self.text] {
            out.extend(count.to_le_bytes());
        }
        for word in [self.root, self.leaf_bits, self.depth, self.exponent as u32] {
            out.extend(word.to_le_bytes());
        }
        for x in self.anchor.into_iter().chain([self.reach]).chain(self.bounds.lo).chain(self.bounds.hi) {
            out.extend(x.to_le_bytes());
        }
        out.extend(self.sah.to_le_bytes());
        for word in [self.left_out, self.oriented] {
            out.extend(word.to_le_bytes());
        }
        out
    }

    /// Of the first bytes of a file of `length` bytes.
    pub(super) fn parse(bytes: &[u8; HEADER], length: u64) -> Result<Self, Fault> {
        let mut fields = Fields(&bytes[MAGIC.len()..]);
        version(&mut fields)?;
        let f = &mut fields;
        let header = Self {
            nodes: f.u64(),
            axis_aligned: f.u64(),
            triangles: f.u64(),
            text: f.u64(),
            root: f.u32(),
            leaf_bits: f.u32(),
            depth: f.u32(),
            exponent: f.u32() as i32,
            anchor: [f.f32(), f.f32(), f.f32()],
            reach: f.f32(),
            bounds: Aabb { lo: [f.f32(), f.f32(), f.f32()], hi: [f.f32(), f.f32(), f.f32()] },
            sah: f64::from_le_bytes(f.next()),
            left_out: f.u32(),
            oriented: f.u32(),
        };
        let (has, wanted) = (length, header.file_bytes());
        match has.cmp(&wanted) {
            std::cmp::Ordering::Equal => Ok(header),
            std::cmp::Ordering::Less => Err(Fault::Size { what: "cut short", has, wanted }),
            std::cmp::Ordering::Greater => Err(Fault::Size { what: "too long", has, wanted }),
        }
    }

    /// Refuses numbers that no tree has, and that tracing should not be given.
    pub(super) fn check(&self) -> Result<(), Fault> {
        let refuse = |field: &str, what: String| Err(Fault::invalid(format!("header, {field}"), what));
        let finite = |all: &[f32]| all.iter().all(|x| x.is_finite());
        if self.scene_triangles() >= INVALID.into() {
            return refuse(
                "triangles",
                format!("the scene has {}, too many to number", self.scene_triangles()),
            );
        }
        if self.axis_aligned != 0 && (self.axis_aligned != self.nodes || self.oriented == 0) {
            let (kept, nodes, turned) = (self.axis_aligned, self.nodes, self.oriented);
            return refuse(
                "nodes",
                format!("{kept} are kept axis-aligned beside {nodes}, {turned} of them oriented"),
            );
        }
        if !(-126..=126).contains(&self.exponent) {
            return refuse("exponent", format!("{} is not within 126 of 0", self.exponent));
        }
        if !finite(&self.anchor) {
            return refuse("anchor", format!("{:?} is no place", self.anchor));
        }
        if !self.reach.is_finite() || self.reach < 0.0 {
            return refuse("reach", format!("{} is no length", self.reach));
        }
        let Aabb { lo, hi } = self.bounds;
        if !finite(&lo) || !finite(&hi) || (0..3).any(|k| lo[k] > hi[k]) {
            return refuse("bounds", format!("{lo:?} to {hi:?} is no box"));
        }
        if !self.sah.is_finite() || self.sah < 0.0 {
            return refuse("SAH cost", format!("{} is none", self.sah));
        }
        Ok(())
    }
}

/// Refuses what other programs and versions wrote.
fn version(fields: &mut Fields<'_>) -> Result<(), Fault> {
    let version = fields.u32();
    // Of a newer file only the version can be understood.
    if version > VERSION {
        return Err(Fault::Newer { found: version, reads: VERSION });
    }
    if version != VERSION {
        return Err(Fault::invalid(
            "header, version",
            format!("there is no version {version} of the format"),
        ));
    }
    for (what, ours) in [
        ("byte order", ORDER),
        ("bytes of the header", HEADER as u32),
        ("bytes of a node", NODE as u32),
        ("words of a triangle", TRIANGLE_WORDS),
    ] {
        let found = fields.u32();
        if found != ours {
            let said = format!("it is {found:#x}, and version {VERSION} has {ours:#x}");
            return Err(Fault::invalid(format!("header, {what}"), said));
        }
    }
    Ok(())
}
