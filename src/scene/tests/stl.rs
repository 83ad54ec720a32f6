//! STL against a reader of a few lines.

use super::*;

pub(super) type Soup = Vec<[[f32; 3]; 3]>;

/// A binary STL: any header of 80 bytes.
pub(super) fn binary(header: &[u8], soup: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut out = header.to_vec();
    out.resize(80, b' ');
    out.extend_from_slice(&(soup.len() as u32).to_le_bytes());
    for (i, corners) in soup.iter().enumerate() {
        out.extend([[f32::NAN; 3]].iter().chain(corners).flatten().flat_map(|x| x.to_le_bytes()));
        out.extend_from_slice(&(i as u16).to_le_bytes());
    }
    out
}

pub(super) fn ascii(name: &str, soup: &[[[f32; 3]; 3]]) -> String {
    let vertex = |[x, y, z]: &[f32; 3]| format!("    vertex {x:e} {y} {z}\n");
    let facet = |corners: &[[f32; 3]; 3]| {
        let vertices: String = corners.iter().map(vertex).collect();
        format!("facet normal 0 0 1\n  outer loop\n{vertices}  endloop\nendfacet\n")
    };
    format!("solid {name}\n{}endsolid {name}\n", soup.iter().map(facet).collect::<String>())
}

/// The second reader: every number behind the word vertex, or every record.
pub(super) fn read_simply(bytes: &[u8]) -> Soup {
    let corners: Vec<[f32; 3]> = match std::str::from_utf8(bytes) {
        Ok(text) => {
            let lower = text.to_lowercase();
            let words: Vec<&str> = lower.split_whitespace().collect();
            let vertices = words.iter().enumerate().filter(|(_, w)| **w == "vertex");
            vertices.map(|(i, _)| [1, 2, 3].map(|k| words[i + k].parse().unwrap())).collect()
        }
        Err(_) => {
            let numbers = |r: &[u8]| -> Vec<f32> {
                r[12..48].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
            };
            let numbers: Vec<f32> = bytes[84..].chunks_exact(50).flat_map(numbers).collect();
            numbers.chunks(3).map(|v| [v[0], v[1], v[2]]).collect()
        }
    };
    corners.chunks(3).map(|c| [c[0], c[1], c[2]]).collect()
}

pub(super) fn bits(soup: &[[[f32; 3]; 3]]) -> Vec<[[u32; 3]; 3]> {
    soup.iter().map(|t| t.map(|v| v.map(f32::to_bits))).collect()
}

fn soup(s: &Scene) -> Soup {
    // As they are kept: `Scene::corners` takes denormals for 0.
    s.triangles.iter().map(|t| t.map(|v| s.positions[v as usize])).collect()
}

const TWO: [[[f32; 3]; 3]; 2] = [
    [[0.0, -0.0, 1e-40], [1.0, 0.1, f32::MAX], [0.0, 1.0, 3.4e-5]],
    [[1.0, 0.1, f32::MAX], [0.0, 1.0, 3.4e-5], [7.0, 8.0, -9.0]],
];

#[test]
fn both_kinds_bit_for_bit() {
    // More facets than one block.
    let many: Soup = (0..40_000).map(|i| TWO[i % 2].map(|v| v.map(|x| x * (i as f32 / 7.0)))).collect();
    let many: Soup = many.into_iter().filter(|t| t.iter().flatten().all(|x| x.is_finite())).collect();
    for mesh in [&TWO[..1], &TWO, &many] {
        for file in [binary(b"any", mesh), binary(b"solid of bytes", mesh), ascii("a", mesh).into_bytes()] {
            let s = read("stl", &file).unwrap();
            assert_eq!(bits(&soup(&s)), bits(mesh));
            assert_eq!(bits(&soup(&s)), bits(&read_simply(&file)));
            assert!(s.warnings.is_empty(), "{:?}", s.warnings);
        }
    }
}

proptest::proptest! {
    #[test]
    fn any_bits_in_binary_any_finite_numbers_in_ascii(
        raw in proptest::collection::vec(proptest::array::uniform9(proptest::num::u32::ANY), 1..40),
    ) {
        let mesh: Soup = raw.iter().map(|r| [0, 3, 6].map(|k| [0, 1, 2].map(|i| f32::from_bits(r[k + i])))).collect();
        proptest::prop_assert_eq!(bits(&soup(&read("stl", &binary(b"solid", &mesh)).unwrap())), bits(&mesh));
        let finite: Soup = mesh.iter().map(|t| t.map(|v| v.map(|x| if x.is_finite() { x } else { 0.5 }))).collect();
        proptest::prop_assert_eq!(bits(&soup(&read("stl", ascii("", &finite).as_bytes()).unwrap())), bits(&finite));
    }
}

