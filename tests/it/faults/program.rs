//! The program on a device that fails: one line that says what to do, exit code 1, no file in part; rows already measured
//! stay.

use crate::bench::{args, folder, rows};
use crate::cli::Folder;
use serde_json::Value;
use std::fs;
use std::process::Output;

fn with(folder: &Folder, fault: &str, args: &[&str]) -> Output {
    folder.command(args).env("BOXWOOD_FAULT", fault).output().unwrap()
}

/// The error: one line, the last.
fn error(out: &Output, what: &str) -> String {
    let stderr = String::from_utf8(out.stderr.clone()).unwrap();
    assert_eq!(out.status.code(), Some(1), "{what}: {stderr}");
    let errors: Vec<&str> = stderr.lines().filter(|line| line.starts_with("error: ")).collect();
    assert!(errors.len() == 1 && stderr.lines().last() == Some(errors[0]), "{what}: {stderr}");
    errors[0].to_owned()
}

#[test]
fn each_command_fails_in_one_line_and_writes_nothing() {
    let folder = Folder::new();
    let size = ["--width", "32", "--height", "24"];
    let commands: [(&[&str], &[&str]); 5] = [
        (&["build", "two.tri", "--runs", "1", "--json", "b.json"], &[]),
        (
            &["query", "two.tri", "--rays", "a.rays", "--out", "a.hits", "--runs", "1", "--json", "q.json"],
            &[],
        ),
        (&["render", "two.tri", "--out", "p.png", "--mode", "ao", "--samples", "2"], &size),
        (&["boxes", "two.tri", "--level", "1", "--out", "b.obj", "--out", "b.png", "--out", "b.glb"], &size),
        (
            &[
                "profile", "two.tri", "--rays", "primary", "--runs", "1", "--out", "t.json", "--json",
                "p.json",
            ],
            &size,
        ),
    ];
    let faults =
        ["allocation:1", "submit:1", "allocation:60", "fence:4", "allocation:300", "submit:9", "budget:1MiB"];
    let before = folder.names();
    for (i, (args, size)) in commands.into_iter().enumerate() {
        let args = [&["-q"][..], args, size].concat();
        // Three of the faults, other ones for the next command; all of them are met by some.
        for j in 0..3 {
            let fault = faults[(3 * i + j) % faults.len()];
            let said = error(&with(&folder, fault, &args), &format!("{fault}, {args:?}"));
            let kind =
                if fault.contains("submit") || fault.contains("fence") { "device lost" } else { "memory" };
            assert!(said.contains(kind) && said.contains("another --device"), "{fault}, {args:?}: {said}");
            assert_eq!(folder.names(), before, "{fault}, {args:?}");
        }
    }
    for absurd in ["allocation:0", "submit:-1", "budget:64", "nonesuch"] {
        let said = error(&with(&folder, absurd, &["-q", "build", "two.tri"]), absurd);
        assert!(said.contains("BOXWOOD_FAULT") && said.contains("allocation:N"), "{said}");
    }
}

#[test]
fn rows_outlive_a_failing_device() {
    let folder = folder();
    let run = |out: &'static str| args(&["--out", out, "--resume", "--quiet", "--rays", "primary,ao"]);
    assert!(folder.run(&run("whole")).status.success());
    let text = || fs::read_to_string(folder.path("cut/rows.jsonl")).unwrap_or_default();
    let mut kept = String::new();
    // Further on each time, until there are rows.
    for tries in 1..20 {
        let fault = match tries % 3 {
            0 => format!("allocation:{}", 250 * tries),
            1 => format!("submit:{}", 60 * tries),
            _ => format!("fence:{}", 60 * tries),
        };
        let said = error(&with(&folder, &fault, &run("cut")), &fault);
        let kind = if tries % 3 == 0 { "memory" } else { "device lost" };
        assert!(said.contains(kind), "{fault}: {said}");
        assert!(text().starts_with(&kept) && text().ends_with('\n'), "{fault}: a finished row is lost");
        kept = text();
        if kept.lines().count() > 3 {
            break;
        }
    }
    assert!(kept.lines().count() > 3, "no row was finished before a fault");
    let out = folder.run(&run("cut"));
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    assert!(text().starts_with(&kept));
    assert_eq!(rows(&folder, "cut/rows.jsonl"), rows(&folder, "whole/rows.jsonl"));
}

