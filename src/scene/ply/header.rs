//! A PLY's header: text, from `ply` to `end_header`.

use std::path::Path;

use crate::scene::SceneError;

/// How the body is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    Little,
    Big,
}

/// A scalar type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of one in a binary body.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A value of an element, or a list of them.
#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// The type of the list's length; none: a single value.
    pub(super) list: Option<Kind>,
}

/// A kind of thing that the body holds `count` of.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// Least bytes that one takes: its values and empty lists.
    pub(super) fn least_bytes(&self, format: Format) -> u64 {
        let each = |p: &Property| match format {
            Format::Ascii => 2, // a digit and a separator
            Format::Little | Format::Big => p.list.unwrap_or(p.kind).size() as u64,
        };
        self.properties.iter().map(each).sum()
    }
}

/// What the header said.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// First byte of the body.
    pub(super) body: usize,
    /// Line of the body's first byte, from 1.
    pub(super) line: u64,
}

impl Header {
    /// Reads the header of `bytes`.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the line.
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, SceneError> {
        let mut header = Self { format: Format::Ascii, elements: Vec::new(), body: 0, line: 1 };
        let mut format = None;
        loop {
            let invalid = |what: String, fix: &str| {
                Err(SceneError::invalid(path, format!("line {} of the header", header.line), what, fix))
            };
            let rest = &bytes[header.body..];
            let Some(end) = rest.iter().position(|&b| b == b'\n') else {
                let what = if header.line == 1 {
                    "this is not a PLY file"
                } else {
                    "the file ends inside the header"
                };
                return invalid(what.to_owned(), "get the file again, or give it the extension it deserves");
            };
            let line = String::from_utf8_lossy(&rest[..end]);
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                ["ply"] if header.line == 1 => {}
                _ if header.line == 1 => {
                    let fix = "a PLY file starts with the line ply: give the file the extension it deserves";
                    return invalid("this is not a PLY file".to_owned(), fix);
                }
                ["format", name, _version] => {
                    format = Some(match name {
                        "ascii" => Format::Ascii,
                        "binary_little_endian" => Format::Little,
                        "binary_big_endian" => Format::Big,
                        _ => {
                            return invalid(
                                format!("unknown format {name:?}"),
                                "write it as ascii or binary",
                            );
                        }
                    });
                }
                [] | ["comment" | "obj_info", ..] => {}
                ["element", name, count] => {
                    let Ok(count) = count.parse() else {
                        return invalid(format!("{count:?} is not a count of {name}s"), "mend the header");
                    };
                    if header.elements.iter().any(|e| e.name == name) {
                        return invalid(format!("a second element {name}"), "mend the header");
                    }
                    header.elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
                }
                ["property", ref spec @ ..] => match (Self::property(spec), header.elements.last_mut()) {
                    (Some(p), Some(element)) => element.properties.push(p),
                    (None, _) => return invalid(format!("{line:?} is not a property"), "mend the header"),
                    (_, None) => {
                        return invalid("a property before any element".to_owned(), "mend the header");
                    }
                },
                ["end_header"] => {
                    let Some(format) = format else {
                        return invalid("no line says the format".to_owned(), "mend the header");
                    };
                    return Ok(Self { format, body: header.body + end + 1, line: header.line + 1, ..header });
                }
                _ => return invalid(format!("{line:?} is no header line"), "mend the header"),
            }
            header.body += end + 1;
            header.line += 1;
        }
    }

    fn property(spec: &[&str]) -> Option<Property> {
        let (name, kind, list) = match *spec {
            ["list", length, kind, name] => (name, kind, Some(Kind::parse(length)?)),
            [kind, name] => (name, kind, None),
            _ => return None,
        };
        if matches!(list, Some(Kind::F32 | Kind::F64)) {
            return None;
        }
        Some(Property { name: name.to_owned(), kind: Kind::parse(kind)?, list })
    }
}
