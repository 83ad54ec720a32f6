//! PLY, by `ply-rs-bw` one element at a time: ASCII (a line an element, no NaN) and binary of either byte order, any
//! properties in any order, faces of any size. Here: counts are held against the file's size before they are believed,
//! names that come twice are refused (it would read the body by the last of them), and faults get their place.

use std::io::ErrorKind;
use std::path::Path;

use indicatif::ProgressBar;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    DefaultElement, ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult,
    PropertyType, ScalarType,
};

use super::mesh::{Faces, Place, Tally};
use super::{Progress, Scene, SceneError, Warning};

/// Elements between two steps of the bar.
const STEP: u64 = 1 << 14;
const CUT_SHORT: &str = "the file is cut short or its header lies: get it again";
const AXES: [&str; 3] = ["x", "y", "z"];

/// Reads a PLY.
///
/// # Errors
/// A header that can't be read or promises more than the file holds, a file cut short, a value that is no number,
/// an index out of range: with line or byte. No triangle.
pub(super) fn parse(path: &Path, bytes: &[u8], progress: Progress) -> Result<Scene, SceneError> {
    let (header, at) = header(path, bytes)?;
    let bar = progress.bytes(format!("parsing {}", path.display()), bytes.len() as u64);
    let mut body = Body::new(path, bytes, &header, at, &bar);
    let mut positions = Vec::new();
    let mut faces = Faces::default();
    for element in header.elements.values() {
        body.enter(element)?;
        match element.name.as_str() {
            "vertex" => vertices(&mut body, element, &mut positions)?,
            "face" => polygons(&mut body, element, &mut faces)?,
            _ if element.properties.is_empty() => {}
            _ => (0..element.count).try_for_each(|_| body.next::<Skipped>(element).map(drop))?,
        }
    }
    bar.finish_and_clear();
    let mut rest = Tally::default();
    if header.encoding != Encoding::Ascii && body.remaining() > 0 {
        rest.add(Place { item: None, unit: "byte", at: body.at as u64 });
    }
    let warning = rest.warning("bytes too many after the last element: is the header's format right?");
    let warning = warning.map(|w| Warning { count: body.remaining() as u64, ..w });
    faces.finish(path, positions, warning.into_iter().collect())
}

/// The header and where the body starts.
fn header(path: &Path, bytes: &[u8]) -> Result<(Header, usize), SceneError> {
    let mut reader = Reader::new(bytes);
    let read = Parser::<DefaultElement>::new().read_header(&mut reader);
    // It reads line by line, so the last one read is the one at fault.
    let text = String::from_utf8_lossy(&bytes[..bytes.len() - reader.get_ref().len()]);
    let header = read.map_err(|e| {
        let place = format!("line {} of the header", text.lines().count().max(1));
        let (what, fix) = if text.lines().nth(1).is_none() {
            ("this is not a PLY file".to_owned(), "a PLY file starts with the line ply: rename it")
        } else if e.kind() == ErrorKind::UnexpectedEof || !text.ends_with('\n') {
            ("the file ends inside the header".to_owned(), "get the file again")
        } else {
            (refusal(text.lines().last().unwrap_or_default(), &e), "mend the header")
        };
        SceneError::invalid(path, place, what, fix)
    })?;
    let named = |word| text.lines().filter(|l| l.split_ascii_whitespace().next() == Some(word)).count();
    let properties: usize = header.elements.values().map(|e| e.properties.len()).sum();
    if (named("element"), named("property")) != (header.elements.len(), properties) {
        let what = "an element or a property is there twice";
        return Err(SceneError::invalid(path, "header", what, "rename one of the two"));
    }
    Ok((header, text.len()))
}

