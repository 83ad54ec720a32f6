//! Wavefront OBJ, positions and faces only. Differs from tobj, which the tests compare it with: errors name the line,
//! short faces are counted, vertices are not renumbered, and nothing is hashed (tobj re-indexes every corner).

use std::path::Path;

use super::mesh::{Faces, Place, Tally};
use super::{Progress, Scene, SceneError};

/// Statements that say nothing about triangles.
const IGNORED: &[&str] = &[
    "vt",
    "vn",
    "vp",
    "g",
    "o",
    "s",
    "mg",
    "mtllib",
    "usemtl",
    "maplib",
    "usemap",
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "call",
    "csh",
];
/// Lines between two steps of the bar.
const STEP: u64 = 1 << 16;

/// Reads an OBJ.
///
/// # Errors
/// A coordinate or index that is no number, an index out of range: with its line. No triangle.
pub(super) fn parse(path: &Path, bytes: &[u8], progress: Progress) -> Result<Scene, SceneError> {
    let bar = progress.bytes(format!("parsing {}", path.display()), bytes.len() as u64);
    let mut reader =
        Reader { path, positions: Vec::new(), faces: Faces::default(), corners: Vec::new(), line: 0 };
    let (mut wires, mut unknown) = (Tally::default(), Tally::default());
    let mut rest = bytes;
    let mut joined = Vec::new();
    while !rest.is_empty() {
        let mut line = next_line(&mut rest);
        reader.line += 1;
        let mut extra = 0;
        if line.ends_with(b"\\") {
            joined.clear();
            while let Some(head) = line.strip_suffix(b"\\") {
                joined.extend_from_slice(head);
                joined.push(b' ');
                extra += u64::from(!rest.is_empty());
                line = next_line(&mut rest);
            }
            joined.extend_from_slice(line);
            line = &joined;
        }
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next() {
            None => {}
            Some(b"v") => reader.vertex(words)?,
            Some(b"f" | b"fo") => reader.face(words)?,
            Some(b"p" | b"l") => wires.add(reader.place()),
            Some(word) if word[0] == b'#' || IGNORED.iter().any(|i| i.as_bytes() == word) => {}
            Some(_) => unknown.add(reader.place()),
        }
        reader.line += extra;
        if reader.line.is_multiple_of(STEP) {
            bar.set_position((bytes.len() - rest.len()) as u64);
        }
    }
    bar.finish_and_clear();
    let warnings = [
        wires.warning("points and lines, left out"),
        unknown.warning("lines that are no OBJ statement, skipped"),
    ];
    reader.faces.finish(path, reader.positions, 1, warnings.into_iter().flatten().collect())
}

/// Cuts the next line off `rest`, without its end.
fn next_line<'a>(rest: &mut &'a [u8]) -> &'a [u8] {
    let end = rest.iter().position(|&b| b == b'\n');
    let line = &rest[..end.unwrap_or(rest.len())];
    *rest = end.map_or(&[], |e| &rest[e + 1..]);
    line.strip_suffix(b"\r").unwrap_or(line)
}

struct Reader<'a> {
    path: &'a Path,
    positions: Vec<[f32; 3]>,
    faces: Faces,
    /// Corners of the face at hand.
    corners: Vec<u32>,
    line: u64,
}

impl Reader<'_> {
    fn place(&self) -> Place {
        Place { item: None, unit: "line", at: self.line }
    }

    fn invalid(&self, what: String, fix: &str) -> SceneError {
        SceneError::invalid(self.path, self.place().to_string(), what, fix)
    }

    /// `v x y z [w] [r g b]`
    fn vertex<'w>(&mut self, mut words: impl Iterator<Item = &'w [u8]>) -> Result<(), SceneError> {
        let mut p = [0.0; 3];
        for (k, x) in p.iter_mut().enumerate() {
            let Some(word) = words.next() else {
                let what = format!("a vertex of {k} coordinates instead of 3");
                return Err(
                    self.invalid(what, "the file is damaged or cut short: get it again, or mend the line")
                );
            };
            *x = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()).ok_or_else(|| {
                let what = format!("{:?} is not a number", String::from_utf8_lossy(word));
                self.invalid(what, "write coordinates as decimal numbers, with a point")
            })?;
        }
        self.positions.push(p);
        Ok(())
    }

    /// `f v v/vt v//vn v/vt/vn …`, from 1, or back from the last vertex where negative.
    fn face<'w>(&mut self, words: impl Iterator<Item = &'w [u8]>) -> Result<(), SceneError> {
        self.corners.clear();
        for word in words {
            if word[0] == b'#' {
                break;
            }
            let index = word.split(|&b| b == b'/').next().unwrap_or_default();
            let Some(i) = std::str::from_utf8(index).ok().and_then(|w| w.parse::<i64>().ok()) else {
                let what = format!("{:?} is not a vertex index", String::from_utf8_lossy(word));
                return Err(self.invalid(what, "write a face as indices: f 1 2 3, or f 1/1/1 2/2/2 3/3/3"));
            };
            let count = self.positions.len() as i64;
            let corner = if i < 0 { count.checked_add(i) } else { i.checked_sub(1) };
            match corner.and_then(|c| u32::try_from(c).ok()) {
                Some(c) => self.corners.push(c),
                None => {
                    let what = format!("a face names vertex {i}, and there are {count} so far");
                    return Err(self.invalid(
                        what,
                        "indices start at 1, or at -1 back from the last vertex: mend the line",
                    ));
                }
            }
        }
        self.faces.push(&self.corners, self.place());
        Ok(())
    }
}
