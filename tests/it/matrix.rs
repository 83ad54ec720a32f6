//! Every stage of a build against its twin, bit for bit: sizes × scenes × recipes × kernel shapes.

#![allow(clippy::unwrap_used)]

use crate::gpu::{gpu, options, quiet, quiet_on};
use crate::soup::{grid, random, scene};
use boxwood::abi::TAIL_CLUSTERS;
use boxwood::bvh::{
    self, Bases, Builder, Built, Collapse, Generator, HostTree, Morton, Recipe, SceneBuffers, Stages,
};
use boxwood::device::{Device, Options, Shape};
use boxwood::oracle::{self, morton::is_wide};
use boxwood::scene::Scene;
use bytemuck::{bytes_of, cast_slice};
use std::sync::{Arc, OnceLock};

/// ODOP of few bases.
pub const ODOP: Builder = Builder::Odop(Bases { generator: Generator::Grid, degree: 2 });

/// A recipe with another radius.
pub fn radius(radius: u32) -> Recipe {
    Recipe { radius, ..Recipe::default() }
}

/// A recipe with another largest leaf.
pub fn max_leaf(max_leaf: u32) -> Recipe {
    let collapse = Collapse { max_leaf, ..Recipe::default().collapse };
    Recipe { collapse, ..Recipe::default() }
}

/// A device whose kernels do without 64-bit numbers.
pub fn narrow() -> &'static Arc<Device> {
    static DEVICE: OnceLock<Arc<Device>> = OnceLock::new();
    if !gpu().is_wide() {
        return gpu();
    }
    let options = Options { narrow: true, ..options() };
    DEVICE.get_or_init(|| Device::open(&options).unwrap())
}

/// A device with the kernel shapes of a GPU.
pub fn gpu_shaped() -> &'static Arc<Device> {
    static DEVICE: OnceLock<Arc<Device>> = OnceLock::new();
    let options = Options { shape: Some(Shape::gpu(256)), ..options() };
    DEVICE.get_or_init(|| Device::open(&options).unwrap())
}

/// Opens a device.
pub type Opened = fn() -> &'static Arc<Device>;

/// With 64-bit numbers, where there are such, and without.
pub fn each_width() -> Vec<Opened> {
    if gpu().is_wide() { vec![gpu, narrow] } else { vec![gpu] }
}

/// Likewise, and with the kernel shapes of a GPU.
pub fn each_shape() -> Vec<Opened> {
    let mut all = each_width();
    all.push(gpu_shaped);
    all
}

/// The tree of `scene` on `device`.
pub fn build(device: &Arc<Device>, scene: &Scene, recipe: &Recipe) -> (Built, Stages) {
    bvh::stages(device, &SceneBuffers::upload(device, scene).unwrap(), recipe).unwrap()
}

/// Fails at the first element whose bits differ.
pub fn first_difference<T: bytemuck::NoUninit + std::fmt::Debug>(what: &str, device: &[T], twin: &[T]) {
    assert_eq!(device.len(), twin.len(), "{what}: counts differ");
    if let Some(i) = device.iter().zip(twin).position(|(a, b)| bytes_of(a) != bytes_of(b)) {
        panic!("{what} {i} differs: device {:?}, twin {:?}", device[i], twin[i]);
    }
}

/// Both trees have the same bytes.
pub fn assert_same_tree(what: &str, a: &HostTree, b: &HostTree) {
    assert_eq!((a.root, a.leaf_bits), (b.root, b.leaf_bits), "{what}: root, leaf bits");
    first_difference(&format!("{what}: node"), &a.nodes, &b.nodes);
    first_difference(&format!("{what}: word of triangles"), &a.triangles, &b.triangles);
}

