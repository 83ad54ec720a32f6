//! Wavefront OBJ, positions and faces, by `tobj`; colours by [`super::mtl`]. It is handed the statements `v` and `f` alone, for it takes a line
//! of three points for a face, knows neither `\` nor a comment behind a statement, and refuses a whole file for an odd
//! colour, texture coordinate or name. It says no place: faults are looked up once it has failed.

use std::borrow::Cow;
use std::path::Path;

use super::mesh::{self, Place, Tally};
use super::mtl::Paint;
use super::siblings::Siblings;
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

/// Reads an OBJ.
///
/// # Errors
/// A coordinate or index that is no number, an index out of range: with its line. No triangle.
pub(super) fn parse(
    path: &Path,
    bytes: &[u8],
    siblings: Siblings<'_>,
    progress: Progress,
) -> Result<Scene, SceneError> {
    let mut plain = Plain::default();
    let mut paint = Paint::default();
    let (mut wires, mut unknown, mut short) = (Tally::default(), Tally::default(), Tally::default());
    for (line, text) in (Statements { rest: bytes, line: 0 }) {
        let mut words = words(&text);
        match words.next() {
            None => {}
            // No w and no colour: tobj would divide by w.
            Some(b"v") => plain.push(line, b"v", words.take(3)),
            Some(b"f" | b"fo") => match corners(words.clone()).checked_sub(2) {
                None | Some(0) => short.add(place(line)),
                Some(triangles) => {
                    paint.face(triangles);
                    plain.push(line, b"f", words);
                }
            },
            Some(b"mtllib") => paint.library(line, operand(&text)),
            Some(b"usemtl") => paint.choose(operand(&text)),
            Some(b"p" | b"l") => wires.add(place(line)),
            Some(word) if IGNORED.iter().any(|i| i.as_bytes() == word) => {}
            Some(_) => unknown.add(place(line)),
        }
    }
    let warnings: Vec<_> = [
        wires.warning("points and lines, left out"),
        unknown.warning("lines that are no OBJ statement, skipped"),
        short.warning("faces of fewer than 3 vertices, left out"),
    ]
    .into_iter()
    .flatten()
    .collect();

    // Not `single_index`: it splits a vertex whose corners differ in texture coordinate or normal.
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let bar = progress.bytes(format!("parsing {}", path.display()), plain.text.len() as u64);
    let mut rest = plain.text.as_slice();
    let read = tobj::load_obj_buf(&mut bar.wrap_read(&mut rest), &options, |_| Ok(Default::default()));
    bar.finish_and_clear();
    let (models, _) = read.map_err(|e| plain.fault(path, rest.len(), e))?;
    // One model, for no statement that starts another got this far.
    let Some(tobj::Model { mesh, .. }) = models.into_iter().find(|m| !m.mesh.indices.is_empty()) else {
        return Err(mesh::empty(path, plain.vertices(), &warnings));
    };
    let positions = mesh.positions.as_chunks().0.to_vec();
    let triangles = mesh.indices.as_chunks().0.to_vec();
    let (materials, missing) = paint.materials(siblings, progress);
    let scene = mesh::scene(path, positions, triangles, warnings.into_iter().chain(missing).collect())?;
    Ok(Scene { materials, ..scene })
}

/// What stands behind a statement's first word: one name, whatever is in it.
fn operand(text: &[u8]) -> Vec<u8> {
    let text = text.trim_ascii();
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    text[end..].trim_ascii().to_owned()
}

fn place(line: u64) -> Place {
    Place { item: None, unit: "line", at: line }
}

/// The words of a statement, up to a comment.
fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    // A vertical tab is a blank to tobj.
    text.split(|b| b.is_ascii_whitespace() || *b == 0x0b)
        .filter(|w| !w.is_empty())
        .take_while(|w| w[0] != b'#')
}

/// Corners of a face, as tobj will see them: it separates words by all of Unicode's blanks.
fn corners<'w>(words: impl Iterator<Item = &'w [u8]>) -> usize {
    let seen = |w: &[u8]| match str::from_utf8(w) {
        Ok(text) if !text.is_ascii() => text.split_whitespace().count(),
        _ => 1,
    };
    words.map(seen).sum()
}

