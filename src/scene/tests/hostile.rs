//! Files that mean harm, where no other test has them: more than there is memory for, ways out of their folder, words
//! that a terminal would obey.

use super::*;

/// Nothing in `message` that a terminal would obey; and what it says.
#[track_caller]
fn harmless(message: &str, says: &str) {
    assert!(message.contains(says), "{message:?} does not say {says:?}");
    assert!(!message.chars().any(char::is_control), "{message:?}");
}

#[test]
fn words_of_files_are_no_commands() {
    let refuses = |extension: &str, bytes: &[u8], says: &str| {
        harmless(&read(extension, bytes).unwrap_err().to_string(), says);
    };
    refuses("obj", b"v 0 0 \x1b[2J\n", "u{1b}[2J");
    refuses("obj", b"v 0 0 0\nf 1 1 \x1b]0;x\x07\n", "is not a vertex index");
    refuses("ply", b"ply\nformat \x1b[2J 1.0\n", "u{1b}[2J");
    let element = "ply\nformat ascii 1.0\nelement \u{9b}2J 99\nproperty int a\nend_header\n";
    refuses("ply", element.as_bytes(), "2J");
    refuses("stl", b"solid\nfacet\n\x1b[2J\nendsolid", "u{1b}[2j");
    refuses("gltf", br#"{"asset":{"version":"\u001b[2J"}}"#, "u{1b}[2J");
    refuses(
        "gltf",
        br#"{"asset":{"version":"2.0"},"extensionsRequired":["\u001b[2J\u000a"]}"#,
        "needs \\u{1b}[2J\\n",
    );
    refuses(
        "gltf",
        br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":1,"uri":"%1b[2J%0a.bin"}]}"#,
        "\\u{1b}[2J\\n.bin",
    );
    refuses("gltf", br#"{"asset":{"version":"2.0"},"nodes":[{"\u001b[2J":1,"mesh":"\u001b[2J"}]}"#, "JSON");
    // As long as the file likes, and as long as people read.
    let long = read("obj", format!("v 0 0 {}\n", "x".repeat(1 << 20)).as_bytes()).unwrap_err().to_string();
    assert!(long.len() < 3000 && long.contains("xxx…"), "{} bytes", long.len());
}

#[test]
fn names_of_files_are_no_commands() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a\u{1b}[2J\n.obj");
    harmless(&open(path.to_str().unwrap(), &QUIET).unwrap_err().to_string(), "a\\u{1b}[2J\\n.obj");
    if fs::write(&path, "mtllib \u{1b}[2J.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").is_ok() {
        let scene = open(path.to_str().unwrap(), &QUIET).unwrap();
        harmless(&scene.warnings[0].what, "\\u{1b}[2J.mtl");
    }
}

/// By its size alone, which the file system need not have either.
#[test]
fn a_file_larger_than_the_memory_is_not_begun() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.tri", "a.ply", "a.obj.gz"] {
        let path = folder.path().join(name);
        if fs::File::create(&path).unwrap().set_len(1 << 43).is_ok() {
            let error = open(path.to_str().unwrap(), &QUIET).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains("take 8796093022208 bytes of memory"), "{error}");
        }
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn no_more_is_unpacked_than_half_the_memory() {
    for (name, bytes) in
        [("a.tri.gz", packed::gzip(&[0; 1 << 17])), ("a.tri.zst", packed::zstd(&[0; 1 << 17]))]
    {
        let unpack = |room| {
            let path = std::path::Path::new(name);
            crate::scene::packed::unpack_within(path, &bytes, Progress::Quiet, room).map(|all| all.len())
        };
        assert_eq!(unpack(1 << 17).unwrap(), 1 << 17);
        let error = unpack((1 << 17) - 1).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("half of the free memory"), "{error}");
    }
}

/// A window that holds everything that ever was, in a frame of nothing.
#[test]
fn windows_of_zstandard_have_a_limit() {
    // Magic; a window by its exponent, no size, no sum; a last raw block of no bytes.
    let frame = |exponent: u8| [0x28, 0xb5, 0x2f, 0xfd, 0, exponent << 3, 1, 0, 0];
    refused("tri.zst", &frame(17), &["no triangle"]); // 128 MiB
    refused("tri.zst", &frame(18), &["byte ", "zstd -d"]);
    refused("tri.zst", &frame(31), &["byte ", "zstd -d"]);
}

#[test]
fn polygons_of_more_corners_than_the_file_has() {
    let header = |list: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty char x\nproperty char y\nproperty char z\n\
             element face 1\nproperty list {list} uint vertex_indices\nend_header\n"
        )
    };
    for (list, count) in [("uint", u32::MAX), ("uint", 1 << 31), ("int", i32::MAX as u32)] {
        let file = [header(list).as_bytes(), &count.to_le_bytes(), &[0; 64]].concat();
        refused("ply", &file, &["face 0 (byte", "ends"]);
    }
    // As many as it has: a fan.
    let corners = 100_000;
    let face: Vec<u8> = (0..corners).flat_map(|_| 0u32.to_le_bytes()).collect();
    let header = header("uint").replace("vertex 0", "vertex 1");
    let file = [header.as_bytes(), &[0; 3], &(corners as u32).to_le_bytes(), &face].concat();
    assert_eq!(read("ply", &file).unwrap().triangles.len(), corners - 2);
    let obj = format!("v 0 0 0\nf{}\n", " 1".repeat(corners));
    assert_eq!(read("obj", obj.as_bytes()).unwrap().triangles.len(), corners - 2);
}

