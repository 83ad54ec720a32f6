//! What is fuzzed: a function a kind of file, which takes any bytes. An answer of either kind is right; a panic, a scene
//! with an index that names nothing, and a message that a terminal would obey are not. `tests/it/fuzz.rs` takes this
//! file too, and replays what was found.

use std::io::Cursor;
use std::path::Path;

use boxwood::abi::{Aabb, INVALID, Ray};
use boxwood::bench::{Presets, Report, Results, compare};
use boxwood::oracle::{morton::Space, trace::Tree};
use boxwood::saved::{Header, Parsed};
use boxwood::scene::{
    Archive, Fetched, Manifest, Materials, Progress, Registry, Scene, SceneError, Siblings, mesh_in, parse,
    printable,
};

/// A name, and what takes the bytes.
pub type Target = (&'static str, fn(&[u8]));

/// Every one there is: `fuzz/fuzz_targets/NAME.rs`, `fuzz/corpus/NAME`.
pub const TARGETS: [Target; 17] = [
    ("obj", obj),
    ("mtl", mtl),
    ("ply", ply),
    ("stl", stl),
    ("tri", tri),
    ("gltf", gltf),
    ("glb", glb),
    ("gz", gz),
    ("zst", zst),
    ("npz", npz),
    ("tgz", tgz),
    ("wheel", wheel),
    ("rays", rays),
    ("scenes", scenes),
    ("presets", presets),
    ("rows", rows),
    ("saved", saved),
];

/// Most bytes of an input: larger ones find nothing more, and are slow.
pub const LARGEST: usize = 4096;
/// Most characters of a message, whatever the file says.
const WORDY: usize = 4000;

/// A Wavefront OBJ, beside a material file.
pub fn obj(bytes: &[u8]) {
    mesh("mesh.obj", bytes);
}

/// A material file, beside an OBJ.
pub fn mtl(bytes: &[u8]) {
    let obj = b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b c\nf 1 2 3 1\nusemtl\nf 3 2 1\n";
    judge(parse(Path::new("mesh.obj"), obj, Siblings::Given(&[("m.mtl", bytes)]), Progress::Quiet));
}

/// A PLY.
pub fn ply(bytes: &[u8]) {
    mesh("mesh.ply", bytes);
}

/// An STL.
pub fn stl(bytes: &[u8]) {
    mesh("mesh.stl", bytes);
}

/// A triangle soup.
pub fn tri(bytes: &[u8]) {
    mesh("mesh.tri", bytes);
}

/// A glTF: JSON, with its buffers in it or beside it.
pub fn gltf(bytes: &[u8]) {
    mesh("mesh.gltf", bytes);
}

/// A GLB.
pub fn glb(bytes: &[u8]) {
    mesh("mesh.glb", bytes);
}

/// A triangle soup, packed by gzip.
pub fn gz(bytes: &[u8]) {
    mesh("mesh.tri.gz", bytes);
}

/// The same, packed by Zstandard.
pub fn zst(bytes: &[u8]) {
    mesh("mesh.tri.zst", bytes);
}

/// A terrain.
pub fn npz(bytes: &[u8]) {
    mesh("terrain.npz", bytes);
}

/// A package of npm's.
pub fn tgz(bytes: &[u8]) {
    member(Archive::Tgz, bytes);
}

/// A package of Python's.
pub fn wheel(bytes: &[u8]) {
    member(Archive::Wheel, bytes);
}

/// A file of rays.
pub fn rays(bytes: &[u8]) {
    match boxwood::trace::rays::parse(bytes) {
        Ok(rays) => assert_eq!(size_of_val(&rays[..]), bytes.len()),
        Err(e) => message(&e.to_string()),
    }
}

/// A manifest like `scenes/scenes.toml`.
pub fn scenes(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else { return };
    match Manifest::parse(text) {
        Ok(manifest) => {
            for entry in &manifest.scenes {
                assert!(entry.spec().starts_with(&entry.name) && manifest.entry(&entry.name).is_some());
            }
        }
        Err(e) => drop(e.to_string()),
    }
}

/// Presets like `scenes/bench.toml`, each of them asked for.
pub fn presets(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else { return };
    let presets = match Presets::parse(text) {
        Ok(presets) => presets,
        Err(e) => return drop(e.to_string()),
    };
    for (name, _) in presets.list() {
        if let Ok(preset) = presets.preset(name) {
            assert!((1..=5).contains(&preset.views) && !preset.size.contains(&0), "{preset:?}");
        }
    }
    for name in presets.recipes() {
        if let Ok(recipe) = presets.recipe(name) {
            assert!(recipe.check().is_ok(), "{recipe:?}");
        }
        let _ = presets.precision(name);
    }
}

/// Rows of a benchmark, as `--resume`, `report` and `compare` take them.
pub fn rows(bytes: &[u8]) {
    let results = match Results::parse(Path::new("rows.jsonl"), bytes) {
        Ok(results) => results,
        Err(e) => return drop(e.to_string()),
    };
    let lines = results.to_lines().expect("rows are written");
    let again = Results::parse(Path::new("rows.jsonl"), &lines).expect("what is written is read");
    assert_eq!(again, results);
    results.missing();
    compare(&results, &again);
    let report = Report::new(&results);
    (report.faults(), report.drivers_faults(), report.checked());
    report.csv().expect("a table is written");
    (report.build_table(), report.ray_table(), report.kernel_table());
    let joined = Results::joined(vec![results, again]);
    assert_eq!(joined.len(), 1);
    boxwood::report::html(&joined).expect("a page is written");
}

/// A saved tree: as it is, and with the checksum that who forges one would give it. Rays go through any that is taken.
pub fn saved(bytes: &[u8]) {
    if let Err(fault) = boxwood::saved::parse(bytes) {
        message(&fault.to_string());
    }
    let Some(all) = bytes.len().checked_sub(blake3::OUT_LEN) else { return };
    let forged = [&bytes[..all], blake3::hash(&bytes[..all]).as_bytes()].concat();
    let Parsed { tree, header, .. } = match boxwood::saved::parse(&forged) {
        Ok(parsed) => parsed,
        Err(fault) => return message(&fault.to_string()),
    };
    let Header { exponent, anchor, reach, bounds: Aabb { lo, hi }, .. } = header;
    let space = Space { exponent, scale: 2f32.powi(exponent), anchor, reach };
    let twin = Tree { tree: &tree, space: &space, wide: true };
    for (origin, direction) in [(lo, [1.0, 0.5, 0.25]), (hi, [0.0, -1.0, 0.0]), ([0.0; 3], [-1.0, 1.0, 1.0])]
    {
        let ray = Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY };
        let (hit, tests) = twin.closest(&ray);
        assert!(hit.triangle == INVALID || u64::from(hit.triangle) < header.scene_triangles(), "{hit:?}");
        assert!(u64::from(tests.triangles) <= header.triangles, "{tests:?}");
        assert!(tests.boxes.div_ceil(4) + tests.oriented.div_ceil(4) <= header.nodes as u32, "{tests:?}");
    }
}