#[test]
fn scenes_tried_outlive_a_failing_device() {
    let folder = Folder::new();
    let json = |file| -> Value { serde_json::from_slice(&fs::read(folder.path(file)).unwrap()).unwrap() };
    // What fails is a finding, and named.
    let only = ["--only", "/none", "--only", "/one", "--builders", "ploc", "--rays", "7"];
    let args = [&["stress", "--quick", "--json", "s.json"], &only[..]].concat();
    let said = error(&with(&folder, "submit:30", &args), "stress");
    assert_eq!(said, "error: 1 of 2 scenes failed; what was saved is in stress");
    let scenes = &json("s.json")["scenes"];
    assert_eq!((&scenes[0]["outcome"], &scenes[1]["outcome"]), (&"pass".into(), &"fail".into()));
    assert!(scenes[1]["failures"][0]["what"].as_str().unwrap().contains("device lost"), "{scenes}");
    // A long run ends there, and keeps its rows.
    let args = ["stress", "--closed", "20000", "--builders", "ploc", "--json", "c.json", "-q"];
    let said = error(&with(&folder, "submit:300", &args), "closed");
    assert!(said.contains("device lost"), "{said}");
    let report = json("c.json");
    let rays: u64 = report["rows"].as_array().unwrap().iter().map(|row| row["rays"].as_u64().unwrap()).sum();
    assert_eq!((&report["rays"], &report["left"]), (&rays.into(), &(20_000 - rays).into()));
    assert!(0 < rays && rays < 20_000, "{rays} rays");
}

#[test]
fn a_scene_that_does_not_fit_leaves_the_others() {
    let folder = folder();
    let run = |out: &'static str| {
        let base =
            ["bench", "sphere:500", "soup:60k", "cube.tri", "--preset", "quick", "--presets", "presets.toml"];
        let more = ["--builders", "ploc", "--rays", "primary", "--runs", "1", "--views", "1", "--no-check"];
        [&base[..], &more[..], &["--quiet", "--resume", "--out", out]].concat()
    };
    fs::copy(folder.path("two.tri"), folder.path("cube.tri")).unwrap();
    let whole = folder.run(&run("whole"));
    assert!(whole.status.success(), "{}", String::from_utf8_lossy(&whole.stderr));
    let said = error(&with(&folder, "budget:16MiB", &run("cut")), "budget");
    let wanted =
        "soup:60k could not be measured: a scene of 60000 triangles, and building over it with ploc, needs ";
    assert!(
        said.contains(wanted) && said.contains(" MiB are free on ") && said.contains("--resume"),
        "{said}"
    );
    let there = rows(&folder, "cut/rows.jsonl");
    assert_eq!(there.len(), 4, "{:?}", there.keys());
    let page = fs::read_to_string(folder.path("cut/report.html")).unwrap();
    assert!(page.contains("missing") && page.contains("cube.tri"));
    assert!(folder.run(&run("cut")).status.success());
    assert_eq!(rows(&folder, "cut/rows.jsonl"), rows(&folder, "whole/rows.jsonl"));
    // Before the scene is made: a thousand million triangles would take minutes.
    for args in [
        &["-q", "build", "sphere:1000M"][..],
        &["-q", "query", "sphere:1000M", "--rays", "a.rays", "--out", "a.hits"],
    ] {
        let said = error(&with(&folder, "budget:64MiB", args), "build");
        assert!(
            said.contains("a scene of 1000000000 triangles") && said.contains("64 MiB are free"),
            "{said}"
        );
    }
    // ODOP keeps to what is granted.
    let said =
        error(&folder.run(&["-q", "build", "sphere:60k", "--builder", "odop4", "--memory", "1MiB"]), "odop");
    assert!(said.contains("--memory") && said.contains("1 MiB are allowed"), "{said}");
}
