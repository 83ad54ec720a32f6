//! What can be wrong with a scene: each says which thing, where, and what to do.

use std::io;
use std::path::{Path, PathBuf};

use super::open::FILES;
use super::printable::in_line;

/// Why a scene could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Neither a known name nor a path with a known extension.
    #[error("no scene is called {spec:?}; give {FILES}, or one of: {known}")]
    UnknownName {
        /// As typed.
        spec: String,
        /// What there is.
        known: String,
    },
    /// The part behind a generated scene's colon.
    #[error("{spec:?}: {what}; write a triangle count from 1 to 2^30, such as {name}:100000 or {name}:1M")]
    BadSize {
        /// As typed.
        spec: String,
        /// The scene's name.
        name: String,
        /// What is wrong with the count.
        what: String,
    },
    /// A file that can't be opened or read.
    #[error("can't read {}: {source}; {fix}", in_line(path.display()))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
        /// What to do.
        fix: &'static str,
    },
    /// A file that is not what it should be.
    #[error("{}: {}: {}; {fix}", in_line(path.display()), in_line(place), in_line(what))]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Line, byte, vertex or face.
        place: String,
        /// What is wrong there.
        what: String,
        /// What to do.
        fix: String,
    },
    /// A file or scene of no triangle.
    #[error("{}: no triangle in it ({}); give a file with faces", in_line(path.display()), in_line(what))]
    Empty {
        /// The file.
        path: PathBuf,
        /// What was found instead.
        what: String,
    },
    /// More than can be indexed or held.
    #[error("{}: {what}; give a smaller scene", in_line(name))]
    TooLarge {
        /// Scene or file.
        name: String,
        /// What was needed.
        what: String,
    },
    /// A scene from a registry that could not be had; [`SceneError::instead`] names one that can.
    #[error("can't fetch {name}:\n{}\nuse a generated scene instead, such as {instead}", tried.iter().map(|t| format!("  {}", in_line(t))).collect::<Vec<_>>().join("\n"))]
    Fetch {
        /// The scene's name.
        name: String,
        /// Each command tried and what came of it.
        tried: Vec<String>,
        /// A generated scene of about the same size.
        instead: String,
    },
    /// A rotation, scale or translation that can't be done.
    #[error("{} {transform}: {what}; {fix}", in_line(name))]
    Transform {
        /// The scene.
        name: String,
        /// What was asked for.
        transform: String,
        /// Why it can't be.
        what: String,
        /// What to do.
        fix: &'static str,
    },
    /// The cache directory can't be used.
    #[error("can't use the cache {}: {source}; set BOXWOOD_CACHE to a directory that can be written", in_line(path.display()))]
    Cache {
        /// The directory or file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

impl SceneError {
    /// The name of a generated scene that can stand in, where a fetched one could not be had.
    pub fn instead(&self) -> Option<&str> {
        match self {
            Self::Fetch { instead, .. } => Some(instead),
            Self::UnknownName { .. }
            | Self::BadSize { .. }
            | Self::Read { .. }
            | Self::Invalid { .. }
            | Self::Empty { .. }
            | Self::TooLarge { .. }
            | Self::Transform { .. }
            | Self::Cache { .. } => None,
        }
    }

    /// A fault at `place` in the file `path`.
    pub(super) fn invalid(
        path: &Path,
        place: impl Into<String>,
        what: impl Into<String>,
        fix: impl Into<String>,
    ) -> Self {
        Self::Invalid { path: path.to_owned(), place: place.into(), what: what.into(), fix: fix.into() }
    }
}