/// Statements with the line each starts on. A `\` joins a line to the next.
struct Statements<'a> {
    rest: &'a [u8],
    line: u64,
}

impl<'a> Statements<'a> {
    fn cut(&mut self) -> &'a [u8] {
        let end = self.rest.iter().position(|&b| b == b'\n');
        let line = &self.rest[..end.unwrap_or(self.rest.len())];
        self.rest = end.map_or(&[], |e| &self.rest[e + 1..]);
        self.line += 1;
        line.strip_suffix(b"\r").unwrap_or(line)
    }
}

impl<'a> Iterator for Statements<'a> {
    type Item = (u64, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let mut text = Cow::Borrowed(self.cut());
        let first = self.line;
        while text.ends_with(b"\\") {
            let joined = text.to_mut();
            joined.pop();
            joined.push(b' ');
            joined.extend_from_slice(self.cut());
        }
        Some((first, text))
    }
}

/// What tobj reads: one statement a line.
#[derive(Default)]
struct Plain {
    text: Vec<u8>,
    /// The file's line of each.
    lines: Vec<u64>,
}

impl Plain {
    fn push<'w>(&mut self, line: u64, name: &[u8], words: impl Iterator<Item = &'w [u8]>) {
        self.text.extend_from_slice(name);
        for word in words {
            self.text.push(b' ');
            self.text.extend_from_slice(word);
        }
        self.text.push(b'\n');
        self.lines.push(line);
    }

    fn vertices(&self) -> usize {
        self.text.split(|&b| b == b'\n').filter(|s| s.starts_with(b"v ")).count()
    }

    /// The first fault up to the statement where tobj stopped with `error`, `unread` bytes before the end.
    fn fault(&self, path: &Path, unread: usize, error: tobj::LoadError) -> SceneError {
        let invalid = |line, what, fix| SceneError::invalid(path, place(line).to_string(), what, fix);
        let read = &self.text[..self.text.len() - unread];
        let all = self.vertices();
        let (mut so_far, mut last) = (0, 0);
        for (text, &line) in read.split(|&b| b == b'\n').zip(&self.lines) {
            let mut words = words(text);
            let found = if matches!(words.next(), Some(b"v")) {
                so_far += 1;
                vertex_fault(words)
            } else {
                words.find_map(|w| corner_fault(w, so_far, all))
            };
            if let Some((what, fix)) = found {
                return invalid(line, what, fix);
            }
            last = line;
        }
        invalid(last, error.to_string(), "the file is damaged: get it again, or mend the line")
    }
}

/// What is wrong with a vertex, and what to do.
fn vertex_fault<'w>(words: impl Iterator<Item = &'w [u8]> + Clone) -> Option<(String, &'static str)> {
    let count = words.clone().count();
    if count < 3 {
        let what = format!("a vertex of {count} coordinates instead of 3");
        return Some((what, "the file is damaged or cut short: get it again, or mend the line"));
    }
    let odd = words.map(String::from_utf8_lossy).find(|w| w.parse::<f32>().is_err())?;
    Some((format!("{odd:?} is not a number"), "write coordinates as decimal numbers, with a point"))
}

/// What is wrong with the corner of a face, and what to do.
fn corner_fault(word: &[u8], so_far: usize, all: usize) -> Option<(String, &'static str)> {
    let text = String::from_utf8_lossy(word);
    let parts = || text.split('/');
    let index = parts().next().and_then(|i| i.parse::<i64>().ok());
    let others = parts().skip(1).all(|i| i.is_empty() || i.parse::<i64>().is_ok());
    let (Some(i), true, ..=3) = (index, others, parts().count()) else {
        let what = format!("{text:?} is not a vertex index");
        return Some((what, "write a face as indices: f 1 2 3, or f 1/1/1 2/2/2 3/3/3"));
    };
    let count = if i < 0 { so_far } else { all };
    if i != 0 && i.unsigned_abs() <= count as u64 {
        return None;
    }
    let what = format!("a face names vertex {i}, and there are {count}");
    Some((what, "indices start at 1, or at -1 back from the last vertex: mend the line"))
}
