//! Scenes through the public door. Fetching needs the registries: `cargo test -- --ignored fetched`.

use boxwood::scene::{Options, Progress, names, open};

#[test]
#[ignore = "needs npm, cargo and their registries"]
fn fetched_scenes_are_whole() {
    let cache = tempfile::tempdir().unwrap();
    let options = Options { progress: Progress::Quiet, cache: Some(cache.path().to_owned()) };
    for (name, triangles) in [("dragon", 871_414), ("sponza", 66_450)] {
        for _ in 0..2 {
            let scene = open(name, &options).unwrap();
            assert_eq!(scene.triangles.len(), triangles, "{name}");
            assert_eq!(scene.name, name);
            assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        }
        // A damaged copy is fetched again.
        let file = std::fs::read_dir(cache.path()).unwrap().map(|e| e.unwrap().path());
        let file = file.into_iter().find(|p| p.file_stem().is_some_and(|s| s == name)).unwrap();
        std::fs::write(&file, "damaged").unwrap();
        assert_eq!(open(name, &options).unwrap().triangles.len(), triangles, "{name} again");
    }
    assert_eq!(std::fs::read_dir(cache.path()).unwrap().count(), 2, "something was left beside");
}

#[test]
fn every_generated_name_opens() {
    let options = Options { progress: Progress::Quiet, cache: None };
    for name in names().iter().filter_map(|n| n.spec.strip_suffix(":N")) {
        let scene = open(&format!("{name}:2k"), &options).unwrap();
        assert!(scene.triangles.len().abs_diff(2000) < 400, "{name}: {}", scene.triangles.len());
        assert!(scene.bounds().lo[0] < scene.bounds().hi[0]);
    }
}
