//! Places that a counter deals out.

use super::{RUNS, Raw, Sorted, a_thousand_times};
use crate::gpu::quiet;
use crate::matrix::first_difference;
use crate::orient::found;
use crate::soup::{random, random_rays, scene};
use boxwood::abi::*;
use boxwood::bvh::{self, Builder, Recipe, SceneBuffers};
use boxwood::device::{Buffer, Recorder, Timing};
use boxwood::kernels;
use boxwood::oracle::collapse;
use boxwood::trace::{Batch, Options, Walk};

#[test]
fn places_in_the_queue_are_dealt_out() {
    let device = quiet();
    let sorted = Sorted::new(scene(&random(300, 0.1, 6)));
    let before = sorted.binary();
    let mut twin = before.clone();
    collapse::expand(&mut twin);
    let kept = collapse::number(&twin, &sorted.costs);
    let inner = before.nodes.len();
    let nodes = Buffer::from_slice(&device, "nodes", &before.nodes).unwrap();
    let cuts = Buffer::from_slice(&device, "cuts", &before.cuts).unwrap();
    let raw = Raw::new(&device, sorted.count());
    let queue = Buffer::<u32>::new(&device, "queue", inner).unwrap();
    let firsts = Buffer::<u32>::new(&device, "firsts", inner).unwrap();
    let rounds = before.root.levels;
    let states = Buffer::<Expansion>::new(&device, "states", rounds as usize + 1).unwrap();
    a_thousand_times(|what, constants, _| {
        let mut rec = Recorder::new(&device, Timing::Off).unwrap();
        rec.copy(&nodes, &raw.nodes);
        rec.copy(&cuts, &raw.cuts);
        rec.update(&queue, &[before.root.node]);
        rec.fill(&firsts, inner, 0);
        rec.fill(&states, size_of::<Expansion>() / 4 * states.len(), 0);
        rec.update(&states, &[Expansion { groups: [1; 3], first: 0, count: 1 }]);
        for round in 0..rounds {
            let args = CollapseExpandArgs {
                raw: raw.nodes.ptr_mut(),
                cuts: raw.cuts.ptr_mut(),
                queue: queue.ptr_mut(),
                firsts: firsts.ptr_mut(),
                state: states.ptr_mut(),
                round,
            };
            let at = round as usize * size_of::<Expansion>();
            rec.dispatch_indirect(&kernels::COLLAPSE_EXPAND, &constants, &states, at, args).unwrap();
        }
        rec.submit().unwrap();
        first_difference(&format!("{what}: node"), &raw.nodes.read().unwrap(), &twin.nodes);
        first_difference(&format!("{what}: cut"), &raw.cuts.read().unwrap(), &twin.cuts);
        let mut queued = queue.read_first(kept.nodes.len()).unwrap();
        queued.sort_unstable();
        first_difference(&format!("{what}: kept node"), &queued, &kept.nodes);
        let firsts = firsts.read().unwrap();
        assert!(kept.nodes.iter().all(|i| firsts[*i as usize] == kept.firsts[*i as usize]), "{what}");
    });
}

#[test]
fn rays_are_dealt_out() {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &scene(&random(200, 0.3, 7))).unwrap();
    let recipe = Recipe { builder: Builder::Lbvh, ..Recipe::default() };
    let bvh = bvh::build(&device, &buffers, &recipe, Timing::Off).unwrap().bvh;
    let rays = random_rays(300, 8);
    let mut batch = Batch::new(&device, rays.len(), false).unwrap();
    batch.set(&rays).unwrap();
    let alone = found(&device, &bvh, &batch, Options { walk: Walk::Single, ..Options::default() });
    for i in 0..RUNS {
        batch.hits.write(&vec![Hit::MISS; rays.len()]).unwrap();
        let hits = found(&device, &bvh, &batch, Options { walk: Walk::Persistent, ..Options::default() });
        first_difference(&format!("run {i}: hit"), &hits, &alone);
    }
}
