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

pub(super) fn assert_full(out: &Output, file: &str, why: &str) {
    let stderr = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(1), "{file}: {stderr}");
    let line = stderr.lines().last().unwrap_or_default();
    assert!(line.starts_with("error: ") && line.contains(file) && line.contains(why), "{file}: {stderr}");
}

#[test]
fn what_has_no_room_is_not_there_in_part() {
    let folder = Folder::new();
    let before = folder.names();
    let commands: [(&[&str], &str); 2] = [
        (&["scenes", "generate", "sphere:150k", "--out", "s.tri"], "s.tri"),
        (&["scenes", "generate", "sphere:300k", "--out", "s.ply"], "s.ply"),
    ];
    for (args, file) in commands {
        assert_full(&limited(&folder, args), &format!("can't write {file}"), "File too large");
        assert_eq!(folder.names(), before, "{file}");
    }
    assert!(folder.run(commands[0].0).status.success(), "the next run, with room");
    assert!(folder.path("s.tri").metadata().unwrap().len() > LIMIT as u64);
}

/// Runs the program with a file system of [`LIMIT`] bytes at `disk`, which begins with what lies there and, where told so, has
/// `room` for so many bytes more; what is on it in the end is copied to `left`. (A limit on files' sizes won't do: lavapipe's
/// memory is a file.) None where this process may not mount.
#[cfg(target_os = "linux")]
pub(super) fn on_small_disk(folder: &Folder, args: &[&str], room: Option<usize>) -> Option<Output> {
    on_small_disk_with(folder.command(args), folder, args, room)
}

/// Likewise, with the environment of `boxwood`.
#[cfg(target_os = "linux")]
pub(super) fn on_small_disk_with(
    boxwood: Command,
    folder: &Folder,
    args: &[&str],
    room: Option<usize>,
) -> Option<Output> {
    const SCRIPT: &str = "set -e; rm -rf left; mkdir left; cp -a disk before; trap 'rm -rf before' EXIT
        mount -t tmpfs -o size=4m tmpfs disk; cp -a before/. disk
        if [ $1 != all ]; then
            free=$(df -B1 --output=avail disk | tail -n 1); head -c $((free - $1)) /dev/zero > disk/filler
        fi; shift
        rc=0; \"$@\" || rc=$?; rm -f disk/filler; cp -a disk/. left; exit $rc";
    let unshare = |args: &[&str]| {
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--mount", "sh", "-c"]).args(args);
        command
    };
    let may = unshare(&["mount -t tmpfs tmpfs /mnt"]).output();
    if !may.is_ok_and(|out| out.status.success()) {
        eprintln!("left out: no file system can be mounted here, even in a namespace of its own");
        return None;
    }
    let room = room.map_or("all".to_owned(), |bytes| bytes.to_string());
    let mut shell = unshare(&[SCRIPT, "sh", &room]);
    shell.arg(boxwood.get_program()).args(args).current_dir(folder.path(""));
    for (name, value) in boxwood.get_envs() {
        match value {
            Some(value) => shell.env(name, value),
            None => shell.env_remove(name),
        };
    }
    Some(shell.output().unwrap())
}

#[test]
#[cfg(target_os = "linux")]
fn what_a_small_disk_has_no_room_for_is_not_there_in_part() {
    let folder = Folder::new();
    let rays: Vec<f32> =
        (0..300_000).flat_map(|i| [1.0, 1.0, 5.0, 0.0, 0.0, 0.0, -2.0, 1.0 + i as f32]).collect();
    folder.write("many.rays", &rays);
    fs::create_dir(folder.path("disk")).unwrap();
    fs::write(folder.path("disk/a.hits"), "those of before").unwrap();
    let city = ["city-rotated:60k", "--level", "leaves", "--out"];
    let commands: [(&[&str], &str); 3] = [
        (&["query", "two.tri", "--rays", "many.rays", "--out", "disk/a.hits", "--runs", "1"], "disk/a.hits"),
        (&["boxes", city[0], city[1], city[2], city[3], "disk/b.obj"], "disk/b.obj"),
        (&["build", "sphere:150k", "--runs", "1", "--save", "disk/s.boxwood"], "disk/s.boxwood"),
    ];
    for (args, file) in commands {
        let Some(out) = on_small_disk(&folder, args, None) else { return };
        assert_full(&out, &format!("can't write {file}"), "No space left on device");
        let mut left: Vec<_> =
            fs::read_dir(folder.path("left")).unwrap().map(|e| e.unwrap().file_name()).collect();
        // Materials are small, and written whole before the mesh that names them.
        left.retain(|name| name != "b.mtl");
        assert_eq!(left, ["a.hits"], "{file}");
        assert_eq!(fs::read_to_string(folder.path("left/a.hits")).unwrap(), "those of before");
    }
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
#[cfg(target_os = "linux")]
fn rows_before_a_full_disk_stay() {
    let folder = folder();
    let run = |out: &'static str| args(&["--out", out, "--resume", "--quiet", "--rays", "primary,ao"]);
    assert!(folder.run(&run("whole")).status.success());
    fs::create_dir(folder.path("disk")).unwrap();
    // The first two rows of the run, and blank lines until there is room for about four more.
    let whole = fs::read_to_string(folder.path("whole/rows.jsonl")).unwrap();
    let first: String = whole.lines().take(3).map(|line| format!("{line}\n")).collect();
    let room = (4 * whole.len() / whole.lines().count()).next_multiple_of(4096);
    fs::write(folder.path("disk/rows.jsonl"), first.clone() + &"\n".repeat(LIMIT - room - first.len()))
        .unwrap();
    if let Some(out) = on_small_disk(&folder, &run("disk"), None) {
        assert_full(&out, "can't write disk/rows.jsonl", "No space left on device");
        let there = fs::read_to_string(folder.path("left/rows.jsonl")).unwrap();
        assert!(there.starts_with(&first) && there.ends_with('\n'), "a row is cut off or lost");
        let rows_there: Vec<&str> = there.lines().filter(|line| !line.is_empty()).collect();
        let count = rows_there.len();
        assert!(count >= 3 && count < whole.lines().count(), "{count} rows");
        fs::create_dir(folder.path("cut")).unwrap();
        fs::write(folder.path("cut/rows.jsonl"), rows_there.join("\n") + "\n").unwrap();
        assert!(folder.run(&run("cut")).status.success());
        assert_eq!(rows(&folder, "cut/rows.jsonl"), rows(&folder, "whole/rows.jsonl"));
    }
    // Of tables and report, of which the report is the largest.
    std::os::unix::fs::symlink("/dev/full", folder.path("full.html")).unwrap();
    let out = folder.run(&["report", "whole", "--out", "full.html"]);
    assert_full(&out, "can't write full.html", "No space left on device");
}
