//! matplotlib's sample of a terrain, an archive of NumPy arrays: heights on a grid, by `zip` and `npyz`, made a mesh.
//! East is +x, up is +y, south is +z, in metres; the middle of the grid at x = z = 0. Row 0 is taken for the northern
//! edge, as matplotlib's own pictures have it.

use std::io::{Cursor, Read};
use std::path::Path;

use npyz::{Deserialize, NpyFile};
use zip::ZipArchive;

use super::procedural::trig::sin_cos;
use super::{Scene, SceneError, mesh};

/// Metres of a degree of latitude: mean radius of the Earth (IUGG), 6371.0088 km, times π/180.
const DEGREE: f64 = 111_195.079_7;
/// Rows and columns at most: the sample has 344 × 403.
const LARGEST: u64 = 1 << 12;
/// Bytes of an array's header at most: NumPy's have 128.
const HEADER: u64 = 1 << 10;
/// Brackets in it at most: one shape in one dictionary has 4.
const BRACKETS: usize = 16;

/// Reads the archive: `elevation` in metres, rows from the north; `dx`, `dy` of a cell and `ymin`, `ymax`, degrees.
///
/// # Errors
/// A damaged archive, an array that is missing or not of that kind. No triangle.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Scene, SceneError> {
    let damaged = |place: &str, what: String| SceneError::invalid(path, place, what, "get it again");
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| damaged("archive", e.to_string()))?;
    let mut number = |name: &str| -> Result<f64, SceneError> {
        let (values, _) = array::<f64>(&mut archive, name, 1).map_err(|what| damaged(name, what))?;
        let number = values.first().copied().filter(|x| x.is_finite());
        number.ok_or_else(|| damaged(name, "it is no finite number".to_owned()))
    };
    let (dx, dy, south, north) = (number("dx")?, number("dy")?, number("ymin")?, number("ymax")?);
    let (heights, shape) = array::<i16>(&mut archive, "elevation", LARGEST * LARGEST)
        .map_err(|what| damaged("elevation", what))?;
    let [rows, columns] = shape[..] else {
        return Err(damaged("elevation", format!("an array of {} axes instead of 2", shape.len())));
    };
    let across = dx * DEGREE * sin_cos((south + north) / 720.0).1;
    let (positions, triangles) = grid(&heights, [rows as usize, columns as usize], [across, dy * DEGREE]);
    mesh::scene(path, positions, triangles, Vec::new())
}

/// The array `name` of at most so many numbers, row by row, and its shape.
fn array<T: Deserialize>(
    archive: &mut ZipArchive<Cursor<&[u8]>>,
    name: &str,
    most: u64,
) -> Result<(Vec<T>, Vec<u64>), String> {
    let member = archive.by_name(&format!("{name}.npy")).map_err(|e| e.to_string())?;
    let mut bytes = vec![];
    member.take(HEADER + most * size_of::<T>() as u64).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    must_be_plain(&bytes)?;
    let file = NpyFile::new(&bytes[..]).map_err(|e| e.to_string())?;
    let shape = file.shape().to_vec();
    let count = shape.iter().try_fold(1, |count: u64, n| count.checked_mul(*n));
    let small = count.is_some_and(|n| n <= most) && shape.iter().all(|n| (1..=LARGEST).contains(n));
    if file.order() != npyz::Order::C || !small {
        return Err(format!("an array of shape {shape:?}, which no terrain has"));
    }
    Ok((file.into_vec().map_err(|e| e.to_string())?, shape))
}

/// Refuses what the crate would make room for, descend into or multiply as the file likes: a header of any length,
/// brackets in brackets, axes.
fn must_be_plain(npy: &[u8]) -> Result<(), String> {
    // Six bytes of magic, the version, and the header's length: of two bytes, from version 2 on of four.
    let start = if npy.get(6).is_some_and(|version| *version < 2) { 10 } else { 12 };
    let length = npy.get(8..start).ok_or("it is cut short")?;
    let length = length.iter().rev().fold(0, |length, byte| length << 8 | u64::from(*byte));
    let header = usize::try_from(length).ok().and_then(|n| npy[start..].get(..n));
    let header = header.filter(|_| length <= HEADER).ok_or(format!("a header of {length} bytes"))?;
    let brackets = header.iter().filter(|b| b"([{".contains(b)).count();
    if brackets > BRACKETS {
        return Err(format!("a header with {brackets} brackets"));
    }
    // Of the axes' product it takes the last 64 bits.
    let words = header.split(|b| !b.is_ascii_alphanumeric() && *b != b'_');
    let numbers = words.filter(|w| w.first().is_some_and(u8::is_ascii_digit));
    let number = |word| str::from_utf8(word).ok()?.parse::<u64>().ok();
    let product = numbers.map(number).try_fold(1, |product: u64, n| product.checked_mul(n?.max(1)));
    product.map(drop).ok_or_else(|| "an array of a shape which no terrain has".to_owned())
}

