//! STL, binary and ASCII, by `stl_io`. Triangles come as the file has them, every corner a vertex of its own, bit for
//! bit; normals and attributes are passed over. The crate is handed blocks of facets in a frame of our own, for it
//! takes a binary file that begins with "solid" for ASCII, and knows neither several solids, nor upper case, nor names
//! that are no UTF-8, nor normals that are no numbers. Here too: the binary count is held against the file's size, and
//! faults get their place. ASCII coordinates must be finite.

use std::io::{self, Cursor};
use std::path::Path;

use indicatif::ProgressBar;

use super::mesh::{self, Place, Tally};
use super::{MAX_TRIANGLES, Progress, Scene, SceneError, Warning};

/// Bytes before the first triangle of a binary file: 80 of any kind, and the count.
const HEADER: usize = 84;
/// Bytes of a binary triangle.
const RECORD: usize = 50;
/// Bytes without a zero that make a file text; a binary one has zeros in its first records.
const LOOKED_AT: usize = 1024;
/// Facets that the crate gets at a time.
const BLOCK: usize = 1 << 14;
/// How the statements of an ASCII facet begin: one a line.
const FACET: [&str; 7] = ["facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet"];
const NO_STL: &str = "the file is cut short or no STL: get it again";
const DAMAGED: &str = "the file is damaged: get it again, or mend the line";

/// Reads an STL.
///
/// # Errors
/// A count that the file is too short for, an ASCII statement out of place, a coordinate that is no finite number: with
/// byte, or facet and line. No triangle.
pub(super) fn parse(path: &Path, bytes: &[u8], progress: Progress) -> Result<Scene, SceneError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let says_solid = text.trim_ascii_start().get(..5).is_some_and(|t| t.eq_ignore_ascii_case(b"solid"));
    let has_zeros = bytes[..bytes.len().min(LOOKED_AT)].contains(&0);
    let fits = count(bytes).is_some_and(|n| size(n) == bytes.len() as u64);
    let bar = progress.bytes(format!("parsing {}", path.display()), bytes.len() as u64);
    let mut soup = Soup { path, bar: &bar, corners: Vec::new() };
    let warning = if says_solid && !fits && !has_zeros {
        ascii(&mut soup, text)?;
        None
    } else {
        binary(&mut soup, bytes)?
    };
    bar.finish_and_clear();
    if soup.corners.len() as u64 > 3 * MAX_TRIANGLES {
        let what = format!("{} triangles are more than 2^30", soup.corners.len() / 3);
        return Err(SceneError::TooLarge { name: path.display().to_string(), what });
    }
    let triangles = (0..soup.corners.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh::scene(path, soup.corners, triangles, warning.into_iter().collect())
}

/// The triangles so far.
struct Soup<'a> {
    path: &'a Path,
    bar: &'a ProgressBar,
    corners: Vec<[f32; 3]>,
}

impl Soup<'_> {
    /// Takes a block of facets as an STL of its own, that ends at byte `at` of the file. An error comes with the count
    /// of facets before it.
    fn push(&mut self, stl: &[u8], at: usize) -> Result<(), (usize, io::Error)> {
        let mut block = Cursor::new(stl);
        let facets = stl_io::create_stl_reader(&mut block).map_err(|e| (0, e))?;
        for (i, facet) in facets.enumerate() {
            let facet = facet.map_err(|e| (i, e))?;
            self.corners.extend(facet.vertices.map(|v| v.0));
        }
        self.bar.set_position(at as u64);
        Ok(())
    }

    fn invalid(&self, place: impl ToString, what: String, fix: &str) -> SceneError {
        SceneError::invalid(self.path, place.to_string(), what, fix)
    }
}