#[test]
fn as_people_write_it() {
    let one = ascii("a name of words", &TWO[..1]);
    let odd = [
        one.replace('\n', "\r\n").into_bytes(),
        one.to_uppercase().into_bytes(),
        one.replace("a name of words", "").into_bytes(),
        one.replace("solid a name of words", "solid").into_bytes(),
        one.replace("normal 0 0 1", "normal -nan(ind) 1.#QNAN 0").into_bytes(),
        one.replace("endsolid a name of words\n", "endsolid").into_bytes(),
        [b"\xef\xbb\xbf\n  ", one.as_bytes()].concat(),
        one.replace('\n', "\n \t\n").into_bytes(),
        String::from("solid caf? ")
            .into_bytes()
            .into_iter()
            .map(|b| if b == b'?' { 0xe9 } else { b })
            .chain(one.bytes().skip(6))
            .collect(),
    ];
    for file in odd {
        let s = read("STL", &file).unwrap();
        assert_eq!(bits(&soup(&s)), bits(&TWO[..1]), "{}", String::from_utf8_lossy(&file));
    }
    let parts = ascii("solid", &TWO[..1]) + &ascii("", &[]) + &ascii("facet normal 1 2 3", &TWO[1..]);
    assert_eq!(bits(&soup(&read("stl", parts.as_bytes()).unwrap())), bits(&TWO));
}

#[test]
fn odd_binaries() {
    for header in [&b"solid"[..], b"SOLID", b"\0"] {
        let long = [binary(header, &TWO), vec![b'x'; 7]].concat();
        let s = read("stl", &long).unwrap();
        assert_eq!(bits(&soup(&s)), bits(&TWO));
        let warned: Vec<_> = s.warnings.iter().map(|w| (w.count, w.first.as_str())).collect();
        assert_eq!(warned, [(7, "byte 184")], "{:?}", s.warnings);
    }
    let mut nan = TWO;
    nan[1][2][0] = f32::NAN;
    let s = read("stl", &binary(b"", &nan)).unwrap();
    assert_eq!((s.triangles.len(), s.warnings[0].first.as_str()), (2, "triangle 1"));
}

#[test]
fn bad_stl_is_refused_with_its_place() {
    refused("stl", b"", &["byte 0", "0 bytes"]);
    refused("stl", &binary(b"", &TWO)[..83], &["byte 0", "83 bytes"]);
    refused("stl", &binary(b"", &TWO)[..183], &["byte 80", "promises 2 triangles in 184 bytes", "has 183"]);
    refused("stl", &binary(b"", &[]), &["no triangle"]);
    let mut absurd = binary(b"solid", &TWO);
    absurd[80..84].fill(0xff);
    refused("stl", &absurd, &["byte 80", "promises 4294967295"]);
    refused("stl", b"solid a\nendsolid\n", &["no triangle"]);
    refused("stl", b"solid", &["line 1", "cut short"]);
    let two = ascii("a", &TWO);
    let lines: Vec<&str> = two.lines().collect();
    for end in 1..lines.len() - 1 {
        refused("stl", lines[..end].join("\n").as_bytes(), &["cut short", "solid of line 1", "line "]);
    }
    let changed = |line: usize, to: &str| {
        let mut lines = lines.clone();
        lines[line - 1] = to;
        lines.join("\n").into_bytes()
    };
    refused("stl", &changed(9, "facet"), &["facet 1 (line 9)"]);
    refused("stl", &changed(10, "outer lop"), &["facet 1"]);
    refused("stl", &changed(11, "vertex 1 2"), &["facet 1 (line 11)", "no vertex of 3"]);
    refused("stl", &changed(5, "vertex 1 2 NaN"), &["facet 0 (line 5)", "no vertex of 3 finite"]);
    refused("stl", &changed(6, "vertex 1 2 1e99"), &["facet 0 (line 6)", "finite"]);
    refused("stl", &changed(6, "vertex 1 2 x"), &["facet 0 (line 6)", "\"vertex 1 2 x\""]);
    refused("stl", &changed(14, "vertex 1 2 3"), &["facet 1 (line 14)", "instead of \"endloop\""]);
    refused("stl", &changed(15, "vertex 1 2 3"), &["facet 1 (line 15)", "instead of \"endfacet\""]);
    refused("stl", &changed(8, "solid b"), &["line 8", "inside the one of line 1"]);
    refused("stl", (two.clone() + "facet normal 0 0 1\n").as_bytes(), &["line 17", "outside a solid"]);
}
