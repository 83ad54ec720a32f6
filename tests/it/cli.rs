//! The binary as other programs use it: files in, files out, JSON, exit codes.

#![allow(clippy::unwrap_used)]

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder with two triangles over each other, three rays down, and no hits yet.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        let floor = |z: f32| [0.0, 0.0, z, 4.0, 0.0, z, 0.0, 4.0, z];
        // The third can't be hit.
        folder.write("two.tri", &[floor(0.0), floor(1.0), [f32::NAN; 9]].concat());
        let down = |x: f32, t_max: f32| [x, 1.0, 5.0, 0.0, 0.0, 0.0, -2.0, t_max];
        folder
            .write("a.rays", &[down(1.0, f32::INFINITY), down(9.0, f32::INFINITY), down(1.0, 1.5)].concat());
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, floats: &[f32]) {
        let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
        fs::write(self.path(name), bytes).unwrap();
    }

    /// What is in it.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.0.path())
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// The program, to be run in the folder, without the validation layers: these watch the tests' own devices, and one
    /// of fifteen such processes side by side died of a C++ exception with layers of 1.3.239.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_boxwood"));
        command.args(args).current_dir(self.0.path()).env_remove("BOXWOOD_VALIDATION");
        // What the device's tests cost is measured once for all tests, and nowhere but here.
        command.env("BOXWOOD_CACHE", concat!(env!("CARGO_TARGET_TMPDIR"), "/cache"));
        command
    }

    pub fn run(&self, args: &[&str]) -> Output {
        self.command(args).output().unwrap()
    }

    /// Runs what must fail with `code`: says so in one line of stderr that holds `words`, and writes nothing.
    pub fn fails(&self, args: &[&str], code: i32, words: &str) {
        let before = self.names();
        let out = self.run(args);
        let stderr = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(code), "{args:?}: {stderr}");
        let line =
            stderr.lines().find(|l| l.starts_with("error: ")).unwrap_or_else(|| panic!("{args:?}: {stderr}"));
        assert!(line.contains(words), "{args:?}: {line}");
        assert_eq!(self.names(), before, "{args:?} left something");
    }
}

/// t and triangle of each hit.
fn hits(path: &Path) -> Vec<(f32, u32)> {
    let word = |b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    fs::read(path).unwrap().chunks_exact(16).map(|h| (f32::from_bits(word(h)), word(&h[4..]))).collect()
}

const MISS: (f32, u32) = (f32::INFINITY, u32::MAX);

