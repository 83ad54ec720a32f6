//! What is written of results once they are measured, and what is kept for later, on a disk that has no room for it.

use super::disk::{assert_full, on_small_disk, on_small_disk_with};
use crate::bench::{args, folder};
use crate::cli::Folder;
use std::fs;
use std::path::Path;
use std::process::Output;

const NO_ROOM: &str = "No space left on device";

/// All files below `folder`, by their paths from there; hidden ones too.
fn files(folder: &Path) -> Vec<String> {
    let mut found = vec![];
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let name = entry.file_name().into_string().unwrap();
        match entry.path().is_dir() {
            true => found.extend(files(&entry.path()).into_iter().map(|f| format!("{name}/{f}"))),
            false => found.push(name),
        }
    }
    found.sort_unstable();
    found
}

/// Bytes that a file system gives `file`.
fn taken(file: &Path) -> usize {
    (file.metadata().unwrap().len() as usize).next_multiple_of(4096)
}

#[test]
fn tables_reports_and_pictures_are_whole_or_not_there() {
    let folder = Folder::new();
    let bench =
        ["bench", "sphere:500", "--preset", "smoke", "--builders", "ploc", "--rays", "primary", "--quiet"];
    let run = folder.run(&[&bench[..], &["--out", "whole"]].concat());
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    fs::create_dir_all(folder.path("disk/pictures")).unwrap();
    fs::write(folder.path("disk/report.html"), "that of before").unwrap();
    let merge = ["report", "merge", "whole", "--out", "disk"];
    let mut pictures: Vec<String> =
        files(&folder.path("whole")).into_iter().filter(|f| f.starts_with("pictures/")).collect();
    // The scene's, 1.png, then those of its builders, 1-1.png.
    pictures.sort_by_key(String::len);
    assert!(!pictures.is_empty());
    let mut room = 0;
    // In the order in which they are written.
    let all =
        pictures.iter().map(String::as_str).chain(["rows.jsonl", "bench.json", "bench.csv", "report.html"]);
    let mut written = vec![];
    for file in all {
        let Some(out) = on_small_disk(&folder, &merge, Some(room)) else { return };
        assert_full(&out, &format!("can't write disk/{file}"), NO_ROOM);
        let mut there = written.clone();
        there.push("report.html".to_owned());
        there.sort_unstable();
        assert_eq!(files(&folder.path("left")), there, "with room for {room} bytes");
        for whole in &written {
            assert_eq!(
                fs::read(folder.path("left").join(whole)).unwrap(),
                fs::read(folder.path("whole").join(whole)).unwrap()
            );
        }
        assert_eq!(fs::read_to_string(folder.path("left/report.html")).unwrap(), "that of before");
        room += taken(&folder.path("whole").join(file));
        written.push(file.to_owned());
    }
    let out = on_small_disk(&folder, &merge, Some(room)).unwrap();
    assert!(out.status.success(), "with room: {}", String::from_utf8_lossy(&out.stderr));
    assert_eq!(files(&folder.path("left")), files(&folder.path("whole")));

    // A run itself: of pictures and tables the first has no room. Rows that are measured stay.
    let rows = fs::read_to_string(folder.path("whole/rows.jsonl")).unwrap();
    fs::remove_dir_all(folder.path("disk")).unwrap();
    fs::create_dir(folder.path("disk")).unwrap();
    fs::copy(folder.path("whole/rows.jsonl"), folder.path("disk/rows.jsonl")).unwrap();
    for picture in &pictures {
        fs::create_dir_all(folder.path("disk/pictures")).unwrap();
        fs::copy(folder.path("whole").join(picture), folder.path("disk").join(picture)).unwrap();
    }
    let again = [&bench[..], &["--out", "disk", "--resume"]].concat();
    let out = on_small_disk(&folder, &again, Some(0)).unwrap();
    assert_full(&out, "can't write disk/bench.json", NO_ROOM);
    assert_eq!(fs::read_to_string(folder.path("left/rows.jsonl")).unwrap(), rows);
    assert!(!files(&folder.path("left")).iter().any(|f| f.contains("bench") || f.contains("part")));
    fs::remove_dir_all(folder.path("disk/pictures")).unwrap();
    let measured: String = rows
        .lines()
        .filter(|line| !line.contains("\"row\":\"picture\""))
        .map(|line| format!("{line}\n"))
        .collect();
    assert!(measured.len() < rows.len());
    fs::write(folder.path("disk/rows.jsonl"), &measured).unwrap();
    let out = on_small_disk(&folder, &again, Some(0)).unwrap();
    assert_full(&out, "can't write disk/pictures/", NO_ROOM);
    assert_eq!(files(&folder.path("left")), ["rows.jsonl"]);
    assert_eq!(fs::read_to_string(folder.path("left/rows.jsonl")).unwrap(), measured);
}

