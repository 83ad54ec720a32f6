//! Node layouts of the literature: hits are the packed tree's bit for bit, boxes hold their triangles, and nodes are of the
//! kinds that their layout has; the device against the twin.

#![allow(clippy::unwrap_used)]

use crate::gpu::{Quiet, quiet, quiet_on};
use crate::matrix::{each_shape, narrow};
use crate::orient::{rays, slivers};
use crate::soup::{Corners, moved, named, random, scene};
use boxwood::abi::{OBB_BIT, Ray, Tests};
use boxwood::bench::{LayoutPlan, RayKind, measure_layouts};
use boxwood::bvh::{self, Bvh, Collapse, Fit, Recipe, SceneBuffers};
use boxwood::device::Timing;
use boxwood::oracle::layouts::BinaryTree;
use boxwood::oracle::morton::Space;
use boxwood::oracle::trace::{BinaryNodes, Tree};
use boxwood::scene::Scene;
use boxwood::trace::layouts::{Binary, HostBinary, Layout, Volume};
use boxwood::trace::rays::View;
use boxwood::trace::{Batch, Options, Precision, Query, trace};

/// A packed tree with oriented nodes, one without, and the binary tree of both.
fn built(device: &Quiet<'_>, scene: &Scene, recipe: Recipe) -> (Bvh, Bvh, BinaryTree) {
    let buffers = SceneBuffers::upload(device, scene).unwrap();
    let (plain, stages) = bvh::stages(device, &buffers, &Recipe { fit: Fit::Aabb, ..recipe }).unwrap();
    let fit = Fit::Dito(14);
    let packed = bvh::build(device, &buffers, &Recipe { fit, ..recipe }, Timing::Off).unwrap().bvh;
    let plain = plain.bvh;
    let tree = BinaryTree::new(&stages, &plain.read().unwrap(), plain.anchor, plain.reach);
    (packed, plain, tree)
}

/// Words of the hits of `rays`, by the packed tree and by each layout.
fn assert_hits(device: &Quiet<'_>, scene: &Scene, recipe: Recipe, rays: &[Ray], least: usize) {
    let (packed, plain, tree) = built(device, scene, recipe);
    let mut batch = Batch::new(device, rays.len(), true).unwrap();
    batch.set(rays).unwrap();
    let found = || -> Vec<[u32; 4]> {
        batch.hits.read_first(batch.count).unwrap().into_iter().map(bytemuck::cast).collect()
    };
    for query in [Query::Closest, Query::Any] {
        let options = Options { query, ..Options::default() };
        trace(device, &packed, &batch, options, Timing::Off).unwrap();
        let wanted = found();
        let hits = wanted.iter().filter(|h| f32::from_bits(h[0]) < f32::INFINITY).count();
        assert!(hits >= least, "{hits} hits");
        for layout in Layout::ALL {
            let made = tree.packed(layout, &recipe);
            let binary = Binary::upload(device, &made).unwrap();
            binary.trace(device, &plain, &batch, options, Timing::Off).unwrap();
            for (i, (a, b)) in wanted.iter().zip(found()).enumerate() {
                assert_eq!(*a, b, "{}, {query:?}: ray {i}, {:?}", layout.name(), rays[i]);
            }
            let tests = batch.tests.as_ref().unwrap().read().unwrap();
            let (boxes, oriented) = tests.iter().fold((0, 0), |sum, t| (sum.0 + t.boxes, sum.1 + t.oriented));
            match layout {
                Layout::Aabb => assert!(boxes > 0 && oriented == 0),
                Layout::Obb => assert!(boxes == 0 && oriented > 0),
                Layout::Mixed => assert!(boxes > 0, "the root's boxes at least"),
            }
        }
    }
}

/// Rays of the matrix of cases at a scene's triangles.
fn aimed(scene: &Scene, at: f32) -> Vec<Ray> {
    let soup: Vec<Corners> = (0..scene.triangles.len()).map(|t| scene.corners(t)).collect();
    rays(&soup, at)
}

#[test]
fn hits_are_those_of_the_packed_tree() {
    for device in each_shape() {
        let device = quiet_on(device);
        for name in ["city-rotated:3k", "hairball:3k", "sphere:3k"] {
            let scene = named(name);
            assert_hits(&device, &scene, Recipe::default(), &aimed(&scene, 0.0), 300);
        }
    }
}

