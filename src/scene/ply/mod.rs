//! PLY: ASCII and binary of either byte order, any properties in any order, faces of any size.
//! Not by `ply-rs-bw`: it allocates by the header's counts, names no place, and hashes every property of every vertex.

mod cursor;
mod header;

use std::path::Path;

use cursor::Cursor;
use header::{Element, Format, Header, Kind};

use super::mesh::{Faces, Tally};
use super::{Progress, Scene, SceneError};

/// Elements between two steps of the bar.
const STEP: u64 = 1 << 14;

/// Reads a PLY.
///
/// # Errors
/// A header that can't be read or promises more than the file holds, a file cut short, a value that is no number,
/// an index out of range: with line or byte. No triangle.
pub(super) fn parse(path: &Path, bytes: &[u8], progress: Progress) -> Result<Scene, SceneError> {
    let header = Header::parse(path, bytes)?;
    let bar = progress.bytes(format!("parsing {}", path.display()), bytes.len() as u64);
    let mut cursor = Cursor::new(path, bytes, &header);
    let mut positions = Vec::new();
    let mut faces = Faces::default();
    for element in &header.elements {
        cursor.enter(element)?;
        match element.name.as_str() {
            "vertex" => vertices(&mut cursor, element, &mut positions, &bar)?,
            "face" => polygons(&mut cursor, element, &mut faces, &bar)?,
            _ if element.properties.is_empty() => {}
            _ => {
                for _ in 0..element.count {
                    for p in &element.properties {
                        cursor.skip(p)?;
                    }
                    cursor.next_item();
                }
            }
        }
    }
    bar.finish_and_clear();
    let mut rest = Tally::default();
    if header.format != Format::Ascii && cursor.remaining() > 0 {
        rest.add(cursor.end_place());
    }
    let warnings = rest.warning("bytes too many after the last element: is the header's format right?");
    let warnings = warnings.map(|w| super::Warning { count: cursor.remaining() as u64, ..w });
    faces.finish(path, positions, warnings.into_iter().collect())
}

fn vertices(
    cursor: &mut Cursor<'_>,
    element: &Element,
    positions: &mut Vec<[f32; 3]>,
    bar: &indicatif::ProgressBar,
) -> Result<(), SceneError> {
    // Which coordinate each property is.
    let axis: Vec<Option<usize>> =
        element.properties.iter().map(|p| ["x", "y", "z"].iter().position(|a| *a == p.name)).collect();
    for (k, name) in ["x", "y", "z"].iter().enumerate() {
        let n = element.properties.iter().filter(|p| p.name == *name && p.list.is_none()).count();
        if n != 1 || axis.iter().filter(|a| **a == Some(k)).count() != 1 {
            let what = format!("the vertices have {n} properties {name} that are a number, and must have 1");
            return Err(cursor.invalid_header(what, "write x, y and z"));
        }
    }
    cursor.reserve(positions, element.count)?;
    for i in 0..element.count {
        let mut p = [0.0f32; 3];
        for (property, axis) in element.properties.iter().zip(&axis) {
            match axis {
                Some(k) => p[*k] = cursor.scalar(property.kind)? as f32,
                None => cursor.skip(property)?,
            }
        }
        positions.push(p);
        cursor.next_item();
        if i.is_multiple_of(STEP) {
            bar.set_position(cursor.position() as u64);
        }
    }
    Ok(())
}

fn polygons(
    cursor: &mut Cursor<'_>,
    element: &Element,
    faces: &mut Faces,
    bar: &indicatif::ProgressBar,
) -> Result<(), SceneError> {
    let named = |p: &header::Property| p.name == "vertex_indices" || p.name == "vertex_index";
    let Some(chosen) = element.properties.iter().position(|p| named(p) && p.list.is_some()) else {
        let what = "the faces have no list vertex_indices or vertex_index".to_owned();
        return Err(cursor.invalid_header(what, "export plain faces, not strips or range grids"));
    };
    if matches!(element.properties[chosen].kind, Kind::F32 | Kind::F64) {
        let what = "the faces' vertex indices are floating-point".to_owned();
        return Err(cursor.invalid_header(what, "write them as int or uint"));
    }
    faces.reserve(element.count as usize);
    let mut corners = Vec::new();
    for i in 0..element.count {
        for (k, property) in element.properties.iter().enumerate() {
            if k != chosen {
                cursor.skip(property)?;
                continue;
            }
            corners.clear();
            for _ in 0..cursor.list_length(property)? {
                let value = cursor.scalar(property.kind)?;
                if !(0.0..=4_294_967_295.0).contains(&value) || value.fract() != 0.0 {
                    let fix = "the file is damaged: get it again, or mend the index";
                    return Err(cursor.invalid(format!("{value} is not a vertex index"), fix));
                }
                corners.push(value as u32);
            }
        }
        faces.push(&corners, cursor.place());
        cursor.next_item();
        if i.is_multiple_of(STEP) {
            bar.set_position(cursor.position() as u64);
        }
    }
    Ok(())
}