#[test]
fn query_round_trip() {
    let folder = Folder::new();
    let base = ["query", "two.tri", "--rays", "a.rays", "--out", "a.hits", "--runs", "1"];
    let out = folder.run(&[&base[..], &["--json", "a.json", "--count", "--check", "--explain"]].concat());
    let stderr = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{stderr}");
    assert!(
        stderr.contains("explain: ") && stderr.contains("left out") && stderr.contains("check: clean"),
        "{stderr}"
    );
    assert_eq!(hits(&folder.path("a.hits")), [(2.0, 1), MISS, MISS]);
    assert_eq!(folder.names(), ["a.hits", "a.json", "a.rays", "two.tri"]);

    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(json, serde_json::from_slice::<Value>(&fs::read(folder.path("a.json")).unwrap()).unwrap());
    let numbers = [
        "triangles",
        "rays",
        "hits",
        "build_ms",
        "build_ms_min",
        "trace_ms",
        "trace_ms_min",
        "build_wall_ms",
        "trace_wall_ms",
        "mrays_s",
        "bvh_bytes",
        "scratch_bytes",
        "sah",
        "node_cost",
        "box_tests",
        "oriented_tests",
        "triangle_tests",
        "cost_per_ray",
        "left_out",
        "radius",
        "depth",
    ];
    for key in numbers {
        assert!(json[key].is_number(), "{key}: {}", json[key]);
    }
    for key in ["device", "driver", "commit", "scene", "tree_hash", "builder", "precision"] {
        assert!(json[key].as_str().is_some_and(|s| !s.is_empty()), "{key}: {}", json[key]);
    }
    assert_eq!((&json["triangles"], &json["left_out"], &json["hits"]), (&3.into(), &1.into(), &1.into()));
    assert_eq!(json["check"]["hits"]["rays"], 3);
    let of = |key: &str| json[key].as_f64().unwrap();
    let tests = ["box_tests", "oriented_tests", "triangle_tests"].map(of);
    let costs: Vec<f64> = json["costs"].as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect();
    assert!(costs.len() == 3 && costs.iter().all(|c| *c > 0.0), "{costs:?}");
    let cost: f64 = tests.iter().zip(&costs).map(|(n, c)| n * c).sum();
    assert!((of("cost_per_ray") - cost / 3.0).abs() <= 1e-12 * cost, "{json}");
    for kernel in json["kernels"].as_array().unwrap() {
        assert!(
            kernel["name"].is_string() && kernel["count"].is_number() && kernel["ms"].is_number(),
            "{kernel}"
        );
    }

    assert_eq!((&json["sorted"], &json["sort_ms"]), (&false.into(), &Value::Null));

    let out = folder.run(&[&base[..], &["--sort", "on", "--explain"]].concat());
    assert!(
        String::from_utf8_lossy(&out.stderr).contains("sorted by origin and direction, as asked"),
        "{out:?}"
    );
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!(json["sorted"] == true && json["sort_ms"].as_f64().is_some_and(|ms| ms > 0.0), "{json}");
    let named = |name: &str| json["kernels"].as_array().unwrap().iter().any(|k| k["name"] == name);
    assert!(named("raysort/keys") && named("sort/scatter") && named("trace/single"), "{json}");
    assert_eq!(hits(&folder.path("a.hits")), [(2.0, 1), MISS, MISS]);

    let out = folder.run(&[&base[..], &["--any", "--precision", "fast", "--quiet"]].concat());
    assert!(out.status.success() && !String::from_utf8_lossy(&out.stderr).contains("Mrays/s"), "{out:?}");
    assert_eq!(hits(&folder.path("a.hits")), [(0.0, u32::MAX), MISS, MISS]);
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!(json["box_tests"].is_null() && json["costs"].is_null() && json["query"] == "any");
}

#[test]
fn build_says_what_it_built() {
    let folder = Folder::new();
    let out = folder.run(&["build", "two.tri", "--runs", "1", "--check", "--max-leaf", "1"]);
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(json["check"]["tree"]["leaves"], 2);
    assert_eq!(json["tree_hash"].as_str().map(str::len), Some(64));
    assert!(json["quality"].is_null());

    // Two leaves apart, the scene's box as high as 1 and as wide as 4: no overlap.
    let out = folder.run(&["build", "two.tri", "--runs", "1", "--quality", "--max-leaf", "1"]);
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    let stderr = String::from_utf8_lossy(&out.stderr);
    assert!(stderr.contains("quality: end-point overlap 0.0000, wide SAH"), "{stderr}");
    assert_eq!((&json["quality"]["epo"], &json["quality"]["levels"][1]["leaves"]), (&0.0.into(), &2.into()));
    assert!(json["quality"]["lcv"].as_f64().unwrap() > 0.0, "{json}");
    // Two boxes at 3/2, two triangles at 2 in halves of no height: half areas 16 of 24.
    let cost = 2.0 * 1.5 + 2.0 * 2.0 * 16.0 / 24.0;
    assert_eq!((&json["tight"]["boxes"], &json["tight"]["total_area"]), (&2.into(), &1.0.into()));
    for key in ["tight", "mixed"] {
        for cost_of in ["cost", "aabb_cost"] {
            assert!((json[key][cost_of].as_f64().unwrap() - cost).abs() < 1e-4, "{key}: {json}");
        }
    }
    assert!(stderr.contains("boxes: 100.00 % axis-aligned"), "{stderr}");
}

