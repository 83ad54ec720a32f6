//! A file becomes a tree, once nothing about it is in doubt.

use super::header::{CHECKSUM, HEAD, HEADER, Header, MAGIC, MOST_TEXT};
use super::{CHUNK, Fault, Origin, SECTIONS, SavedError};
use crate::abi::{Node, TRIANGLE_WORDS};
use crate::bvh::structure::{self, Shape};
use crate::bvh::{Bvh, HostTree, leaf_bits};
use crate::device::{Buffer, Device};
use crate::scene::{Scene, in_line};
use rayon::slice::ParallelSliceMut;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Words of a triangle.
const WORDS: usize = TRIANGLE_WORDS as usize;

/// A tree on the device, and where it comes from.
#[derive(Debug)]
pub struct Loaded {
    /// The tree.
    pub bvh: Bvh,
    /// Where it comes from.
    pub origin: Origin,
    /// Bytes of the file.
    pub bytes: u64,
}

impl Loaded {
    /// Refuses another scene than the one that the tree was built from.
    ///
    /// # Errors
    /// [`Fault::OtherScene`].
    pub fn require_scene(&self, scene: &Scene) -> Result<(), Fault> {
        let given = scene.corners_hash();
        if given == self.origin.corners {
            return Ok(());
        }
        let said = |name: &str, triangles: u64, hash: &str| {
            let hash = hash.chars().take(12).collect::<String>();
            in_line(format_args!("{name:?} of {triangles} triangles, corners {hash}…"))
        };
        let triangles = u64::from(self.bvh.triangle_count) + u64::from(self.bvh.left_out);
        Err(Fault::OtherScene {
            saved: said(&self.origin.scene, triangles, &self.origin.corners),
            given: said(&scene.name, scene.triangles.len() as u64, &given),
        })
    }
}

/// A tree in host memory, and all else that its file says.
#[derive(Debug, Clone)]
pub struct Parsed {
    /// The tree.
    pub tree: HostTree,
    /// Its nodes as they were before some became oriented, where both are kept.
    pub axis_aligned: Option<Vec<Node>>,
    /// The tree in numbers.
    pub header: Header,
    /// Where it comes from.
    pub origin: Origin,
}

/// Loads the tree of the file `path` onto `device`. Beside the tree on the device, host memory for its nodes and for four
/// bytes a triangle is taken meanwhile.
///
/// # Errors
/// [`SavedError`].
pub fn load(device: &Arc<Device>, path: &Path) -> Result<Loaded, SavedError> {
    onto(device, path).map_err(|fault| SavedError { path: path.to_owned(), fault })
}

fn onto(device: &Arc<Device>, path: &Path) -> Result<Loaded, Fault> {
    let meta = std::fs::metadata(path)?;
    if !meta.is_file() {
        return Err(Fault::NoFile(if meta.is_dir() { "a directory" } else { "no regular file" }));
    }
    let mut stream = Stream::new(File::open(path)?, meta.len());
    let header = stream.header()?;
    device.require_memory("the tree", header.device_bytes())?;
    let triangles = Buffer::<u32>::new(device, "bvh.triangles", header.triangles as usize * WORDS)?;
    let body = stream.body(&header, |first, words| Ok(triangles.write_at(first, words)?))?;
    let kept = match &body.axis_aligned {
        Some(nodes) => Some(Buffer::from_slice(device, "bvh.axis_aligned", nodes)?),
        None => None,
    };
    let Header { root, leaf_bits, depth, exponent, anchor, reach, bounds, sah, left_out, oriented, .. } =
        header;
    let bvh = Bvh {
        nodes: Buffer::from_slice(device, "bvh.nodes", &body.nodes)?,
        triangles,
        root,
        leaf_bits,
        depth,
        exponent,
        anchor,
        reach,
        bounds,
        sah,
        triangle_count: header.triangles as u32,
        left_out,
        oriented,
        axis_aligned: kept,
    };
    Ok(Loaded { bvh, origin: body.origin, bytes: meta.len() })
}

/// The tree of a file of these bytes. Takes memory in proportion to them, and no time to speak of, whatever they are.
///
/// # Errors
/// [`Fault`].
pub fn parse(bytes: &[u8]) -> Result<Parsed, Fault> {
    let mut stream = Stream::new(bytes, bytes.len() as u64);
    let header = stream.header()?;
    let mut triangles = room::<u32>(header.triangles as usize * WORDS)?;
    let body = stream.body(&header, |_, words| {
        triangles.extend_from_slice(words);
        Ok(())
    })?;
    let Header { root, leaf_bits, .. } = header;
    let tree = HostTree { nodes: body.nodes, triangles, root, leaf_bits };
    Ok(Parsed { tree, axis_aligned: body.axis_aligned, header, origin: body.origin })
}

