//! Profiles as programs see them: tables, figures and timelines.

use super::format::fault;
use crate::cli::Folder;
use boxwood::trace::Walk;
use serde_json::Value;
use std::fs;

fn profile(folder: &Folder, args: &[&str]) -> (String, Value, Value) {
    let base = ["--width", "24", "--height", "16", "--runs", "2", "--out", "t.json", "--json", "p.json"];
    let out = folder.run(&[&["profile"], args, &base].concat());
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let read = |name: &str| serde_json::from_slice(&fs::read(folder.path(name)).unwrap()).unwrap();
    (String::from_utf8(out.stdout).unwrap(), read("t.json"), read("p.json"))
}

#[test]
fn timelines_are_in_the_trace_event_format() {
    let folder = Folder::new();
    for scene in ["sphere:5k", "two.tri"] {
        for builder in ["ploc", "sah"] {
            let rays = "primary,ao,diffuse,shadow";
            let (said, timeline, figures) = profile(&folder, &[scene, "--builder", builder, "--rays", rays]);
            assert_eq!(fault(&timeline), None, "{scene}, {builder}");
            let events = timeline["traceEvents"].as_array().unwrap();
            let device: Vec<&Value> = events.iter().filter(|e| e["args"]["kernel"].is_string()).collect();
            for part in figures["parts"].as_array().unwrap() {
                for kernel in part["kernels"].as_array().unwrap() {
                    let name = kernel["name"].as_str().unwrap();
                    assert!(said.contains(&format!(" {name} ")), "{name} in {said}");
                    let there = events.iter().filter(|e| e["name"] == name).count() as u64;
                    assert!(
                        there >= kernel["calls"].as_u64().unwrap(),
                        "{scene}, {builder}: {there} of {name}"
                    );
                }
            }
            assert!(device.iter().any(|e| e["name"] == "layout/triangles" && e["tid"] == 2));
            assert!(device.iter().any(|e| e["args"]["stage"] == "trace" && e["tid"] == 3));
            assert!(
                device.iter().all(|e| e["args"]["bytes_read"].is_u64() || e["args"]["invocations"].is_null())
            );
        }
    }
}

#[test]
fn bytes_of_a_traversal_are_those_that_rays_ask_for() {
    let folder = Folder::new();
    let (said, _, figures) = profile(&folder, &["sphere:5k", "--rays", "primary,diffuse"]);
    assert!(said.contains("Active lanes a step"), "{said}");
    for (part, lanes) in figures["parts"].as_array().unwrap()[1..].iter().zip(["primary", "diffuse"]) {
        assert_eq!(part["name"], lanes);
        let row = part["kernels"].as_array().unwrap().last().unwrap();
        let walks = figures["lanes"].as_array().unwrap();
        let walk = walks.iter().find(|l| l["rays"] == lanes && l["kernel"] == row["name"]).unwrap();
        let of = |what: &str| {
            let by = if row["name"] == "trace/packet" { "steps" } else { "lanes" };
            walk[what][by].as_u64().unwrap()
        };
        let ray = if walk["sorted"] == true { 32 + 4 + 16 } else { 32 + 16 };
        let bytes = 64 * of("nodes") + 40 * of("triangles") + ray * walk["count"].as_u64().unwrap();
        assert_eq!(row["bytes"], bytes);
        assert_eq!(walks.iter().filter(|l| l["rays"] == lanes).count(), Walk::ALL.len());
    }
}

#[test]
fn scenes_may_have_any_name() {
    let folder = Folder::new();
    let name = "a\"],}\\ <b>\u{1f}é.tri";
    fs::copy(folder.path("two.tri"), folder.path(name)).unwrap();
    let (_, timeline, figures) = profile(&folder, &[name, "--rays", "primary"]);
    assert_eq!(fault(&timeline), None);
    let scene = figures["scene"].as_str().unwrap();
    assert!(scene.contains("\"],}\\ <b>\u{1f}é"), "{scene:?}");
    assert_eq!(timeline["otherData"]["scene"], scene);
    let process = timeline["traceEvents"].as_array().unwrap().iter().find(|e| e["name"] == "process_name");
    assert!(process.unwrap()["args"]["name"].as_str().unwrap().contains(scene));
}

#[test]
fn rays_that_meet_nothing_leave_none() {
    let folder = Folder::new();
    folder.write("none.tri", &[f32::NAN; 9]);
    let (_, timeline, figures) = profile(&folder, &["none.tri", "--rays", "primary,ao"]);
    assert_eq!(fault(&timeline), None);
    let parts: Vec<&str> =
        figures["parts"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert_eq!(parts, ["build", "primary"]);
}

#[test]
fn what_can_not_be_profiled_is_refused() {
    let folder = Folder::new();
    folder.fails(&["profile", "two.tri", "--rays", "primary,x-rays"], 2, "x-rays");
    folder.fails(&["profile", "two.tri", "--runs", "0"], 2, "runs");
    folder.fails(&["profile", "two.tri", "--width", "0"], 2, "width");
    folder.fails(&["profile", "two.tri", "--out", "none/t.json"], 1, "none/t.json");
    folder.fails(&["profile", "two.tri", "--out", "."], 1, "directory");
    folder.fails(&["profile", "none.tri", "--out", "t.json"], 1, "none.tri");
}
