//! What `auto` tries on scenes that need unlike boxes, and rays through both kinds of boxes that it keeps.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::assert_twin;
use crate::orient::{found, rays, slivers};
use crate::soup::{Corners, grid, named, scene};
use boxwood::bvh::{self, Fit, Recipe, SceneBuffers};
use boxwood::device::Timing;
use boxwood::oracle::validate::{Claims, validate};
use boxwood::scene::{Scene, Transform};
use boxwood::trace::{Batch, Boxes, Options, Query, Walk};

fn auto() -> Recipe {
    Recipe { fit: Fit::Auto, ..Recipe::default() }
}

/// What ran on a scene, and whether both kinds of boxes were kept: sound, and the twin's to the bit.
fn built(scene: &Scene) -> (String, u32, bool) {
    let device = quiet();
    let (built, twin) = assert_twin("auto", &device, scene, &auto());
    assert_eq!(built.bvh.oriented, twin.oriented);
    validate(scene, &built.bvh.read().unwrap(), &Claims::of(&built.bvh, auto().collapse)).unwrap();
    (built.explain.join("\n"), built.bvh.oriented, built.bvh.axis_aligned.is_some())
}

fn rotated(name: &str) -> Scene {
    Transform { rotate: [30.0, 20.0, 10.0], ..Transform::default() }.apply(named(name)).unwrap()
}

#[test]
fn scenes_get_what_they_need() {
    let (said, oriented, both) = built(&named("city:5k"));
    assert!(said.contains("oriented boxes skipped") && oriented == 0 && !both, "{said}");
    let (said, oriented, both) = built(&rotated("city:5k"));
    assert!(said.contains("DiTO skipped") && oriented > 0 && both, "{said}");
    let (said, oriented, both) = built(&scene(&slivers(2000, 3)));
    assert!(said.contains("by DiTO, bases skipped") && oriented > 0 && both, "{said}");
    assert!(!built(&scene(&grid(500))).2, "nothing to orient, so nothing kept twice");
}

#[test]
fn axis_aligned_geometry_gets_the_tree_of_ploc() {
    let device = quiet();
    let city = named("city:5k");
    let hash = |recipe| {
        let buffers = SceneBuffers::upload(&device, &city).unwrap();
        let bvh = bvh::build(&device, &buffers, &recipe, Timing::Off).unwrap().bvh;
        (bvh.read().unwrap().hash(), bvh.bytes())
    };
    assert_eq!(hash(auto()), hash(Recipe::default()));
}

#[test]
fn both_kinds_of_boxes_give_the_same_hits() {
    let device = quiet();
    let soup: Vec<Corners> = slivers(3000, 12);
    let scene = scene(&soup);
    let buffers = SceneBuffers::upload(&device, &scene).unwrap();
    let build = |fit| bvh::build(&device, &buffers, &Recipe { fit, ..auto() }, Timing::Off).unwrap().bvh;
    let (plain, both) = (build(Fit::Aabb), build(Fit::Auto));
    assert_eq!((Boxes::of(&plain).len(), Boxes::of(&both).len()), (1, 2));
    let rays = rays(&soup, 0.0);
    let mut batch = Batch::new(&device, rays.len(), true).unwrap();
    batch.set(&rays).unwrap();
    let oriented_tests = |batch: &Batch| {
        let tests = batch.tests.as_ref().unwrap().read_first(batch.count).unwrap();
        tests.iter().map(|t| t.oriented).sum::<u32>()
    };
    for query in [Query::Closest, Query::Any] {
        let given = found(&device, &plain, &batch, Options { query, ..Options::default() });
        for (boxes, walk) in Boxes::of(&both).iter().flat_map(|b| Walk::all(&device).iter().map(|w| (*b, *w)))
        {
            let options = Options { query, walk, boxes, ..Options::default() };
            let hits = found(&device, &both, &batch, options);
            assert_eq!(
                bytemuck::cast_slice::<_, u8>(&hits),
                bytemuck::cast_slice::<_, u8>(&given),
                "{options:?}"
            );
            assert_eq!(oriented_tests(&batch) > 0, boxes == Boxes::Mixed, "{options:?}");
        }
    }
}
