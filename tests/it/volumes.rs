//! What oriented boxes buy, as the README has it at full size, held on small scenes: expected costs, and tests a ray.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::soup::named;
use boxwood::abi::Ray;
use boxwood::bench::{Costs, Presets, try_recipes};
use boxwood::bvh::{self, Recipe, SceneBuffers};
use boxwood::device::{Device, Timing};
use boxwood::oracle::mixed;
use boxwood::scene::Scene;
use boxwood::trace::rays::{Secondary, View, primary, secondary};
use boxwood::trace::{Batch, Boxes, Options, trace};
use std::sync::Arc;

const SECONDARY_RAYS: usize = 1 << 13;
/// About those of lavapipe.
const COSTS: Costs = Costs { boxes: 10.0, oriented: 14.0, triangles: 17.0 };

/// The binary tree's expected cost with the cheaper box for each node, over that with axis-aligned ones.
#[test]
fn binary_trees_cost_less_with_either_box() {
    let device = quiet();
    for (name, most) in [
        ("dragon-like:30k", 0.94),
        ("tree:30k", 0.97),
        ("conference:30k", 0.995),
        ("hairball:30k", 0.87),
        ("pipes:30k", 0.17),
        ("power-plant:30k", 0.45),
        ("city:30k", 1.0),
        ("city-rotated:30k", 0.84),
    ] {
        let scene = named(name);
        let buffers = SceneBuffers::upload(&device, &scene).unwrap();
        let (_, stages) = bvh::stages(&device, &buffers, &Recipe::default()).unwrap();
        let mixed = mixed::measure(&scene, &stages);
        let ratio = mixed.cost / mixed.aabb_cost;
        assert!(ratio <= most, "{name}: {ratio} of the cost of axis-aligned boxes");
    }
}

/// Rays of a small picture, and those that leave what they meet: ambient occlusion, diffuse.
fn ray_sets(device: &Arc<Device>, scene: &Scene, buffers: &SceneBuffers) -> [(Options, Vec<Ray>); 3] {
    let view = View { width: 96, height: 72, ..View::standard(scene.views[0]) };
    let tree = bvh::build(device, buffers, &Recipe::default(), Timing::Off).unwrap().bvh;
    let mut primaries = Batch::new(device, view.pixels(), false).unwrap();
    primary(device, &view, &mut primaries, Timing::Off).unwrap();
    trace(device, &tree, &primaries, Options::default(), Timing::Off).unwrap();
    let leaving = |kind: Secondary| {
        let mut batch = Batch::new(device, SECONDARY_RAYS, false).unwrap();
        secondary(device, buffers, &primaries, &kind, 0, &mut batch, Timing::Off).unwrap();
        let options = Options { query: kind.query(), ..Options::default() };
        (options, batch.rays.read_first(batch.count).unwrap())
    };
    let seen = primaries.rays.read_first(primaries.count).unwrap();
    [(Options::default(), seen), leaving(Secondary::ao(&scene.bounds())), leaving(Secondary::diffuse())]
}

/// What tests cost a ray of each set, through whichever boxes of the tree cost that set less.
fn cost_of_tests(
    device: &Arc<Device>,
    buffers: &SceneBuffers,
    recipe: &Recipe,
    sets: &[(Options, Vec<Ray>)],
) -> Vec<f64> {
    let tree = bvh::build(device, buffers, recipe, Timing::Off).unwrap().bvh;
    let cost = |(options, rays): &(Options, Vec<Ray>), boxes| {
        let mut batch = Batch::new(device, rays.len(), true).unwrap();
        batch.set(rays).unwrap();
        trace(device, &tree, &batch, Options { boxes, ..*options }, Timing::Off).unwrap();
        let tests = batch.tests.as_ref().unwrap().read_first(rays.len()).unwrap();
        let cost = tests.iter().map(|t| {
            COSTS.boxes * f64::from(t.boxes)
                + COSTS.oriented * f64::from(t.oriented)
                + COSTS.triangles * f64::from(t.triangles)
        });
        cost.sum::<f64>() / rays.len() as f64
    };
    let least = |set| Boxes::of(&tree).iter().map(|b| cost(set, *b)).fold(f64::INFINITY, f64::min);
    sets.iter().map(least).collect()
}

/// `auto` alone against the trees that it has to choose from, PLOC's in either boxes; and where it may try others on a
/// sample of the rays, against those by oriented distances as well.
#[test]
fn auto_tests_as_little_as_the_best() {
    let device = quiet();
    let presets = Presets::own().unwrap();
    let recipe = |name| presets.recipe(name).unwrap();
    for name in ["dragon-like", "conference", "hairball", "pipes", "power-plant", "city", "city-rotated"] {
        let scene = named(&format!("{name}:20k"));
        let buffers = SceneBuffers::upload(&device, &scene).unwrap();
        let sets = ray_sets(&device, &scene, &buffers);
        let costs = |recipe| cost_of_tests(&device, &buffers, &recipe, &sets);
        let auto = costs(recipe("auto"));
        let others = ["ploc", "dito", "odop2", "odop3"].map(|name| costs(recipe(name)));
        for (i, (options, rays)) in sets.iter().enumerate() {
            let best = |of: &[Vec<f64>]| of.iter().map(|costs| costs[i]).fold(f64::INFINITY, f64::min);
            let sample: Vec<Ray> = rays.iter().copied().step_by(4).collect();
            let tried = try_recipes(&device, &buffers, &recipe("auto"), &sample, *options, COSTS).unwrap();
            let sampled = cost_of_tests(&device, &buffers, &tried[0].recipe, &sets)[i];
            for (what, cost, best) in
                [("alone", auto[i], best(&others[..2])), ("by a sample", sampled, best(&others))]
            {
                assert!(cost <= 1.02 * best, "{name}, rays {i}, {what}: {cost} against {best}");
            }
        }
    }
}