#[test]
fn stress_goes_on_and_keeps_the_old_file() {
    let folder = Folder::new();
    fs::create_dir(folder.path("disk")).unwrap();
    fs::write(folder.path("disk/a.json"), "that of before").unwrap();
    let one = ["stress", "--quick", "--only", "/one", "--builders", "ploc", "--rays", "7"];
    let closed = ["stress", "--closed", "700", "--builders", "ploc"];
    for (args, last) in [(&one[..], "1 scene: 1 passed"), (&closed[..], "| all ")] {
        let Some(out) = on_small_disk(&folder, &[args, &["--json", "disk/a.json"]].concat(), Some(0)) else {
            return;
        };
        assert_full(&out, "can't write disk/a.json", NO_ROOM);
        let stderr = String::from_utf8_lossy(&out.stderr);
        assert!(stderr.contains("what is done is not kept"), "{stderr}");
        assert!(String::from_utf8_lossy(&out.stdout).contains(last), "the run ended before its end");
        assert_eq!(files(&folder.path("left")), ["a.json"]);
        assert_eq!(fs::read_to_string(folder.path("left/a.json")).unwrap(), "that of before");
    }
}

/// Runs `args` with a cache on the disk, which is full.
fn with_full_cache(folder: &Folder, args: &[&str], bin: &Path) -> Option<Output> {
    let mut boxwood = folder.command(args);
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    boxwood.env("BOXWOOD_CACHE", folder.path("disk")).env("PATH", path);
    on_small_disk_with(boxwood, folder, args, Some(0))
}

#[test]
fn a_full_cache_keeps_nothing_in_part() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let bin = folder.path("bin");
    fs::create_dir(&bin).unwrap();
    fs::create_dir(folder.path("disk")).unwrap();
    fs::write(bin.join("npm"), "#!/bin/sh\nexec head -c 9000 /dev/zero > half.tgz\n").unwrap();
    fs::set_permissions(bin.join("npm"), fs::Permissions::from_mode(0o755)).unwrap();
    // What a device's tests cost is measured, and measured again.
    let args = ["-q", "build", "two.tri", "--runs", "1", "--builder", "dito", "--costs", "measured"];
    let Some(out) = with_full_cache(&folder, &args, &bin) else { return };
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!(!json["sah_costs"].is_null(), "{json}");
    assert!(files(&folder.path("left")).is_empty());
    // A mesh has to be kept.
    let out = with_full_cache(&folder, &["scenes", "fetch", "dragon"], &bin).unwrap();
    let stderr = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.code() == Some(1) && stderr.contains("No space left on device"), "{stderr}");
    assert!(files(&folder.path("left")).is_empty());
}

#[test]
fn two_runs_in_one_folder_do_not_mix() {
    let folder = folder();
    let run = args(&["--out", "r", "--quiet", "--rays", "primary,ao"]);
    let mut first = folder.command(&run).stdout(std::process::Stdio::null()).spawn().unwrap();
    let rows = folder.path("r/rows.jsonl");
    while fs::metadata(&rows).map_or(0, |m| m.len()) == 0 && first.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    for more in [&[][..], &["--resume"]] {
        let second = folder.run(&[&run[..], more].concat());
        // Where the first was faster, the second is as good as alone.
        if first.try_wait().unwrap().is_none() {
            assert_full(&second, "r/rows.jsonl", "another boxwood writes");
        }
    }
    assert!(first.wait().unwrap().success());
    assert!(folder.run(&[&run[..], &["--resume"]].concat()).status.success());
}
