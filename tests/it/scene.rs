//! Scenes through the public door. Fetching needs the registries: `cargo test --test it -- --ignored fetched`.

#![allow(clippy::unwrap_used)]

use boxwood::abi::Ray;
use boxwood::oracle::rays::primary;
use boxwood::oracle::reference::Reference;
use boxwood::scene::{
    Camera, Entry, Options, Progress, Scene, Source, Transform, is_cached, manifest, names, open,
};
use boxwood::trace::rays::View;
use std::path::Path;

const QUIET: Options = Options { progress: Progress::Quiet, cache: None };

fn named(kind: fn(&Source) -> bool) -> impl Iterator<Item = &'static Entry> {
    manifest().scenes.iter().filter(move |s| kind(&s.source))
}

/// A coarse picture: a cell for about 1500 rays.
fn look(camera: Camera) -> Vec<Ray> {
    primary(&View { camera, width: 48, height: 32 })
}

/// Triangles that the rays of each view meet first.
fn seen(scene: &Scene) -> Vec<Vec<Option<u32>>> {
    let reference = Reference::new(scene);
    let hits = |c: &Camera| reference.closest_all(&look(*c), None);
    scene.views.iter().map(|c| hits(c).iter().map(|h| h.map(|h| h.triangle)).collect()).collect()
}

fn hits(seen: &[Option<u32>]) -> usize {
    seen.iter().flatten().count()
}

/// Five views, no two from one place, each of which sees at least one ray in fifty hit something.
fn has_five_good_views(scene: &Scene) {
    assert_eq!(scene.views.len(), 5, "{}", scene.name);
    for (i, view) in scene.views.iter().enumerate() {
        let all = [view.eye, view.target, view.up].concat();
        assert!(all.iter().all(|x| x.is_finite()) && view.eye != view.target, "{} {i}: {view:?}", scene.name);
        assert!((10.0..=90.0).contains(&view.fov_y), "{} {i}", scene.name);
        assert!(scene.views[..i].iter().all(|v| v.eye != view.eye), "{}: view {i} comes twice", scene.name);
    }
    for (i, seen) in seen(scene).iter().enumerate() {
        let (hits, rays) = (hits(seen), seen.len());
        assert!(50 * hits >= rays, "{}: view {i} sees {hits} hits of {rays}", scene.name);
    }
}

#[test]
#[ignore = "needs npm, cargo, pip and their registries"]
fn fetched_scenes_are_whole() {
    let cache = tempfile::tempdir().unwrap();
    let options = Options { progress: Progress::Quiet, cache: Some(cache.path().to_owned()) };
    let files = || std::fs::read_dir(cache.path()).unwrap().map(|e| e.unwrap().path());
    let mut count = 0;
    for entry in named(|s| matches!(s, Source::Fetched(_))) {
        let name = entry.name.as_str();
        assert!(!is_cached(entry, &options), "{name}");
        for _ in 0..2 {
            let scene = open(name, &options).unwrap();
            assert_eq!(scene.triangles.len() as u64, entry.triangles, "{name}");
            assert_eq!(scene.name, name);
            assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
            assert!(is_cached(entry, &options), "{name}");
        }
        let scene = open(name, &options).unwrap();
        has_five_good_views(&scene);
        match name {
            "sponza" => assert_eq!((scene.view().eye, scene.view().fov_y), ([-12.0, 3.5, 0.0], 70.0)),
            "dragon" => assert_eq!(scene.view(), Camera::default_for(&scene.bounds())),
            _ => {}
        }
        // A damaged copy is fetched again.
        let file = files().find(|p| p.file_stem().is_some_and(|s| s == name)).unwrap();
        std::fs::write(&file, "damaged").unwrap();
        assert!(!is_cached(entry, &options), "{name}");
        assert_eq!(open(name, &options).unwrap().triangles.len() as u64, entry.triangles, "{name} again");
        count += 1;
    }
    assert_eq!(files().count(), count, "something was left beside");
}

#[test]
fn every_generated_name_opens() {
    assert_eq!(names().len(), manifest().scenes.len());
    for name in names().iter().filter_map(|n| n.strip_suffix(":N")) {
        let scene = open(&format!("{name}:2k"), &QUIET).unwrap();
        assert!(scene.triangles.len().abs_diff(2000) < 400, "{name}: {}", scene.triangles.len());
        assert!(scene.bounds().lo[0] < scene.bounds().hi[0]);
    }
}