#[test]
fn materials_come_from_the_folder_alone() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("in");
    fs::create_dir(&inner).unwrap();
    let outside = folder.path().join("outside.mtl");
    fs::write(&outside, "newmtl a\nKd 1 0 0\n").unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&outside, inner.join("link.mtl")).unwrap();
        std::os::unix::fs::symlink(folder.path(), inner.join("up")).unwrap();
    }
    let path = inner.join("mesh.obj");
    let absolute = outside.to_str().unwrap().to_owned();
    for name in
        [absolute.as_str(), "../outside.mtl", "link.mtl", "up/outside.mtl", "%2e%2e/outside.mtl", "/dev/zero"]
    {
        let obj = format!("mtllib {name}\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        fs::write(&path, obj).unwrap();
        let scene = open(path.to_str().unwrap(), &QUIET).unwrap();
        assert_eq!(scene.materials.color(0), None, "{name}");
        assert_eq!(scene.warnings.len(), 1, "{name}");
    }
}

/// What nests, nests in the file alone: 100 000 deep, of every kind.
#[test]
fn manifests_as_deep_as_one_likes() {
    let deep = 100_000;
    for text in [
        format!("a = {}", "[".repeat(deep)),
        format!("a = {}", "{a=".repeat(deep)),
        format!("{}a = 1", "a.".repeat(deep)),
        format!("[{}a]", "a.".repeat(deep)),
        format!("sets = {{ {}a = 1 }}", "a.".repeat(deep)),
    ] {
        assert!(crate::scene::Manifest::parse(&text).is_err());
    }
}

#[test]
fn views_are_of_a_scene_that_has_its_own() {
    let scene = |name: &str, views: &str| {
        format!(
            "[[scene]]\nname='{name}'\nlicence=''\ncredit=''\ntriangles=1\nviews={views}\nsource.generated='sphere'\n"
        )
    };
    let own = "['standard','standard','standard','standard','standard']";
    let parse = |a: &str, b: &str| {
        crate::scene::Manifest::parse(&format!("sets = {{}}\n{}{}", scene("a", a), scene("b", b)))
            .map(|m| m.scenes.len())
            .map_err(|e| e.to_string())
    };
    assert_eq!(parse(own, "'a'"), Ok(2));
    for (a, b) in [("'b'", "'a'"), ("'a'", own), (own, "'c'")] {
        assert!(parse(a, b).unwrap_err().contains("none of its own"), "{a} {b}");
    }
}
