//! Walks a PLY's body value by value, and knows where it is.

use std::path::Path;

use super::header::{Element, Format, Header, Kind, Property};
use crate::scene::SceneError;
use crate::scene::mesh::Place;

const CUT_SHORT: &str = "the file is cut short or its header lies: get it again";

pub(super) struct Cursor<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    format: Format,
    /// Next byte.
    at: usize,
    /// Line of `at`, from 1; counted in ASCII only.
    line: u64,
    element: &'static str,
    /// Which of the element's items, from 0.
    item: u64,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(path: &'a Path, bytes: &'a [u8], header: &Header) -> Self {
        Self { path, bytes, format: header.format, at: header.body, line: header.line, element: "", item: 0 }
    }

    /// Starts on an element, whose count must fit the bytes that are left.
    pub(super) fn enter(&mut self, element: &Element) -> Result<(), SceneError> {
        self.element = match element.name.as_str() {
            "vertex" => "vertex",
            "face" => "face",
            _ => "element",
        };
        self.item = 0;
        // In ASCII the last value needs no separator.
        let left = self.remaining() as u64 + u64::from(self.format == Format::Ascii);
        let least = element.least_bytes(self.format);
        if element.count.checked_mul(least).is_none_or(|need| need > left) {
            let what = format!(
                "the header promises {} of element {}, at least {least} bytes each, and {} bytes are left",
                element.count,
                element.name,
                self.remaining()
            );
            return Err(self.invalid(what, CUT_SHORT));
        }
        if least == 0 && element.count > 0 && self.element != "element" {
            let what = format!("the header gives element {} no property", element.name);
            return Err(self.invalid_header(what, "mend the header"));
        }
        Ok(())
    }

    /// Room for `count` items, which [`Cursor::enter`] has bounded by the file's size.
    pub(super) fn reserve<T>(&self, items: &mut Vec<T>, count: u64) -> Result<(), SceneError> {
        items.try_reserve_exact(count as usize).map_err(|_| SceneError::TooLarge {
            name: self.path.display().to_string(),
            what: format!("its {count} vertices don't fit in memory"),
        })
    }

    pub(super) fn next_item(&mut self) {
        self.item += 1;
    }

    pub(super) fn position(&self) -> usize {
        self.at
    }

    pub(super) fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The item at hand.
    pub(super) fn place(&self) -> Place {
        Place { item: Some((self.element, self.item)), ..self.end_place() }
    }

    /// The next byte, or its line.
    pub(super) fn end_place(&self) -> Place {
        match self.format {
            Format::Ascii => Place { item: None, unit: "line", at: self.line },
            Format::Little | Format::Big => Place { item: None, unit: "byte", at: self.at as u64 },
        }
    }

    pub(super) fn invalid(&self, what: String, fix: &str) -> SceneError {
        SceneError::invalid(self.path, self.place().to_string(), what, fix)
    }

    pub(super) fn invalid_header(&self, what: String, fix: &str) -> SceneError {
        SceneError::invalid(self.path, "header", what, fix)
    }

    /// The next `N` bytes of a binary body.
    fn take<const N: usize>(&mut self) -> Result<[u8; N], SceneError> {
        match self.bytes[self.at..].first_chunk::<N>() {
            Some(&b) => {
                self.at += N;
                Ok(b)
            }
            None => Err(self.invalid("the file ends here".to_owned(), CUT_SHORT)),
        }
    }

    /// The next word of an ASCII body.
    fn word(&mut self) -> Result<&'a [u8], SceneError> {
        while let Some(b) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            self.line += u64::from(*b == b'\n');
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if end == 0 {
            return Err(self.invalid("the file ends here".to_owned(), CUT_SHORT));
        }
        self.at += end;
        Ok(&rest[..end])
    }

    /// The next value. Every type fits an f64 without loss.
    pub(super) fn scalar(&mut self, kind: Kind) -> Result<f64, SceneError> {
        let little = match self.format {
            Format::Ascii => return self.ascii(kind),
            Format::Little => true,
            Format::Big => false,
        };
        macro_rules! number {
            ($t:ty) => {{
                let b = self.take::<{ size_of::<$t>() }>()?;
                f64::from(if little { <$t>::from_le_bytes(b) } else { <$t>::from_be_bytes(b) })
            }};
        }
        Ok(match kind {
            Kind::I8 => number!(i8),
            Kind::U8 => number!(u8),
            Kind::I16 => number!(i16),
            Kind::U16 => number!(u16),
            Kind::I32 => number!(i32),
            Kind::U32 => number!(u32),
            Kind::F32 => number!(f32),
            Kind::F64 => number!(f64),
        })
    }

    fn ascii(&mut self, kind: Kind) -> Result<f64, SceneError> {
        let word = self.word()?;
        // Short integers are most of a file; the rest goes through the standard library.
        if word.len() <= 9 && word.iter().all(u8::is_ascii_digit) {
            return Ok(f64::from(word.iter().fold(0u32, |n, b| n * 10 + u32::from(b - b'0'))));
        }
        let text = std::str::from_utf8(word).ok();
        let value = match kind {
            // Straight to f32: through f64 it would be rounded twice.
            Kind::F32 => text.and_then(|t| t.parse::<f32>().ok()).map(f64::from),
            _ => text.and_then(|t| t.parse::<f64>().ok()),
        };
        value.ok_or_else(|| {
            let what = format!("{:?} is not a number", String::from_utf8_lossy(word));
            self.invalid(what, "the file is damaged: get it again, or mend the line")
        })
    }

    /// The length of the list that comes next, bounded by what is left of the file.
    pub(super) fn list_length(&mut self, property: &Property) -> Result<u64, SceneError> {
        let value = self.scalar(property.list.unwrap_or(Kind::U8))?;
        let each = match self.format {
            Format::Ascii => 2,
            Format::Little | Format::Big => property.kind.size(),
        };
        let most = (self.remaining() / each) as f64;
        if !(0.0..=most).contains(&value) || value.fract() != 0.0 {
            let what = format!("a list of {value} values, and {} bytes are left", self.remaining());
            return Err(self.invalid(what, CUT_SHORT));
        }
        Ok(value as u64)
    }

    /// Steps over a value or a list.
    pub(super) fn skip(&mut self, property: &Property) -> Result<(), SceneError> {
        let n = if property.list.is_some() { self.list_length(property)? } else { 1 };
        for _ in 0..n {
            self.scalar(property.kind)?;
        }
        Ok(())
    }
}
