//! `boxwood bench` as a program: its files, and that a run cut off anywhere goes on to the same rows.

#![allow(clippy::unwrap_used)]

use crate::cli::Folder;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::process::Stdio;
use std::time::Duration;

const ARGS: [&str; 11] = [
    "bench",
    "sphere:2k",
    "hairball:2k",
    "--preset",
    "quick",
    "--runs",
    "1",
    "--views",
    "2",
    "--builders",
    "ploc,wide-leaves",
];
/// Builders of a file of one's own.
const PRESETS: &str = "[recipes.default]
builder = 'ploc'
morton = 'auto'
radius = 8
traversal-cost = 3
node-cost = 4
triangle-cost = 2
max-leaf = 8
fit = 'aabb'
oriented-cost = 5
[recipes.ploc]
parent = 'default'
[recipes.wide-leaves]
parent = 'default'
max-leaf = 32
[presets.quick]
scenes = []
builders = []
rays = ['primary', 'ao', 'diffuse', 'shadow', 'file:b.rays']
views = 1
width = 64
height = 48
warm-ups = 1
runs = 1
sample = 2048
check = 500
";
/// Two scenes × two builders × (a build, four sets of two views, a file).
const ROWS: usize = 2 * 2 * (1 + 4 * 2 + 1);

/// A folder with presets and rays of its own.
pub fn folder() -> Folder {
    let folder = Folder::new();
    fs::write(folder.path("presets.toml"), PRESETS).unwrap();
    let rays: Vec<f32> =
        (0..100).flat_map(|i| [0.0, 0.0, 5.0, 0.0, i as f32 * 0.004 - 0.2, 0.1, -1.0, 100.0]).collect();
    folder.write("b.rays", &rays);
    folder
}

/// What measures two scenes with two builders there.
pub fn args<'a>(more: &[&'a str]) -> Vec<&'a str> {
    ARGS.into_iter().chain(["--presets", "presets.toml"]).chain(more.iter().copied()).collect()
}

/// The rows of a file by what they are about, without times and what hangs on times; what a ray costs follows from the
/// costs in the file's first line.
pub fn rows(folder: &Folder, path: &str) -> BTreeMap<String, Value> {
    let mut rows = BTreeMap::new();
    let text = fs::read_to_string(folder.path(path)).unwrap();
    let mut lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let costs = lines.next().unwrap()["costs"].take();
    for mut row in lines {
        let fields = row.as_object_mut().unwrap();
        if let Some(per_ray) = fields.remove("cost_per_ray") {
            assert_costs(&per_ray, &fields["tests"], &costs, &fields["rays"]);
        }
        for timed in ["build_ms", "build_wall_ms", "trace_ms", "kernel", "sorted", "kernels"] {
            fields.remove(timed);
        }
        let key = ["row", "scene", "builder", "view", "set"].map(|k| fields.get(k).map(Value::to_string));
        assert!(rows.insert(format!("{key:?}"), row).is_none(), "twice: {key:?}");
    }
    rows
}

/// `per_ray` is what `tests` of `rays` rays cost in the mean.
fn assert_costs(per_ray: &Value, tests: &Value, costs: &Value, rays: &Value) {
    let cost = |test: &str| tests[test].as_f64().unwrap() * costs[test].as_f64().unwrap();
    let sum = cost("boxes") + cost("oriented") + cost("triangles");
    let expected = sum / rays.as_f64().unwrap();
    assert!((per_ray.as_f64().unwrap() / expected - 1.0).abs() < 1e-12, "{per_ray} for {expected}");
}

