//! Dispatches of more workgroups than one dimension of a grid has: small workgroups, so that little work does.

#![allow(clippy::unwrap_used)]

use crate::gpu::{gpu, options, quiet, quiet_on};
use crate::matrix::assert_same_tree;
use crate::soup::named;
use boxwood::abi::{GRID_WIDTH, Hit};
use boxwood::bvh::{Bvh, Recipe, SceneBuffers, build};
use boxwood::device::{Device, Options, Shape, Timing};
use boxwood::scene::Scene;
use boxwood::trace::rays::{View, primary};
use boxwood::trace::{self, Batch, Walk, trace};
use std::sync::{Arc, OnceLock};

/// Invocations of a workgroup: with an item each, 2^17 items fill a grid's first dimension.
const WORKGROUP: u32 = 4;

/// A device whose dispatches need two dimensions early.
fn tall() -> &'static Arc<Device> {
    static DEVICE: OnceLock<Arc<Device>> = OnceLock::new();
    let shape = Shape {
        workgroup: WORKGROUP,
        items: 1,
        sort_workgroup: WORKGROUP,
        sort_items: 1,
        sort_digit_bits: 4,
        trace_workgroup: WORKGROUP,
        ..gpu().shape().clone()
    };
    let options = Options { shape: Some(shape), ..options() };
    DEVICE.get_or_init(|| Device::open(&options).unwrap())
}

/// Its tree, and what a picture of it hits, a ray at a time and refilled.
fn tree_and_hits(device: &Arc<Device>, scene: &Scene) -> (Bvh, Vec<Vec<Hit>>) {
    let buffers = SceneBuffers::upload(device, scene).unwrap();
    let bvh = build(device, &buffers, &Recipe::default(), Timing::Off).unwrap().bvh;
    let view = View { camera: scene.view(), width: 400, height: 350 };
    let mut batch = Batch::new(device, view.pixels(), false).unwrap();
    primary(device, &view, &mut batch, Timing::Off).unwrap();
    let hits = [Walk::Single, Walk::Refill].map(|walk| {
        trace(device, &bvh, &batch, trace::Options { walk, ..Default::default() }, Timing::Off).unwrap();
        batch.hits.read_first(batch.count).unwrap()
    });
    (bvh, hits.to_vec())
}

#[test]
fn a_second_dimension_changes_nothing() {
    let scene = named("sphere:140k");
    assert!(scene.triangles.len() > (GRID_WIDTH * WORKGROUP) as usize, "one dimension is enough");
    let (flat, flat_hits) = {
        let device = quiet();
        let (bvh, hits) = tree_and_hits(&device, &scene);
        (bvh.read().unwrap(), hits)
    };
    let device = quiet_on(tall);
    let (bvh, hits) = tree_and_hits(&device, &scene);
    assert_same_tree("two dimensions", &bvh.read().unwrap(), &flat);
    let bytes =
        |hits: &[Vec<Hit>]| hits.iter().flat_map(|h| bytemuck::cast_slice(h).to_vec()).collect::<Vec<u8>>();
    assert!(bytes(&hits) == bytes(&flat_hits), "hits differ");
    assert!(hits[0].iter().any(Hit::is_hit));
}