/// Builds on `device` and as the twins do, and compares each stage.
pub fn assert_twin(
    what: &str,
    device: &Arc<Device>,
    scene: &Scene,
    recipe: &Recipe,
) -> (Built, oracle::Built) {
    let what = format!("{what}, {} triangles, {recipe:?}", scene.triangles.len());
    let (built, stages) = build(device, scene, recipe);
    let twin = oracle::build(scene, recipe);
    let mut codes = oracle::morton::encode(scene, &twin.bounds, recipe.morton);
    if !recipe.builder.wants_codes() {
        codes.clear();
    }
    let low_keys: Vec<u32> =
        codes.iter().filter(|_| is_wide(recipe.morton)).map(|code| *code as u32).collect();
    let shift = if is_wide(recipe.morton) { 32 } else { 0 };
    let keys: Vec<u32> = codes.iter().map(|code| (code >> shift) as u32).collect();
    first_difference(&format!("{what}: code"), &stages.keys, &keys);
    first_difference(&format!("{what}: low word of code"), &stages.low_keys, &low_keys);
    first_difference(&format!("{what}: rank"), &stages.order, &twin.order);
    let bvh = &built.bvh;
    let device_space = (stages.scale, bvh.exponent, bvh.anchor.map(f32::to_bits), bvh.reach);
    let space = &twin.space;
    let twin_space = (space.scale, space.exponent, space.anchor.map(f32::to_bits), space.reach);
    assert_eq!(device_space, twin_space, "{what}: unit space");
    let none = || (vec![], vec![], None, vec![], vec![], vec![], 0.0);
    let raw = twin.raw.clone().map_or_else(none, |(tree, kept)| {
        (tree.nodes, tree.cuts, Some(tree.root), kept.nodes, kept.packed, kept.firsts, kept.sah)
    });
    let (nodes, cuts, root, kept, packed, firsts, sah) = raw;
    first_difference(&format!("{what}: raw node"), &stages.nodes, &nodes);
    first_difference(&format!("{what}: raw cut"), &stages.cuts, &cuts);
    first_difference(&format!("{what}: root"), stages.root.as_slice(), root.as_slice());
    first_difference(&format!("{what}: kept node"), &stages.kept, &kept);
    let of_kept = |all: &[u32]| kept.iter().map(|i| all[*i as usize]).collect::<Vec<_>>();
    first_difference(&format!("{what}: packed index"), &of_kept(&stages.packed), &of_kept(&packed));
    let (device_first, twin_first) = (of_kept(&stages.firsts), of_kept(&firsts));
    first_difference(&format!("{what}: first triangle"), &device_first, &twin_first);
    assert_same_tree(&what, &bvh.read().unwrap(), &twin.tree);
    // A sum of f32s a workgroup.
    assert!((bvh.sah - sah).abs() <= 1e-5 * sah, "{what}: SAH cost {}, the twin's is {sah}", bvh.sah);
    assert_eq!(bvh.triangle_count as usize + bvh.left_out as usize, scene.triangles.len(), "{what}");
    (built, twin)
}

/// Sizes around those at which something changes: subgroups, workgroups, tiles of both shapes, the tail, powers of 2.
fn sizes(shape: &Shape) -> Vec<usize> {
    let tile = (shape.workgroup * shape.items) as usize;
    let sort_tile = (shape.sort_workgroup * shape.sort_items) as usize;
    let steps =
        [shape.workgroup as usize, 64, 256, tile, 1024, TAIL_CLUSTERS as usize, 4096, sort_tile, 32768];
    let mut sizes = vec![0, 1, 2, 3, 70_001];
    sizes.extend(steps.iter().flat_map(|n| [n - 1, *n, n + 1]));
    sizes.sort_unstable();
    sizes.dedup();
    sizes
}

#[test]
fn every_size_equals_the_twin() {
    let device = quiet();
    for n in sizes(device.shape()) {
        for builder in Builder::ALL {
            // The others' twins are too slow for more.
            if matches!(builder, Builder::Ploc | Builder::Lbvh) || n < 5000 {
                let recipe = Recipe { builder, ..Recipe::default() };
                assert_twin("random", &device, &scene(&random(n, 0.05, n as u64)), &recipe);
            }
        }
    }
}

