//! A tree becomes a file, a piece at a time.

use super::header::Header;
use super::{CHUNK, Fault, Origin, SECTIONS};
use crate::bvh::Bvh;
use crate::device::Buffer;
use std::io::Write;

/// Writes `bvh` to `out`, which holds no more of it than a piece at once; returns how many bytes. What else writes the
/// file whole or not at all is up to the caller.
///
/// # Errors
/// [`Fault::Io`] as `out` fails, [`Fault::Device`] as reading back does; a scene's name that is too long.
pub fn write(bvh: &Bvh, origin: &Origin, out: &mut (impl Write + ?Sized)) -> Result<u64, Fault> {
    let text = serde_json::to_vec(origin).map_err(std::io::Error::from)?;
    let header = Header::of(bvh, text.len() as u64);
    header.check()?;
    let mut to = Hashed { out, hasher: blake3::Hasher::new(), bytes: 0 };
    to.put(&header.to_bytes())?;
    let mut heads = SECTIONS.into_iter().zip(header.lengths());
    let mut head = |to: &mut Hashed<_>| match heads.next() {
        Some((name, length)) => to.put(&[name, length.to_le_bytes()].concat()),
        None => Ok(()),
    };
    head(&mut to)?;
    to.put(&text)?;
    head(&mut to)?;
    to.put_all(&bvh.nodes)?;
    head(&mut to)?;
    if let Some(nodes) = &bvh.axis_aligned {
        to.put_all(nodes)?;
    }
    head(&mut to)?;
    to.put_all(&bvh.triangles)?;
    head(&mut to)?;
    let hash = to.hasher.finalize();
    to.put(hash.as_bytes())?;
    to.out.flush()?;
    Ok(to.bytes)
}

/// What was written so far.
struct Hashed<'o, W: ?Sized> {
    out: &'o mut W,
    hasher: blake3::Hasher,
    bytes: u64,
}

impl<W: Write + ?Sized> Hashed<'_, W> {
    fn put(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        self.hasher.update(bytes);
        self.out.write_all(bytes)?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    /// The elements of a buffer, which are words.
    fn put_all<T: bytemuck::Pod>(&mut self, buffer: &Buffer<T>) -> Result<(), Fault> {
        let piece = CHUNK / size_of::<T>();
        for first in (0..buffer.len()).step_by(piece) {
            let mut elements = buffer.read_from(first, piece.min(buffer.len() - first))?;
            let words: &mut [u32] = bytemuck::cast_slice_mut(&mut elements);
            words.iter_mut().for_each(|word| *word = word.to_le());
            self.put(bytemuck::cast_slice(words))?;
        }
        Ok(())
    }
}
