//! Built trees as files: [`write`](fn@write) a tree, [`load`] it without its scene, [`parse`] it without a device.
//! Rays through a loaded tree have the very hits that they have through the one that was saved.
//!
//! # Format, version 1
//! All numbers are little-endian, whatever the machine; all sizes are whole bytes and nothing is padded.
//!
//! | bytes | what |
//! |---|---|
//! | 12 | `\x89boxwood\r\n\x1a\n`: changes where a file is copied as text |
//! | 4 | u32 version of the format; all that follows depends on it |
//! | 4 | u32 0x01020304, the order of bytes |
//! | 4 | u32 136, bytes of all up to the first section |
//! | 4, 4 | u32 64, bytes of a node; u32 10, words of a triangle |
//! | 8, 8, 8, 8 | u64: nodes; nodes kept axis-aligned beside oriented ones, or 0; triangles; bytes of the text |
//! | 4, 4, 4, 4 | root, bits of a leaf's size, levels at most, exponent (signed) |
//! | 12, 4, 24 | f32: anchor, reach, bounds (least corner first), as [`Bvh`](crate::bvh::Bvh) has them |
//! | 8, 4, 4 | f64 SAH cost; u32: triangles left out, oriented nodes |
//! | 16 + text | section `text`: [`Origin`] as JSON |
//! | 16 + 64 a node | section `nodes`: [`Node`](crate::abi::Node)s |
//! | 16 + 64 a node | section `aabb`: those kept axis-aligned |
//! | 16 + 40 a triangle | section `corners`: [`PackedTriangle`](crate::abi::PackedTriangle)s |
//! | 16 + 32 | section `blake3`: BLAKE3 of all bytes before its own 32 |
//!
//! A section begins with its name, eight bytes with zeros behind it, and a u64 length.
//!
//! BLAKE3, not SHA-256: as sure to tell, and two to ten times as fast where a processor has no instructions for the latter,
//! so that reading a tree takes no longer for being checked.
//!
//! # What is refused
//! Any file but one of these very bytes. Sizes are held against the file's length before anything is allocated. Then the
//! checksum is compared; it finds what was damaged, but who forges a file computes a new one, so what was read is checked as
//! if there were none: [`structure`](crate::bvh::structure) for both sets of nodes, every triangle's corners and index, and
//! the numbers of the header. No kernel sees a tree before. Whether its boxes hold its triangles only `--check` can tell,
//! with the scene: where they don't, hits are missed, and nothing is read out of bounds.

mod error;
mod header;
mod read;
mod write;

pub use error::{Fault, SavedError};
pub use header::{Header, VERSION};
pub use read::{Loaded, Parsed, load, parse};
pub use write::write;

use crate::bvh::Recipe;
use crate::scene::Scene;

/// Names of the sections, in their order.
const SECTIONS: [[u8; 8]; 5] =
    [*b"text\0\0\0\0", *b"nodes\0\0\0", *b"aabb\0\0\0\0", *b"corners\0", *b"blake3\0\0"];
/// Bytes that are read, hashed and handed on at once: whole triangles and nodes.
const CHUNK: usize = 320 << 15;

/// Where a tree comes from.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Version of the boxwood that built it.
    pub boxwood: String,
    /// Its commit.
    pub commit: String,
    /// Name of the scene.
    pub scene: String,
    /// As [`Scene::corners_hash`].
    pub corners: String,
    /// How it was built.
    pub recipe: Recipe,
}

impl Origin {
    /// Of a tree that this boxwood built of `scene` by `recipe`.
    pub fn new(scene: &Scene, recipe: Recipe) -> Self {
        Self {
            boxwood: env!("CARGO_PKG_VERSION").into(),
            commit: env!("BOXWOOD_COMMIT").into(),
            scene: scene.name.clone(),
            corners: scene.corners_hash(),
            recipe,
        }
    }
}
