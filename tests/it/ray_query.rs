//! The driver's own structures and traversal: judged by the f64 reference, for there is no twin of a driver. Devices
//! without ray queries say so.

#![allow(clippy::unwrap_used)]

use crate::bench::{args, folder, rows};
use crate::gpu::{Quiet, gpu, options, quiet, quiet_on};
use crate::matrix::{gpu_shaped, narrow};
use crate::soup::{Corners, grid, random, random_rays, ray, scene, sphere};
use boxwood::abi::{Hit, Ray};
use boxwood::bvh::{BuildError, SceneBuffers};
use boxwood::device::{Acceleration, Buffer, Device, DeviceError, Options, Recorder, Timing, Triangles};
use boxwood::oracle::compare::{self, Arithmetic, Verdict, compare};
use boxwood::oracle::reference::Reference;
use boxwood::ray_query::{Built, TriangleOrder, build, trace};
use boxwood::scene::Scene;
use boxwood::trace::{Batch, Query, RayOrder};
use serde_json::Value;
use std::fs;
use std::sync::{Arc, OnceLock};

/// A device on which nobody may ask for ray queries.
fn without() -> &'static Arc<Device> {
    static DEVICE: OnceLock<Arc<Device>> = OnceLock::new();
    let options = Options { without_ray_query: true, ..options() };
    DEVICE.get_or_init(|| Device::open(&options).unwrap())
}

fn has_ray_query(device: &Device) -> bool {
    device.info().features.iter().any(|f| f.name == "VK_KHR_ray_query" && f.present)
}

/// Structures over `scene` in both orders of its triangles; none where the device has no ray queries, which it must say.
fn structures(device: &Arc<Device>, scene: &Scene) -> Option<[Built; 2]> {
    let buffers = SceneBuffers::upload(device, scene).unwrap();
    let builds = TriangleOrder::ALL.map(|order| build(device, &buffers, order, Timing::Kernels));
    if has_ray_query(device) {
        return Some(builds.map(Result::unwrap));
    }
    builds.into_iter().for_each(|built| assert_lacking(device, built.unwrap_err()));
    None
}

fn assert_lacking(device: &Device, error: BuildError) {
    let said = error.to_string();
    assert!(matches!(error, BuildError::Device(DeviceError::Lacking { .. })), "{said}");
    for words in [&device.info().name, "VK_KHR_ray_query", "--device", "boxwood devices"] {
        assert!(said.contains(words), "{said}");
    }
}

fn hits(device: &Arc<Device>, built: &Built, rays: &[Ray], query: Query, order: RayOrder) -> Vec<Hit> {
    let mut batch = Batch::new(device, rays.len(), false).unwrap();
    batch.set(rays).unwrap();
    trace(device, &built.structure, &batch, query, order, Timing::Off).unwrap();
    batch.hits.read().unwrap()
}

fn bits(hits: &[Hit]) -> &[[u32; 4]] {
    bytemuck::cast_slice(hits)
}

fn faults(v: &Verdict) -> usize {
    v.malformed + v.missed_stable + v.false_stable + v.leaked_stable + v.wrong_triangle_stable
}

/// Directions of any length and limits that cut hits off on either side.
fn limited(mut rays: Vec<Ray>) -> Vec<Ray> {
    for (i, ray) in rays.iter_mut().enumerate() {
        let length = [1.0, 1e-3, 700.0][i % 3];
        ray.direction = ray.direction.map(|x| length * x);
        if i % 2 == 1 {
            (ray.t_min, ray.t_max) = (0.4 / length, 1.6 / length);
        }
    }
    rays
}

