//! Profiles: what submits say of their passes, how full subgroups are; beside, what the command writes.

#![allow(clippy::unwrap_used)]

mod cli;
mod format;

use crate::gpu::{gpu, quiet, quiet_on};
use crate::matrix::gpu_shaped;
use crate::soup::{named, random, random_rays, scene};
use boxwood::abi::{Ray, SPEC_WG, SortGatherArgs, Steps, Tests};
use boxwood::bvh::{self, Builder, Bvh, HostTree, Recipe, SceneBuffers};
use boxwood::device::{Buffer, Device, Recorder, Times, Timing, Traffic, Work};
use boxwood::kernels;
use boxwood::oracle::morton::Space;
use boxwood::oracle::trace::{Nodes, Setup, Tree};
use boxwood::trace::{Batch, Options, Query, Walk, trace};
use std::cell::Cell;
use std::sync::Arc;
use std::time::Duration;

fn built(device: &Arc<Device>, recipe: &Recipe, timing: Timing) -> Times {
    let buffers = SceneBuffers::upload(device, &named("sphere:20k")).unwrap();
    bvh::build(device, &buffers, recipe, timing).unwrap().times
}

#[test]
fn passes_add_up_to_what_lies_between_the_outer_stamps() {
    let device = quiet();
    for builder in [Builder::Ploc, Builder::Lbvh, Builder::Binned] {
        let recipe = Recipe { builder, ..Recipe::default() };
        // What has no stamp is missing from every run; a machine that pauses between two stamps is not.
        let off = || {
            let times = built(&device, &recipe, Timing::Passes);
            let sum: f64 = times.passes.iter().map(|p| p.ms).sum();
            (sum / times.device_ms - 1.0).abs()
        };
        let mut offs = vec![];
        while offs.len() < 40 && offs.last().is_none_or(|last| *last >= 0.05) {
            offs.push(off());
        }
        assert!(offs.last() < Some(&0.05), "{builder:?}: sums are off by {offs:?}");
    }
}

#[test]
fn submits_see_every_pass_and_transfer() {
    let device = quiet();
    let recipe = Recipe::default();
    let [kernels, times] = [Timing::Kernels, Timing::Passes].map(|timing| built(&device, &recipe, timing));
    assert!(kernels.submits.is_empty() && kernels.host.is_empty() && times.submits.len() > 1);
    let events: Vec<_> = times.submits.iter().flat_map(|s| &s.events).collect();
    let names: Vec<&str> = times.passes.iter().map(|p| p.name).collect();
    assert!(events.iter().map(|e| e.name).eq(names.iter().copied()), "{names:?}");
    let transfer = |name: &&str| matches!(*name, "fill" | "update" | "copy");
    let without: Vec<&str> = names.iter().copied().filter(|name| !transfer(name)).collect();
    assert!(kernels.passes.iter().map(|p| p.name).eq(without.iter().copied()), "{without:?}");
    assert!(
        without.len() < names.len() && events.iter().all(|e| transfer(&e.name) == (e.work == Work::Transfer))
    );
    for submit in &times.submits {
        let last = submit.device_at + Duration::from_secs_f64(submit.device_ms * 1e-3);
        let fence = submit.at + Duration::from_secs_f64(submit.wall_ms * 1e-3);
        assert!(submit.at <= submit.device_at && last <= fence + Duration::from_micros(1), "{submit:?}");
        assert!(submit.events.windows(2).all(|e| e[0].at <= e[1].at), "{submit:?}");
        assert!(submit.events.iter().all(|e| submit.device_at <= e.at && e.at <= last && e.ms >= 0.0));
    }
    let host = built(&device, &Recipe { builder: Builder::Binned, ..recipe }, Timing::Passes);
    assert!(host.host.iter().any(|work| work.name == "binned/split" && work.ms > 0.0), "{:?}", host.host);
}