/// Triangles that a binary header promises.
fn count(bytes: &[u8]) -> Option<u32> {
    bytes.get(HEADER - 4..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
}

/// Bytes of a binary file of `count` triangles.
fn size(count: u32) -> u64 {
    HEADER as u64 + u64::from(count) * RECORD as u64
}

/// Reads a binary file; what stands behind the last triangle comes back as a warning.
fn binary(soup: &mut Soup<'_>, bytes: &[u8]) -> Result<Option<Warning>, SceneError> {
    let length = bytes.len() as u64;
    let Some(count) = count(bytes) else {
        let what = format!("{length} bytes that begin neither with \"solid\" nor with a whole header");
        return Err(soup.invalid("byte 0", what, NO_STL));
    };
    let size = size(count);
    if size > length {
        let what =
            format!("the header promises {count} triangles in {size} bytes, and the file has {length}");
        return Err(soup.invalid("byte 80", what, NO_STL));
    }
    let mut at = HEADER;
    for records in bytes[HEADER..size as usize].chunks(BLOCK * RECORD) {
        let mut block = vec![b' '; HEADER - 4];
        block.extend_from_slice(&((records.len() / RECORD) as u32).to_le_bytes());
        block.extend_from_slice(records);
        let start = at;
        at += records.len();
        soup.push(&block, at)
            .map_err(|(i, e)| soup.invalid(format!("byte {}", start + i * RECORD), e.to_string(), NO_STL))?;
    }
    let mut rest = Tally::default();
    if size < length {
        rest.add(Place { item: None, unit: "byte", at: size });
    }
    let warning = rest.warning("bytes too many after the last triangle");
    Ok(warning.map(|w| Warning { count: length - size, ..w }))
}

/// Reads an ASCII file, solid by solid, a statement a line.
fn ascii(soup: &mut Soup<'_>, text: &[u8]) -> Result<(), SceneError> {
    let mut block = Block::default();
    let mut open: Option<u64> = None;
    let (mut line, mut at) = (0, 0);
    for statement in text.split_inclusive(|&b| b == b'\n') {
        line += 1;
        at += statement.len();
        let words = || statement.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        let Some(first) = words().next().map(<[u8]>::to_ascii_lowercase) else { continue };
        let place = || Place { item: None, unit: "line", at: line };
        match (first.as_slice(), open) {
            (b"solid", None) => open = Some(line),
            (b"solid", Some(start)) => {
                let what = format!("a solid starts inside the one of line {start}");
                return Err(soup.invalid(place(), what, "end each solid with endsolid"));
            }
            (_, None) => {
                let said = String::from_utf8_lossy(&first).into_owned();
                return Err(soup.invalid(place(), format!("{said:?} stands outside a solid"), DAMAGED));
            }
            (b"endsolid", Some(_)) => {
                block.hand_over(soup, at)?;
                open = None;
            }
            (keyword, Some(_)) => {
                if keyword == b"facet" && block.lines.len() >= BLOCK * FACET.len() {
                    block.hand_over(soup, at)?;
                }
                block.push(line, words());
            }
        }
    }
    if let Some(start) = open {
        let what = format!("the file ends inside the solid of line {start}");
        return Err(soup.invalid(format!("line {line}"), what, "the file is cut short: get it again"));
    }
    Ok(())
}

/// ASCII facets as the crate wants them.
#[derive(Default)]
struct Block {
    /// Lower case, one space between words, one statement a line.
    text: Vec<u8>,
    /// The file's line of each statement.
    lines: Vec<u64>,
    /// Facets handed over before.
    before: usize,
}

impl Block {
    fn push<'w>(&mut self, line: u64, words: impl Iterator<Item = &'w [u8]>) {
        if self.lines.is_empty() {
            self.text.extend_from_slice(b"solid \n");
        }
        let start = self.text.len();
        for word in words {
            self.text.extend(word.iter().map(u8::to_ascii_lowercase));
            self.text.push(b' ');
        }
        // Of a facet of no area programs write -nan, -1.#IND and what not.
        if self.text[start..].starts_with(b"facet normal ") {
            self.text.truncate(start);
            self.text.extend_from_slice(b"facet normal 0 0 0");
        }
        self.text.push(b'\n');
        self.lines.push(line);
    }

    /// Empties the block into `soup`. The last statement ends at byte `at` of the file.
    fn hand_over(&mut self, soup: &mut Soup<'_>, at: usize) -> Result<(), SceneError> {
        if self.lines.is_empty() {
            return Ok(());
        }
        let statements = self.text.len();
        self.text.extend_from_slice(b"endsolid\n");
        soup.push(&self.text, at).map_err(|(i, error)| {
            let item = Some(("facet", (self.before + i) as u64));
            let (k, what) = self.fault(&self.text[..statements], i, &error);
            let at = self.lines.get(k).or(self.lines.last()).copied().unwrap_or_default();
            soup.invalid(Place { item, unit: "line", at }, what, DAMAGED)
        })?;
        self.before += self.lines.len() / FACET.len();
        self.text.clear();
        self.lines.clear();
        Ok(())
    }

    /// The statement at fault in facet `i`, for which the crate refused it with `error`, and what is wrong there.
    fn fault(&self, text: &[u8], i: usize, error: &io::Error) -> (usize, String) {
        let first = i * FACET.len();
        let mut statements = text.split(|&b| b == b'\n').skip(1 + first);
        for (k, keyword) in FACET.iter().enumerate() {
            let said = String::from_utf8_lossy(statements.next().unwrap_or_default());
            let mut words = said.split_ascii_whitespace();
            if words.next() != Some(keyword) {
                return (first + k, format!("{:?} instead of {keyword:?}", said.trim_end()));
            }
            let finite = |w: &str| w.parse::<f32>().is_ok_and(f32::is_finite);
            if *keyword == "vertex" && (words.clone().count() != 3 || !words.all(finite)) {
                return (first + k, format!("{:?} is no vertex of 3 finite numbers", said.trim_end()));
            }
        }
        (first, error.to_string())
    }
}