#[test]
fn equal_codes_equal_the_twin() {
    let device = quiet();
    for n in [7, 9, 63, 600, 2049, 5000, 20_000] {
        for morton in Morton::ALL {
            for builder in [Builder::Ploc, Builder::Lbvh] {
                let recipe = Recipe { builder, morton, ..Recipe::default() };
                assert_twin("grid", &device, &scene(&grid(n)), &recipe);
            }
        }
    }
}

#[test]
fn every_radius_equals_the_twin() {
    let device = quiet();
    let soups = [("random", scene(&random(4500, 0.1, 1))), ("grid", scene(&grid(4500)))];
    // Up to 32 in registers, beyond by loads.
    for r in [1, 2, 3, 5, 16, 32, 33, 64, 128] {
        for (what, soup) in &soups {
            assert_twin(what, &device, soup, &radius(r));
        }
    }
}

#[test]
fn every_leaf_size_equals_the_twin() {
    let device = quiet();
    let soups = [scene(&random(3000, 0.4, 2)), scene(&grid(3000)), scene(&random(30, 1.0, 3))];
    for leaf in [1, 2, 3, 4, 7, 8, 9, 31, 32, 63, 64] {
        for soup in &soups {
            assert_twin("leaves", &device, soup, &max_leaf(leaf));
            assert_twin("leaves", &device, soup, &Recipe { builder: Builder::Lbvh, ..max_leaf(leaf) });
        }
        assert_twin("leaves", &device, &soups[2], &Recipe { builder: Builder::Binned, ..max_leaf(leaf) });
    }
    let costs = |node_cost, triangle_cost| Recipe {
        collapse: Collapse { node_cost, triangle_cost, max_leaf: 64, ..Recipe::default().collapse },
        ..Recipe::default()
    };
    for recipe in [costs(1e9, 1.0), costs(1e-9, 1.0), costs(0.7, 1.3)] {
        for soup in &soups {
            assert_twin("costs", &device, soup, &recipe);
        }
    }
}

#[test]
fn shapes_and_loads_do_not_show() {
    let soups = [
        scene(&[]),
        scene(&random(1, 0.1, 4)),
        scene(&random(3, 0.1, 4)),
        scene(&random(513, 0.1, 4)),
        scene(&grid(2049)),
        scene(&random(9001, 0.1, 5)),
        scene(&grid(9001)),
    ];
    for (what, other) in [("GPU shapes", gpu_shaped as Opened), ("narrow loads", narrow)] {
        let device = quiet_on(other);
        for soup in &soups {
            assert_twin(what, &device, soup, &Recipe::default());
            assert_twin(what, &device, soup, &Recipe { builder: ODOP, ..Recipe::default() });
            for morton in [Morton::Auto, Morton::Ext7] {
                let recipe = Recipe { builder: Builder::Lbvh, morton, ..Recipe::default() };
                assert_twin(what, &device, soup, &recipe);
            }
        }
    }
    // The window in registers and the plain loads, at a radius that has both.
    let device = quiet_on(gpu_shaped);
    for r in [2, 16] {
        assert_twin("loads", &device, &soups[5], &radius(r));
        assert_twin("loads", &device, &soups[3], &Recipe { builder: ODOP, ..radius(r) });
    }
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let device = quiet();
    let soup = scene(&random(20_000, 0.03, 6));
    for builder in Builder::ALL {
        let recipe = Recipe { builder, ..Recipe::default() };
        let first = build(&device, &soup, &recipe).0.bvh.read().unwrap();
        for _ in 0..4 {
            let again = build(&device, &soup, &recipe).0.bvh.read().unwrap();
            assert_eq!(cast_slice::<_, u8>(&first.nodes), cast_slice::<_, u8>(&again.nodes));
            assert_eq!(first.hash(), again.hash());
        }
    }
}