#[test]
fn the_device_counts_the_invocations_that_it_was_asked_for() {
    for device in [gpu, gpu_shaped] {
        let device = quiet_on(device);
        let times = built(&device, &Recipe::default(), Timing::Statistics);
        let has = device.info().features.iter().any(|f| f.name == "pipelineStatisticsQuery" && f.present);
        let mut found = 0;
        for event in times.submits.iter().flat_map(|s| &s.events) {
            let Some(counted) = event.invocations else {
                assert!(!has || event.work == Work::Transfer, "{}: nothing counted", event.name);
                continue;
            };
            found += 1;
            match event.work {
                Work::Groups { groups, size } => {
                    assert_eq!(counted, groups * u64::from(size), "{}", event.name);
                    assert_eq!(event.work.invocations(), Some(counted));
                }
                Work::Indirect { size } => assert_eq!(counted % u64::from(size), 0, "{}", event.name),
                Work::Transfer | Work::Driver => {
                    panic!("{}: {counted} invocations of a transfer", event.name)
                }
            }
        }
        assert_eq!(found > 0, has);
    }
}

#[test]
fn traffic_is_each_buffer_once() {
    let device = quiet();
    let buffer = |name: &str, n: usize| Buffer::from_slice(&device, name, &vec![0u32; n]).unwrap();
    let (source, order, gathered) = (buffer("source", 1000), buffer("order", 100), buffer("gathered", 200));
    let mut rec = Recorder::new(&device, Timing::Passes).unwrap();
    let mut gather = |source: &Buffer<u32>, order: &Buffer<u32>| {
        let args = SortGatherArgs {
            source: source.ptr(),
            order: order.ptr(),
            gathered: gathered.ptr_mut(),
            count: 100,
        };
        rec.dispatch(&kernels::SORT_GATHER, &[(SPEC_WG, 32)], 4, args).unwrap();
    };
    gather(&source, &order);
    gather(&order, &order);
    rec.fill(&gathered, 50, 7);
    rec.update(&gathered, &[1, 2]);
    rec.copy(&order, &source);
    let times = rec.submit().unwrap();
    let found: Vec<_> = times.submits[0].events.iter().map(|e| (e.name, e.work, e.traffic)).collect();
    let dispatch = Work::Groups { groups: 4, size: 32 };
    let written = gathered.bytes();
    assert_eq!(
        found,
        [
            ("sort/gather", dispatch, Traffic { read: source.bytes() + order.bytes(), written }),
            ("sort/gather", dispatch, Traffic { read: order.bytes(), written }),
            ("fill", Work::Transfer, Traffic { read: 0, written: 200 }),
            ("update", Work::Transfer, Traffic { read: 0, written: 8 }),
            ("copy", Work::Transfer, Traffic { read: order.bytes(), written: order.bytes() }),
        ]
    );
}

/// A tree whose visited nodes are counted.
struct Visits<'a> {
    tree: &'a HostTree,
    nodes: Cell<u32>,
}

impl Nodes for Visits<'_> {
    fn root(&self) -> u32 {
        self.tree.root
    }
    fn met(&self, s: &Setup, node: u32, t_max: f32, tests: &mut Tests) -> Vec<(i32, u32)> {
        self.nodes.set(self.nodes.get() + 1);
        self.tree.met(s, node, t_max, tests)
    }
}

/// Nodes that the twin visits with a ray, and triangles that it tests.
fn visits(twin: &Tree, ray: &Ray, query: Query) -> (u32, u32) {
    let nodes = Visits { tree: twin.tree, nodes: Cell::new(0) };
    let (_, tests) = match query {
        Query::Closest => twin.closest_by(&nodes, ray),
        Query::Any => twin.any_by(&nodes, ray),
    };
    (nodes.nodes.get(), tests.triangles)
}

/// Steps and tests of all rays.
fn counted(device: &Arc<Device>, bvh: &Bvh, rays: &[Ray], options: Options) -> (Vec<Steps>, Vec<Tests>) {
    let mut batch = Batch::new(device, rays.len(), true).unwrap();
    batch.set(rays).unwrap();
    trace(device, bvh, &batch, options, Timing::Off).unwrap();
    let plain: Vec<u32> = batch.hits.read().unwrap().iter().map(|h| h.t.to_bits()).collect();
    batch.count_steps(device).unwrap();
    trace(device, bvh, &batch, options, Timing::Off).unwrap();
    let hits = batch.hits.read().unwrap();
    assert!(hits.iter().map(|h| h.t.to_bits()).eq(plain), "counting changes hits");
    (batch.steps.unwrap().read().unwrap(), batch.tests.unwrap().read().unwrap())
}