/// What follows the header, but for the triangles, which are handed on.
struct Body {
    origin: Origin,
    nodes: Vec<Node>,
    axis_aligned: Option<Vec<Node>>,
}

/// An empty list with room for `len` elements. Only for what the file's length bears out.
fn room<T>(len: usize) -> Result<Vec<T>, Fault> {
    let mut list = vec![];
    list.try_reserve_exact(len).map_err(|_| Fault::Memory(len.saturating_mul(size_of::<T>())))?;
    Ok(list)
}

/// A file while it is read.
struct Stream<R> {
    from: R,
    length: u64,
    at: u64,
    hasher: blake3::Hasher,
}

impl<R: Read> Stream<R> {
    fn new(from: R, length: u64) -> Self {
        Self { from, length, at: 0, hasher: blake3::Hasher::new() }
    }

    /// The next bytes, as many as `out` has.
    fn fill(&mut self, out: &mut [u8]) -> Result<(), Fault> {
        for piece in out.chunks_mut(CHUNK) {
            self.from.read_exact(piece).map_err(|e| match e.kind() {
                // It had them when it was opened.
                std::io::ErrorKind::UnexpectedEof => {
                    Fault::Size { what: "cut short while it was read", has: self.at, wanted: self.length }
                }
                _ => e.into(),
            })?;
            self.hasher.update(piece);
            self.at += piece.len() as u64;
        }
        Ok(())
    }

    /// The header of a file of the right length.
    fn header(&mut self) -> Result<Header, Fault> {
        let mut bytes = [0; HEADER];
        let there = HEADER.min(self.length as usize);
        self.fill(&mut bytes[..there])?;
        let begins = &bytes[..there.min(MAGIC.len())];
        if there == 0 || !MAGIC.starts_with(begins) {
            let begins = match begins {
                [] => "nothing: it is empty".into(),
                text if text.is_ascii() => format!("{:?}", String::from_utf8_lossy(text)),
                other => other.iter().map(|b| format!("{b:02x}")).collect::<Vec<_>>().join(" "),
            };
            return Err(Fault::Foreign { begins });
        }
        if there < HEADER {
            let wanted = (HEADER + 5 * HEAD + CHECKSUM) as u64;
            return Err(Fault::Size { what: "cut short", has: self.length, wanted });
        }
        Header::parse(&bytes, self.length)
    }

    /// The beginning of section `index`.
    fn head(&mut self, header: &Header, index: usize) -> Result<(), Fault> {
        let at = self.at;
        let mut found = [0; HEAD];
        self.fill(&mut found)?;
        let (name, length) = (SECTIONS[index], header.lengths()[index]);
        if found[..8] != name || found[8..] != length.to_le_bytes() {
            let name = String::from_utf8_lossy(&name).trim_end_matches('\0').to_owned();
            let what = format!("section {name} of {length} bytes should begin here, by the header");
            return Err(Fault::invalid(format!("byte {at}"), what));
        }
        Ok(())
    }

    /// All else, checked; `take` gets the triangles, a piece at a time, with the place of the piece's first word.
    fn body(
        &mut self,
        header: &Header,
        take: impl FnMut(usize, &[u32]) -> Result<(), Fault>,
    ) -> Result<Body, Fault> {
        if header.text > MOST_TEXT {
            return Err(Fault::invalid("header, text", format!("its {} bytes are too many", header.text)));
        }
        self.head(header, 0)?;
        let mut text = vec![0; header.text as usize];
        let text_at = self.at;
        self.fill(&mut text)?;
        self.head(header, 1)?;
        let nodes = self.nodes(header.nodes)?;
        self.head(header, 2)?;
        let axis_aligned = self.nodes(header.axis_aligned)?;
        self.head(header, 3)?;
        let triangles = self.triangles(header, take)?;
        self.head(header, 4)?;
        self.checksum()?;

        header.check()?;
        let origin: Origin = serde_json::from_slice(&text)
            .map_err(|e| Fault::invalid(format!("text, at byte {text_at}"), e))?;
        origin.recipe.check().map_err(|e| Fault::invalid("text, recipe", e))?;
        let max_leaf = origin.recipe.collapse.max_leaf;
        if header.leaf_bits != leaf_bits(max_leaf) {
            let what = format!("{} for leaves of up to {max_leaf}", header.leaf_bits);
            return Err(Fault::invalid("header, bits of a leaf's size", what));
        }
        let Header { root, leaf_bits, depth, oriented, .. } = *header;
        let shape = Shape { root, leaf_bits, depth, max_leaf, triangles: header.triangles as usize };
        walked("nodes", &nodes, &shape, oriented)?;
        let kept = header.axis_aligned > 0;
        if kept {
            walked("nodes kept axis-aligned", &axis_aligned, &shape, 0)?;
        }
        triangles.check()?;
        Ok(Body { origin, nodes, axis_aligned: kept.then_some(axis_aligned) })
    }

