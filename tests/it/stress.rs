//! The catalogue that tries to break all: some of it here; and that what is broken is found, made small and saved.

#![allow(clippy::unwrap_used)]

use crate::cli::Folder;
use crate::gpu::quiet;
use boxwood::abi::Hit;
use boxwood::bvh::{Bvh, Method};
use boxwood::device::{Device, DeviceError};
use boxwood::stress::smallest::{Again, Budget, save, smallest};
use boxwood::stress::{Answer, CASES, Effort, Kind, Outcome, Plan, Row, SETS, chosen, run, traced};
use boxwood::trace::{Batch, Options, Precision, Query, Walk};
use serde_json::Value;
use std::fs;
use std::sync::Arc;
use std::time::Duration;

fn plan(builders: &[&str]) -> Plan {
    let methods = builders.iter().map(|name| Method::named(name).unwrap()).collect();
    Plan { effort: Effort::Quick, methods, precisions: Precision::ALL.to_vec(), rays: 28, seed: 7 }
}

fn rows(device: &Arc<Device>, scenes: &[&str], plan: &Plan, answer: Answer) -> Vec<Row> {
    let cases = chosen(&scenes.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>());
    assert_eq!(cases.len(), scenes.len());
    run(device, &cases, plan, answer, &|_| {})
}

#[test]
fn some_of_the_catalogue() {
    let device = quiet();
    let scenes = ["/none", "/one", "/zero-area", "/scaled-1e-30", "/halves"];
    for row in rows(&device, &scenes, &plan(&["ploc", "lbvh", "auto"]), &traced) {
        assert_eq!(row.outcome(), Outcome::Pass, "{}: {:?}", row.case.title(), row.failures);
        assert!(row.cases >= 3 * 8 && row.rays >= row.cases * SETS.len(), "{}", row.case.title());
    }
}

#[test]
fn a_tree_too_deep_is_refused() {
    let device = quiet();
    let row = &rows(&device, &["/too-deep"], &plan(&["ploc", "lbvh"]), &traced)[0];
    assert_eq!(row.outcome(), Outcome::Refused, "{:?}", row.failures);
    let said = row.refused.as_deref().unwrap();
    assert!(said.contains("entries of a ray's stack: 4400 exceeds this device's limit of 4096"), "{said}");
    // The radix tree is as deep as its codes at most, and answers.
    assert!(row.refusals == 1 && row.rays > 0, "{row:?}");
    // What is traced in spite of it is no answer.
    let careless = |_: &Arc<Device>, _: &Bvh, batch: &Batch, _: Options| batch.hits.read();
    let row = &rows(&device, &["/too-deep"], &plan(&["ploc"]), &careless)[0];
    assert!(row.failures.iter().any(|f| f.kind == Kind::Trace), "{row:?}");
}

type Hits = Result<Vec<Hit>, DeviceError>;

/// Misses triangles of odd numbers.
fn blind(device: &Arc<Device>, bvh: &Bvh, batch: &Batch, options: Options) -> Hits {
    let odd = |h: &Hit| h.is_hit() && h.triangle % 2 == 1;
    let hits = traced(device, bvh, batch, options)?;
    Ok(hits.into_iter().map(|h| if odd(&h) { Hit::MISS } else { h }).collect())
}

/// Weights swapped by packets.
fn turned(device: &Arc<Device>, bvh: &Bvh, batch: &Batch, options: Options) -> Hits {
    let mut hits = traced(device, bvh, batch, options)?;
    if options.walk == Walk::Packet {
        hits.iter_mut().for_each(|h| std::mem::swap(&mut h.u, &mut h.v));
    }
    Ok(hits)
}

/// NaN where the fast test hits.
fn undefined(device: &Arc<Device>, bvh: &Bvh, batch: &Batch, options: Options) -> Hits {
    let mut hits = traced(device, bvh, batch, options)?;
    if options.precision == Precision::Fast {
        hits.iter_mut().filter(|h| h.is_hit()).for_each(|h| h.t = f32::NAN);
    }
    Ok(hits)
}

/// What was there before.
fn idle(_: &Arc<Device>, _: &Bvh, batch: &Batch, _: Options) -> Hits {
    batch.hits.read()
}

