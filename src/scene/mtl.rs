//! Colours of an OBJ's faces: `mtllib`, `usemtl`, and `Kd` of the material files, taken as linear light, as Blender
//! writes it; the format doesn't say. Read here, for `tobj` refuses a whole material file for one odd number in it.

use std::collections::HashMap;

use super::printable::in_line;
use super::siblings::Siblings;
use super::{Materials, Progress, Warning};

/// What the statements of an OBJ say of colours.
#[derive(Default)]
pub(super) struct Paint {
    /// Files named, with their lines.
    libraries: Vec<(u64, String)>,
    /// Number of each material's name, in the order of their first use.
    numbers: HashMap<Vec<u8>, u32>,
    /// The one in use.
    current: Option<u32>,
    /// Runs of triangles of one material.
    runs: Vec<(Option<u32>, usize)>,
}

impl Paint {
    /// Takes a `mtllib` of that line.
    pub(super) fn library(&mut self, line: u64, names: Vec<u8>) {
        self.libraries.push((line, String::from_utf8_lossy(&names).into_owned()));
    }

    /// Takes a `usemtl`.
    pub(super) fn choose(&mut self, name: Vec<u8>) {
        let next = self.numbers.len() as u32;
        self.current = Some(*self.numbers.entry(name).or_insert(next));
    }

    /// Takes a face of so many triangles.
    pub(super) fn face(&mut self, triangles: usize) {
        match self.runs.last_mut() {
            Some((material, count)) if *material == self.current => *count += triangles,
            _ => self.runs.push((self.current, triangles)),
        }
    }

    /// The colours, and what is wrong with the material files.
    pub(super) fn materials(
        self,
        siblings: Siblings<'_>,
        progress: Progress,
    ) -> (Materials, Option<Warning>) {
        if matches!(siblings, Siblings::None) {
            return Default::default();
        }
        let mut known = HashMap::new();
        let mut missing: Option<Warning> = None;
        for (line, names) in &self.libraries {
            // A name may have blanks in it, or there are many.
            let files = match siblings.read(names, progress) {
                Ok(file) => vec![Ok(file)],
                Err(_) => names.split_ascii_whitespace().map(|name| siblings.read(name, progress)).collect(),
            };
            for file in files {
                match file {
                    Ok(bytes) => known.extend(colors(&bytes)),
                    Err(what) => {
                        missing
                            .get_or_insert_with(|| Warning {
                                what: format!(
                                    "material files that can't be read, so that faces lack colours ({})",
                                    in_line(what)
                                ),
                                count: 0,
                                first: format!("line {line}"),
                            })
                            .count += 1;
                    }
                }
            }
        }
        (self.of(&known), missing)
    }

    fn of(&self, known: &HashMap<Vec<u8>, [f32; 3]>) -> Materials {
        let mut names: Vec<(&[u8], u32)> =
            self.numbers.iter().map(|(name, n)| (name.as_slice(), *n)).collect();
        names.sort_unstable_by_key(|(_, n)| *n);
        let mut colors = vec![];
        let mut indices = vec![];
        for (name, _) in names {
            let color = known.get(name);
            indices.push(color.map_or(Materials::NONE, |_| colors.len() as u32));
            colors.extend(color);
        }
        if colors.is_empty() {
            return Materials::default();
        }
        let index = |number: Option<u32>| number.map_or(Materials::NONE, |n| indices[n as usize]);
        let of_triangles = self.runs.iter().flat_map(|(m, n)| std::iter::repeat_n(index(*m), *n)).collect();
        Materials { colors, of_triangles }
    }
}

/// `Kd` of each material of a file that has one.
fn colors(bytes: &[u8]) -> HashMap<Vec<u8>, [f32; 3]> {
    let mut colors = HashMap::new();
    let mut current: &[u8] = b"";
    for line in bytes.split(|&b| b == b'\n').map(<[u8]>::trim_ascii) {
        let (keyword, rest) =
            line.split_at(line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len()));
        match keyword {
            b"newmtl" => current = rest.trim_ascii(),
            b"Kd" => {
                let words = std::str::from_utf8(rest).unwrap_or_default().split_ascii_whitespace();
                let numbers: Vec<f32> =
                    words.map_while(|w| w.parse().ok()).filter(|x: &f32| x.is_finite()).collect();
                let color = match numbers[..] {
                    [r, g, b, ..] => [r, g, b],
                    [grey] => [grey; 3],
                    _ => continue,
                };
                colors.insert(current.to_owned(), color.map(|x| x.clamp(0.0, 1.0)));
            }
            _ => {}
        }
    }
    colors
}
