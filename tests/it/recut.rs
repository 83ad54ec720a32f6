//! Collapse after the fit: cuts against the twin's bit for bit, and what the trees are like.

#![allow(clippy::unwrap_used)]

use crate::gpu::{quiet, quiet_on};
use crate::matrix::{ODOP, assert_same_tree, assert_twin, build, each_shape};
use crate::orient::{found, rays, slivers, stats};
use crate::soup::{grid, named, random, scene};
use boxwood::bvh::{self, Builder, Collapse, Directions, Fit, Moment, Recipe, SceneBuffers};
use boxwood::device::Timing;
use boxwood::oracle::tight;
use boxwood::trace::{Batch, Options};

fn after(fit: Fit) -> Recipe {
    Recipe { fit, collapsed: Moment::After, ..Recipe::default() }
}

#[test]
fn trees_equal_the_twins() {
    for device in each_shape() {
        let device = quiet_on(device);
        for n in [0, 1, 2, 3, 7, 64, 65, 600, 2100] {
            for builder in [Builder::Ploc, Builder::Lbvh] {
                for soup in [slivers(n, 5), random(n, 0.3, n as u64), grid(n)] {
                    let recipe = Recipe { builder, ..after(Fit::Dito(14)) };
                    assert_twin("recut", &device, &scene(&soup), &recipe);
                }
            }
        }
    }
}

#[test]
fn every_choice_equals_the_twin() {
    let device = quiet();
    let soup = scene(&slivers(700, 7));
    for fit in [Fit::Dito(12), Fit::Dito(20), Fit::Dito(26), Fit::Hybrid] {
        assert_twin("recut", &device, &soup, &after(fit));
    }
    let plain = after(Fit::Dito(14));
    let collapse = |max_leaf| Collapse { max_leaf, ..plain.collapse };
    for recipe in [
        Recipe { local_search: 12, ..plain },
        Recipe { directions: Directions::Zone, ..plain },
        Recipe { builder: ODOP, ..plain },
        Recipe { builder: Builder::Binned, ..plain },
        Recipe { collapse: collapse(1), ..plain },
        Recipe { collapse: collapse(64), ..plain },
        Recipe { collapse: Collapse { node_cost: 1e9, ..collapse(64) }, ..plain },
    ] {
        assert_twin("recut", &device, &soup, &recipe);
    }
    // A tree that is a leaf by the builder's boxes, and one by DiTO's.
    assert_twin("leaf", &device, &scene(&slivers(5, 3)), &plain);
    assert_twin("leaf", &device, &scene(&random(5, 0.9, 3)), &plain);
}

#[test]
fn what_lies_along_the_axes_is_cut_as_before() {
    let device = quiet();
    let soup = scene(&grid(1500));
    let [before, after] = [Recipe { fit: Fit::Dito(14), ..Recipe::default() }, after(Fit::Dito(14))]
        .map(|recipe| build(&device, &soup, &recipe).0.bvh.read().unwrap());
    // Of a right triangle DiTO's box is the upright rectangle.
    assert_same_tree("grid", &before, &after);
}

#[test]
fn cuts_are_others_and_hits_the_same() {
    let corners = slivers(3000, 8);
    let soup = scene(&corners);
    let cost = |recipe: &Recipe| {
        stats(&soup, recipe);
        let built = build(&quiet(), &soup, recipe).0.bvh;
        tight::measure(&built.read().unwrap(), built.anchor, &built.bounds).cost
    };
    let before = Recipe { fit: Fit::Dito(14), ..Recipe::default() };
    let costs = [cost(&before), cost(&after(Fit::Dito(14)))];
    assert!(costs[0] != costs[1] && costs[1] < 1.05 * costs[0], "{costs:?}");
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &soup).unwrap();
    let [plain, recut] = [Recipe::default(), after(Fit::Dito(14))]
        .map(|recipe| bvh::build(&device, &buffers, &recipe, Timing::Off).unwrap().bvh);
    let rays = rays(&corners, 0.0);
    let mut batch = Batch::new(&device, rays.len(), false).unwrap();
    batch.set(&rays).unwrap();
    let hits = [&plain, &recut].map(|bvh| found(&device, bvh, &batch, Options::default()));
    assert!(hits[0].iter().filter(|h| h.is_hit()).count() > 300);
    assert_eq!(bytemuck::cast_slice::<_, u32>(&hits[0]), bytemuck::cast_slice::<_, u32>(&hits[1]));
}

#[test]
fn it_wants_dito() {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &named("city:1k")).unwrap();
    for fit in [Fit::Aabb, Fit::Own(3), Fit::Auto] {
        let error = bvh::build(&device, &buffers, &after(fit), Timing::Off).unwrap_err().to_string();
        assert!(error.contains("dito14"), "{error}");
    }
}