#[test]
fn what_is_broken_is_found_made_small_and_saved() {
    let device = quiet();
    let plan = plan(&["ploc", "lbvh"]);
    let broken: [(&str, Answer, Kind, Precision); 4] = [
        ("blind", &blind, Kind::Hits, Precision::Robust),
        ("turned", &turned, Kind::Differ, Precision::Robust),
        ("undefined", &undefined, Kind::Hits, Precision::Fast),
        ("idle", &idle, Kind::Hits, Precision::Robust),
    ];
    for (name, answer, kind, precision) in broken {
        let row = &rows(&device, &["/soup"], &plan, answer)[0];
        assert_eq!(row.outcome(), Outcome::Fail, "{name}");
        let wanted = (kind, precision, Query::Closest);
        let failure = row
            .failures
            .iter()
            .find(|f| (f.kind, f.options.precision, f.options.query) == wanted)
            .unwrap_or_else(|| panic!("{name}: {:?}", row.failures));
        let small = smallest(
            &device,
            answer,
            &plan,
            row,
            failure,
            Budget { time: Duration::from_secs(60), ..Budget::default() },
        );
        assert_eq!(small.again, Again::Failed, "{name}: {}", small.what);
        // An odd number is the second of two at least.
        assert_eq!(small.rays.len(), 1, "{name}");
        assert!(small.scene.triangles.len() <= 2, "{name}: {} triangles", small.scene.triangles.len());

        let folder = Folder::new();
        let saved = save(&folder.path("."), &device, &plan, row, failure, &small).unwrap();
        assert_eq!((saved.rays, saved.triangles), (1, small.scene.triangles.len()));
        let note: Value = serde_json::from_slice(&fs::read(&saved.files[2]).unwrap()).unwrap();
        assert_eq!((&note["scene"], &note["again"]), (&"triangles/soup".into(), &"failed".into()));
        assert_eq!(note["replay"][0], saved.replay[0]);
        assert_eq!(saved.replay.len(), if kind == Kind::Differ { 3 } else { 1 });
        // The program's own answers are right: what is replayed is checked and clean.
        let words: Vec<&str> = saved.replay[0].split(' ').collect();
        assert_eq!(words[0], "boxwood");
        let out = folder.run(&words[1..]);
        assert!(out.status.success(), "{name}: {}", String::from_utf8_lossy(&out.stderr));
        let said: Value = serde_json::from_slice(&out.stdout).unwrap();
        assert_eq!((&said["rays"], &said["check"]["hits"]["malformed"]), (&1.into(), &0.into()));
        assert_eq!(said["triangles"], saved.triangles);
    }
}

#[test]
fn all_that_there_is_is_listed() {
    let out = Folder::new().run(&["stress", "--list"]);
    let list = String::from_utf8(out.stdout).unwrap();
    for case in CASES {
        let line = list.lines().find(|l| l.contains(&format!("| {} ", case.title())));
        assert!(line.is_some_and(|l| l.contains(case.why)), "{}: {list}", case.title());
    }
    assert!(SETS.iter().all(|s| list.contains(&format!("| {} ", s.name)) && list.contains(s.why)), "{list}");
}

#[test]
fn the_program_says_what_it_tried() {
    let folder = Folder::new();
    let args =
        ["stress", "--quick", "--only", "/two", "--only", "flat-y", "--builders", "ploc,sah", "--json", "a"];
    let out = folder.run(&[&args[..], &["--rays", "12", "--quiet"]].concat());
    let table = String::from_utf8(out.stdout).unwrap();
    assert!(out.status.success() && out.stderr.is_empty(), "{table}{}", String::from_utf8_lossy(&out.stderr));
    let json: Value = serde_json::from_slice(&fs::read(folder.path("a")).unwrap()).unwrap();
    let scenes = json["scenes"].as_array().unwrap();
    // two, two-codes, flat-y, flat-yz.
    assert_eq!((scenes.len(), &json["summary"]["passed"]), (4, &4.into()), "{json}");
    assert_eq!(table.lines().count(), 2 + 4 + 2, "{table}");
    assert!(
        table.lines().last().unwrap().starts_with("4 scenes: 4 passed, 0 refused, 0 failed; "),
        "{table}"
    );
    for scene in scenes {
        assert_eq!(scene["rays"], scene["cases"].as_u64().unwrap() * 12 * SETS.len() as u64);
        for key in ["missed", "false_hits", "leaked", "wrong_triangle", "malformed", "differing"] {
            assert_eq!(scene["robust"][key], 0, "{key}: {scene}");
        }
    }
    assert!(!folder.path("stress").exists(), "a folder though nothing failed");
    folder.fails(&["stress", "--only", "nonesuch"], 1, "nonesuch: see `boxwood stress --list`");
    folder.fails(&["stress", "--builders", "nonesuch"], 2, "nonesuch");
    folder.fails(&["stress", "--rays", "0"], 2, "0");
}
