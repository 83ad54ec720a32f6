//! A disk without room: by the limit on files' sizes, which has a write fail in the middle as a full disk does, and by
//! /dev/full. The error names the file, nothing is there in part, rows measured before stay.

use crate::bench::{args, folder, rows};
use crate::cli::Folder;
use std::fs;
use std::process::{Command, Output};

/// Files may have 4 MiB: more than those of the driver's own cache, which must not suffer.
const LIMIT: usize = 4 << 20;

/// Runs the program under the limit.
fn limited(folder: &Folder, args: &[&str]) -> Output {
    let boxwood = folder.command(&[]);
    let mut shell = Command::new("bash");
    shell.args(["-c", &format!("ulimit -f {} && exec \"$@\"", LIMIT >> 10), "bash"]);
    shell.arg(boxwood.get_program()).args(args).current_dir(folder.path(""));
    for (name, value) in boxwood.get_envs() {
        match value {
            Some(value) => shell.env(name, value),
            None => shell.env_remove(name),
        };
    }
    shell.output().unwrap()
}

fn assert_full(out: &Output, file: &str, why: &str) {
    let stderr = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(1), "{file}: {stderr}");
    let line = stderr.lines().last().unwrap_or_default();
    assert!(line.starts_with("error: ") && line.contains(file) && line.contains(why), "{file}: {stderr}");
}

#[test]
fn what_has_no_room_is_not_there_in_part() {
    let folder = Folder::new();
    let rays: Vec<f32> =
        (0..300_000).flat_map(|i| [1.0, 1.0, 5.0, 0.0, 0.0, 0.0, -2.0, 1.0 + i as f32]).collect();
    folder.write("many.rays", &rays);
    fs::write(folder.path("a.hits"), "those of before").unwrap();
    let before = folder.names();
    let commands: [(&[&str], &str); 5] = [
        (&["query", "two.tri", "--rays", "many.rays", "--out", "a.hits", "--runs", "1"], "a.hits"),
        (&["scenes", "generate", "sphere:150k", "--out", "s.tri"], "s.tri"),
        (&["scenes", "generate", "sphere:300k", "--out", "s.ply"], "s.ply"),
        (&["boxes", "city-rotated:60k", "--level", "leaves", "--out", "b.obj"], "b.obj"),
        (&["boxes", "city-rotated:60k", "--level", "leaves", "--out", "b.glb"], "b.glb"),
    ];
    for (args, file) in commands {
        assert_full(&limited(&folder, args), &format!("can't write {file}"), "File too large");
        let mut there = folder.names();
        // Materials are small, and written whole before the mesh that names them.
        there.retain(|name| name != "b.mtl");
        assert_eq!(there, before, "{file}");
    }
    assert_eq!(fs::read_to_string(folder.path("a.hits")).unwrap(), "those of before");
    assert!(folder.run(commands[1].0).status.success(), "the next run, with room");
    assert!(folder.path("s.tri").metadata().unwrap().len() > LIMIT as u64);
}

/// Small files, at a device that is always full.
#[test]
#[cfg(target_os = "linux")]
fn a_full_device_is_named() {
    let folder = Folder::new();
    for name in ["p.png", "b.glb", "b.obj", "b.json", "t.json", "r.html", "a.hits"] {
        std::os::unix::fs::symlink("/dev/full", folder.path(name)).unwrap();
    }
    let size = ["--width", "32", "--height", "24"];
    let commands: [(&[&str], &[&str], &str); 7] = [
        (&["build", "two.tri", "--runs", "1", "--json", "b.json"], &[], "b.json"),
        (&["query", "two.tri", "--rays", "a.rays", "--out", "a.hits", "--runs", "1"], &[], "a.hits"),
        (&["render", "two.tri", "--out", "p.png"], &size, "p.png"),
        (&["boxes", "two.tri", "--level", "1", "--out", "p.png"], &size, "p.png"),
        (&["boxes", "two.tri", "--level", "1", "--out", "b.obj"], &size, "b.obj"),
        (&["boxes", "two.tri", "--level", "1", "--out", "b.glb"], &size, "b.glb"),
        (&["profile", "two.tri", "--rays", "primary", "--runs", "1", "--out", "t.json"], &size, "t.json"),
    ];
    for (args, size, file) in commands {
        let out = folder.run(&[args, size].concat());
        assert_full(&out, &format!("can't write {file}"), "No space left on device");
    }
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let out = folder.command(&["scenes", "list", "--json"]).stdout(full).output().unwrap();
    assert_full(&out, "can't write to stdout", "No space left on device");
}

#[test]
fn rows_before_a_full_disk_stay() {
    let folder = folder();
    let run = |out: &'static str| args(&["--out", out, "--resume", "--quiet", "--rays", "primary,ao"]);
    assert!(folder.run(&run("whole")).status.success());
    let path = folder.path("cut/rows.jsonl");
    fs::create_dir_all(folder.path("cut")).unwrap();
    // The first two rows of the run, and blank lines until there is room for about two more.
    let whole = fs::read_to_string(folder.path("whole/rows.jsonl")).unwrap();
    let first: String = whole.lines().take(3).map(|line| format!("{line}\n")).collect();
    let room = 2 * whole.len() / whole.lines().count();
    fs::write(&path, first.clone() + &"\n".repeat(LIMIT - room - first.len())).unwrap();
    assert_full(&limited(&folder, &run("cut")), "can't write cut/rows.jsonl", "File too large");
    let there = fs::read_to_string(&path).unwrap();
    assert!(there.starts_with(&first) && there.ends_with('\n'), "a row is cut off or lost");
    let rows_there: Vec<&str> = there.lines().filter(|line| !line.is_empty()).collect();
    assert!(rows_there.len() >= 3 && rows_there.len() < whole.lines().count(), "{} rows", rows_there.len());
    fs::write(&path, rows_there.join("\n") + "\n").unwrap();
    assert!(folder.run(&run("cut")).status.success());
    assert_eq!(rows(&folder, "cut/rows.jsonl"), rows(&folder, "whole/rows.jsonl"));
    // Of tables and report, of which the report is the largest.
    let html = fs::read(folder.path("whole/report.html")).unwrap();
    assert!(html.len() < LIMIT);
    #[cfg(target_os = "linux")]
    {
        std::os::unix::fs::symlink("/dev/full", folder.path("full.html")).unwrap();
        let out = folder.run(&["report", "whole", "--out", "full.html"]);
        assert_full(&out, "can't write full.html", "No space left on device");
    }
}