/// Everything about one scene; how many rays hit, where the device can tell.
fn check(device: &Quiet<'_>, what: &str, scene: &Scene, rays: &[Ray]) -> Option<usize> {
    let [mesh, morton] = structures(device, scene)?;
    let reference = Reference::new(scene);
    let nearest = [&mesh, &morton].map(|b| hits(device, b, rays, Query::Closest, RayOrder::AsGiven));
    for (hits, order) in nearest.iter().zip(TriangleOrder::ALL) {
        let verdict = compare(&reference, rays, hits, compare::Query::Closest, Arithmetic::Rounded);
        assert!(faults(&verdict) == 0, "{what}, {order:?}: {verdict}");
    }
    let ts = nearest.each_ref().map(|hits| hits.iter().map(|h| h.t.to_bits()).collect::<Vec<_>>());
    assert_eq!(ts[0], ts[1], "{what}: t by the order of triangles");
    for (built, order) in [&mesh, &morton].into_iter().zip(TriangleOrder::ALL) {
        let any = hits(device, built, rays, Query::Any, RayOrder::AsGiven);
        let verdict = compare(&reference, rays, &any, compare::Query::Any, Arithmetic::Rounded);
        assert!(faults(&verdict) == 0, "{what}, any hit, {order:?}: {verdict}");
        assert!(any.iter().all(|h| *bits(&[*h]) == *bits(&[Hit::MISS]) || h.t == 0.0), "{what}");
        for (query, plain) in [(Query::Closest, &nearest[order as usize]), (Query::Any, &any)] {
            let sorted = hits(device, built, rays, query, RayOrder::Sorted);
            assert_eq!(bits(&sorted), bits(plain), "{what}, {order:?}, {query:?}: sorted");
        }
    }
    Some(nearest[0].iter().filter(|h| h.is_hit()).count())
}

#[test]
fn hits_are_the_references() {
    let device = quiet();
    for (what, scene) in [
        ("soup", scene(&random(3000, 0.2, 1))),
        ("grid", scene(&grid(512))),
        ("one", scene(&random(1, 1.0, 2))),
    ] {
        let rays = limited(random_rays(6000, 3));
        if let Some(hits) = check(&device, what, &scene, &rays) {
            let least = if scene.triangles.len() > 1 { 500 } else { 1 };
            assert!(hits >= least && hits < rays.len() - least, "{what}: {hits} of {} hit", rays.len());
        }
    }
}

#[test]
fn closed_meshes_are_closed_but_for_edges() {
    let device = quiet();
    let scene = sphere(24, [0.3, -0.2, 0.1], 0.9);
    let rays: Vec<Ray> = random_rays(4000, 5).iter().map(|r| ray([0.3, -0.2, 0.1], r.direction)).collect();
    if let Some(hits) = check(&device, "sphere", &scene, &rays) {
        assert_eq!(hits, rays.len());
    }
}

#[test]
fn any_kernel_shape_and_word_size() {
    for other in [gpu_shaped, narrow] {
        let device = quiet_on(other);
        let rays = limited(random_rays(1500, 7));
        if let Some(hits) = check(&device, "soup", &scene(&random(500, 0.4, 6)), &rays) {
            assert!(hits > 100, "{hits}");
        }
    }
}

#[test]
fn what_cannot_be_hit_is_left_out() {
    let device = quiet();
    let mut corners: Vec<Corners> = random(300, 0.4, 8);
    corners[3][1][2] = f32::NAN;
    corners[77][0][0] = f32::INFINITY;
    corners[200] = [corners[200][0]; 3];
    let rays = random_rays(2000, 9);
    if let Some(hits) = check(&device, "with holes", &scene(&corners), &rays) {
        assert!(hits > 300, "{hits}");
    }
    let none = [[[f32::NAN; 3]; 3]; 2];
    for empty in [&none[..], &[]] {
        assert!(check(&device, "nothing", &scene(empty), &rays).is_none_or(|hits| hits == 0));
    }
}

#[test]
fn rays_that_go_nowhere_miss() {
    let device = quiet();
    let Some(both) = structures(&device, &scene(&random(300, 0.6, 10))) else { return };
    let good = ray([0.0; 3], [1.0, 0.2, 0.1]);
    let rays = [
        Ray { direction: [0.0; 3], ..good },
        Ray { direction: [f32::NAN, 0.0, 1.0], ..good },
        Ray { origin: [f32::INFINITY, 0.0, 0.0], ..good },
        Ray { t_min: 2.0, t_max: 1.0, ..good },
        Ray { t_min: -2.0, t_max: -1.0, ..good },
        Ray { t_max: f32::NAN, ..good },
    ];
    for built in &both {
        for query in [Query::Closest, Query::Any] {
            let hits = hits(&device, built, &rays, query, RayOrder::AsGiven);
            assert_eq!(bits(&hits), bits(&[Hit::MISS; 6]), "{query:?}");
        }
    }
}

