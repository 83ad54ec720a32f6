use super::*;

/// A made-up scene whose package nobody has published.
const NOWHERE: Fetched = Fetched {
    name: "nowhere",
    file: "nowhere.obj",
    registry: Registry::Cargo,
    package: "bvh",
    version: "0.13.0",
    member: "media/nowhere.obj",
    packing: Packing::Plain,
    bytes: 5,
    // of "hello"
    sha256: "2cf24dba5fb0a30e26e83b2ac5b9e29e1b161e5c1fa7425e73043362938b9824",
    camera: None,
    instead: "sphere:5",
};

#[test]
fn a_sound_cached_file_is_taken_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let options = Options { cache: Some(folder.path().to_owned()), ..quiet() };
    fs::write(folder.path().join(NOWHERE.file), "hello").unwrap();
    let (path, bytes) = get(&NOWHERE, &options).unwrap();
    assert_eq!((path, bytes), (folder.path().join(NOWHERE.file), b"hello".to_vec()));
}

#[test]
fn a_damaged_file_is_refused() {
    assert!(check(&NOWHERE, b"hello").is_ok());
    let sum = check(&NOWHERE, b"hellO").unwrap_err();
    assert!(sum.contains("SHA-256"), "{sum}");
    let size = check(&NOWHERE, b"hell").unwrap_err();
    assert!(size.contains("4 bytes instead of 5"), "{size}");
}

#[test]
fn storing_replaces_and_leaves_nothing_beside() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh");
    for text in ["damaged", "hello"] {
        store(folder.path(), &path, text.as_bytes()).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn unpacking_stops_at_the_pinned_size() {
    let endless = io::repeat(b'x');
    assert_eq!(unpack(&NOWHERE, endless).unwrap().len() as u64, NOWHERE.bytes + 1);
    let gzip = Fetched { packing: Packing::Gzip, ..NOWHERE };
    assert!(unpack(&gzip, &b"not gzip"[..]).unwrap_err().contains("damaged"));
}

#[test]
fn a_cache_that_is_a_file_is_an_error_and_a_failed_fetch_names_a_stand_in() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let error = get(&NOWHERE, &Options { cache: Some(file), ..quiet() }).unwrap_err();
    assert!(error.to_string().contains("BOXWOOD_CACHE"), "{error}");
    let error = SceneError::Fetch { name: "x", tried: vec!["npm: no".to_owned()], instead: "sphere:5" };
    assert_eq!(error.instead(), Some("sphere:5"));
    assert!(error.to_string().contains("npm: no"), "{error}");
}

fn quiet() -> Options {
    Options { progress: crate::scene::Progress::Quiet, cache: None }
}