#[test]
fn costs_are_the_books_the_devices_or_typed() {
    let folder = Folder::new();
    let built = |costs: &[&str]| -> Value {
        let out = folder.run(&[&["build", "two.tri", "--runs", "1", "--builder", "dito"], costs].concat());
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        serde_json::from_slice(&out.stdout).unwrap()
    };
    let of = |json: &Value| {
        [&json["sah_costs"][0], &json["sah_costs"][1], &json["node_cost"], &json["oriented_cost"]]
            .map(|c| c.as_f64().unwrap())
    };
    let book = of(&built(&[]));
    assert_eq!((book, of(&built(&["--costs", "book"]))), ([3.0, 2.0, 5.0, 6.0], book));
    let typed = of(&built(&["--costs", "1.5,1", "--oriented-cost", "9"]));
    assert_eq!(typed, [1.5, 1.0, 5.0, 9.0]);
    let [pair, triangle, node, oriented] = of(&built(&["--costs", "measured"]));
    assert!(pair > 0.0 && triangle > 0.0 && oriented > 0.0);
    assert!((node / pair - 2.0).abs() < 1e-6, "four boxes, {node}, for two, {pair}");
    let [_, again, typed, _] = of(&built(&["--costs", "measured", "--node-cost", "7"]));
    assert_eq!((again, typed), (triangle, 7.0), "measured anew, or not as typed");
}

#[test]
fn builders_and_codes_go_by_their_names() {
    let folder = Folder::new();
    let run = |builder: &str, morton: &str| -> Value {
        let base = ["build", "two.tri", "--runs", "1", "--check", "--explain"];
        let out = folder.run(&[&base[..], &["--builder", builder, "--morton", morton]].concat());
        let stderr = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.success(), "{stderr}");
        let stage = if builder == "sah" { "binned: " } else { builder };
        assert!(stderr.contains(&format!("explain: {stage}")), "{stderr}");
        serde_json::from_slice(&out.stdout).unwrap()
    };
    for (builder, morton) in [("ploc", "63"), ("lbvh", "ext4"), ("lbvh", "ext7"), ("lbvh", "auto")] {
        let json = run(builder, morton);
        assert_eq!((&json["builder"], &json["morton"]), (&builder.into(), &morton.into()));
        assert_eq!((json["radius"].is_number(), &json["build_host_ms"]), (builder == "ploc", &0.0.into()));
    }
    let json = run("sah", "auto");
    assert_eq!((&json["builder"], &json["morton"]), (&"sah".into(), &Value::Null));
    assert!(json["build_host_ms"].as_f64() > Some(0.0), "{json}");
    folder.fails(&["build", "two.tri", "--morton", "31"], 2, "31");
    // Choices that don't go with the builder.
    for (args, word) in [
        (["--builder", "dito", "--bases", "zone"], "odop1 to odop8"),
        (["--builder", "odop4", "--bases", "dito14"], "1 to 3"),
        (["--builder", "odop4", "--directions", "zone"], "dito14"),
        (["--builder", "odop4", "--collapse", "after"], "hybrid"),
        (["--builder", "dito", "--threshold", "9"], "hybrid"),
    ] {
        folder.fails(&[&["build", "two.tri"][..], &args].concat(), 1, word);
    }
}

#[test]
fn fits_are_tabled() {
    let folder = Folder::new();
    let out = folder.run(&["fits", "--sets", "1", "--local-search", "6", "--json"]);
    let report: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!((&report["sets"], &report["local_search"]), (&1.into(), &6.into()));
    let row = |method: &str| {
        let rows = report["rows"].as_array().unwrap();
        rows.iter().find(|r| r["set"] == "flat quad" && r["method"] == method).unwrap()["mean"]
            .as_f64()
            .unwrap()
    };
    assert!(row("dito14") < 1e-3 && row("aabb") > 1.0);
    let table = String::from_utf8(folder.run(&["fits", "--sets", "1", "-q"]).stdout).unwrap();
    // Head, line, fifteen kinds, means.
    assert_eq!(table.lines().count(), 18, "{table}");
}

