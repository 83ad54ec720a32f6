//! Files of other programs: rays in, hits and JSON out. What is written appears whole or not at all.

use crate::abi::{Hit, Ray};
use crate::output;
use crate::trace::rays;
use anyhow::{Context, Result, bail};
use std::fs;
use std::io::Write;
use std::path::Path;

/// Reads a ray file, see [`rays::parse`].
pub(super) fn rays(path: &Path) -> Result<Vec<Ray>> {
    let name = path.display();
    let meta = fs::metadata(path).with_context(|| format!("can't read the rays {name}"))?;
    if meta.is_dir() {
        bail!("can't read the rays {name}: it is a directory");
    }
    let bytes = fs::read(path).with_context(|| format!("can't read the rays {name}"))?;
    rays::parse(&bytes).with_context(|| format!("can't take the rays of {name}"))
}

/// A file to be written, whole or not at all; what can't be written is found out before the work.
#[derive(Clone, Copy)]
pub(super) struct Output<'p> {
    path: &'p Path,
    /// The path is a device or a pipe, which can't be replaced.
    special: bool,
}

impl<'p> Output<'p> {
    /// Prepares to write `path`.
    pub(super) fn new(path: &'p Path) -> Result<Self> {
        let name = path.display();
        let special = match fs::metadata(path) {
            Ok(m) if m.is_dir() => bail!("can't write {name}: it is a directory"),
            Ok(m) => !m.is_file(),
            Err(_) => false,
        };
        if !special {
            output::probe(path).with_context(|| format!("can't write {name}"))?;
        }
        Ok(Self { path, special })
    }

    /// Writes what there is so far, should the rest never come. A device or a pipe gets the whole only: what it was given
    /// can't be replaced.
    pub(super) fn keep(self, bytes: &[u8]) -> Result<()> {
        if self.special { Ok(()) } else { self.finish(bytes) }
    }

    /// Writes `bytes` and gives the file its name.
    pub(super) fn finish(self, bytes: &[u8]) -> Result<()> {
        self.finish_by(|out| Ok(out.write_all(bytes)?))
    }

    /// Has `write` write it, and gives the file its name.
    pub(super) fn finish_by<T>(self, write: impl FnOnce(&mut fs::File) -> Result<T>) -> Result<T> {
        let written = match self.special {
            true => {
                let open = fs::OpenOptions::new().write(true).open(self.path);
                open.map_err(Into::into).and_then(|mut file| write(&mut file))
            }
            false => output::write_by(self.path, write),
        };
        written.with_context(|| format!("can't write {}", self.path.display()))
    }
}

/// The bytes of a hit file: little-endian f32 t, u32 triangle, f32 u, f32 v, a hit.
pub(super) fn hit_bytes(hits: &[Hit]) -> Vec<u8> {
    let words = |h: &Hit| [h.t.to_bits(), h.triangle, h.u.to_bits(), h.v.to_bits()];
    hits.iter().flat_map(words).flat_map(u32::to_le_bytes).collect()
}

/// A JSON text, with a newline at its end.
pub(super) fn json(value: &impl serde::Serialize) -> Result<String> {
    Ok(serde_json::to_string_pretty(value)? + "\n")
}

/// Prints `value` as JSON to stdout, and writes it to `path` where there is one.
pub(super) fn emit(value: &impl serde::Serialize, path: Option<Output>) -> Result<()> {
    let text = json(value)?;
    if let Some(output) = path {
        output.finish(text.as_bytes())?;
    }
    std::io::stdout().lock().write_all(text.as_bytes())?;
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn written_whole_or_not_at_all() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.hits");
        Output::new(&path).unwrap();
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0, "something is left of an abandoned output");
        Output::new(&path).unwrap().finish(b"whole").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        Output::new(&path).unwrap().keep(b"so far").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"so far");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        assert!(Output::new(&dir.path().join("none/a.hits")).is_err());
        assert!(Output::new(dir.path()).is_err());
    }
}