#[test]
fn generated_scenes_have_five_views_at_any_size() {
    for entry in named(|s| matches!(s, Source::Generated(_))) {
        for size in ["30k", "120k"] {
            has_five_good_views(&open(&format!("{}:{size}", entry.name), &QUIET).unwrap());
        }
    }
}

/// The pictures that people know: the first view is the one that there was before there were five.
#[test]
fn first_views_stay() {
    let view = |spec: &str| open(spec, &QUIET).unwrap().view();
    let hairball = Camera { eye: [1.6, 1.15, 2.55], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y: 45.0 };
    assert_eq!(view("hairball:1k"), hairball);
    assert_eq!(view("city:10k").target, [0.0, 15.0, 0.0]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tri");
    std::fs::write(&path, boxwood::scene::write::tri(&open("sphere:1k", &QUIET).unwrap())).unwrap();
    let file = open(path.to_str().unwrap(), &QUIET).unwrap();
    assert_eq!(file.view(), Camera::default_for(&file.bounds()));
    has_five_good_views(&file);
}

#[test]
fn the_thesis_set_is_eight_scenes() {
    let set = boxwood::scene::set("thesis").unwrap();
    assert_eq!(set.len(), 8);
    let counts: Vec<u64> = set
        .iter()
        .map(|spec| match spec.split_once(':') {
            Some((_, count)) => count.parse().unwrap(),
            None => manifest().entry(spec).unwrap().triangles,
        })
        .collect();
    assert_eq!((counts.iter().min(), counts.iter().max()), (Some(&314_148), Some(&12_698_880)));
}

#[test]
fn powers_of_two_change_no_hit() {
    for spec in ["hairball:5k", "city-rotated:5k"] {
        let scene = open(spec, &QUIET).unwrap();
        let before = seen(&scene);
        for scale in [2f64.powi(-60), 0.5, 2f64.powi(40)] {
            let scaled = Transform { scale, ..Transform::default() }.apply(scene.clone()).unwrap();
            assert!(scaled.warnings.is_empty());
            assert_eq!(seen(&scaled), before, "{}", scaled.name);
        }
    }
}

#[test]
fn a_scene_and_its_views_turn_together() {
    for spec in ["hairball:5k", "city:5k", "sphere:5k"] {
        let scene = open(spec, &QUIET).unwrap();
        let before = seen(&scene);
        // Quarter turns about one axis only swap coordinates and signs; others round each vertex.
        for (rotate, most) in
            [([0.0, 0.0, 90.0], 0.003), ([45.0, 45.0, 45.0], 0.01), ([10.0, -20.0, 130.0], 0.01)]
        {
            let turned = Transform { rotate, ..Transform::default() }.apply(scene.clone()).unwrap();
            for (i, (a, b)) in before.iter().zip(seen(&turned)).enumerate() {
                let other = a.iter().zip(&b).filter(|(a, b)| a.is_some() != b.is_some()).count();
                let share = other as f64 / a.len() as f64;
                assert!(share <= most, "{} view {i}: {other} of {} rays", turned.name, a.len());
            }
        }
    }
}

/// The generator's own rotated city, and the city under `--rotate`, are one scene with the same views.
#[test]
fn the_rotated_city_is_the_city_rotated() {
    let pose = Transform { rotate: [45.0; 3], ..Transform::default() };
    let ours = pose.apply(open("city:20k", &QUIET).unwrap()).unwrap();
    let theirs = open("city-rotated:20k", &QUIET).unwrap();
    assert_eq!(ours.triangles, theirs.triangles);
    let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() <= 1e-4);
    assert!(ours.positions.iter().zip(&theirs.positions).all(|(a, b)| near(*a, *b)));
    for (a, b) in ours.views.iter().zip(&theirs.views) {
        assert!(near(a.eye, b.eye) && near(a.target, b.target) && near(a.up, b.up), "{a:?} {b:?}");
    }
}

#[test]
fn what_is_written_opens_again() {
    let folder = tempfile::tempdir().unwrap();
    let scene = open("hairball:2k", &QUIET).unwrap();
    let written = |name: &str, bytes: Vec<u8>| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        open(Path::new(&path).to_str().unwrap(), &QUIET).unwrap()
    };
    let ply = written("a.ply", boxwood::scene::write::ply(&scene));
    assert_eq!((&ply.positions, &ply.triangles), (&scene.positions, &scene.triangles));
    let tri = written("a.tri", boxwood::scene::write::tri(&scene));
    assert!((0..scene.triangles.len()).all(|i| tri.corners(i) == scene.corners(i)));
}
