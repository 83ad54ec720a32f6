//! Run time against error, as programs: the preset `smoke`, whose rows have every kind of error there is.

#![allow(clippy::unwrap_used)]

use crate::cli::Folder;
use serde_json::Value;
use std::fs;

const ARGS: [&str; 9] = [
    "bench",
    "city-rotated:2k",
    "sphere:500@10",
    "--preset",
    "smoke",
    "--builders",
    "ploc,ploc-fast,auto",
    "--out",
    "r",
];

fn rows(folder: &Folder) -> Vec<Value> {
    let text = fs::read_to_string(folder.path("r/rows.jsonl")).unwrap();
    text.lines().skip(1).map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Rows of a kind whose fields are as said.
fn of<'r>(rows: &'r [Value], kind: &str, fields: &[(&str, &str)]) -> Vec<&'r Value> {
    let fits = |r: &&Value| r["row"] == kind && fields.iter().all(|(name, value)| r[*name] == *value);
    rows.iter().filter(fits).collect()
}

fn sum(rows: &[&Value], name: &str) -> u64 {
    rows.iter().map(|r| r["check"][name].as_u64().unwrap()).sum()
}

#[test]
fn every_kind_of_error_is_measured() {
    let folder = Folder::new();
    let out = folder.run(&ARGS);
    assert!(
        out.status.success(),
        "what the fast test misses is no failure: {}",
        String::from_utf8_lossy(&out.stderr)
    );
    let all = rows(&folder);
    // Two scenes × three builders × (a build, four sets of rays); two kinds of pictures by two samplers, 1 and 4 samples;
    // the scene, and a map a builder.
    assert_eq!(all.len(), 2 * (3 * 5 + 2 * 2 * 2 + 1 + 3));

    // Hits: the robust test has no faults, the fast one has at vertices.
    let at_vertices = [("set", "vertices"), ("builder", "ploc-fast")];
    assert!(sum(&of(&all, "rays", &at_vertices), "missed") > 0);
    assert!(of(&all, "rays", &at_vertices).iter().all(|r| r["precision"] == "fast"));
    assert_eq!(sum(&of(&all, "rays", &[("precision", "robust")]), "faults"), 0);
    for name in ["missed", "false_hits", "leaked", "wrong_triangle", "unsure"] {
        assert_eq!(sum(&of(&all, "rays", &[("precision", "robust")]), name), 0, "{name}");
    }
    let errors = |precision| {
        let rows = of(&all, "rays", &[("precision", precision), ("set", "primary")]);
        rows.iter().map(|r| r["check"]["t_error"]["max"].as_f64().unwrap()).fold(0.0, f64::max)
    };
    assert!(0.0 < errors("robust") && errors("robust") < 1.2e-7, "{}", errors("robust"));
    assert!(errors("robust") < errors("fast"));

    // Boxes: off the axes oriented ones are nearer to the optimum.
    let excess = |builder| {
        let build = of(&all, "build", &[("scene", "city-rotated:2k"), ("builder", builder)]);
        build[0]["excess"]["total"].as_f64().unwrap()
    };
    assert!(excess("auto") < 0.5 * excess("ploc"), "{} and {}", excess("auto"), excess("ploc"));

    // Pictures: four samples are nearer than one, and Halton's four nearer than chance's.
    for shows in ["ao", "diffuse"] {
        let rmse = |sampler: &str, samples: u64| {
            let images =
                of(&all, "image", &[("scene", "city-rotated:2k"), ("shows", shows), ("sampler", sampler)]);
            let image = images.iter().find(|i| i["samples"] == samples).unwrap();
            assert!(image["pixels"].as_u64().unwrap() > 200 && image["builder"] == "ploc");
            image["rmse"].as_f64().unwrap()
        };
        assert!(rmse("halton", 4) < 0.75 * rmse("halton", 1), "{shows}");
        assert!(rmse("halton", 4) < rmse("random", 4) && rmse("random", 4) < rmse("random", 1), "{shows}");
    }

    let page = fs::read_to_string(folder.path("r/report.html")).unwrap();
    for title in [
        "Build time against area of boxes",
        "Time against wrong hits",
        "Time against the error of t",
        "Error of a picture of ambient occlusion",
        "Error of a picture of light of the sky",
        "Errors of pictures",
    ] {
        assert!(page.contains(title), "{title}");
    }
    assert_eq!(page.matches("data:image/png;base64,").count(), 2 * (1 + 3));
    for row in of(&all, "picture", &[]) {
        let file = format!("r/pictures/{}", row["file"].as_str().unwrap());
        assert_eq!(image::open(folder.path(&file)).unwrap().width(), 48);
    }
    assert!(page.contains("none is wrong") && !page.contains("Hits are wrong"));
}

#[test]
fn a_run_cut_off_goes_on_with_its_pictures() {
    let folder = Folder::new();
    assert!(folder.run(&ARGS).status.success());
    let whole = rows(&folder);
    let lines = fs::read_to_string(folder.path("r/rows.jsonl")).unwrap();
    let kept: Vec<&str> = lines.lines().take(lines.lines().count() - 3).collect();
    fs::write(folder.path("r/rows.jsonl"), kept.join("\n") + "\n{\"row\":\"ima").unwrap();
    let args = [&ARGS[..], &["--resume"]].concat();
    assert!(folder.run(&args).status.success());
    let key = |r: &Value| {
        ["scene", "builder", "set", "shows", "sampler", "samples", "rmse", "tree_hash"]
            .map(|f| r[f].to_string())
    };
    let keys = |rows: &[Value]| rows.iter().map(key).collect::<Vec<_>>();
    assert_eq!(keys(&rows(&folder)), keys(&whole));
}

#[test]
fn recipes_name_a_test_that_there_is() {
    let folder = Folder::new();
    let text = "[recipes.default]\nbuilder='ploc'\nmorton='auto'\nradius=8\ntraversal-cost=3\nnode-cost=5\n\
                triangle-cost=2\nmax-leaf=8\noriented-cost=6\nprecision='quick'\n[presets.default]\nscenes=[]\nbuilders=[]\n\
                rays=[]\nviews=1\nwidth=8\nheight=8\nwarm-ups=0\nruns=1\nsample=1\ncheck=0";
    fs::write(folder.path("p.toml"), text).unwrap();
    folder.fails(&["bench", "sphere:9", "--presets", "p.toml", "--builders", "default"], 1, "robust or fast");
    folder.fails(&["bench", "sphere:9", "--rays", "corners"], 1, "vertices, edges");
}