#[test]
fn layouts_are_compared() {
    let folder = Folder::new();
    let size = ["layouts", "city-rotated:2k", "--runs", "1", "--width", "64", "--height", "48"];
    let out = folder.run(&[&size[..], &["--rays", "primary,ao", "--sample", "512", "--json"]].concat());
    let report: Value = serde_json::from_slice(&out.stdout).unwrap();
    let (sizes, rows) = (report["sizes"].as_array().unwrap(), report["rows"].as_array().unwrap());
    // Builds with dito by default, and so has an axis-aligned packed tree beside.
    assert_eq!((sizes.len(), rows.len()), (5, 10), "{report}");
    assert!(sizes[2..].iter().all(|s| s["outside"] == 0) && rows.iter().all(|r| r["differing"] == 0));
    let args = [&size[..], &["--rays", "primary", "--builder", "lbvh", "-q"]].concat();
    let table = String::from_utf8(folder.run(&args).stdout).unwrap();
    // Two tables of head, line and four layouts, and what parts them.
    assert_eq!(table.lines().count(), 13, "{table}");
    folder.fails(&["layouts", "city:2k", "--rays", "secondary"], 2, "secondary");
}

#[test]
fn devices_names_the_one_in_use() {
    let out = Folder::new().run(&["devices", "--json"]);
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    let chosen: Vec<&Value> = json.as_array().unwrap().iter().filter(|d| d["chosen"] == true).collect();
    assert!(chosen.len() == 1 && chosen[0]["usable"] == true && chosen[0]["features"].is_array(), "{json}");
}

#[test]
fn bad_input_is_named() {
    let folder = Folder::new();
    let query = |scene: &'static str, rays: &'static str, out: &'static str| {
        ["query", scene, "--rays", rays, "--out", out, "--runs", "1"]
    };
    folder.write("short.rays", &[0.0; 9]);
    folder.write("empty.rays", &[]);
    folder.fails(&query("none.tri", "a.rays", "a.hits"), 1, "none.tri");
    folder.fails(&query("nonesuch", "a.rays", "a.hits"), 1, "no scene is called \"nonesuch\"");
    folder.fails(&query("two.tri", "none.rays", "a.hits"), 1, "none.rays");
    folder.fails(&query("two.tri", "short.rays", "a.hits"), 1, "36 bytes are no multiple of 32");
    folder.fails(&query("two.tri", "empty.rays", "a.hits"), 1, "holds no ray");
    folder.fails(&query("two.tri", "a.rays", "none/a.hits"), 1, "can't write none/a.hits");
    folder.fails(&["build", "two.tri", "--device", "no such device"], 1, "no usable device");
    folder.fails(&["build", "two.tri", "--builder", "nonesuch"], 2, "nonesuch");
    folder.fails(&["build", "two.tri", "--radius", "129"], 2, "129");
    folder.fails(&["build", "two.tri", "--costs", "1"], 2, "costs");
    folder.fails(&["build", "two.tri", "--node-cost", "0"], 2, "above 0");
    folder.fails(&["build"], 2, "required");
    folder.fails(&["nonesuch"], 2, "nonesuch");
}

#[test]
fn scenes_are_listed_with_their_credit() {
    let folder = Folder::new();
    let out = folder.run(&["scenes", "list", "--json"]);
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    let scenes = json["scenes"].as_array().unwrap();
    for scene in scenes {
        for key in ["name", "spec", "kind", "what", "licence", "credit"] {
            assert!(scene[key].as_str().is_some_and(|s| !s.is_empty()), "{key}: {scene}");
        }
        assert!(
            scene["triangles"].as_u64().unwrap() > 0
                && scene["cached"].is_boolean() == (scene["kind"] == "fetched")
        );
    }
    assert_eq!(json["sets"]["dragons"].as_array().unwrap().len(), 4);
    let table = String::from_utf8(folder.run(&["scenes", "list"]).stdout).unwrap();
    assert!(scenes.iter().all(|s| table.contains(s["spec"].as_str().unwrap())), "{table}");
    assert!(table.contains("dragons: "), "{table}");
}