/// Two triangles a cell, anticlockwise from above.
fn grid(heights: &[i16], [rows, columns]: [usize; 2], [dx, dz]: [f64; 2]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let place = |i: usize, n: usize, step: f64| ((i as f64 - (n - 1) as f64 / 2.0) * step) as f32;
    let vertex = |(i, h): (usize, &i16)| {
        [place(i % columns, columns, dx), f32::from(*h), place(i / columns, rows, dz)]
    };
    let positions = heights.iter().enumerate().map(vertex).collect();
    let cells = (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |c| (row * columns + c) as u32));
    let triangles = cells.flat_map(|a| {
        let (b, c) = (a + 1, a + columns as u32);
        [[a, c, b], [b, c, c + 1]]
    });
    (positions, triangles.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use zip::write::{SimpleFileOptions, ZipWriter};

    fn npy(kind: &str, shape: &str, values: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
        let header = format!("{header:<117}\n");
        [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), values].concat()
    }

    fn archive(members: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in members {
            zip.start_file(format!("{name}.npy"), SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    fn hill() -> Vec<(&'static str, Vec<u8>)> {
        let number = |x: f64| npy("<f8", "()", &x.to_le_bytes());
        let heights: Vec<u8> = [10i16, 20, 30, 40, 50, -60].iter().flat_map(|h| h.to_le_bytes()).collect();
        vec![
            ("elevation", npy("<i2", "(2, 3)", &heights)),
            ("dx", number(0.001)),
            ("dy", number(0.001)),
            ("ymin", number(59.0)),
            ("ymax", number(61.0)),
        ]
    }

    #[test]
    fn heights_become_metres() {
        let s = parse(Path::new("a.npz"), &archive(&hill())).unwrap();
        assert_eq!(s.triangles, [[0, 3, 1], [1, 3, 4], [1, 4, 2], [2, 4, 5]]);
        // At 60° a degree of longitude is half as long.
        let cell = [55.597_54f32, 111.195_08];
        let [x, y, z] = s.positions[5];
        assert!((x - cell[0]).abs() < 1e-4 && y == -60.0 && (z - cell[1] / 2.0).abs() < 1e-4, "{x} {y} {z}");
        assert_eq!(s.positions[0], [-x, 10.0, -z]);
    }

    #[test]
    fn damage_is_named() {
        let says = |members: &[(&str, Vec<u8>)], text: &str| {
            let error = parse(Path::new("a.npz"), &archive(members)).unwrap_err().to_string();
            assert!(error.contains(text), "{error}");
        };
        says(&hill()[..4], "ymax");
        let mut flat = hill();
        flat[0].1 = npy("<i2", "(6,)", &[0; 12]);
        says(&flat, "1 axes");
        flat[0].1 = npy("<i2", "(2, 3)", &[0; 11]);
        says(&flat, "elevation");
        flat[0].1 = npy("<i2", "(1, 6)", &[0; 12]);
        says(&flat, "no triangle");
        // More than there is room for, or than fits 64 bits.
        for shape in ["(4097, 2)", "(100000, 100000)", "(4096, 4096, 4096, 4096, 4096, 4096)", "(2, 0)"] {
            flat[0].1 = npy("<i2", shape, &[0; 64]);
            says(&flat, "which no terrain has");
        }
        flat[0].1 = npy("<i2", "(4096, 4096)", &[0; 64]);
        says(&flat, "elevation");
        // A header of 4 GiB, and one that goes deep.
        flat[0].1 = [b"\x93NUMPY\x02\x00", &[0xff; 4][..], &[b' '; 300]].concat();
        says(&flat, "a header of 4294967295 bytes");
        flat[0].1 = npy("<i2", &"(".repeat(900), &[]);
        says(&flat, "brackets");
        let mut many = hill();
        many[1].1 = npy("<f8", "(4000,)", &[0; 32_000]);
        says(&many, "which no terrain has");
        let whole = archive(&hill());
        for end in 0..whole.len() {
            assert!(parse(Path::new("a.npz"), &whole[..end]).is_err(), "{end} bytes");
        }
    }
}
