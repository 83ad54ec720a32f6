//! Files, sound and damaged, through the front door.

use std::fs;
use std::path::PathBuf;

use super::siblings::Siblings;
use super::{Options, Progress, Scene, SceneError, open};

mod gltf;
mod hostile;
mod mtl;
mod packed;
mod soup;
mod stl;
mod write;

const QUIET: Options = Options { progress: Progress::Quiet, cache: None };

const CUBE_CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.5, 0.0], [0.0, 1.0, -2.0]];

/// Opens `bytes` as a file of that extension.
fn read(extension: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join(format!("mesh.{extension}"));
    fs::write(&path, bytes).unwrap();
    open(path.to_str().unwrap(), &QUIET)
}

#[track_caller]
fn refused(extension: &str, bytes: &[u8], says: &[&str]) {
    let error = read(extension, bytes).unwrap_err().to_string();
    for s in says.iter().chain(&["mesh."]) {
        assert!(error.contains(s), "{error:?} does not say {s:?}");
    }
}

/// A square as a PLY: properties out of order, wide types, one unwanted list, faces of 4 and of 2.
fn ply(format: &str) -> Vec<u8> {
    let header = format!(
        "ply\r\nformat {format} 1.0\ncomment a square\nelement camera 1\nproperty uchar a\n\
         element vertex 4\nproperty double z\nproperty list uchar short odd\nproperty float x\nproperty uchar red\n\
         property float y\nelement face 2\nproperty uchar flags\nproperty list ushort int vertex_indices\nend_header\n"
    );
    let mut out = header.into_bytes();
    let big = format.contains("big");
    let mut put = |little: &[u8], text: String| {
        if format == "ascii" {
            out.extend_from_slice(format!("{text} ").as_bytes());
        } else {
            out.extend(little.iter().rev().filter(|_| big).chain(little.iter().filter(|_| !big)));
        }
    };
    put(&[9], "9\n".into());
    for (i, [x, y, z]) in CUBE_CORNERS.into_iter().enumerate() {
        put(&f64::from(z).to_le_bytes(), z.to_string());
        put(&[i as u8], i.to_string());
        for k in 0..i as i16 {
            put(&(-k).to_le_bytes(), (-k).to_string());
        }
        put(&x.to_le_bytes(), x.to_string());
        put(&[200], "200".into());
        put(&y.to_le_bytes(), format!("{y}\r\n"));
    }
    for face in [&[0, 1, 2, 3][..], &[1, 2]] {
        put(&[1], "1".into());
        put(&(face.len() as u16).to_le_bytes(), face.len().to_string());
        for &v in face {
            let v: i32 = v;
            put(&v.to_le_bytes(), v.to_string());
        }
        put(&[], "\n".into());
    }
    out
}

const PLY_FORMATS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

const OBJ: &str = "# a square\r\nmtllib none.mtl\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1.5 0\n  v 0 1.0e0 -2\nvn 0 0 1\n\
    o one\ng two\nusemtl red\ns off\nf 1/1/1 2//1 3 \\\n 4\nf -4 -3\nl 1 2\nf -4 -3 -2 # last\n";

fn tri() -> Vec<u8> {
    [0, 1, 2, 0, 2, 3].iter().flat_map(|&v: &usize| CUBE_CORNERS[v]).flat_map(f32::to_le_bytes).collect()
}

/// A sound file of each format, with its extension.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let mut files: Vec<(&str, Vec<u8>)> = PLY_FORMATS.iter().map(|f| ("ply", ply(f))).collect();
    files.push(("obj", OBJ.as_bytes().to_vec()));
    files.push(("tri", tri()));
    let soup = [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v: usize| CUBE_CORNERS[v]));
    files.push(("stl", stl::binary(b"", &soup)));
    files.push(("stl", stl::ascii("square", &soup).into_bytes()));
    let (doc, bin) = gltf::plain(soup.as_flattened());
    files.push(("gltf", gltf::embedded(&doc, &bin)));
    files.push(("glb", gltf::glb(&doc, &bin)));
    files
}

