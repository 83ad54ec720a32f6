//! The boxes of a level: where they stand, what they hold, how many and how large they are; and `boxwood boxes`, which
//! shows them.

#![allow(clippy::unwrap_used)]

use crate::cli::Folder;
use crate::gpu::quiet;
use crate::soup::{Corners, moved, named, random, scene};
use boxwood::abi::{INVALID, TRIANGLE_WORDS};
use boxwood::bvh::{self, Bvh, Child, Fit, HostTree, Level, NodeBox, PlacedBox, Recipe, SceneBuffers};
use boxwood::device::Timing;
use boxwood::oracle::quality::measure;
use boxwood::oracle::validate::{Claims, validate};
use boxwood::scene::Scene;
use glam::DVec3;
use serde_json::Value;
use std::collections::{HashMap, HashSet};
use std::fs;

fn recipe(fit: Fit) -> Recipe {
    Recipe { fit, ..Recipe::default() }
}

/// The device's tree, here and there.
fn built(scene: &Scene, recipe: &Recipe) -> (Bvh, HostTree) {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, scene).unwrap();
    let bvh = bvh::build(&device, &buffers, recipe, Timing::Off).unwrap().bvh;
    let tree = bvh.read().unwrap();
    (bvh, tree)
}

/// Places of the triangles below.
fn below(tree: &HostTree, child: Child) -> Vec<u32> {
    match child {
        Child::Leaf { first, count } => (first..first + count).collect(),
        Child::Node(i) => {
            tree.children(&tree.nodes[i as usize]).iter().flat_map(|(c, _)| below(tree, *c)).collect()
        }
    }
}

fn is_leaf(b: &NodeBox) -> bool {
    matches!(b.child, Child::Leaf { .. })
}

/// Soups that lie along no axis, small, far off, large.
fn scenes() -> Vec<(&'static str, Scene)> {
    let turned = |p: [f32; 3]| [p[0] * 0.8 - p[1] * 0.6, p[0] * 0.6 + p[1] * 0.8, p[2]];
    let slivers: Vec<Corners> = random(1500, 0.3, 1).iter().map(|[a, b, _]| [*a, *b, *a]).collect();
    let slivers: Vec<Corners> =
        slivers.iter().map(|[a, b, _]| [*a, *b, std::array::from_fn(|k| a[k] + 1e-3 * k as f32)]).collect();
    vec![
        ("random", scene(&random(700, 0.2, 3))),
        ("slivers", scene(&slivers)),
        ("far", scene(&moved(&slivers, |p| p.map(|x| 1e-3 * x + 40.0)))),
        ("large", scene(&moved(&slivers, |p| p.map(|x| 1e20 * x)))),
        ("turned", scene(&moved(&random(300, 0.1, 4), turned))),
        ("city", named("city-rotated:5k")),
        ("few", scene(&random(20, 0.3, 5))),
    ]
}