#[test]
fn bench_writes_its_tables() {
    let folder = folder();
    let out = folder.run(&args(&["--out", "r"]));
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    assert_eq!(rows(&folder, "r/rows.jsonl").len(), ROWS);
    let json: Value = serde_json::from_slice(&fs::read(folder.path("r/bench.json")).unwrap()).unwrap();
    let (builds, rays) = (json["builds"].as_array().unwrap(), json["rays"].as_array().unwrap());
    assert_eq!((builds.len(), rays.len()), (4, ROWS - 4));
    assert_ne!(builds[0]["tree_hash"], builds[1]["tree_hash"], "one recipe for two builders");
    for row in rays {
        assert!(row["rays"].as_u64().unwrap() > 0 && row["check"]["rays"].as_u64().unwrap() > 0, "{row}");
        assert!(row["trace_ms"]["median"].as_f64().unwrap() > 0.0, "{row}");
        assert_costs(&row["cost_per_ray"], &row["tests"], &json["costs"], &row["rays"]);
    }
    for row in builds {
        let [of, aabb] = ["cost", "aabb_cost"].map(|key| row["tight"][key].as_f64().unwrap());
        assert!(
            of > 0.0 && of == aabb && row["tight"]["aabb_share"] == 1.0 && row["mixed"].is_null(),
            "{row}"
        );
    }
    let sorted = |rows: &[Value]| rows.iter().filter(|r| r["sorted"] == true).count();
    let on = folder.run(&args(&["--out", "s", "--sort", "on"]));
    assert!(on.status.success(), "{}", String::from_utf8_lossy(&on.stderr));
    let json: Value = serde_json::from_slice(&fs::read(folder.path("s/bench.json")).unwrap()).unwrap();
    let primaries = rays.iter().filter(|r| r["set"] == "primary").count();
    assert_eq!(sorted(json["rays"].as_array().unwrap()), rays.len() - primaries, "all but primaries");
    // The same rays for every builder, and the same hits.
    let counts = |builder: &str| -> Vec<_> {
        let of = rays.iter().filter(|r| r["builder"] == builder);
        of.map(|r| (r["set"].clone(), r["view"].clone(), r["rays"].clone(), r["hits"].clone())).collect()
    };
    assert_eq!(counts("ploc"), counts("wide-leaves"));
    let csv = fs::read_to_string(folder.path("r/bench.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + rays.len(), "{csv}");
    let tables = String::from_utf8(out.stdout).unwrap();
    assert!(tables.contains("file:b.rays") && tables.contains("wide-leaves"), "{tables}");
}

#[test]
fn a_run_cut_off_goes_on() {
    let folder = folder();
    let out = folder.run(&args(&["--out", "whole"]));
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let lines = || fs::read_to_string(folder.path("cut/rows.jsonl")).map_or(0, |text| text.lines().count());
    for kill in 0..10 {
        let run = args(&["--out", "cut", "--resume", "--quiet"]);
        let mut child = folder.command(&run).stdout(Stdio::null()).spawn().unwrap();
        // Some way on from the last time, at any moment between two rows.
        let wanted = kill * (ROWS - 2) / 10;
        while lines() < wanted && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(kill as u64 * 7 % 10 * 3));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(kill > 5 || lines() <= ROWS, "run {kill} was over before it was killed");
    }
    let out = folder.run(&args(&["--out", "cut", "--resume"]));
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    assert_eq!(rows(&folder, "cut/rows.jsonl"), rows(&folder, "whole/rows.jsonl"));
    let others: Vec<_> = fs::read_dir(folder.path("cut")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(others.len(), 4, "something is left over: {others:?}");
}

#[test]
fn oriented_trees_are_measured_against_axis_aligned_ones() {
    let folder = Folder::new();
    let mut presets = PRESETS.replace("'primary', 'ao', 'diffuse', 'shadow', 'file:b.rays'", "'primary'");
    presets.push_str("[recipes.dito]\nparent = 'default'\nbuilder = 'dito14'\nfit = 'dito14'\n");
    fs::write(folder.path("presets.toml"), presets).unwrap();
    let args = ["bench", "city-rotated:5k", "--preset", "quick", "--presets", "presets.toml"];
    let out = folder.run(&[&args[..], &["--builders", "dito,ploc", "--out", "r"]].concat());
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let json: Value = serde_json::from_slice(&fs::read(folder.path("r/bench.json")).unwrap()).unwrap();
    let (builds, rays) = (&json["builds"], &json["rays"]);
    let of = |row: &Value, key: &str| row["tight"][key].as_f64().unwrap();
    let (dito, ploc) = (&builds[0], &builds[1]);
    assert!(of(dito, "aabb_share") < 0.9 && of(dito, "total_area") < 0.9, "{dito}");
    // The tree before, and the tree that PLOC builds, are one.
    assert!((of(dito, "aabb_cost") / of(ploc, "cost") - 1.0).abs() < 1e-6, "{dito}");
    let [cost, aabb_cost] = ["cost", "aabb_cost"].map(|key| dito["mixed"][key].as_f64().unwrap());
    assert!(cost < 0.9 * aabb_cost && cost / aabb_cost < of(dito, "cost") / of(dito, "aabb_cost"), "{dito}");
    assert!(
        rays[0]["tests"]["oriented"].as_u64().unwrap() > 0 && rays[1]["tests"]["oriented"] == 0,
        "{rays}"
    );
    let csv = fs::read_to_string(folder.path("r/bench.csv")).unwrap();
    let mut csv = csv::Reader::from_reader(csv.as_bytes());
    let at = csv.headers().unwrap().iter().position(|h| h == "memory_share").unwrap();
    let shares: Vec<String> = csv.records().map(|r| r.unwrap()[at].to_owned()).collect();
    assert_eq!(shares, ["1.0", "1.0"], "an oriented node takes no more");
}

#[test]
fn what_cannot_be_measured_is_said() {
    let folder = folder();
    folder.fails(&["bench", "--preset", "nonesuch"], 1, "no preset is called \"nonesuch\"");
    folder.fails(&["bench", "sphere:9", "--builders", "nonesuch"], 1, "no builder is called \"nonesuch\"");
    folder.fails(&["bench", "sphere:9", "--rays", "nonesuch"], 1, "no rays are called \"nonesuch\"");
    folder.fails(&["bench", "sphere:9", "--rays", "file:none.rays"], 1, "none.rays");
    let first = ["bench", "sphere:9", "--preset", "quick", "--runs", "1", "--out", "o", "--resume"];
    assert!(folder.run(&first).status.success());
    let other = ["bench", "sphere:9", "--preset", "quick", "--runs", "2", "--out", "o", "--resume"];
    folder.fails(&other, 1, "its plan is");
}