    fn nodes(&mut self, count: u64) -> Result<Vec<Node>, Fault> {
        let mut nodes = room::<Node>(count as usize)?;
        nodes.resize(count as usize, bytemuck::Zeroable::zeroed());
        self.fill(bytemuck::cast_slice_mut(&mut nodes))?;
        native(bytemuck::cast_slice_mut(&mut nodes));
        Ok(nodes)
    }

    /// The triangles, handed to `take`, and what is to be said of them.
    fn triangles(
        &mut self,
        header: &Header,
        mut take: impl FnMut(usize, &[u32]) -> Result<(), Fault>,
    ) -> Result<Triangles, Fault> {
        let total = header.triangles as usize;
        let mut seen = Triangles { indices: room(total)?, fault: None };
        let piece = (CHUNK / 4 / WORDS).min(total);
        let mut words = room::<u32>(piece * WORDS)?;
        words.resize(piece * WORDS, 0);
        for first in (0..total).step_by(piece.max(1)) {
            let words = &mut words[..piece.min(total - first) * WORDS];
            self.fill(bytemuck::cast_slice_mut(words))?;
            native(words);
            seen.look(first, words, header.scene_triangles());
            take(first * WORDS, words)?;
        }
        Ok(seen)
    }

    /// Compares what was read with what is noted.
    fn checksum(&mut self) -> Result<(), Fault> {
        let (bytes, found) = (self.at, self.hasher.finalize());
        let mut noted = [0; CHECKSUM];
        self.fill(&mut noted)?;
        if found != noted {
            let noted = blake3::Hash::from_bytes(noted).to_string();
            return Err(Fault::Checksum { bytes, found: found.to_string(), noted });
        }
        Ok(())
    }
}

/// Words of a file become the machine's.
fn native(words: &mut [u32]) {
    words.iter_mut().for_each(|word| *word = u32::from_le(*word));
}

fn walked(section: &'static str, nodes: &[Node], shape: &Shape, oriented: u32) -> Result<(), Fault> {
    let found = structure::check(nodes, shape).map_err(|fault| Fault::Structure { section, fault })?;
    if found.oriented != oriented {
        let what = format!("{} have a frame, and {oriented} should", found.oriented);
        return Err(Fault::invalid(section, what));
    }
    Ok(())
}

/// What was seen of the triangles: told only once the checksum is right, for damage is the likelier cause.
struct Triangles {
    /// In the scene.
    indices: Vec<u32>,
    /// The first thing wrong.
    fault: Option<Fault>,
}

impl Triangles {
    fn look(&mut self, first: usize, words: &[u32], scene: u64) {
        for (i, triangle) in words.chunks_exact(WORDS).enumerate() {
            let (corners, index) = (&triangle[..WORDS - 1], triangle[WORDS - 1]);
            let wrong = if u64::from(index) >= scene {
                format!("is the scene's {index}, which has {scene}")
            } else if corners.iter().any(|x| !f32::from_bits(*x).is_finite()) {
                "has a corner nowhere".to_owned()
            } else {
                continue;
            };
            if self.fault.is_none() {
                self.fault = Some(Fault::invalid("corners", format!("triangle {} {wrong}", first + i)));
            }
        }
        self.indices.extend(words.chunks_exact(WORDS).map(|triangle| triangle[WORDS - 1]));
    }

    fn check(mut self) -> Result<(), Fault> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        self.indices.par_sort_unstable();
        match self.indices.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(twice) => Err(Fault::invalid(
                "corners",
                format!("the scene's triangle {} is in the tree twice", twice[0]),
            )),
            None => Ok(()),
        }
    }
}