#[test]
fn scenes_are_written_transformed_and_read_again() {
    let folder = Folder::new();
    let transform = ["--rotate", "0,0,-90", "--scale", "2", "--translate", "-1,0,1e3"];
    for name in ["moved.tri", "moved.ply"] {
        let out = folder.run(&[&["scenes", "generate", "two.tri", "--out", name][..], &transform].concat());
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    }
    let words = |name: &str| fs::read(folder.path(name)).unwrap();
    let moved: Vec<f32> =
        words("moved.tri").chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    // (x, y, z) to (2y - 1, -2x, 2z + 1000).
    assert_eq!(moved[..9], [-1.0, 0.0, 1000.0, -1.0, -8.0, 1000.0, 7.0, 0.0, 1000.0]);
    assert!(moved[18..27].iter().all(|x| x.is_nan()));
    let build = |args: &[&str]| -> Value {
        let out = folder.run(&[&["build", "--runs", "1"], args].concat());
        serde_json::from_slice(&out.stdout).unwrap()
    };
    let [there, here] = [build(&["moved.ply"]), build(&[&["two.tri"][..], &transform].concat())];
    assert_eq!((&there["tree_hash"], &there["triangles"]), (&here["tree_hash"], &3.into()));
    assert_eq!(here["scene"], "two.tri rotated 0,0,-90 scaled 2 translated -1,0,1000");
}

#[test]
fn bad_scenes_and_transforms_are_named() {
    let folder = Folder::new();
    folder.fails(&["scenes", "generate", "two.tri", "--out", "a.obj"], 1, "ends in .ply or .tri");
    folder.fails(&["scenes", "generate", "sphere:0", "--out", "a.ply"], 1, "sphere:100000");
    folder.fails(&["scenes", "fetch", "nonesuch"], 1, "no scene is called \"nonesuch\"");
    folder.fails(&["scenes", "fetch"], 2, "required");
    folder.fails(&["build", "two.tri", "--scale", "1e38"], 1, "overflows");
    folder.fails(&["build", "two.tri", "--scale", "-1"], 2, "above 0");
    folder.fails(&["build", "two.tri", "--rotate", "1,2"], 2, "three numbers");
    folder.fails(&["build", "two.tri", "--translate", "1,2,inf"], 2, "three numbers");
    folder.fails(&["render", "two.tri", "--out", "a.png", "--view", "6"], 2, "6");
}

/// Red, green and blue of each pixel.
fn pixels(png: &[u8]) -> Vec<[u8; 3]> {
    image::load_from_memory(png).unwrap().to_rgb8().pixels().map(|p| p.0).collect()
}

#[test]
fn render_takes_base_colours_as_albedo() {
    let folder = Folder::new();
    let floor = |paint: &str| {
        format!("{paint}v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nv 0 1 0\nf 4 3 2 1\nf 1 2 5\nf 3 4 5\n")
    };
    fs::write(folder.path("plain.obj"), floor("")).unwrap();
    fs::write(folder.path("grey.obj"), floor("mtllib a.mtl\nusemtl grey\n")).unwrap();
    fs::write(folder.path("red.obj"), floor("mtllib a.mtl\nusemtl red\n")).unwrap();
    fs::write(folder.path("a.mtl"), "newmtl grey\nKd 0.8 0.8 0.8\nnewmtl red\nKd 0.8 0 0\n").unwrap();
    for mode in ["primary", "diffuse", "ao"] {
        let picture = |scene: &str| {
            let size = ["--width", "48", "--height", "36", "--samples", "4"];
            let out = folder.run(&[&["render", scene, "--out", "a.png", "--mode", mode][..], &size].concat());
            assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
            fs::read(folder.path("a.png")).unwrap()
        };
        let (plain, grey, red) = (picture("plain.obj"), picture("grey.obj"), picture("red.obj"));
        assert!(plain == grey, "{mode}: what has no colour is not 0.8 grey");
        if mode == "ao" {
            assert!(plain == red, "occlusion has a colour");
            continue;
        }
        let painted =
            pixels(&plain).into_iter().zip(pixels(&red)).filter(|(p, r)| p != r).collect::<Vec<_>>();
        assert!(painted.len() > 200, "{mode}: {} pixels of {} are red", painted.len(), 48 * 36);
        assert!(painted.iter().all(|(p, r)| *r == [p[0], 0, 0]), "{mode}");
    }
}
