//! Files that appear whole or not at all: each is written beside its place, brought to the disk, then given its name. What
//! a killed process leaves beside is hidden, says what it is, and goes with the next write to the same name.
//!
//! Whoever works on something beside holds a lock on it, which the system lets go of when the process ends, however it
//! does. So what can be locked is nobody's any more.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

/// End of the names of files that are not whole.
const PART: &str = ".boxwood-part";
/// Characters of a name that are kept in the name beside: a file system takes 255 bytes, and ours adds some.
const KEPT: usize = 50;

/// Finds out whether `path` can be written, without touching it, and clears what killed processes left beside.
///
/// # Errors
/// Its folder can't be written to.
pub fn probe(path: &Path) -> io::Result<()> {
    clear(folder_of(path), &prefix(path), PART);
    beside(path).map(drop)
}

/// Writes `bytes` to `path`, which has all of them from then on; nothing is changed where that fails.
///
/// # Errors
/// The folder can't be written to, or the disk is full.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_by(path, |file| file.write_all(bytes))
}

/// Likewise what `write` writes; its result.
///
/// # Errors
/// Those of `write`, and as [`write()`].
pub fn write_by<T, E: From<io::Error>>(
    path: &Path,
    write: impl FnOnce(&mut File) -> Result<T, E>,
) -> Result<T, E> {
    clear(folder_of(path), &prefix(path), PART);
    let mut file = beside(path)?;
    let written = write(file.as_file_mut())?;
    file.as_file().sync_data()?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(written)
}

/// A folder for a while in `folder`; clears those of that `prefix` which killed processes left.
///
/// # Errors
/// `folder` can't be written to.
pub fn scratch(folder: &Path, prefix: &str) -> io::Result<Scratch> {
    clear(folder, prefix, "");
    loop {
        let scratch = tempfile::Builder::new().prefix(prefix).tempdir_in(folder)?;
        let lock = File::open(scratch.path()).ok();
        if let Some(lock) = &lock {
            // Where locks are not known, nothing is cleared either.
            let _ = lock.lock();
        }
        if scratch.path().exists() {
            return Ok(Scratch { folder: scratch, _lock: lock });
        }
    }
}

/// A folder that goes with this.
#[derive(Debug)]
pub struct Scratch {
    folder: tempfile::TempDir,
    _lock: Option<File>,
}

impl Scratch {
    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// How names of files beside `path` begin.
fn prefix(path: &Path) -> String {
    let name = path.file_name().unwrap_or(OsStr::new("file")).to_string_lossy();
    format!(".{}.", name.chars().take(KEPT).collect::<String>())
}

/// A new file beside `path`, which goes unless it gets that name.
fn beside(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let prefix = prefix(path);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(PART);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    loop {
        let file = builder.tempfile_in(folder_of(path))?;
        // Between the two another process may have taken it for one that nobody has any more.
        let _ = file.as_file().lock();
        if file.path().exists() {
            return Ok(file);
        }
    }
}

/// Removes what is named so in `folder` and locked by nobody.
fn clear(folder: &Path, prefix: &str, suffix: &str) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let named = name.to_str().is_some_and(|n| n.starts_with(prefix) && n.ends_with(suffix));
        let Some(left) = named.then(|| File::open(entry.path()).ok()).flatten() else { continue };
        if left.try_lock().is_ok() {
            // Another process may have been faster, which is as well.
            let path = entry.path();
            let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_whole_and_alone() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.hits");
        probe(&path).unwrap();
        assert!(names(dir.path()).is_empty());
        for text in ["one", "another, longer"] {
            write(&path, text.as_bytes()).unwrap();
            assert_eq!((fs::read_to_string(&path).unwrap().as_str(), names(dir.path()).len()), (text, 1));
        }
        // As long as a name can be.
        let long = dir.path().join("ä".repeat(127));
        write(&long, b"x").unwrap();
        assert_eq!(fs::read(&long).unwrap(), b"x");
        assert!(probe(&dir.path().join("none/a.hits")).is_err());
        assert!(write(dir.path(), b"x").is_err());
    }

    #[test]
    fn what_nobody_holds_is_cleared_and_what_somebody_holds_stays() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.hits");
        fs::write(dir.path().join(".a.hits.dead00.boxwood-part"), "half").unwrap();
        // Of another file; somebody's own, named alike.
        fs::write(dir.path().join(".b.hits.dead00.boxwood-part"), "half").unwrap();
        fs::write(dir.path().join(".a.hits.notes"), "mine").unwrap();
        let held = beside(&path).unwrap();
        write(&path, b"whole").unwrap();
        let held_name = held.path().file_name().unwrap().to_str().unwrap().to_owned();
        let mut wanted = vec![".a.hits.notes", ".b.hits.dead00.boxwood-part", "a.hits", &held_name];
        wanted.sort_unstable();
        assert_eq!(names(dir.path()), wanted);
    }

    #[test]
    fn folders_likewise() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir_all(dir.path().join("fetch-dead00/package")).unwrap();
        let first = scratch(dir.path(), "fetch-").unwrap();
        let second = scratch(dir.path(), "fetch-").unwrap();
        assert!(first.path().is_dir() && second.path().is_dir());
        assert_eq!(names(dir.path()).len(), 2);
        drop((first, second));
        assert!(names(dir.path()).is_empty());
    }
}
