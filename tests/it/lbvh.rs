//! LBVH: the climb, its ties, its levels. Every build of `matrix` and `adversarial` compares its trees.

#![allow(clippy::unwrap_used)]

use crate::gpu::{quiet, quiet_on};
use crate::matrix::{assert_twin, gpu_shaped};
use crate::soup::{Random, random, scene};
use boxwood::bvh::raw::{half_area, merged};
use boxwood::bvh::{Builder, Morton, Recipe};
use boxwood::oracle::lbvh;
use proptest::prelude::*;

const LBVH: Builder = Builder::Lbvh;

#[test]
fn equal_codes_make_a_balanced_tree() {
    let device = quiet();
    let one = random(1, 1.0, 1)[0];
    for n in [2usize, 3, 100, 4096, 5000] {
        for morton in Morton::ALL {
            let recipe = Recipe { builder: LBVH, morton, ..Recipe::default() };
            let (built, _) = assert_twin("all alike", &device, &scene(&vec![one; n]), &recipe);
            assert_eq!(built.bvh.depth, n.next_power_of_two().ilog2(), "{n} alike, {morton:?}");
        }
    }
}

#[test]
fn a_climb_does_not_hang_on_who_arrives_first() {
    // Many short workgroups, so that siblings come from different ones.
    let device = quiet_on(gpu_shaped);
    let soup = scene(&random(9000, 0.05, 3));
    let recipe = Recipe { builder: LBVH, morton: Morton::Bits63, ..Recipe::default() };
    let first = assert_twin("climb", &device, &soup, &recipe).0.bvh.read().unwrap().hash();
    for _ in 0..20 {
        assert_eq!(assert_twin("climb", &device, &soup, &recipe).0.bvh.read().unwrap().hash(), first);
    }
}

#[test]
fn low_words_decide_where_high_ones_are_equal() {
    let device = quiet();
    // All in a cell of the 31 upper bits, but for two that span the scene.
    let mut places = Random(5);
    let mut corners = vec![[[-1.0; 3], [-1.0, -1.0, -0.999], [-1.0, -0.999, -1.0]]];
    corners.push([[1.0; 3], [1.0, 1.0, 0.999], [1.0, 0.999, 1.0]]);
    corners.extend((0..3000).map(|_| {
        let at = places.point().map(|x| 0.3 + 2e-4 * x);
        [at, [at[0] + 1e-6, at[1], at[2]], [at[0], at[1] + 1e-6, at[2]]]
    }));
    let soup = scene(&corners);
    // Area of the nodes within the cell.
    let area = |morton| -> f32 {
        let recipe = Recipe { builder: LBVH, morton, ..Recipe::default() };
        let (tree, _) = assert_twin("cell", &device, &soup, &recipe).1.raw.unwrap();
        let areas = tree.nodes.iter().map(|n| half_area(&merged(&n.left_bounds, &n.right_bounds)));
        areas.filter(|area| *area < 1e-3).sum()
    };
    let (short, long) = (area(Morton::Bits30), area(Morton::Bits63));
    assert!(long < 0.3 * short, "30 bits: {short:e}, 63: {long:e}");
}

proptest! {
    #[test]
    fn a_split_parts_the_codes_at_their_highest_bit(words in prop::collection::vec(0u64..50, 2..40)) {
        let mut keys = words;
        keys.sort_unstable();
        let last = keys.len() - 1;
        let right = lbvh::split(&keys, 0, last);
        prop_assert!(0 < right && right <= last);
        if keys[0] == keys[last] {
            prop_assert!(right.is_power_of_two() && 2 * right > last);
        } else {
            let apart = |i: usize| keys[i] ^ keys[i + 1];
            prop_assert!((0..last).all(|i| apart(i) <= apart(right - 1)), "{keys:?}: {right}");
        }
    }
}
