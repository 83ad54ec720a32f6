//! Wavefront OBJ, an object and a material a part, and the material file beside it.

use super::{Part, halves};
use std::fmt::Write;

/// OBJ of `parts` as triangles; `library` is its material file's name, see [`mtl`]. Positions keep all their digits.
pub fn obj(parts: &[Part], library: &str) -> Vec<u8> {
    let mut out = format!("mtllib {library}\n");
    let mut first = 1;
    // Writing to a string can't fail.
    for part in parts {
        let _ = writeln!(out, "o {}\nusemtl {0}", part.name);
        for [x, y, z] in &part.positions {
            let _ = writeln!(out, "v {x} {y} {z}");
        }
        for [a, b, c] in part.faces.iter().flat_map(|f| halves(*f)).map(|t| t.map(|v| first + u64::from(v))) {
            let _ = writeln!(out, "f {a} {b} {c}");
        }
        first += part.positions.len() as u64;
    }
    out.into_bytes()
}

/// The materials of `parts`: diffuse colours and opacities.
pub fn mtl(parts: &[Part]) -> Vec<u8> {
    let material = |part: &Part| {
        let [r, g, b, opacity] = part.color;
        format!("newmtl {}\nKd {r} {g} {b}\nd {opacity}\n", part.name)
    };
    parts.iter().map(material).collect::<String>().into_bytes()
}
