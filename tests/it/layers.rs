//! The architecture as the sources have it: who may know whom, where `unsafe` is, one name in four places.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

/// Room, and the rooms that it may know.
const LAYERS: &[(&str, &[&str])] = &[
    ("abi", &[]),
    ("geom", &["abi"]),
    ("kernels", &["abi"]),
    ("output", &[]),
    ("scene", &["abi", "geom", "output"]),
    // What it takes and judges (recipes, trees, queries), never the device.
    ("oracle", &["abi", "geom", "scene", "bvh", "trace"]),
    ("device", &["abi", "kernels"]),
    ("bvh", &["abi", "geom", "scene", "kernels", "device"]),
    ("saved", &["abi", "scene", "device", "bvh"]),
    ("trace", &["abi", "geom", "scene", "kernels", "device", "bvh"]),
    ("ray_query", &["abi", "kernels", "device", "bvh", "trace"]),
    ("picture", &["abi", "geom", "scene", "device", "bvh", "trace", "oracle"]),
    (
        "bench",
        &[
            "abi",
            "geom",
            "output",
            "scene",
            "kernels",
            "device",
            "bvh",
            "trace",
            "ray_query",
            "oracle",
            "picture",
        ],
    ),
    ("profile", &["abi", "geom", "scene", "device", "bvh", "trace", "bench"]),
    ("stress", &["abi", "geom", "scene", "device", "bvh", "trace", "oracle", "bench"]),
    ("report", &["oracle", "bench"]),
];
/// Rooms that may know all.
const TOPS: &[&str] = &["lib", "main", "cli"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files(dir: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = vec![];
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|e| e == extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Sources below src/: room, path, text without comments.
fn sources() -> Vec<(String, String, String)> {
    let read = |path: PathBuf| {
        let name = path.strip_prefix(root().join("src")).unwrap().to_string_lossy().into_owned();
        let room = name.split(['/', '.']).next().unwrap().to_owned();
        let text = fs::read_to_string(&path).unwrap();
        let code: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap()).collect();
        (room, name, code.join("\n"))
    };
    files(&root().join("src"), "rs").into_iter().map(read).collect()
}

fn ident(text: &str) -> &str {
    &text[..text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len())]
}

/// What is named first in each part of `{…}`, or in the text itself.
fn heads(text: &str) -> Vec<&str> {
    let Some(inner) = text.strip_prefix('{') else { return vec![ident(text)] };
    let (mut depth, mut start, mut found) = (0, 0, vec![]);
    for (i, c) in inner.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                let part = inner[start..i].trim();
                if !part.is_empty() {
                    found.push(ident(part));
                }
                start = i + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    found
}

#[test]
fn rooms_know_only_the_rooms_below() {
    let mut faults = vec![];
    for (room, name, code) in sources() {
        if TOPS.contains(&room.as_str()) {
            continue;
        }
        let Some((_, known)) = LAYERS.iter().find(|l| l.0 == room) else {
            faults.push(format!("{name}: {room} has no layer; add it to LAYERS"));
            continue;
        };
        for (at, _) in code.match_indices("crate::") {
            for to in heads(&code[at + "crate::".len()..]) {
                if to != room && !known.contains(&to) {
                    faults.push(format!("{name}: {room} must not know {to}"));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn unsafe_stays_in_its_room() {
    let is_word = |line: &str| line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w == "unsafe");
    for (room, name, code) in sources() {
        for line in code.lines().filter(|line| is_word(line)) {
            let pod = room == "abi" && line.trim().starts_with("unsafe impl bytemuck::");
            assert!(room == "device" || pod, "{name}: unsafe outside src/device: {}", line.trim());
        }
    }
}

#[test]
fn a_stage_has_one_name_in_four_places() {
    let there = |paths: &[String]| paths.iter().any(|p| root().join(p).exists());
    for stage in fs::read_dir(root().join("glsl")).unwrap().map(|e| e.unwrap()) {
        let s = stage.file_name().into_string().unwrap();
        if !stage.path().is_dir() || files(&stage.path(), "comp").is_empty() {
            continue;
        }
        let host = [
            format!("src/bvh/{s}.rs"),
            format!("src/bvh/{s}/mod.rs"),
            format!("src/{s}/mod.rs"),
            format!("src/trace/{s}.rs"),
        ];
        // The scan is a step of other stages, which record it.
        assert!(s == "scan" || there(&host), "glsl/{s} has none of {host:?}");
        // A driver has no twin: the f64 reference judges what it says.
        let twin = s == "ray_query" || there(&[format!("src/oracle/{s}.rs")]);
        assert!(twin, "glsl/{s} has no twin src/oracle/{s}.rs");
        assert!(there(&[format!("tests/it/{s}.rs")]), "glsl/{s} has no tests/it/{s}.rs");
    }
}

#[test]
fn kernels_stay_short() {
    for path in files(&root().join("glsl"), "comp") {
        let lines = fs::read_to_string(&path).unwrap().lines().count();
        assert!(lines <= 150, "{}: {lines} lines", path.display());
    }
}
