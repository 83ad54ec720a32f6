//! Nearly every kernel of a build and a query once, on so little work that GPU-assisted validation, which checks each access
//! of each invocation, is done in time: `.ci/test` runs these under it.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::soup::{grid, random, scene};
use boxwood::abi::Ray;
use boxwood::bvh::{self, Builder, Collapse, Morton, Recipe, SceneBuffers};
use boxwood::device::Timing;
use boxwood::trace::{Batch, Options, Query, Walk, trace};

#[test]
fn builds() {
    let device = quiet();
    let recipe = Recipe::default();
    for (corners, recipe) in [
        (random(2100, 0.1, 1), recipe),
        (grid(300), Recipe { morton: Morton::Bits63, radius: 33, ..recipe }),
        (random(300, 0.1, 4), Recipe { builder: Builder::Lbvh, morton: Morton::Ext7, ..recipe }),
        (random(300, 0.1, 5), Recipe { builder: Builder::Binned, morton: Morton::Ext4, ..recipe }),
        (random(5, 0.5, 2), Recipe { collapse: Collapse { node_cost: 1e6, ..recipe.collapse }, ..recipe }),
    ] {
        let buffers = SceneBuffers::upload(&device, &scene(&corners)).unwrap();
        let built = bvh::build(&device, &buffers, &recipe, Timing::Kernels).unwrap();
        assert_eq!(built.bvh.triangle_count as usize, corners.len());
    }
}

#[test]
fn traces() {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &scene(&random(200, 0.3, 3))).unwrap();
    let bvh = bvh::build(&device, &buffers, &Recipe::default(), Timing::Off).unwrap().bvh;
    let ray = |i: i32| {
        let origin = [-2.0, (i % 8) as f32 / 4.0 - 1.0, (i / 8) as f32 / 4.0 - 1.0];
        Ray { origin, t_min: 0.0, direction: [1.0, 0.0, 0.0], t_max: f32::INFINITY }
    };
    let rays: Vec<Ray> = (0..64).map(ray).collect();
    let mut hits = vec![];
    // Not trace/refill: what it reads and writes trace/persistent does too, and each kernel takes half a minute here.
    let walks = [Walk::Single, Walk::Packet, Walk::Persistent].map(|walk| (Query::Closest, walk));
    for (query, walk) in walks.into_iter().chain([(Query::Any, Walk::Single)]) {
        let mut batch = Batch::new(&device, rays.len(), true).unwrap();
        batch.set(&rays).unwrap();
        let options = Options { query, walk, ..Options::default() };
        trace(&device, &bvh, &batch, options, Timing::Off).unwrap();
        hits.push(batch.hits.read().unwrap().iter().filter(|h| h.is_hit()).count());
    }
    assert!(hits[0] > 0 && hits.iter().all(|n| *n == hits[0]), "{hits:?}");
}
