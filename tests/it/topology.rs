//! Trees chosen by what a sample of rays costs there.

#![allow(clippy::unwrap_used)]

use crate::cli::Folder;
use crate::gpu::quiet;
use crate::orient::{rays, slivers};
use crate::soup::{grid, scene};
use boxwood::abi::Ray;
use boxwood::bench::{Costs, TestTotals, Tried, try_recipes};
use boxwood::bvh::{self, Builder, Fit, Recipe, SceneBuffers};
use boxwood::device::{Device, Timing};
use boxwood::scene::Scene;
use boxwood::trace::{Batch, Options, trace};
use serde_json::Value;
use std::sync::Arc;

const COSTS: Costs = Costs { boxes: 3.0, oriented: 4.0, triangles: 2.0 };

fn tried(device: &Arc<Device>, scene: &Scene, rays: &[Ray]) -> Vec<Tried> {
    let buffers = SceneBuffers::upload(device, scene).unwrap();
    let auto = Recipe { fit: Fit::Auto, ..Recipe::default() };
    let tried = try_recipes(device, &buffers, &auto, rays, Options::default(), COSTS).unwrap();
    assert!(tried.iter().all(|t| t.cost_per_ray >= tried[0].cost_per_ray));
    tried
}

#[test]
fn the_first_costs_least() {
    let device = quiet();
    let soup = slivers(3000, 7);
    let (scene, rays) = (scene(&soup), rays(&soup, 0.0));
    let tried = tried(&device, &scene, &rays);
    let with = |wanted: fn(&Builder) -> bool| tried.iter().filter(|t| wanted(&t.recipe.builder)).count();
    assert_eq!(with(|b| *b == Builder::Ploc), 2, "in either boxes");
    assert!(
        with(|b| *b == Builder::Binned) == 2 && with(|b| matches!(b, Builder::Odop(_))) == 1,
        "{tried:?}"
    );
    // Each as it is counted alone.
    let buffers = SceneBuffers::upload(&device, &scene).unwrap();
    let mut batch = Batch::new(&device, rays.len(), true).unwrap();
    batch.set(&rays).unwrap();
    for t in &tried {
        let tree = bvh::build(&device, &buffers, &t.recipe, Timing::Off).unwrap().bvh;
        trace(&device, &tree, &batch, Options { boxes: t.boxes, ..Options::default() }, Timing::Off).unwrap();
        let mut sum = TestTotals::default();
        for tests in batch.tests.as_ref().unwrap().read_first(rays.len()).unwrap() {
            sum.boxes += u64::from(tests.boxes);
            sum.oriented += u64::from(tests.oriented);
            sum.triangles += u64::from(tests.triangles);
        }
        assert_eq!((t.tests, t.cost_per_ray), (sum, COSTS.per_ray(&sum, rays.len())));
    }
}

#[test]
fn oriented_distances_are_skipped_where_nothing_is_oriented() {
    let soup = grid(500);
    let tried = tried(&quiet(), &scene(&soup), &rays(&soup, 0.0));
    assert!(tried.iter().all(|t| !matches!(t.recipe.builder, Builder::Odop(_))), "{tried:?}");
    assert_eq!(tried.len(), 2);
}

#[test]
fn query_takes_the_tree_that_a_sample_costs_least() {
    let folder = Folder::new();
    let rays: Vec<f32> =
        (0..200).flat_map(|i| [0.0, 0.0, 9.0, 0.0, i as f32 * 0.004 - 0.4, 0.1, -1.0, 1e9]).collect();
    folder.write("b.rays", &rays);
    let query = ["query", "hairball:2k", "--rays", "b.rays", "--out", "b.hits", "--runs", "1", "--count"];
    let run = |more: &[&str]| {
        let out = folder.run(&[&query[..], more].concat());
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let json: Value = serde_json::from_slice(&out.stdout).unwrap();
        (json, String::from_utf8(out.stderr).unwrap())
    };
    let (json, said) = run(&["--builder", "auto", "--sample", "200", "--explain", "--check"]);
    assert!(said.contains("explain: sample: what 200 rays cost"), "{said}");
    let sah = run(&["--builder", "sah"]).0;
    let cost = |json: &Value| json["cost_per_ray"].as_f64().unwrap();
    // Boxes are then chosen by time, of which so few rays tell nothing: the mixed ones.
    assert!(cost(&json) <= 1.1 * cost(&sah), "{json} {sah}");
    folder.fails(&[&query[..], &["--sample", "9"]].concat(), 1, "give --builder auto");
}