#[test]
fn a_build_is_timed_and_weighed() {
    let device = quiet();
    let Some([mesh, morton]) = structures(&device, &scene(&random(2000, 0.1, 11))) else { return };
    let passes = |b: &Built| b.times.passes.iter().map(|p| p.name).collect::<Vec<_>>();
    let own = ["acceleration/triangles", "acceleration/instance"];
    assert_eq!(passes(&mesh), own);
    let sorted = passes(&morton);
    assert_eq!(sorted[sorted.len() - 3..], ["ray_query/index", own[0], own[1]]);
    assert!(sorted.contains(&"morton/encode") && sorted.contains(&"sort/scatter"), "{sorted:?}");
    assert_eq!(morton.structure.bytes(), mesh.structure.bytes() + 4 * 2000);
    for built in [&mesh, &morton] {
        assert!(built.structure.bytes() > 2000 * 36 && built.scratch_bytes > 0 && built.wall_ms > 0.0);
    }
    assert!(
        morton.explain.iter().any(|s| s.contains("sorting is part of the build")),
        "{:?}",
        morton.explain
    );
}

#[test]
fn without_ray_queries_the_error_says_so() {
    let device = quiet_on(without);
    let buffers = SceneBuffers::upload(&device, &scene(&grid(3))).unwrap();
    for order in TriangleOrder::ALL {
        assert_lacking(&device, build(&device, &buffers, order, Timing::Off).unwrap_err());
    }
}

#[test]
fn no_more_triangles_than_there_are() {
    let device = quiet();
    if structures(&device, &scene(&[])).is_none() {
        return;
    }
    let corners = Buffer::from_slice(&device, "corners", &[0f32; 18]).unwrap();
    let mut rec = Recorder::new(&device, Timing::Off).unwrap();
    let triangles = Triangles { corners: &corners, indices: None, count: 3 };
    let error = Acceleration::record(&mut rec, &triangles).unwrap_err();
    assert!(matches!(error, DeviceError::Limit { wanted: 3, limit: 2, .. }), "{error}");
}

/// What a run of the benchmark against the device's own has, beside what it has without.
#[test]
fn the_benchmark_measures_the_devices_own_in_turn() {
    let folder = folder();
    let against = args(&["--against", "ray-query", "--out", "r"]);
    if !has_ray_query(gpu()) {
        return folder.fails(&against, 1, "VK_KHR_ray_query");
    }
    let out = folder.run(&against);
    let said = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let all = rows(&folder, "r/rows.jsonl");
    let (theirs, own): (Vec<_>, Vec<_>) = all.iter().partition(|(key, _)| key.contains("ray-query"));
    assert_eq!((theirs.len(), own.len()), (40, 40), "two builders of either kind");
    for (key, row) in &theirs {
        let absent = ["tree", "quality", "tight", "tree_hash", "tests", "boxes"];
        assert!(absent.iter().all(|field| row.get(field).is_none()), "{key}: {row}");
        if row["row"] == "rays" {
            let mine = &all[&key.replace("ray-query-morton", "ploc").replace("ray-query", "ploc")];
            assert_eq!(
                (&row["rays"], &row["check"]["rays"]),
                (&mine["rays"], &mine["check"]["rays"]),
                "{key}"
            );
            let [hits, expected] = [row, mine].map(|r| r["hits"].as_f64().unwrap());
            assert!((hits - expected).abs() <= 0.001 * expected, "{key}: {hits} of {expected}");
        } else {
            assert!(row["bvh_bytes"].as_u64() > Some(0) && row["scratch_bytes"].as_u64() > Some(0), "{row}");
        }
    }
    let of_tables = |name: &str| said.lines().filter(|line| line.contains(name)).count();
    assert!(of_tables("| ray-query-morton ") >= 12 && of_tables("ray_query/trace") >= 20, "{said}");
    let csv = fs::read_to_string(folder.path("r/bench.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 2 * 4 * 9, "{csv}");
    let json: Value = serde_json::from_slice(&fs::read(folder.path("r/bench.json")).unwrap()).unwrap();
    assert_eq!((json["builds"].as_array().unwrap().len(), json["rays"].as_array().unwrap().len()), (8, 72));
    for others in [&["compare", "r", "r/bench.json"][..], &["report", "r", "--out", "page.html"]] {
        let out = folder.run(others);
        assert!(out.status.success(), "{others:?}: {}", String::from_utf8_lossy(&out.stderr));
    }
    assert!(fs::read_to_string(folder.path("page.html")).unwrap().contains("ray-query-morton"));
    // A part that has the device's own alone traces the same rays.
    let mut part = args(&["--against", "ray-query", "--shard", "2/2", "--out", "s"]);
    part.retain(|a| *a != "hairball:2k");
    let out = folder.run(&part);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let part = rows(&folder, "s/rows.jsonl");
    assert_eq!(part.len(), 20);
    assert!(part.iter().all(|(key, row)| key.contains("ray-query") && all[key] == *row));
}