/// Why the library refused `line`, in its words less the place, the line again and its grammar's inside.
fn refusal(line: &str, error: &ParseError) -> String {
    let said = error.to_string();
    let said = error.line().and_then(|n| said.strip_prefix(&format!("Line {n}: "))).unwrap_or(&said);
    let noise = |l: &&str| *l == "'" || l.starts_with("String:") || l.starts_with("Error: ParseError");
    let said = said.lines().map(str::trim).filter(|l| !noise(l)).collect::<Vec<_>>().join(" ");
    let line: String = line.chars().take(80).collect();
    format!("{line:?}: {said}")
}

/// A vertex; other properties are passed over.
struct Vertex([f32; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([0.0; 3])
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        match (AXES.iter().position(|a| *a == name), value.to_f32_lossy()) {
            (Some(k), Some(x)) => self.0[k] = x,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// A face's corners; none: an index is negative.
struct Face(Option<Vec<u32>>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(None)
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !is_corners(name) {
            return PropertyAccessResult::Ignored;
        }
        self.0 = value.to_u32_list();
        PropertyAccessResult::Set
    }
}

/// An element that says nothing about triangles.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

fn is_corners(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

fn vertices(
    body: &mut Body<'_>,
    element: &ElementDef,
    positions: &mut Vec<[f32; 3]>,
) -> Result<(), SceneError> {
    let number =
        |a: &str| element.properties.get(a).is_some_and(|p| matches!(p.data_type, PropertyType::Scalar(_)));
    let lacking: Vec<_> = AXES.into_iter().filter(|a| !number(a)).collect();
    if !lacking.is_empty() {
        let what = format!("the vertices have no numbers as properties {}", lacking.join(", "));
        return Err(body.invalid_header(what, "write x, y and z"));
    }
    // The count is bounded by the file's size since `enter`.
    positions.try_reserve_exact(element.count).map_err(|_| SceneError::TooLarge {
        name: body.path.display().to_string(),
        what: format!("its {} vertices don't fit in memory", element.count),
    })?;
    for _ in 0..element.count {
        positions.push(body.next::<Vertex>(element)?.0);
    }
    Ok(())
}

fn polygons(body: &mut Body<'_>, element: &ElementDef, faces: &mut Faces) -> Result<(), SceneError> {
    let mut corners = element.properties.values().filter(|p| is_corners(&p.name)).map(|p| &p.data_type);
    match (corners.next(), corners.next()) {
        (Some(PropertyType::List(_, ScalarType::Float | ScalarType::Double)), None) => {
            let what = "the faces' vertex indices are floating-point".to_owned();
            return Err(body.invalid_header(what, "write them as int or uint"));
        }
        (Some(PropertyType::List(..)), None) => {}
        (_, Some(_)) => {
            let what = "the faces have both vertex_indices and vertex_index".to_owned();
            return Err(body.invalid_header(what, "rename one of the two"));
        }
        _ => {
            let what = "the faces have no list vertex_indices or vertex_index".to_owned();
            return Err(body.invalid_header(what, "export plain faces, not strips or range grids"));
        }
    }
    faces.reserve(element.count);
    for _ in 0..element.count {
        let Face(Some(corners)) = body.next(element)? else {
            let fix = "the file is damaged: get it again, or mend the index";
            return Err(body.invalid("a vertex index is negative".to_owned(), fix));
        };
        faces.push(&corners, body.place);
    }
    Ok(())
}

/// Walks the body element by element, and knows where it is.
struct Body<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    encoding: Encoding,
    bar: &'a ProgressBar,
    /// Next byte.
    at: usize,
    /// Lines before `at`; counted in ASCII only.
    lines: u64,
    element: &'static str,
    /// How many of the element were begun.
    begun: u64,
    /// The one begun last.
    place: Place,
}

impl<'a> Body<'a> {
    fn new(path: &'a Path, bytes: &'a [u8], header: &Header, at: usize, bar: &'a ProgressBar) -> Self {
        let lines = bytes[..at].iter().filter(|b| **b == b'\n').count() as u64;
        let place = Place { item: None, unit: "byte", at: at as u64 };
        Self { path, bytes, encoding: header.encoding, bar, at, lines, element: "", begun: 0, place }
    }

    fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn invalid(&self, what: String, fix: &str) -> SceneError {
        SceneError::invalid(self.path, self.place.to_string(), what, fix)
    }

    fn invalid_header(&self, what: String, fix: &str) -> SceneError {
        SceneError::invalid(self.path, "header", what, fix)
    }

    /// Starts on an element, whose count must fit the bytes that are left.
    fn enter(&mut self, element: &ElementDef) -> Result<(), SceneError> {
        self.element = match element.name.as_str() {
            "vertex" => "vertex",
            "face" => "face",
            _ => "element",
        };
        self.begun = 0;
        let least = least_bytes(element, self.encoding);
        // In ASCII the last value needs no separator.
        let left = self.remaining() as u64 + u64::from(self.encoding == Encoding::Ascii);
        if (element.count as u64).checked_mul(least).is_none_or(|need| need > left) {
            let what = format!(
                "the header promises {} of element {}, at least {least} bytes each, and {} bytes are left",
                element.count,
                element.name,
                self.remaining()
            );
            return Err(self.invalid_header(what, CUT_SHORT));
        }
        if least == 0 && element.count > 0 && self.element != "element" {
            let what = format!("the header gives element {} no property", element.name);
            return Err(self.invalid_header(what, "mend the header"));
        }
        Ok(())
    }

    /// The next of `element`, which must have a property: the library would take a binary one from no bytes.
    fn next<E: PropertyAccess>(&mut self, element: &ElementDef) -> Result<E, SceneError> {
        let item = Some((self.element, self.begun));
        self.begun += 1;
        if self.begun.is_multiple_of(STEP) {
            self.bar.set_position(self.at as u64);
        }
        self.place = Place { item, unit: "byte", at: self.at as u64 };
        let parser = Parser::<E>::new();
        let mut rest = &self.bytes[self.at..];
        let read = match self.encoding {
            Encoding::Ascii => {
                let line = self.next_line();
                self.place = Place { item, unit: "line", at: self.lines };
                let Some(line) = line else {
                    return Err(self.invalid("the file ends here".to_owned(), CUT_SHORT));
                };
                let line = String::from_utf8_lossy(line);
                return parser.read_ascii_element(&line, element).map_err(|e| {
                    self.invalid(refusal(&line, &e), "the file is damaged: get it again, or mend the line")
                });
            }
            Encoding::BinaryLittleEndian => parser.read_little_endian_element(&mut rest, element),
            Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut rest, element),
        };
        self.at = self.bytes.len() - rest.len();
        read.map_err(|e| match e.kind() {
            ErrorKind::UnexpectedEof => self.invalid("the file ends inside it".to_owned(), CUT_SHORT),
            _ => self.invalid(e.to_string(), "the file is damaged: get it again"),
        })
    }

    /// The next line that is not blank.
    fn next_line(&mut self) -> Option<&'a [u8]> {
        while self.remaining() > 0 {
            let rest = &self.bytes[self.at..];
            let end = rest.iter().position(|&b| b == b'\n').map_or(rest.len(), |e| e + 1);
            self.at += end;
            self.lines += 1;
            let line = rest[..end].trim_ascii();
            if !line.is_empty() {
                return Some(line);
            }
        }
        None
    }
}

/// Least bytes that one takes: its values and empty lists.
fn least_bytes(element: &ElementDef, encoding: Encoding) -> u64 {
    let each = |t: &PropertyType| match (encoding, t) {
        (Encoding::Ascii, _) => 2, // a digit and a separator
        (_, PropertyType::Scalar(t) | PropertyType::List(t, _)) => match t {
            ScalarType::Char | ScalarType::UChar => 1,
            ScalarType::Short | ScalarType::UShort => 2,
            ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
            ScalarType::Double => 8,
        },
    };
    element.properties.values().map(|p| each(&p.data_type)).sum()
}