#[test]
fn ply_both_ways_and_ascii() {
    for format in PLY_FORMATS {
        let s = read("PLY", &ply(format)).unwrap();
        assert_eq!(s.positions, CUBE_CORNERS, "{format}");
        assert_eq!(s.triangles, [[0, 1, 2], [0, 2, 3]], "{format}");
        assert_eq!(s.warnings.len(), 1, "{:?}", s.warnings);
        assert_eq!(s.warnings[0].count, 1);
        assert!(s.warnings[0].first.starts_with("face 1 ("), "{:?}", s.warnings);
    }
}

#[test]
fn obj_as_people_write_it() {
    let s = read("Obj", OBJ.as_bytes()).unwrap();
    assert_eq!(s.positions, CUBE_CORNERS);
    assert_eq!(s.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    let warned: Vec<_> = s.warnings.iter().map(|w| (w.count, w.first.as_str())).collect();
    assert_eq!(warned, [(1, "line 15"), (1, "line 14"), (1, "line 2")], "{:?}", s.warnings);
}

#[test]
fn obj_corners_come_in_the_order_of_the_faces() {
    let vertices = [[0.1, 1e-3, 7.0], [1.0, 0.0, 0.0], [1.0, 1.5, 0.0], [0.3, 1.0, -2.0], [5.0, 5.0, 5.0f32]];
    let text: String = vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z} 2\n")).collect();
    let s = read("obj", (text + "vt 0\nf 1/1 2 3 4\no b\nf 5 4 3\nl 1 2 3\ng \nf -1 -2 -4\nf\n").as_bytes())
        .unwrap();
    let corners: Vec<_> = (0..s.triangles.len()).map(|i| s.corners(i)).collect();
    let faces = [[0, 1, 2], [0, 2, 3], [4, 3, 2], [4, 3, 1]];
    assert_eq!(corners, faces.map(|f| f.map(|v: usize| vertices[v])));
    assert_eq!(s.positions.len(), 5, "a vertex was split");
}

#[test]
fn obj_of_any_bytes_in_names_and_comments() {
    let latin = b"# caf\xe9\nmtllib \xe9\nusemtl\nv 0 0 0 1 1\nv 1 0 0 # \xe9\nv 0 1 0\ng \xe9\nf 1 2 3\n";
    assert_eq!(read("obj", latin).unwrap().triangles, [[0, 1, 2]]);
    refused("obj", b"v 0 0 0\nv 0 0 \xe9\n", &["line 2", "not a number"]);
    refused("obj", b"v 0 0 0\nf 1 1 1/1/1/1\n", &["line 2", "not a vertex index"]);
}