#[test]
fn every_triangle_lies_in_one_box_of_each_level() {
    let mut oriented = 0;
    for (name, scene) in scenes() {
        for fit in [Fit::Aabb, Fit::Dito(14)] {
            let (bvh, tree) = built(&scene, &recipe(fit));
            let unit = 2f64.powi(-bvh.exponent);
            for level in (0..=bvh.depth).map(Level::Depth).chain([Level::Leaves]) {
                let boxes = tree.boxes(level, &bvh.bounds);
                let places: Vec<u32> = boxes.iter().flat_map(|b| below(&tree, b.child)).collect();
                let all: Vec<u32> = (0..bvh.triangle_count).collect();
                assert_eq!(places, all, "{name}, {fit:?}, {level:?}: each triangle once, in order");
                for b in &boxes {
                    let placed = PlacedBox::of(&bvh, &b.volume);
                    oriented += usize::from(b.volume.frame.is_some());
                    // As `validate` allows, and for f32 corners less the anchor.
                    let allowed = 12.0 * f64::from(f32::EPSILON) * f64::from(bvh.reach) * unit;
                    for place in below(&tree, b.child) {
                        let corners = scene.corners(tree.input_index(place as usize) as usize);
                        for corner in corners.map(|p| DVec3::from_array(p.map(f64::from))) {
                            for k in 0..3 {
                                let at = placed.axes[k].dot(corner - placed.origin);
                                let out = (-at).max(at - placed.size[k]);
                                assert!(out <= allowed, "{name}, {fit:?}, {level:?}: {out:e} > {allowed:e}");
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(oriented > 1000, "{oriented}");
}

#[test]
fn levels_have_the_boxes_and_areas_that_quality_counts() {
    for (name, scene) in scenes() {
        for fit in [Fit::Aabb, Fit::Dito(20)] {
            let recipe = recipe(fit);
            let (bvh, tree) = built(&scene, &recipe);
            let claims = Claims::of(&bvh, recipe.collapse);
            let stats = validate(&scene, &tree, &claims).unwrap();
            let quality = measure(&tree, &claims);
            let whole = tree.boxes(Level::Depth(0), &bvh.bounds)[0].volume.half_area();
            let (mut leaves_above, mut all_areas) = (0, 0.0);
            for (depth, level) in quality.levels.iter().enumerate() {
                let boxes = tree.boxes(Level::Depth(depth as u32), &bvh.bounds);
                let leaves = boxes.iter().filter(|b| is_leaf(b)).count();
                let counts = (boxes.len(), leaves);
                let wanted = level.leaves + leaves_above;
                assert_eq!(counts, (level.nodes + wanted, wanted), "{name}, {fit:?}, level {depth}");
                leaves_above = wanted;
                let here = boxes.iter().filter(|b| b.depth == depth as u32);
                let area = here.map(|b| b.volume.half_area()).sum::<f64>() / whole;
                let tight = stats.area_by_level[depth];
                if fit == Fit::Aabb {
                    // Rounded outward to their nodes' grids.
                    let share = area / tight;
                    assert!((0.999_999..1.3).contains(&share), "{name}, level {depth}: {share}");
                }
                if depth > 0 {
                    all_areas += area;
                }
            }
            assert!(
                (all_areas / stats.box_area - 1.0).abs() < 1e-9,
                "{name}: {all_areas} {}",
                stats.box_area
            );
            let last = quality.levels.len() as u32 - 1;
            let deepest = tree.boxes(Level::Depth(last), &bvh.bounds);
            assert_eq!(deepest, tree.boxes(Level::Leaves, &bvh.bounds), "{name}");
            assert_eq!(deepest, tree.boxes(Level::Depth(u32::MAX), &bvh.bounds), "{name}");
            assert_eq!(deepest.len(), stats.leaves, "{name}");
        }
    }
}

#[test]
fn level_0_is_the_scenes_box() {
    for (name, scene) in scenes() {
        let (bvh, tree) = built(&scene, &recipe(Fit::Dito(14)));
        let boxes = tree.boxes(Level::Depth(0), &bvh.bounds);
        assert_eq!(boxes.len(), 1, "{name}");
        let (vertices, bounds) = (PlacedBox::of(&bvh, &boxes[0].volume).vertices(), scene.bounds());
        for (end, wanted) in [(0, bounds.lo), (7, bounds.hi)] {
            for (x, y) in vertices[end].iter().zip(wanted) {
                // An ulp of unit space.
                let allowed = f64::from(f32::EPSILON) * f64::from(bvh.reach) * 2f64.powi(-bvh.exponent);
                assert!((f64::from(*x) - f64::from(y)).abs() <= 2.0 * allowed, "{name}: {x} {y}");
            }
        }
    }
}

#[test]
fn trees_of_one_leaf_and_of_nothing() {
    let (bvh, tree) = built(&scene(&random(1, 0.5, 1)), &recipe(Fit::Aabb));
    for level in [Level::Depth(0), Level::Depth(1), Level::Leaves] {
        let boxes = tree.boxes(level, &bvh.bounds);
        assert_eq!((boxes.len(), boxes[0].depth, boxes[0].child), (1, 0, Child::Leaf { first: 0, count: 1 }));
    }
    let (bvh, tree) = built(&scene(&[[[f32::NAN; 3]; 3]]), &recipe(Fit::Aabb));
    assert_eq!(bvh.root, INVALID);
    assert!(tree.boxes(Level::Leaves, &bvh.bounds).is_empty());
    assert_eq!(tree.triangles.len() % TRIANGLE_WORDS as usize, 0);
}

/// A box's triangles by the bits of their corners: closed, and turned outward.
fn assert_closed(scene: &Scene, name: &str) {
    let at = |v: u32| scene.positions[v as usize].map(f32::to_bits);
    for (i, surface) in scene.triangles.chunks_exact(12).enumerate() {
        let mut edges: HashMap<_, i32> = HashMap::new();
        let mut volume = 0.0;
        let middle: DVec3 = surface.iter().flatten().map(|v| point(scene, *v)).sum::<DVec3>() / 36.0;
        for t in surface {
            for k in 0..3 {
                let (a, b) = (at(t[k]), at(t[(k + 1) % 3]));
                *edges.entry((a, b)).or_default() += 1;
                *edges.entry((b, a)).or_default() -= 1;
            }
            let [a, b, c] = t.map(|v| point(scene, v) - middle);
            volume += a.cross(b).dot(c);
        }
        assert!(edges.values().all(|n| *n == 0), "{name}: box {i} is open");
        assert!(volume >= 0.0, "{name}: box {i} is turned inside out");
    }
}

fn point(scene: &Scene, v: u32) -> DVec3 {
    DVec3::from_array(scene.positions[v as usize].map(f64::from))
}

#[test]
fn pictures_and_meshes_by_their_extensions() {
    let folder = Folder::new();
    let run = |level: &str, out: &[&str]| -> (Value, String) {
        let base = ["boxes", "dragon-like:2k", "--builder", "dito14", "--width", "64", "--height", "48"];
        let files: Vec<&str> = out.iter().flat_map(|f| ["--out", f]).collect();
        let out = folder.run(&[&base[..], &["--level", level], &files].concat());
        let stderr = String::from_utf8(out.stderr).unwrap();
        assert!(out.status.success(), "{stderr}");
        (serde_json::from_slice(&out.stdout).unwrap(), stderr)
    };
    let (json, stderr) = run("4", &["a.png", "a.glb", "a.obj"]);
    let boxes = json["boxes"].as_u64().unwrap() as usize;
    let oriented = json["oriented"].as_u64().unwrap() as usize;
    assert!(boxes > oriented && oriented > 0 && json["leaves"].as_u64() <= Some(boxes as u64), "{json}");
    assert!(
        json["triangles"] == 12 * boxes && json["files"] == serde_json::json!(["a.png", "a.glb", "a.obj"])
    );
    assert!(
        json["area"].as_f64() > Some(0.1) && stderr.contains(&format!("level 4: {boxes} boxes")),
        "{stderr}"
    );

    let read = |name: &str| named(folder.path(name).to_str().unwrap());
    let [glb, obj] = ["a.glb", "a.obj"].map(read);
    for (name, mesh) in [("glb", &glb), ("obj", &obj)] {
        assert_eq!(mesh.triangles.len(), 12 * boxes, "{name}");
        assert_closed(mesh, name);
        let colors: Vec<_> = (0..12 * boxes).map(|i| mesh.materials.color(i).unwrap()).collect();
        let blue = colors.iter().take_while(|c| c[2] > c[0]).count();
        assert_eq!(blue, 12 * (boxes - oriented), "{name}: the axis-aligned ones, first and blue");
        assert!(colors[blue..].iter().all(|c| c[0] > c[2]), "{name}: {:?}", colors[blue]);
    }
    let corners =
        |s: &Scene| (0..s.triangles.len()).map(|i| s.corners(i).map(|p| p.map(f32::to_bits))).collect();
    let (of_glb, of_obj): (Vec<_>, Vec<_>) = (corners(&glb), corners(&obj));
    assert!(of_glb == of_obj, "GLB and OBJ differ");

    let bytes = fs::read(folder.path("a.glb")).unwrap();
    let document = gltf::Gltf::from_slice(&bytes).unwrap();
    let names: Vec<&str> = document.nodes().filter_map(|n| n.name()).collect();
    assert_eq!(names, ["aabb", "oriented"]);

    let picture = image::open(folder.path("a.png")).unwrap().to_rgb8();
    assert!(picture.width() == 64 && picture.height() > 48);
    let colors: HashSet<[i32; 3]> = picture.pixels().map(|p| p.0.map(i32::from)).collect();
    let some = |what: fn(&[i32; 3]) -> bool| colors.iter().filter(|c| what(c)).count();
    let (blue, orange) = (some(|c| c[2] > c[0] + 30), some(|c| c[0] > c[2] + 30));
    assert!(blue > 20 && orange > 20, "{blue} bluish colours, {orange} orange ones");

    let (json, stderr) = run("99", &["b.glb"]);
    assert!(json["leaves"] == json["boxes"] && stderr.contains("all leaves' boxes"), "{stderr}");
    let (leaves, _) = run("leaves", &["c.glb"]);
    assert_eq!((&leaves["boxes"], &leaves["level"]), (&json["boxes"], &"leaves".into()));
    let (json, _) = run("0", &["d.obj"]);
    assert_eq!((&json["triangles"], &json["area"], &json["oriented"]), (&12.into(), &1.0.into(), &0.into()));
}

#[test]
fn what_cannot_be_shown_is_named() {
    let folder = Folder::new();
    folder.write("nothing.tri", &[f32::NAN; 9]);
    let boxes = |scene: &'static str, level: &'static str, out: &'static str| {
        ["boxes", scene, "--level", level, "--out", out]
    };
    folder.fails(&boxes("two.tri", "1", "a.stl"), 1, "ends in .png, .glb or .obj");
    folder.fails(&boxes("two.tri", "1", "none/a.obj"), 1, "can't write none/a.obj");
    folder.fails(&boxes("two.tri", "-1", "a.png"), 2, "leaves");
    folder.fails(&boxes("two.tri", "half", "a.png"), 2, "whole number");
    folder.fails(&boxes("nothing.tri", "1", "a.obj"), 1, "no triangle of it can be hit");
    folder.fails(&["boxes", "two.tri", "--level", "1"], 2, "required");
    folder.fails(&["boxes", "two.tri", "--out", "a.png"], 2, "required");
}
