//! Trees as files: what is saved is what is loaded, and nothing else is.

#![allow(clippy::unwrap_used)]

mod forged;
mod programs;

use crate::gpu::quiet;
use crate::soup::{named, random, random_rays, scene};
use boxwood::abi::{Hit, Ray};
use boxwood::bvh::{Builder, Bvh, Collapse, Fit, Method, Recipe, SceneBuffers, build};
use boxwood::device::{Device, Timing};
use boxwood::oracle::validate::{Claims, validate};
use boxwood::saved::{self, Origin, load, parse};
use boxwood::scene::Scene;
use boxwood::trace::{Batch, Boxes, Options, Walk, trace};
use bytemuck::cast_slice;
use std::fs;
use std::sync::{Arc, OnceLock};

fn built(device: &Arc<Device>, scene: &Scene, recipe: &Recipe) -> Bvh {
    build(device, &SceneBuffers::upload(device, scene).unwrap(), recipe, Timing::Off).unwrap().bvh
}

fn bytes_of_tree(bvh: &Bvh, scene: &Scene, recipe: &Recipe) -> Vec<u8> {
    let mut bytes = vec![];
    let written = saved::write(bvh, &Origin::new(scene, *recipe), &mut bytes).unwrap();
    assert_eq!(written, bytes.len() as u64);
    bytes
}

fn hits(device: &Arc<Device>, bvh: &Bvh, rays: &[Ray], options: Options) -> Vec<Hit> {
    let mut batch = Batch::new(device, rays.len(), false).unwrap();
    batch.set(rays).unwrap();
    trace(device, bvh, &batch, options, Timing::Off).unwrap();
    batch.hits.read().unwrap()
}

/// A file with these bytes, loaded onto the device.
fn loaded(device: &Arc<Device>, bytes: &[u8]) -> saved::Loaded {
    let file = tempfile::NamedTempFile::new().unwrap();
    fs::write(file.path(), bytes).unwrap();
    load(device, file.path()).unwrap()
}

fn assert_round_trip(what: &str, device: &Arc<Device>, scene: &Scene, recipe: &Recipe) {
    let bvh = built(device, scene, recipe);
    let bytes = bytes_of_tree(&bvh, scene, recipe);
    let again = loaded(device, &bytes);
    let (tree, back) = (bvh.read().unwrap(), again.bvh.read().unwrap());
    assert!(cast_slice::<_, u8>(&tree.nodes) == cast_slice::<_, u8>(&back.nodes), "{what}: nodes differ");
    assert!(tree.triangles == back.triangles, "{what}: triangles differ");
    assert_eq!(tree.hash(), back.hash(), "{what}");
    let kept = |bvh: &Bvh| bvh.axis_aligned.as_ref().map(|nodes| nodes.read().unwrap());
    let (ours, theirs) = (kept(&bvh), kept(&again.bvh));
    let same = ours.as_deref().map(cast_slice::<_, u8>) == theirs.as_deref().map(cast_slice::<_, u8>);
    assert!(same, "{what}: nodes kept axis-aligned differ");
    let numbers = |b: &Bvh| {
        let floats = [b.anchor, [b.reach; 3], b.bounds.lo, b.bounds.hi].map(|p| p.map(f32::to_bits));
        let words = [b.root, b.leaf_bits, b.depth, b.triangle_count, b.left_out, b.oriented];
        (floats, words, b.exponent, b.sah.to_bits(), b.bytes())
    };
    assert_eq!(numbers(&bvh), numbers(&again.bvh), "{what}");
    assert_eq!((&again.origin.recipe, again.bytes), (recipe, bytes.len() as u64), "{what}");
    assert!(again.require_scene(scene).is_ok(), "{what}");

    let parsed = parse(&bytes).unwrap();
    assert_eq!(parsed.tree.hash(), tree.hash(), "{what}");
    // Saved again: the same file.
    assert!(bytes_of_tree(&again.bvh, scene, recipe) == bytes, "{what}: saved again it differs");

    let rays = random_rays(400, 7);
    for boxes in Boxes::of(&bvh) {
        for walk in Walk::all(device) {
            let options = Options { walk: *walk, boxes: *boxes, ..Options::default() };
            let (ours, theirs) =
                (hits(device, &bvh, &rays, options), hits(device, &again.bvh, &rays, options));
            assert!(cast_slice::<_, u8>(&ours) == cast_slice::<_, u8>(&theirs), "{what}: hits differ");
        }
    }
}