#[test]
fn tri_is_a_soup() {
    let s = read("tri", &tri()).unwrap();
    assert_eq!(s.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(s.corners(1), [CUBE_CORNERS[0], CUBE_CORNERS[2], CUBE_CORNERS[3]]);
    refused("tri", &tri()[..71], &["byte 36", "triangle 1", "71 bytes"]);
    refused("tri", b"", &["no triangle"]);
}

#[test]
fn denormal_coordinates_count_as_zero() {
    let least = f32::MIN_POSITIVE;
    let positions = vec![[least, -least, 1.0], [least.next_down(), -1e-44, f32::from_bits(1)]];
    let scene = Scene { positions, triangles: vec![[0, 1, 1]], ..Scene::default() };
    let bits = scene.corners(0).map(|p| p.map(f32::to_bits));
    assert_eq!(bits[0], [least, -least, 1.0].map(f32::to_bits));
    assert_eq!(bits[1], [0.0f32, -0.0, 0.0].map(f32::to_bits));
}

#[test]
fn odd_triangles_stay_in_the_numbering() {
    let mut soup = tri();
    soup[4..8].copy_from_slice(&f32::NAN.to_le_bytes());
    let s = read("tri", &soup).unwrap();
    assert_eq!((s.triangles.len(), s.warnings[0].count, s.warnings[0].first.as_str()), (2, 1, "triangle 0"));
    assert!(s.bounds().lo.iter().all(|x| x.is_finite()));
    let s = read("obj", b"v 0 0 0\nv 1 0 0\nv inf 1e99 nan\nv 1 1 1\nf 1 2 4\nf 1 2 3\n").unwrap();
    assert_eq!((s.triangles.len(), s.warnings[0].first.as_str()), (2, "triangle 1"));
}

#[test]
fn bad_obj_is_refused_with_its_line() {
    refused("obj", b"", &["no triangle"]);
    refused("obj", b"v 0 0 0\n", &["no triangle", "1 vertices"]);
    refused("obj", b"v 0 0 0\nv 1 0\n", &["line 2", "2 coordinates"]);
    refused("obj", b"\nv 0 0 x\n", &["line 2", "\"x\" is not a number"]);
    refused("obj", b"v 0 0 0\nf 1 1 2\nf 1 1 1\n", &["line 2", "vertex 2, and there are 1"]);
    refused("obj", b"v 0 0 0\nf 1 1 0\n", &["line 2", "start at 1"]);
    refused("obj", b"v 0 0 0\nf 1 1 -2\n", &["line 2", "vertex -2"]);
    refused("obj", b"v 0 0 0\nf 1 1 99999999999\n", &["line 2"]);
    refused("obj", b"v 0 0 0\nf 1 1 -9223372036854775808\n", &["line 2"]);
    refused("obj", b"v 0 0 0\nf 1 /1 1\n", &["line 2", "not a vertex index"]);
    refused("obj", &[0xff, 0, 0xfe, b'\n', 7], &["no triangle", "no OBJ statement"]);
}

#[test]
fn bad_ply_is_refused_with_its_place() {
    let body = |header: &str, body: &[u8]| [header.as_bytes(), body].concat();
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let head = |vertices: u64, faces: u64, format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\n{xyz}element face {faces}\n\
             property list uchar uint vertex_index\nend_header\n"
        )
    };
    refused("ply", b"", &["line 1", "not a PLY"]);
    refused("ply", b"v 0 0 0\n", &["line 1", "not a PLY"]);
    refused("ply", b"ply\nformat ascii 1.0\nelement vertex", &["line 3", "ends inside the header"]);
    refused("ply", b"ply\nformat asci 1.0\n", &["line 2", "asci"]);
    refused("ply", b"ply\nelement vertex -1\n", &["line 2", "-1"]);
    refused("ply", b"ply\nproperty float x\n", &["line 2", "without preceding element"]);
    refused("ply", b"ply\nend_header\n", &["line 2", "format"]);
    for twice in ["element vertex 1", "element face 1", "property float y"] {
        let header = head(1, 1, "ascii").replace("element face", &format!("{twice}\nelement face"));
        refused("ply", header.as_bytes(), &["header", "twice"]);
    }
    let signed = head(1, 1, "binary_little_endian").replace("uchar uint", "uchar char");
    refused(
        "ply",
        &body(&signed, &[[0; 12].as_slice(), &[3, 0, 0, 0xff]].concat()),
        &["face 0 (byte", "negative"],
    );
    let wide = head(0, 1, "binary_big_endian").replace("uchar uint", "int uint");
    refused("ply", &body(&wide, &[0xff, 0xff, 0xff, 0xfe]), &["face 0 (byte", "negative"]);
    refused("ply", &body(&wide, &[0x7f, 0xff, 0xff, 0xff, 0, 0]), &["face 0 (byte", "ends"]);
    // The library would read elements of no property for ever.
    let hollow = head(0, 0, "binary_little_endian")
        .replace("end_header", &format!("element e {}\nend_header", u64::MAX));
    refused("ply", hollow.as_bytes(), &["no triangle"]);
    for format in PLY_FORMATS {
        for absurd in [1 << 20, u64::MAX / 12, u64::MAX] {
            refused("ply", head(absurd, 1, format).as_bytes(), &["promises", "vertex"]);
            refused("ply", head(0, absurd, format).as_bytes(), &["promises", "face"]);
        }
        refused("ply", head(0, 0, format).as_bytes(), &["no triangle"]);
    }
    refused(
        "ply",
        &body(&head(1, 1, "ascii"), b"0 0 0\n3 0 0 1\n"),
        &["face 0 (line 11)", "vertex 1, and there are 1"],
    );
    refused("ply", &body(&head(1, 1, "ascii"), b"0 0 zero\n3 0 0 0\n"), &["vertex 0 (line 10)", "zero"]);
    refused("ply", &body(&head(1, 1, "ascii"), b"0 0 0\n3 0 0\n"), &["face 0 (line 11)", "3 list elements"]);
    refused(
        "ply",
        &body(&head(1, 1, "ascii"), b"0 0 0\n4000000000 0 0\n"),
        &["face 0", "4000000000 list elements"],
    );
    refused(
        "ply",
        &body(&head(1, 1, "ascii"), b"0 0 0\n3 0 -1 0\n"),
        &["face 0", "3 0 -1 0", "InvalidDigit"],
    );
    refused("ply", &body(&head(1, 1, "ascii"), b"0 0 0\n2 0 0\n"), &["no triangle", "fewer than 3"]);
    let cloud = format!("ply\nformat ascii 1.0\nelement vertex 1\n{xyz}end_header\n0 0 0\n");
    refused("ply", cloud.as_bytes(), &["no triangle", "1 vertices"]);
    refused(
        "ply",
        b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
        &["properties y"],
    );
    refused("ply", b"ply\nformat ascii 1.0\nelement face 9\nend_header\n0\n", &["face no property"]);
    let strips = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int strip\nend_header\n1 0\n";
    refused("ply", strips.as_bytes(), &["no list vertex_indices"]);
}

