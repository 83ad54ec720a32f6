//! `build --save` and `query --tree`: files in, files out, exit codes.

use crate::cli::Folder;
use std::fs;

/// Where a file's version is, bytes.
const VERSION_AT: usize = 12;

fn json(out: &std::process::Output) -> serde_json::Value {
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).unwrap()
}

#[test]
fn programs_save_and_query() {
    let folder = Folder::new();
    let build =
        ["build", "two.tri", "--runs", "1", "--builder", "lbvh", "--max-leaf", "1", "--save", "t.boxwood"];
    let report = json(&folder.run(&build));
    let file = fs::read(folder.path("t.boxwood")).unwrap();
    assert_eq!(report["saved"]["bytes"], file.len());
    assert!(report["saved"]["ms"].as_f64().is_some_and(|ms| ms > 0.0), "{report}");

    let query = |args: &[&'static str]| [&["query", "--rays", "a.rays", "--runs", "1"][..], args].concat();
    let fresh =
        json(&folder.run(&query(&["two.tri", "--out", "b.hits", "--builder", "lbvh", "--max-leaf", "1"])));
    let out = folder.run(&query(&["--tree", "t.boxwood", "--out", "a.hits", "--explain"]));
    let stderr = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(stderr.contains("nothing built, no scene read") && stderr.contains("loaded in"), "{stderr}");
    let loaded = json(&out);
    assert_eq!(fs::read(folder.path("a.hits")).unwrap(), fs::read(folder.path("b.hits")).unwrap());
    for key in ["tree_hash", "scene", "triangles", "left_out", "builder", "max_leaf", "nodes", "sah", "hits"]
    {
        assert_eq!(loaded[key], fresh[key], "{key}");
    }
    assert_eq!((&loaded["loaded"], &loaded["loaded_bytes"]), (&"t.boxwood".into(), &file.len().into()));
    assert!(loaded["loaded_ms"].as_f64().is_some_and(|ms| ms > 0.0), "{loaded}");
    assert!(loaded["built_by"].as_str().is_some_and(|by| by.contains(env!("CARGO_PKG_VERSION"))), "{loaded}");
    for key in ["build_ms", "build_wall_ms", "scratch_bytes"] {
        assert!(loaded[key].is_null() && !fresh[key].is_null(), "{key}: {loaded}");
    }
    let checked =
        json(&folder.run(&query(&["two.tri", "--tree", "t.boxwood", "--out", "a.hits", "--check"])));
    assert_eq!(
        (&checked["check"]["tree"]["leaves"], &checked["check"]["hits"]["rays"]),
        (&2.into(), &3.into())
    );
}

#[test]
fn programs_refuse_and_leave_nothing() {
    let folder = Folder::new();
    json(&folder.run(&["build", "two.tri", "--runs", "1", "--save", "t.boxwood"]));
    let file = fs::read(folder.path("t.boxwood")).unwrap();
    fs::write(folder.path("short.boxwood"), &file[..file.len() - 1]).unwrap();
    let mut flipped = file.clone();
    flipped[file.len() / 2] ^= 4;
    fs::write(folder.path("flipped.boxwood"), flipped).unwrap();
    let mut newer = file.clone();
    newer[VERSION_AT] += 1;
    fs::write(folder.path("newer.boxwood"), newer).unwrap();
    folder.write("one.tri", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);

    let query =
        |args: &[&'static str]| [&["query", "--rays", "a.rays", "--out", "a.hits"][..], args].concat();
    for (tree, words) in [
        ("short.boxwood", "short.boxwood: cut short"),
        ("flipped.boxwood", "flipped.boxwood: damaged"),
        ("newer.boxwood", "written by a newer boxwood"),
        ("two.tri", "no tree saved by boxwood"),
        ("none.boxwood", "can't load the tree none.boxwood: No such file"),
        (".", "it is a directory"),
        ("/dev/null", "no regular file"),
    ] {
        folder.fails(&query(&["--tree", tree]), 1, words);
    }
    folder.fails(&query(&["--tree", "t.boxwood", "--check"]), 1, "--check compares with the scene");
    folder.fails(&query(&["one.tri", "--tree", "t.boxwood"]), 1, "its scene is another one");
    folder.fails(&query(&["two.tri", "--scale", "2", "--tree", "t.boxwood"]), 1, "its scene is another one");
    // What makes no sense together.
    folder.fails(&query(&["--tree", "t.boxwood", "--builder", "ploc"]), 2, "cannot be used with");
    folder.fails(&query(&["--tree", "t.boxwood", "--node-cost", "4"]), 2, "cannot be used with");
    folder.fails(&query(&["--tree", "t.boxwood", "--sample", "4"]), 2, "cannot be used with");
    folder.fails(&query(&["--tree", "t.boxwood", "--scale", "2"]), 2, "required");
    folder.fails(&query(&[]), 2, "required");
    // Disks and permissions.
    let save = |to: &'static str| ["build", "two.tri", "--runs", "1", "--save", to];
    folder.fails(&save("none/t.boxwood"), 1, "can't write none/t.boxwood");
    folder.fails(&save("/dev/full"), 1, "can't write /dev/full: No space left");
    folder.fails(&save("."), 1, "it is a directory");
    assert_eq!(fs::read(folder.path("t.boxwood")).unwrap(), file);
}