#[test]
fn far_rays_and_far_scenes_miss_nothing() {
    let device = quiet();
    let far = |soup: &[Corners]| moved(soup, |p| p.map(|x| x + 1e4));
    let soup = far(&slivers(1000, 10));
    assert_hits(&device, &scene(&soup), Recipe::default(), &rays(&soup, 1e4), 300);
    // Origins up to thousands of times as far as what boxes are padded for. From farther still, the triangle test takes
    // rays for hits that pass a sliver's end.
    let soup = slivers(1000, 11);
    let mut rays = rays(&soup, 0.0);
    for (i, ray) in rays.iter_mut().enumerate() {
        let steps = 10f32.powi(1 + i as i32 % 4);
        ray.origin = std::array::from_fn(|k| ray.origin[k] - steps * ray.direction[k]);
    }
    assert_hits(&device, &scene(&soup), Recipe::default(), &rays, 300);
}

#[test]
fn boxes_hold_their_triangles() {
    let device = quiet();
    let scenes = [
        ("city-rotated:5k", named("city-rotated:5k"), 0.3),
        ("hairball:5k", named("hairball:5k"), 0.1),
        ("sphere:5k", named("sphere:5k"), 0.05),
        ("far", scene(&moved(&slivers(1000, 3), |p| p.map(|x| x + 1e4))), 0.1),
        ("tiny", scene(&moved(&slivers(1000, 4), |p| p.map(|x| x * 1e-3))), 0.1),
        ("flat", scene(&moved(&random(500, 0.3, 5), |[x, y, _]| [x, y, 0.0])), 0.0),
    ];
    for (name, scene, least) in scenes {
        let recipe = Recipe::default();
        let (_, _, tree) = built(&device, &scene, recipe);
        let nodes = Layout::ALL.map(|layout| {
            let made = tree.packed(layout, &recipe);
            assert_eq!(tree.outside(&made), 0, "{name}, {}", layout.name());
            made
        });
        let [aabb, obb, mixed] = &nodes;
        assert!(aabb.nodes() > 100 && nodes.iter().all(|made| made.nodes() == aabb.nodes()), "{name}");
        assert!(aabb.obbs.is_empty() && obb.aabbs.is_empty(), "{name}");
        let share = mixed.obbs.len() as f64 / mixed.nodes() as f64;
        assert!(share >= least && share < 1.0, "{name}: {share} of the nodes have an oriented box");
    }
}

/// A child reference's boxes made smaller by 2⁻¹⁰ of themselves.
fn shrunk(made: &HostBinary) -> HostBinary {
    let mut shrunk = made.clone();
    for n in &mut shrunk.obbs {
        for row in [&mut n.left.x, &mut n.left.y, &mut n.left.z] {
            *row = row.map(|x| x * (1.0 + 1.0 / 1024.0));
        }
    }
    for n in &mut shrunk.aabbs {
        n.right.hi[0] -= (n.right.hi[0] - n.right.lo[0]) / 1024.0;
    }
    shrunk
}

#[test]
fn what_lies_outside_is_found() {
    let device = quiet();
    let (_, _, tree) = built(&device, &named("hairball:2k"), Recipe::default());
    for layout in [Layout::Aabb, Layout::Obb] {
        let made = tree.packed(layout, &Recipe::default());
        assert!(tree.outside(&shrunk(&made)) > 100);
    }
}

#[test]
fn mixed_nodes_may_have_a_box_of_either_kind() {
    let device = quiet();
    let recipe = Recipe::default();
    let (_, _, tree) = built(&device, &named("city-rotated:5k"), recipe);
    let mixed = tree.packed(Layout::Mixed, &recipe);
    let kinds: Vec<usize> = (0..mixed.obbs.len() as u32)
        .map(|i| {
            let children = mixed.children(OBB_BIT | i);
            children.into_iter().filter(|(_, volume)| matches!(volume, Volume::Obb(_))).count()
        })
        .collect();
    assert!(kinds.contains(&1) && kinds.contains(&2) && !kinds.contains(&0));
    // Where turning a ray is dear, nothing is oriented.
    let dear = Recipe { oriented_cost: 1e9, ..recipe };
    assert!(tree.packed(Layout::Mixed, &dear).obbs.is_empty());
}

