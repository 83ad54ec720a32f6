//! `.tri`: nine little-endian f32 a triangle, no header. Every corner is a vertex of its own.

use std::path::Path;

use super::{MAX_TRIANGLES, Scene, SceneError, mesh};

/// Bytes of a triangle.
const RECORD: usize = 36;

/// Reads a triangle soup.
///
/// # Errors
/// A size that is no multiple of 36 bytes, no triangle, more than 2^30.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Scene, SceneError> {
    let whole = bytes.len() / RECORD;
    if !bytes.len().is_multiple_of(RECORD) {
        return Err(SceneError::invalid(
            path,
            format!("byte {}", whole * RECORD),
            format!("triangle {whole} is cut short: {} bytes are not a multiple of {RECORD}", bytes.len()),
            "a .tri file is 9 little-endian f32 a triangle with no header: write it again",
        ));
    }
    if whole as u64 > MAX_TRIANGLES {
        let what = format!("{whole} triangles are more than 2^30");
        return Err(SceneError::TooLarge { name: path.display().to_string(), what });
    }
    let float = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let positions = bytes.chunks_exact(12).map(|v| [float(v), float(&v[4..]), float(&v[8..])]).collect();
    let triangles = (0..whole as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh::scene(path, positions, triangles, Vec::new())
}
