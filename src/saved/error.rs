//! What can be wrong with a file of a tree: what, where, and what to do.

use crate::bvh::structure;
use crate::device::DeviceError;
use crate::scene::in_line;
use std::fmt::Display;
use std::io;
use std::path::PathBuf;

/// What to do about a file that is not as it was written.
const AGAIN: &str = "copy it again, or build and save the tree anew";

/// Why a tree can't be saved or loaded.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// What the system said.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// No regular file, whose size would be known.
    #[error("it is {0}; name a file that `boxwood build SCENE --save FILE` has written")]
    NoFile(&'static str),
    /// A file of something else.
    #[error(
        "no tree saved by boxwood: it begins with {begins}; name a file that `boxwood build SCENE --save FILE` has written"
    )]
    Foreign {
        /// Its first bytes, as text or numbers.
        begins: String,
    },
    /// A later format.
    #[error("written by a newer boxwood: its format is version {found}, and this boxwood ({}) reads version {reads}; use a newer boxwood, or build and save the tree anew", env!("CARGO_PKG_VERSION"))]
    Newer {
        /// The file's.
        found: u32,
        /// Ours.
        reads: u32,
    },
    /// Less or more than there should be.
    #[error("{what}: it has {has} bytes and should have {wanted}; {AGAIN}")]
    Size {
        /// Cut short, or too long.
        what: &'static str,
        /// The file's, bytes.
        has: u64,
        /// By its header, bytes; of a file without one, at least.
        wanted: u64,
    },
    /// Bytes that differ from those written.
    #[error(
        "damaged: the checksum of its {bytes} bytes is {found}, and {noted} is noted at byte {bytes}; {AGAIN}"
    )]
    Checksum {
        /// Bytes before the checksum's own.
        bytes: u64,
        /// Of those read.
        found: String,
        /// In the file.
        noted: String,
    },
    /// Something that no tree of ours says.
    #[error("{place}: {what}; {AGAIN}")]
    Invalid {
        /// Section and byte.
        place: String,
        /// What is wrong there.
        what: String,
    },
    /// Nodes through which no ray should be sent.
    #[error("{section}: {fault}; {AGAIN}")]
    Structure {
        /// Which nodes.
        section: &'static str,
        /// What is wrong with them.
        fault: structure::Fault,
    },
    /// Another scene than the tree's.
    #[error(
        "its scene is another one: it was built from {saved}, and given is {given}; give the scene that it was built from, turned, scaled and moved alike, or build and save the tree of the other"
    )]
    OtherScene {
        /// Name, triangles and hash of the tree's.
        saved: String,
        /// Those of the one given.
        given: String,
    },
    /// More than the host has.
    #[error("{0} bytes don't fit in memory; use a machine with more, or build a smaller scene's tree")]
    Memory(usize),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

impl Fault {
    /// `what` may be the file's own words.
    pub(super) fn invalid(place: impl Into<String>, what: impl Display) -> Self {
        Self::Invalid { place: place.into(), what: in_line(what) }
    }
}

/// A file that can't be loaded.
#[derive(Debug, thiserror::Error)]
#[error("can't load the tree {}: {fault}", path.display())]
pub struct SavedError {
    /// The file.
    pub path: PathBuf,
    /// Why.
    #[source]
    pub fault: Fault,
}
