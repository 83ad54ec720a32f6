//! Files of other programs: rays in, hits and JSON out. What is written appears whole or not at all.

use crate::abi::{Hit, Ray};
use crate::output;
use anyhow::{Context, Result, bail};
use std::fs;
use std::io::Write;
use std::path::Path;

/// Bytes of a ray.
const RAY: u64 = size_of::<Ray>() as u64;

/// Reads a ray file: little-endian f32, eight a ray (origin, t_min, direction, t_max), no header.
pub(super) fn rays(path: &Path) -> Result<Vec<Ray>> {
    let name = path.display();
    let meta = fs::metadata(path).with_context(|| format!("can't read the rays {name}"))?;
    if meta.is_dir() {
        bail!("can't read the rays {name}: it is a directory");
    }
    let bytes = fs::read(path).with_context(|| format!("can't read the rays {name}"))?;
    let size = bytes.len() as u64;
    if size == 0 {
        bail!(
            "{name} holds no ray: it is empty; a ray is 8 little-endian f32 (origin, t_min, direction, t_max)"
        );
    }
    if !size.is_multiple_of(RAY) {
        bail!(
            "{name}: {size} bytes are no multiple of {RAY}, so ray {} is cut short; a ray is 8 little-endian f32 \
             (origin, t_min, direction, t_max) and there is no header",
            size / RAY
        );
    }
    let word = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let ray = |b: &[u8]| {
        let f: [f32; 8] = std::array::from_fn(|i| word(&b[4 * i..]));
        bytemuck::cast::<[f32; 8], Ray>(f)
    };
    Ok(bytes.chunks_exact(RAY as usize).map(ray).collect())
}

/// A file to be written, whole or not at all; what can't be written is found out before the work.
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

    /// Writes `bytes` and gives the file its name.
    pub(super) fn finish(self, bytes: &[u8]) -> Result<()> {
        let written = match self.special {
            true => fs::OpenOptions::new().write(true).open(self.path).and_then(|mut f| f.write_all(bytes)),
            false => output::write(self.path, bytes),
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
        drop(Output::new(&path).unwrap());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0, "something is left of an abandoned output");
        Output::new(&path).unwrap().finish(b"whole").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        assert!(Output::new(&dir.path().join("none/a.hits")).is_err());
        assert!(Output::new(dir.path()).is_err());
    }

    #[test]
    fn rays_come_in_whole_records() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.rays");
        let bytes: Vec<u8> = (0..8).flat_map(|i| (i as f32).to_le_bytes()).collect();
        fs::write(&path, &bytes).unwrap();
        let read = rays(&path).unwrap();
        assert_eq!((read.len(), read[0].t_min, read[0].t_max), (1, 3.0, 7.0));
        fs::write(&path, &bytes[1..]).unwrap();
        assert!(rays(&path).unwrap_err().to_string().contains("31 bytes"));
    }
}
