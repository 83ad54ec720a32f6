//! Processes that fill one cache at once, and a cache that was damaged. Fetched scenes: `src/scene/fetch/tests.rs`.

use crate::cli::Folder;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::{Child, Stdio};

#[test]
fn processes_fill_one_cache() {
    let folder = Folder::new();
    let cache = folder.path("cache");
    let args = ["-q", "build", "two.tri", "--runs", "1", "--builder", "dito", "--costs", "measured"];
    let start = || -> Child {
        let mut command = folder.command(&args);
        command.env("BOXWOOD_CACHE", &cache).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let costs = |child: Child| -> Value {
        let out = child.wait_with_output().unwrap();
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let mut json: Value = serde_json::from_slice(&out.stdout).unwrap();
        json["sah_costs"].take()
    };
    let file = || -> PathBuf {
        let files: Vec<PathBuf> = fs::read_dir(&cache).unwrap().map(|e| e.unwrap().path()).collect();
        assert_eq!(files.len(), 1, "{files:?}");
        files[0].clone()
    };
    let all = [start(), start(), start()].map(costs);
    let kept = fs::read_to_string(file()).unwrap();
    let again = costs(start());
    assert!(all.contains(&again), "{again} is none of {all:?}");
    assert_eq!(fs::read_to_string(file()).unwrap(), kept, "measured anew, though all was well");
    // Cut off, and one digit another: noticed, and made anew.
    let digit = kept.find("\"boxes\": ").unwrap() + "\"boxes\": ".len();
    let mut flipped = kept.clone().into_bytes();
    flipped[digit] ^= 1;
    for damaged in [&kept.as_bytes()[..kept.len() / 2], &flipped] {
        fs::write(file(), damaged).unwrap();
        let anew = costs(start());
        assert!(fs::read(file()).unwrap() != damaged, "damaged, and still there");
        assert_eq!(costs(start()), anew, "not kept");
    }
}