#[test]
fn what_is_no_mesh_is_refused() {
    let error = |spec: &str| open(spec, &QUIET).unwrap_err().to_string();
    assert!(error("missing.obj").contains("missing.obj"));
    assert!(error("mesh.xyz").contains("hairball:N"));
    assert!(error("").contains("sponza"));
    assert!(error("sphere:0").contains("sphere:100000"));
    assert!(error("city:2000M").contains("2^30"));
    let folder = tempfile::tempdir().unwrap();
    let named = folder.path().join("folder.ply");
    fs::create_dir(&named).unwrap();
    for path in [folder.path(), &named] {
        assert!(error(path.to_str().unwrap()).contains("it is a directory"));
    }
}

/// Every cut and many flipped bits: an answer of either kind, never a panic, never a scene with a wild index.
#[test]
fn damage_never_panics() {
    let files = samples();
    let path = std::path::Path::new("mesh");
    let sane = |extension: &str, bytes: &[u8]| {
        let read = match extension {
            "ply" => super::ply::parse(path, bytes, Progress::Quiet),
            "obj" => super::obj::parse(path, bytes, Siblings::None, Progress::Quiet),
            "stl" => super::stl::parse(path, bytes, Progress::Quiet),
            "gltf" | "glb" => super::gltf::parse(path, bytes, Siblings::None, Progress::Quiet),
            _ => super::tri::parse(path, bytes),
        };
        if let Ok(s) = read {
            assert!(s.triangles.iter().flatten().all(|&v| (v as usize) < s.positions.len()));
        }
    };
    for (extension, bytes) in &files {
        for end in 0..bytes.len() {
            sane(extension, &bytes[..end]);
        }
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            sane(extension, &damaged);
            // A second fault, somewhere else.
            let other = bit.wrapping_mul(0x9E37_79B1) % (8 * bytes.len());
            damaged[other / 8] ^= 1 << (other % 8);
            sane(extension, &damaged);
        }
        for at in 0..bytes.len() {
            for filler in [0x00, 0xff, b'9', b'-', b'\n', b' '] {
                let mut damaged = bytes.clone();
                damaged[at..].iter_mut().take(4).for_each(|b| *b = filler);
                sane(extension, &damaged);
            }
        }
    }
}
