//! The binned builder: its host passes, its threads, its depth. Every build of `matrix` and `adversarial` compares its
//! trees.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::build;
use crate::soup::{grid, named, random, scene};
use boxwood::bvh::{self, Builder, Recipe, SceneBuffers};
use boxwood::device::Timing;

fn by(builder: Builder) -> Recipe {
    Recipe { builder, ..Recipe::default() }
}

#[test]
fn threads_do_not_show() {
    let device = quiet();
    // More than two chunks of bins, and many tasks.
    for (what, soup) in [("random", scene(&random(40_000, 0.02, 1))), ("grid", scene(&grid(40_000)))] {
        let hash = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| build(&device, &soup, &by(Builder::Binned)).0.bvh.read().unwrap().hash())
        };
        let one = hash(1);
        for threads in [2, 3, 8] {
            assert_eq!(hash(threads), one, "{what}: {threads} threads");
        }
    }
}

#[test]
fn its_time_on_the_host_counts() {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &scene(&random(3000, 0.1, 2))).unwrap();
    let times = |builder, timing| bvh::build(&device, &buffers, &by(builder), timing).unwrap().times;
    for timing in [Timing::Off, Timing::Outer, Timing::Kernels] {
        let times = times(Builder::Binned, timing);
        assert!(0.0 < times.host_ms && times.host_ms < times.device_ms, "{times:?}");
    }
    let passes = times(Builder::Binned, Timing::Kernels).passes;
    for name in ["binned/read", "binned/split", "binned/write", "collapse/count", "layout/nodes"] {
        assert!(passes.iter().any(|p| p.name == name && p.ms > 0.0), "no {name}: {passes:?}");
    }
    assert!(passes.iter().all(|p| !p.name.starts_with("sort/")), "{passes:?}");
    assert_eq!(times(Builder::Lbvh, Timing::Outer).host_ms, 0.0);
}

#[test]
fn better_than_ploc_better_than_lbvh() {
    let device = quiet();
    for soup in [named("sphere:5k"), named("city-rotated:5k")] {
        let sah = |builder| build(&device, &soup, &by(builder)).0.bvh.sah;
        let [ploc, lbvh, binned] = [Builder::Ploc, Builder::Lbvh, Builder::Binned].map(sah);
        assert!(ploc < lbvh && binned < 1.05 * ploc, "{}: {ploc}, {lbvh}, {binned}", soup.name);
    }
}

#[test]
fn no_scene_makes_it_deep() {
    let device = quiet();
    // A line: no area anywhere, so every split costs the same.
    let line = (0..20_000).map(|i| [0.0, 0.3, 1.0].map(|x| [i as f32 + x, 0.0, 0.0]));
    let depth = build(&device, &scene(&line.collect::<Vec<_>>()), &by(Builder::Binned)).0.bvh.depth;
    assert!((14..20).contains(&depth), "a line of 20,000: {depth} levels");
    // Each triangle is a third of the one before: bins part few of them from the rest.
    let shrinking = (0..30_000).map(|i| {
        let s = 3f32.powi(-(i % 80)) * (1.0 + i as f32 * 1e-6);
        [[s, 0.0, 0.0], [s, s, 0.0], [s, 0.0, s]]
    });
    let depth = build(&device, &scene(&shrinking.collect::<Vec<_>>()), &by(Builder::Binned)).0.bvh.depth;
    assert!(depth <= bvh::binned::DEEPEST + 15, "shrinking: {depth} levels");
}
