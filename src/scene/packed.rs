//! Packed mesh files: gzip by `flate2`, any number of members; Zstandard by `ruzstd`, any number of frames. Here: what
//! comes out is limited while it comes, for a few bytes can unpack to more than any memory holds, and a frame's sum
//! and size are held against what it says, which `ruzstd` leaves to its caller.

use std::borrow::Cow;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

use super::{MAX_TRIANGLES, Progress, SceneError, memory};

/// Unpacked bytes between two steps of the bar.
const CHUNK: usize = 1 << 20;
/// Most bytes out of a byte packed, beyond [`FREE`]. Meshes reach about 50; gzip goes to 1032, Zstandard to 32768.
const RATIO: u64 = 256;
/// Unpacked bytes that are always allowed.
const FREE: u64 = 256 << 20;
/// Bytes that a Zstandard frame may look back, as `zstd --ultra -22` and `--long` have it: room is made for them at once.
const WINDOW: u64 = 128 << 20;
/// Bytes of a triangle in the widest of the usual formats: ASCII STL.
const WIDEST: u64 = 256;

/// How a file is packed.
#[derive(Debug, Clone, Copy)]
enum Packing {
    Gzip,
    Zstd,
}

/// `path` less the ending that says how it is packed, if it has one.
fn split(path: &Path) -> Option<(PathBuf, Packing)> {
    let packing = match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "gz" => Packing::Gzip,
        "zst" => Packing::Zstd,
        _ => return None,
    };
    Some((path.with_extension(""), packing))
}

/// The path that says what is in the file: `kitchen.obj` for `kitchen.obj.zst`, the path itself for a plain file.
pub(super) fn inside(path: &Path) -> Cow<'_, Path> {
    split(path).map_or(Cow::Borrowed(path), |(inside, _)| Cow::Owned(inside))
}

/// Bytes that a file of so many packed ones may unpack to.
pub(super) fn most_of(packed: u64) -> u64 {
    packed.saturating_mul(RATIO).clamp(FREE, MAX_TRIANGLES * WIDEST)
}

/// What is in the file `path` whose bytes are `bytes`: those bytes, or what they unpack to.
///
/// # Errors
/// Damaged, cut short or unpacking to more than any mesh of that size: with the byte. More than memory holds.
pub(super) fn unpack<'b>(
    path: &Path,
    bytes: &'b [u8],
    progress: Progress,
) -> Result<Cow<'b, [u8]>, SceneError> {
    // The other half is for the scene that is made of it.
    unpack_within(path, bytes, progress, memory::free() / 2)
}

/// The same, where `room` bytes of memory may be taken.
pub(super) fn unpack_within<'b>(
    path: &Path,
    bytes: &'b [u8],
    progress: Progress,
    room: u64,
) -> Result<Cow<'b, [u8]>, SceneError> {
    let Some((_, packing)) = split(path) else { return Ok(Cow::Borrowed(bytes)) };
    let limit = most_of(bytes.len() as u64);
    let bar = progress.bytes(format!("unpacking {}", path.display()), bytes.len() as u64);
    let mut stream = match packing {
        Packing::Gzip => Stream::Gzip(MultiGzDecoder::new(bytes)),
        Packing::Zstd => Stream::Zstd(Box::new(Frames::new(bytes))),
    };
    let mut out = Vec::new();
    loop {
        out.try_reserve(CHUNK).map_err(|_| SceneError::TooLarge {
            name: path.display().to_string(),
            what: format!("what it unpacks to, over {} bytes, doesn't fit in memory", out.len()),
        })?;
        let got = (&mut stream).take(CHUNK as u64).read_to_end(&mut out);
        let at = bytes.len() - stream.left();
        let got = got.map_err(|e| {
            let (what, fix) = fault(&e, packing);
            SceneError::invalid(path, format!("byte {at} of {}", bytes.len()), what, fix)
        })?;
        bar.set_position(at as u64);
        if out.len() as u64 > limit {
            let what = format!("its {} bytes unpack to over {limit}, which no mesh does", bytes.len());
            let fix = "if it is a mesh all the same, unpack it by hand and give the plain file";
            return Err(SceneError::invalid(path, format!("byte {at} of {}", bytes.len()), what, fix));
        }
        if out.len() as u64 > room {
            let what = format!("what it unpacks to, over {room} bytes, is more than half of the free memory");
            return Err(SceneError::TooLarge { name: path.display().to_string(), what });
        }
        if got == 0 {
            bar.finish_and_clear();
            return Ok(Cow::Owned(out));
        }
    }
}