#[test]
fn few_triangles_have_no_node_or_one() {
    let device = quiet();
    for n in [0, 1, 2, 3, 9] {
        for max_leaf in [1, 8] {
            let collapse = Collapse { max_leaf, ..Recipe::default().collapse };
            let recipe = Recipe { collapse, ..Recipe::default() };
            let soup = random(n, 0.5, 6);
            let (packed, plain, tree) = built(&device, &scene(&soup), recipe);
            let rays = rays(&random(50, 0.5, 6), 0.0);
            let mut batch = Batch::new(&device, rays.len(), false).unwrap();
            batch.set(&rays).unwrap();
            for precision in [Precision::Robust, Precision::Fast] {
                let options = Options { precision, ..Options::default() };
                trace(&device, &packed, &batch, options, Timing::Off).unwrap();
                let wanted = batch.hits.read().unwrap();
                for layout in Layout::ALL {
                    let made = tree.packed(layout, &recipe);
                    assert!(made.nodes() < n.max(1));
                    let binary = Binary::upload(&device, &made).unwrap();
                    binary.trace(&device, &plain, &batch, options, Timing::Off).unwrap();
                    let found = batch.hits.read().unwrap();
                    assert!(bytemuck::cast_slice::<_, u8>(&found) == bytemuck::cast_slice::<_, u8>(&wanted));
                }
            }
        }
    }
}

#[test]
fn layouts_are_measured() {
    let device = quiet();
    let scene = named("city-rotated:3k");
    let camera = scene.views_or_default()[0];
    let plan = LayoutPlan {
        recipe: Recipe { fit: Fit::Dito(14), ..Recipe::default() },
        view: View { camera, width: 64, height: 48 },
        kinds: RayKind::ALL.to_vec(),
        sample: 2048,
        runs: 1,
    };
    let layouts = measure_layouts(&device, &scene, &plan, &|_| {}).unwrap();
    let names: Vec<_> = layouts.sizes.iter().map(|s| s.layout).collect();
    assert_eq!(names, ["packed", "packed-aabb", "aabb64", "obb112", "mixed"]);
    let bytes: Vec<_> = layouts.sizes.iter().map(|s| s.bytes as f64 / s.nodes as f64).collect();
    assert_eq!((bytes[0], bytes[1], bytes[2], bytes[3]), (64.0, 64.0, 64.0, 112.0));
    assert!(bytes[4] > 64.0 && bytes[4] < 112.0, "{bytes:?}");
    assert_eq!(layouts.rows.len(), 4 * names.len());
    for row in &layouts.rows {
        assert!(row.differing == 0 && row.count > 500 && row.trace_ms.median > 0.0, "{row:?}");
        assert!(row.tests.boxes + row.tests.oriented > row.count as u64, "{row:?}");
    }
}

#[test]
fn hits_and_counts_are_those_of_the_twin() {
    let device = quiet_on(narrow);
    let recipe = Recipe::default();
    for name in ["city-rotated:2k", "hairball:2k"] {
        let scene = named(name);
        let (_, plain, tree) = built(&device, &scene, recipe);
        let Bvh { exponent, anchor, reach, .. } = plain;
        let space = Space { exponent, scale: 2f32.powi(exponent), anchor, reach };
        let triangles = plain.read().unwrap();
        let twin = Tree { tree: &triangles, space: &space, wide: device.is_wide() };
        let rays = aimed(&scene, 0.0);
        let mut batch = Batch::new(&device, rays.len(), true).unwrap();
        batch.set(&rays).unwrap();
        for (layout, query) in Layout::ALL.into_iter().flat_map(|l| [(l, Query::Closest), (l, Query::Any)]) {
            let made = tree.packed(layout, &recipe);
            let options = Options { query, ..Options::default() };
            let binary = Binary::upload(&device, &made).unwrap();
            binary.trace(&device, &plain, &batch, options, Timing::Off).unwrap();
            let (hits, tests) = (batch.hits.read().unwrap(), batch.tests.as_ref().unwrap().read().unwrap());
            let nodes = BinaryNodes::new(&made, &space);
            for (i, ray) in rays.iter().enumerate() {
                let (hit, counts) = match query {
                    Query::Closest => twin.closest_by(&nodes, ray),
                    Query::Any => twin.any_by(&nodes, ray),
                };
                let what = format!("{name}, {}, {query:?}: ray {i}, {ray:?}", layout.name());
                assert_eq!((hits[i].t, hits[i].triangle), (hit.t, hit.triangle), "{what}");
                let counts_of = |t: &Tests| (t.boxes, t.oriented, t.triangles);
                assert_eq!(counts_of(&tests[i]), counts_of(&counts), "{what}");
            }
        }
    }
}
