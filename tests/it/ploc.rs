//! PLOC: its keys, its search kernels, its progress. Every build of `matrix` compares its trees.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::{assert_twin, radius};
use crate::soup::{Random, grid, random, scene};
use boxwood::abi::{Aabb, LEAF_BIT, PlocSearchArgs, PlocState, RAW_MASK, SPEC_ITEMS, SPEC_RADIUS, SPEC_WG};
use boxwood::bvh::{Builder, Recipe};
use boxwood::device::{Buffer, Recorder, Timing};
use boxwood::kernels;
use boxwood::oracle::ploc;
use proptest::prelude::*;
use std::collections::BTreeSet;

fn point_box(x: f32) -> Aabb {
    Aabb { lo: [x; 3], hi: [x; 3] }
}

proptest! {
    #[test]
    fn a_key_names_its_pair(i in 0u32..10_000, distance in 1u32..=128, wider in 0u32..=128) {
        let radius = (distance + wider).min(128);
        let key = ploc::pair_key(&point_box(0.5), &point_box(1.5), i, distance, radius);
        prop_assert_eq!(ploc::partner_of(i, key, radius), i + distance);
        prop_assert_eq!(ploc::partner_of(i + distance, key, radius), i);
    }

    #[test]
    fn pairs_of_one_cluster_have_different_colours(i in 128u32..10_000, radius in 1u32..=128) {
        let b = point_box(0.0);
        let after = (1..=radius).map(|d| ploc::pair_key(&b, &b, i, d, radius));
        let before = (1..=radius).map(|d| ploc::pair_key(&b, &b, i - d, d, radius));
        let keys: BTreeSet<u32> = after.chain(before).collect();
        prop_assert_eq!(keys.len() as u32, 2 * radius);
    }
}

#[test]
fn both_searches_find_the_same_in_either_half() {
    let device = quiet();
    let shape = device.shape();
    for n in [2u32, 9, 255, 2049, 5000] {
        let mut random = Random(n.into());
        let mut boxes = |alike: bool| -> Vec<Aabb> {
            let mut one = || {
                let p = random.point();
                if alike { point_box(0.25) } else { Aabb { lo: p, hi: p.map(|x| x + 0.01) } }
            };
            (0..n).map(|_| one()).collect()
        };
        let halves = [boxes(false), boxes(true)];
        let bounds = Buffer::from_slice(&device, "bounds", &halves.concat()).unwrap();
        for (rounds, half) in halves.iter().enumerate() {
            let state = PlocState { groups: [1; 3], clusters: n, rounds: rounds as u32 };
            let state = Buffer::from_slice(&device, "state", &[state, state]).unwrap();
            for r in [8, 16] {
                let constants = [(SPEC_WG, shape.workgroup), (SPEC_ITEMS, shape.items), (SPEC_RADIUS, r)];
                let groups = n.div_ceil(shape.workgroup * shape.items);
                let in_registers = Buffer::<u32>::new(&device, "nearest", n as usize).unwrap();
                let by_loads = Buffer::<u32>::new(&device, "nearest", n as usize).unwrap();
                let (bounds, state, round, capacity) = (bounds.ptr(), state.ptr(), 1, n);
                let mut rec = Recorder::new(&device, Timing::Off).unwrap();
                let nearest = in_registers.ptr_mut();
                let args = PlocSearchArgs { bounds, state, nearest, round, capacity };
                rec.dispatch(&kernels::PLOC_SEARCH, &constants, groups, args).unwrap();
                let nearest = by_loads.ptr_mut();
                let args = PlocSearchArgs { nearest, ..args };
                rec.dispatch(&kernels::PLOC_SEARCH_LOADS, &constants, groups, args).unwrap();
                rec.submit().unwrap();
                let twin = ploc::search(half, r);
                assert_eq!(in_registers.read().unwrap(), twin, "registers, {n} clusters, radius {r}");
                assert_eq!(by_loads.read().unwrap(), twin, "loads, {n} clusters, radius {r}");
            }
        }
    }
}

#[test]
fn coincident_triangles_pair_up_at_once() {
    let device = quiet();
    let one = random(1, 1.0, 1)[0];
    for n in [2usize, 100, 2049, 5000, 16_384] {
        let (built, twin) = assert_twin("all alike", &device, &scene(&vec![one; n]), &Recipe::default());
        let rounds = twin.raw.map(|(tree, _)| tree.root.levels).unwrap();
        let halvings = n.next_power_of_two().ilog2();
        assert!(rounds <= halvings + 4, "{n} triangles: {rounds} rounds, {halvings} halvings");
        assert_eq!(built.bvh.depth, rounds.max(1));
    }
}

#[test]
fn every_raw_node_has_its_place() {
    for (what, soup) in [("random", scene(&random(3000, 0.1, 2))), ("grid", scene(&grid(3000)))] {
        for builder in Builder::ALL {
            let twin = boxwood::oracle::build(&soup, &Recipe { builder, ..radius(8) });
            let (tree, _) = twin.raw.unwrap();
            let mut seen = BTreeSet::new();
            for (i, node) in tree.nodes.iter().enumerate() {
                let mut count = 0;
                for child in [node.left, node.right] {
                    let child = child & (LEAF_BIT | RAW_MASK);
                    assert!(seen.insert(child), "{what}: node {i}: {child:#x} has two parents");
                    count += if child < LEAF_BIT { tree.cuts[child as usize].count } else { 1 };
                }
                assert_eq!(tree.cuts[i].count, count, "{what}: triangles below {i}");
            }
            assert_eq!(tree.cuts[(tree.root.node & RAW_MASK) as usize].count, 3000, "{what}: the root");
            assert_eq!(seen.len(), 2 * tree.nodes.len(), "{what}: all but the root have a parent");
        }
    }
}