/// What is wrong with a packed file, and what to do.
fn fault(error: &io::Error, packing: Packing) -> (String, &'static str) {
    let (kind, fix) = match packing {
        Packing::Gzip => ("gzip", "get it again, or see what gunzip makes of it"),
        Packing::Zstd => ("Zstandard", "get it again, or unpack it with zstd -d and give the plain file"),
    };
    match error.kind() {
        io::ErrorKind::UnexpectedEof => (format!("the {kind} file is cut short here"), "get it again"),
        _ => (format!("no sound {kind} file: {error}"), fix),
    }
}

/// A packed file that is being unpacked.
enum Stream<'b> {
    Gzip(MultiGzDecoder<&'b [u8]>),
    Zstd(Box<Frames<'b>>),
}

impl Stream<'_> {
    /// Packed bytes not yet read.
    fn left(&self) -> usize {
        match self {
            Self::Gzip(decoder) => decoder.get_ref().len(),
            Self::Zstd(frames) => frames.rest.len(),
        }
    }
}

impl Read for Stream<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Gzip(decoder) => decoder.read(out),
            Self::Zstd(frames) => frames.read(out),
        }
    }
}

/// Zstandard frames, one behind another.
struct Frames<'b> {
    rest: &'b [u8],
    decoder: FrameDecoder,
    /// Bytes that the frame gave so far; none: between frames.
    given: Option<u64>,
}

impl<'b> Frames<'b> {
    fn new(bytes: &'b [u8]) -> Self {
        let mut decoder = FrameDecoder::new();
        decoder.set_max_window_size(WINDOW);
        Self { rest: bytes, decoder, given: None }
    }

    /// Starts on the next frame that isn't to be skipped. False: there is none.
    fn start(&mut self) -> io::Result<bool> {
        loop {
            // An empty file isn't sound, but it unpacks to an empty one, and that is refused.
            if self.rest.is_empty() {
                return Ok(false);
            }
            match self.decoder.init(&mut self.rest) {
                Ok(()) => {
                    self.given = Some(0);
                    return Ok(true);
                }
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                    length,
                    ..
                })) => {
                    let after = self.rest.get(length as usize..);
                    self.rest = after.ok_or(io::ErrorKind::UnexpectedEof)?;
                }
                Err(e) => return Err(cause(e)),
            }
        }
    }

    /// Whether the frame held what it says.
    fn check(&self, given: u64) -> io::Result<()> {
        let said = self.decoder.content_size();
        if said != 0 && said != given {
            return Err(io::Error::other(format!("a frame of {said} bytes has {given}")));
        }
        let sum = self.decoder.get_checksum_from_data();
        if sum.is_some() && sum != self.decoder.get_calculated_checksum() {
            return Err(io::Error::other("a frame's checksum differs"));
        }
        Ok(())
    }
}

impl Read for Frames<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if out.is_empty() {
            return Ok(0);
        }
        loop {
            let Some(given) = self.given else {
                match self.start()? {
                    true => continue,
                    false => return Ok(0),
                }
            };
            if self.decoder.can_collect() > 0 {
                let got = self.decoder.read(out)?;
                self.given = Some(given + got as u64);
                return Ok(got);
            }
            if self.decoder.is_finished() {
                self.check(given)?;
                self.given = None;
            } else {
                let step = BlockDecodingStrategy::UptoBlocks(1);
                self.decoder.decode_blocks(&mut self.rest, step).map_err(cause)?;
            }
        }
    }
}

/// `error` as one of reading: cut short where that lies below it.
fn cause(error: FrameDecoderError) -> io::Error {
    let mut below: Option<&(dyn std::error::Error + 'static)> = Some(&error);
    while let Some(e) = below {
        if e.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::UnexpectedEof) {
            return io::ErrorKind::UnexpectedEof.into();
        }
        below = e.source();
    }
    io::Error::other(error)
}
