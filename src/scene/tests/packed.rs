//! Packed files, of gzip 1.12 and zstd 1.5.4 and of the crates' own packers.

use std::io::Write;

use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::*;

/// `v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n` by `gzip -9n`, and `f 3 2 1\n# xxx…\n`, 311 bytes.
const GZIP: [&str; 2] = [
    "1f8b08000000000002032b53300041ae320543286d006271a501492305632e0043f96e2a20000000",
    "1f8b08000000000002034b533056305230e45256a8180544032e00bdc61d8637010000",
];
/// The same by `zstd -19 --check`.
const ZSTD: [&str; 2] = [
    "28b52ffd2420e500009201050ae0e958c094bd3ba1f1090ac129daf91cedee040100b3eb05dc47cf34",
    "28b52ffd6437009d000060662033203220310a2320780a0100282af00269dd7c8e",
];

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap()).collect()
}

pub(super) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub(super) fn zstd(bytes: &[u8]) -> Vec<u8> {
    compress_to_vec(bytes, CompressionLevel::Fastest)
}

#[test]
fn what_gzip_and_zstd_wrote() {
    let [first, second] = GZIP.map(bytes);
    assert_eq!(read("obj.gz", &first).unwrap().triangles, [[0, 1, 2]]);
    assert_eq!(read("OBJ.GZ", &[first, second].concat()).unwrap().triangles, [[0, 1, 2], [2, 1, 0]]);
    let [first, second] = ZSTD.map(bytes);
    let skipped = [&0x184D_2A53_u32.to_le_bytes()[..], &3u32.to_le_bytes(), b"any"].concat();
    assert_eq!(read("obj.zst", &first).unwrap().triangles, [[0, 1, 2]]);
    let both = [skipped.clone(), first, skipped, second].concat();
    assert_eq!(read("Obj.Zst", &both).unwrap().triangles, [[0, 1, 2], [2, 1, 0]]);
}

#[test]
fn every_format_may_be_packed() {
    for (extension, plain) in samples() {
        let scene = read(extension, &plain).unwrap();
        for (ending, packed) in [("gz", gzip(&plain)), ("zst", zstd(&plain))] {
            let s = read(&format!("{extension}.{ending}"), &packed).unwrap();
            assert_eq!((s.positions, s.triangles), (scene.positions.clone(), scene.triangles.clone()));
            assert!(s.name.ends_with(ending), "{}", s.name);
        }
    }
}

#[test]
fn damage_is_named() {
    let both = |packed: [&str; 2]| packed.map(bytes).concat();
    for (ending, files, length) in [("obj.gz", GZIP, 75), ("obj.zst", ZSTD, 74)] {
        let sound = both(files);
        assert_eq!(sound.len(), length);
        let first = bytes(files[0]).len();
        for end in (1..sound.len()).filter(|e| *e != first) {
            refused(ending, &sound[..end], &["cut short", "byte ", "get it again"]);
        }
        // A flipped bit of the data or the sums can't pass.
        for at in [first - 1, first - 6, first - 12] {
            let mut damaged = sound.clone();
            damaged[at] ^= 0x10;
            refused(ending, &damaged, &["byte ", "get it again"]);
        }
        refused(ending, b"", &[]);
        refused(ending, b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &["byte ", "no sound", "get it again"]);
        refused(ending, &[sound, b"rubbish".to_vec()].concat(), &["byte ", "get it again"]);
    }
    refused("tri.gz", &gzip(&[0; 35]), &["mesh.tri.gz", "triangle 0 is cut short"]);
    let error = open("none.gz", &QUIET).unwrap_err().to_string();
    assert!(error.contains(".ply") && error.contains(".zst"), "{error}");
}

/// Every cut and every flipped bit: an answer of either kind.
#[test]
fn damage_never_panics() {
    for (ending, files) in [("obj.gz", GZIP), ("obj.zst", ZSTD)] {
        let path = std::path::Path::new("mesh").with_extension(ending);
        let sound = files.map(bytes).concat();
        let more = [("obj.zst", zstd(OBJ.as_bytes())), ("obj.gz", gzip(OBJ.as_bytes()))];
        let more = more.into_iter().filter(|m| m.0 == ending).map(|m| m.1);
        for sound in std::iter::once(sound).chain(more) {
            for bit in 0..8 * sound.len() {
                let mut damaged = sound.clone();
                damaged[bit / 8] ^= 1 << (bit % 8);
                let _ = crate::scene::packed::unpack(&path, &damaged, Progress::Quiet);
            }
        }
    }
}

#[test]
fn bombs_are_refused() {
    // A small file may unpack to 256 MiB, and no further.
    let bomb = gzip(&vec![0; 16 << 20]).repeat(17);
    assert!(bomb.len() < 1 << 20);
    refused("tri.gz", &bomb, &["unpack to over 268435456", "no mesh"]);
    // Blocks of one byte repeated, 128 KiB each out of 4 bytes.
    let mut bomb = bytes("28b52ffd0058");
    for _ in 0..4000 {
        let header = (1u32 << 1) | (0x2_0000 << 3);
        bomb.extend_from_slice(&header.to_le_bytes()[..3]);
        bomb.push(0);
    }
    refused("tri.zst", &bomb, &["unpack to over 268435456", "no mesh"]);
}