#[test]
fn every_builders_tree_comes_back() {
    let device = quiet();
    let city = named("city-rotated:2k");
    for method in Method::ALL {
        let recipe = Recipe { builder: method.builder, fit: method.fit, ..Recipe::default() };
        assert_round_trip(method.name, &device, &city, &recipe);
    }
    let own = Recipe { fit: Fit::Own(4), threshold: None, ..Recipe::default() };
    let hybrid = Recipe { fit: Fit::Hybrid, threshold: Some(20), local_search: 7, ..Recipe::default() };
    let leaf = |max_leaf| Recipe {
        collapse: Collapse { max_leaf, ..Recipe::default().collapse },
        ..Recipe::default()
    };
    for (what, recipe) in
        [("own", own), ("hybrid", hybrid), ("leaves of 1", leaf(1)), ("leaves of 64", leaf(64))]
    {
        assert_round_trip(what, &device, &city, &recipe);
    }
    let auto = built(&device, &city, &Recipe { fit: Fit::Auto, ..Recipe::default() });
    assert!(auto.axis_aligned.is_some(), "no tree here keeps both");
}

#[test]
fn small_and_odd_scenes_come_back() {
    let device = quiet();
    let nan = [[f32::NAN; 3]; 3];
    let far = [[1e30, 0.0, 0.0], [1.1e30, 0.0, 0.0], [1e30, 1e29, 0.0]];
    let tiny = [[1e-30, 0.0, 0.0], [2e-30, 0.0, 0.0], [1e-30, 1e-30, 0.0]];
    let one = random(1, 0.3, 1);
    let soups: [(&str, Vec<_>); 7] = [
        ("nothing", vec![]),
        ("nothing that can be hit", vec![nan, nan]),
        ("one triangle", one.clone()),
        ("one and one left out", vec![nan, one[0]]),
        ("far away", vec![far, far]),
        ("tiny", vec![tiny]),
        ("one leaf of three", random(3, 0.01, 2)),
    ];
    for (what, corners) in &soups {
        for builder in Builder::ALL {
            assert_round_trip(what, &device, &scene(corners), &Recipe { builder, ..Recipe::default() });
        }
    }
    // Longer than a piece that is read at once.
    assert_round_trip("long", &device, &scene(&random(270_000, 0.01, 3)), &Recipe::default());
}

/// A small file, some of whose nodes are oriented, with both sets of nodes; and its scene.
fn small() -> &'static (Scene, Vec<u8>) {
    static SMALL: OnceLock<(Scene, Vec<u8>)> = OnceLock::new();
    SMALL.get_or_init(|| {
        let turned = |t: usize, k: usize| {
            let (x, y) = (t as f32 * 0.3, k as f32 * 0.9 - 1.0);
            [[x + y, x - y, x], [x + y + 2.0, x - y + 2.1, x], [x + y, x - y, x + 0.1]]
        };
        let soup = scene(&(0..14).map(|t| turned(t, t % 3)).collect::<Vec<_>>());
        let leaves = Collapse { max_leaf: 3, ..Recipe::default().collapse };
        let recipe = Recipe { fit: Fit::Auto, collapse: leaves, ..Recipe::default() };
        let bvh = built(&quiet(), &soup, &recipe);
        assert!(bvh.axis_aligned.is_some() && bvh.nodes.len() > 2, "{bvh:?}");
        let bytes = bytes_of_tree(&bvh, &soup, &recipe);
        (soup, bytes)
    })
}

#[test]
fn other_scenes_are_refused() {
    let (soup, bytes) = small();
    let device = quiet();
    let tree = loaded(&device, bytes);
    assert!(tree.require_scene(soup).is_ok());
    let mut nudged = soup.clone();
    nudged.positions[5][1] = f32::from_bits(nudged.positions[5][1].to_bits() ^ 1);
    let mut fewer = soup.clone();
    fewer.triangles.pop();
    let mut swapped = soup.clone();
    swapped.triangles.swap(3, 4);
    for other in [nudged, fewer, swapped, scene(&[])] {
        let fault = tree.require_scene(&other).unwrap_err().to_string();
        assert!(fault.contains("another one") && fault.contains("14 triangles"), "{fault}");
    }
    // The same corners otherwise indexed, by another name: the same tree.
    let shared =
        Scene { name: "other".into(), ..scene(&(0..14).map(|t| soup.corners(t)).collect::<Vec<_>>()) };
    assert!(tree.require_scene(&shared).is_ok());
    // What is loaded is as sound as what was built.
    let claims = Claims::of(&tree.bvh, tree.origin.recipe.collapse);
    validate(soup, &tree.bvh.read().unwrap(), &claims).unwrap();
}