#[test]
fn lanes_add_up_to_the_visits_of_all_rays() {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &scene(&random(1500, 0.2, 21))).unwrap();
    let bvh = bvh::build(&device, &buffers, &Recipe::default(), Timing::Off).unwrap().bvh;
    let Bvh { exponent, anchor, reach, .. } = bvh;
    let (tree, wide) = (bvh.read().unwrap(), device.is_wide());
    let space = Space { exponent, scale: 2f32.powi(exponent), anchor, reach };
    let twin = Tree { tree: &tree, space: &space, wide };
    let subgroup = device.info().subgroup_size as usize;
    for (n, query) in
        [(1, Query::Closest), (subgroup + 1, Query::Closest), (777, Query::Closest), (777, Query::Any)]
    {
        let rays = random_rays(n, n as u64);
        let expected: Vec<(u32, u32)> = rays.iter().map(|ray| visits(&twin, ray, query)).collect();
        for walk in Walk::ALL {
            let (steps, tests) = counted(&device, &bvh, &rays, Options { query, walk, ..Options::default() });
            let what = format!("{n} rays, {query:?}, {}", walk.kernel_name());
            for (i, (s, t)) in steps.iter().zip(&tests).enumerate() {
                assert_eq!(s.triangles, t.triangles, "{what}: ray {i}");
                // Company has no say in what these two visit.
                if matches!(walk, Walk::Single | Walk::Refill) {
                    assert_eq!((s.nodes, s.triangles), expected[i], "{what}: ray {i}");
                }
            }
            let sum = |f: fn(&Steps) -> u32| steps.iter().map(|s| u64::from(f(s))).sum::<u64>();
            for (lanes, taken) in
                [(sum(|s| s.nodes), sum(|s| s.node_steps)), (sum(|s| s.triangles), sum(|s| s.triangle_steps))]
            {
                assert!(lanes <= taken * subgroup as u64, "{what}: {lanes} lanes in {taken} steps");
                // Of a packet's steps some are for nothing.
                assert!(walk == Walk::Packet || taken <= lanes, "{what}: {lanes} lanes in {taken} steps");
                assert!(n < 777 || taken > 0, "{what}: no step");
            }
            if walk == Walk::Single {
                // Neighbours share a subgroup: it steps as often as the longest of their walks at least.
                for (g, of_group) in steps.chunks(subgroup).enumerate() {
                    let taken: u32 = of_group.iter().map(|s| s.node_steps).sum();
                    let longest = of_group.iter().map(|s| s.nodes).max().unwrap();
                    assert!(taken >= longest, "{what}: subgroup {g}: {taken} steps, a walk of {longest}");
                }
            }
        }
    }
}

#[test]
fn a_lone_ray_fills_one_lane_and_equal_rays_fill_all() {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &named("sphere:2k")).unwrap();
    let bvh = bvh::build(&device, &buffers, &Recipe::default(), Timing::Off).unwrap().bvh;
    let ray = crate::soup::ray([3.0, 0.1, 0.2], [-1.0, 0.01, -0.02]);
    let subgroup = device.info().subgroup_size;
    for (n, lanes) in [(1, 1), (subgroup, subgroup)] {
        let (steps, _) = counted(&device, &bvh, &vec![ray; n as usize], Options::default());
        let sum = |f: fn(&Steps) -> u32| steps.iter().map(f).sum::<u32>();
        assert!(sum(|s| s.node_steps) > 2);
        assert_eq!(sum(|s| s.nodes), lanes * sum(|s| s.node_steps));
        assert_eq!(sum(|s| s.triangles), lanes * sum(|s| s.triangle_steps));
    }
}
