//! Words out of files, for people: a terminal obeys control characters, and marks of writing direction turn what
//! follows.

use std::borrow::Cow;
use std::fmt::{Display, Write};

/// Most characters of a file's words in a message.
const LONGEST: usize = 1000;

/// Whether a terminal might do anything but show it.
fn acts(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// `text` with characters that a terminal would obey written out (`\u{1b}`); line ends and tabs stay.
pub fn printable(text: &str) -> Cow<'_, str> {
    let acts = |c: char| acts(c) && !matches!(c, '\n' | '\t');
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if acts(c) { plain.extend(c.escape_unicode()) } else { plain.push(c) }
    }
    Cow::Owned(plain)
}

/// `words` as a part of a line, not longer than people read.
pub(crate) fn in_line(words: impl Display) -> String {
    let mut line = Line { text: String::new(), room: LONGEST };
    // It fails where the room ends.
    if write!(line, "{words}").is_err() {
        line.text.push('…');
    }
    line.text
}

/// What takes characters until its room ends.
struct Line {
    text: String,
    room: usize,
}

impl Write for Line {
    fn write_str(&mut self, words: &str) -> std::fmt::Result {
        for c in words.chars() {
            self.room = self.room.checked_sub(1).ok_or(std::fmt::Error)?;
            match c {
                '\n' | '\r' | '\t' => self.text.extend(c.escape_default()),
                c if acts(c) => self.text.extend(c.escape_unicode()),
                c => self.text.push(c),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_written_out() {
        assert_eq!(printable("a\tb\nö–"), "a\tb\nö–");
        assert!(matches!(printable("plain"), Cow::Borrowed(_)));
        assert_eq!(printable("\u{1b}]0;x\u{7}\r\u{9b}\u{202e}"), "\\u{1b}]0;x\\u{7}\\u{d}\\u{9b}\\u{202e}");
    }

    #[test]
    fn a_line_stays_a_line_and_ends() {
        assert_eq!(in_line("a\nb\r\tc\u{1b}"), "a\\nb\\r\\tc\\u{1b}");
        assert_eq!(in_line("ä".repeat(LONGEST)), "ä".repeat(LONGEST));
        let long = in_line("ä".repeat(LONGEST + 1));
        assert_eq!((long.chars().count(), long.ends_with('…')), (LONGEST + 1, true));
    }
}