fn mesh(name: &str, bytes: &[u8]) {
    let beside: [(&str, &[u8]); 2] = [("a.mtl", b"newmtl a\nKd 1 0.5 0\n"), ("a.bin", &[0x3f; 64])];
    judge(parse(Path::new(name), bytes, Siblings::Given(&beside), Progress::Quiet));
}

fn judge(read: Result<Scene, SceneError>) {
    let scene = match read {
        Ok(scene) => scene,
        Err(e) => return message(&e.to_string()),
    };
    assert!(!scene.triangles.is_empty());
    assert!(scene.triangles.iter().flatten().all(|v| (*v as usize) < scene.positions.len()));
    let Materials { colors, of_triangles } = &scene.materials;
    assert!(of_triangles.is_empty() || of_triangles.len() == scene.triangles.len());
    assert!(of_triangles.iter().all(|c| *c == Materials::NONE || (*c as usize) < colors.len()));
    assert!(colors.iter().flatten().all(|c| (0.0..=1.0).contains(c)), "{colors:?}");
    for warning in &scene.warnings {
        message(&format!("{} {} {}", warning.count, warning.what, warning.first));
    }
    assert!(scene.views_or_default().iter().all(|v| v.eye.iter().all(|x| x.is_finite())));
}

fn member(archive: Archive, bytes: &[u8]) {
    let mesh = Fetched {
        registry: Registry::Npm,
        package: "meshes".to_owned(),
        version: "1.0.0".to_owned(),
        member: "media/mesh.tri".to_owned(),
        bytes: 5,
        sha256: "2cf24dba5fb0a30e26e83b2ac5b9e29e1b161e5c1fa7425e73043362938b9824".to_owned(),
        instead: "sphere:5".to_owned(),
    };
    match mesh_in(archive, Cursor::new(bytes), &mesh) {
        Ok(mesh) => assert_eq!(mesh, b"hello"),
        Err(what) => message(&what),
    }
}

/// What people read of a file: not as long as the file likes.
fn message(text: &str) {
    assert!(text.chars().count() <= WORDY, "{} characters: {text}", text.chars().count());
    assert_eq!(text, printable(text));
    assert!(!text.contains('\n'), "{text}");
}
