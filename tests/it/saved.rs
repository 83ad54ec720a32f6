//! Trees as files: what is saved is what is loaded, and nothing else is.

#![allow(clippy::unwrap_used)]

use crate::cli::Folder;
use crate::gpu::quiet;
use crate::soup::{named, random, random_rays, scene};
use boxwood::abi::{Hit, INVALID, LEAF_BIT, ORIENTED_BIT, Ray};
use boxwood::bvh::frame::words;
use boxwood::bvh::{Builder, Bvh, Collapse, Fit, Method, Recipe, SceneBuffers, build, leaf_bits};
use boxwood::device::{Device, Timing};
use boxwood::oracle::validate::{Claims, validate};
use boxwood::saved::{self, Fault, Origin, VERSION, load, parse};
use boxwood::scene::Scene;
use boxwood::trace::{Batch, Boxes, Options, Walk, trace};
use bytemuck::{bytes_of, cast_slice};
use proptest::prelude::*;
use std::fs;
use std::sync::{Arc, OnceLock};

/// Where fields of the header are, bytes.
const VERSION_AT: usize = 12;
const NODES_AT: usize = 32;
const AABB_AT: usize = 40;
const TRIANGLES_AT: usize = 48;
const TEXT_AT: usize = 56;
const ROOT_AT: usize = 64;
const LEAF_BITS_AT: usize = 68;
const DEPTH_AT: usize = 72;
const EXPONENT_AT: usize = 76;
const ANCHOR_AT: usize = 80;
const REACH_AT: usize = 92;
const BOUNDS_AT: usize = 96;
const SAH_AT: usize = 120;
const LEFT_OUT_AT: usize = 128;
const ORIENTED_AT: usize = 132;
const HEADER: usize = 136;
const HEAD: usize = 16;
const NODE: usize = 64;

fn built(device: &Arc<Device>, scene: &Scene, recipe: &Recipe) -> Bvh {
    build(device, &SceneBuffers::upload(device, scene).unwrap(), recipe, Timing::Off).unwrap().bvh
}

fn bytes_of_tree(bvh: &Bvh, scene: &Scene, recipe: &Recipe) -> Vec<u8> {
    let mut bytes = vec![];
    let written = saved::write(bvh, &Origin::new(scene, *recipe), &mut bytes).unwrap();
    assert_eq!(written, bytes.len() as u64);
    bytes
}

fn hits(device: &Arc<Device>, bvh: &Bvh, rays: &[Ray], options: Options) -> Vec<Hit> {
    let mut batch = Batch::new(device, rays.len(), false).unwrap();
    batch.set(rays).unwrap();
    trace(device, bvh, &batch, options, Timing::Off).unwrap();
    batch.hits.read().unwrap()
}

/// A file with these bytes, loaded onto the device.
fn loaded(device: &Arc<Device>, bytes: &[u8]) -> saved::Loaded {
    let file = tempfile::NamedTempFile::new().unwrap();
    fs::write(file.path(), bytes).unwrap();
    load(device, file.path()).unwrap()
}

fn assert_round_trip(what: &str, device: &Arc<Device>, scene: &Scene, recipe: &Recipe) {
    let bvh = built(device, scene, recipe);
    let bytes = bytes_of_tree(&bvh, scene, recipe);
    let again = loaded(device, &bytes);
    let (tree, back) = (bvh.read().unwrap(), again.bvh.read().unwrap());
    assert!(cast_slice::<_, u8>(&tree.nodes) == cast_slice::<_, u8>(&back.nodes), "{what}: nodes differ");
    assert!(tree.triangles == back.triangles, "{what}: triangles differ");
    assert_eq!(tree.hash(), back.hash(), "{what}");
    let kept = |bvh: &Bvh| bvh.axis_aligned.as_ref().map(|nodes| nodes.read().unwrap());
    let (ours, theirs) = (kept(&bvh), kept(&again.bvh));
    let same = ours.as_deref().map(cast_slice::<_, u8>) == theirs.as_deref().map(cast_slice::<_, u8>);
    assert!(same, "{what}: nodes kept axis-aligned differ");
    let numbers = |b: &Bvh| {
        let floats = [b.anchor, [b.reach; 3], b.bounds.lo, b.bounds.hi].map(|p| p.map(f32::to_bits));
        let words = [b.root, b.leaf_bits, b.depth, b.triangle_count, b.left_out, b.oriented];
        (floats, words, b.exponent, b.sah.to_bits(), b.bytes())
    };
    assert_eq!(numbers(&bvh), numbers(&again.bvh), "{what}");
    assert_eq!((&again.origin.recipe, again.bytes), (recipe, bytes.len() as u64), "{what}");
    assert!(again.require_scene(scene).is_ok(), "{what}");

    let parsed = parse(&bytes).unwrap();
    assert_eq!(parsed.tree.hash(), tree.hash(), "{what}");
    // Saved again: the same file.
    assert!(bytes_of_tree(&again.bvh, scene, recipe) == bytes, "{what}: saved again it differs");

    let rays = random_rays(400, 7);
    for boxes in Boxes::of(&bvh) {
        for walk in Walk::all(device) {
            let options = Options { walk: *walk, boxes: *boxes, ..Options::default() };
            let (ours, theirs) =
                (hits(device, &bvh, &rays, options), hits(device, &again.bvh, &rays, options));
            assert!(cast_slice::<_, u8>(&ours) == cast_slice::<_, u8>(&theirs), "{what}: hits differ");
        }
    }
}

#[test]
fn every_builders_tree_comes_back() {
    let device = quiet();
    let city = named("city-rotated:2k");
    for method in Method::ALL {
        let recipe = Recipe { builder: method.builder, fit: method.fit, ..Recipe::default() };
        assert_round_trip(method.name, &device, &city, &recipe);
    }
    let own = Recipe { fit: Fit::Own(4), threshold: None, ..Recipe::default() };
    let hybrid = Recipe { fit: Fit::Hybrid, threshold: Some(20), local_search: 7, ..Recipe::default() };
    let leaf = |max_leaf| Recipe {
        collapse: Collapse { max_leaf, ..Recipe::default().collapse },
        ..Recipe::default()
    };
    for (what, recipe) in
        [("own", own), ("hybrid", hybrid), ("leaves of 1", leaf(1)), ("leaves of 64", leaf(64))]
    {
        assert_round_trip(what, &device, &city, &recipe);
    }
    let auto = built(&device, &city, &Recipe { fit: Fit::Auto, ..Recipe::default() });
    assert!(auto.axis_aligned.is_some(), "no tree here keeps both");
}

#[test]
fn small_and_odd_scenes_come_back() {
    let device = quiet();
    let nan = [[f32::NAN; 3]; 3];
    let far = [[1e30, 0.0, 0.0], [1.1e30, 0.0, 0.0], [1e30, 1e29, 0.0]];
    let tiny = [[1e-30, 0.0, 0.0], [2e-30, 0.0, 0.0], [1e-30, 1e-30, 0.0]];
    let one = random(1, 0.3, 1);
    let soups: [(&str, Vec<_>); 7] = [
        ("nothing", vec![]),
        ("nothing that can be hit", vec![nan, nan]),
        ("one triangle", one.clone()),
        ("one and one left out", vec![nan, one[0]]),
        ("far away", vec![far, far]),
        ("tiny", vec![tiny]),
        ("one leaf of three", random(3, 0.01, 2)),
    ];
    for (what, corners) in &soups {
        for builder in Builder::ALL {
            assert_round_trip(what, &device, &scene(corners), &Recipe { builder, ..Recipe::default() });
        }
    }
    // Longer than a piece that is read at once.
    assert_round_trip("long", &device, &scene(&random(270_000, 0.01, 3)), &Recipe::default());
}

/// A small file, some of whose nodes are oriented, with both sets of nodes; and its scene.
fn small() -> &'static (Scene, Vec<u8>) {
    static SMALL: OnceLock<(Scene, Vec<u8>)> = OnceLock::new();
    SMALL.get_or_init(|| {
        let turned = |t: usize, k: usize| {
            let (x, y) = (t as f32 * 0.3, k as f32 * 0.9 - 1.0);
            [[x + y, x - y, x], [x + y + 2.0, x - y + 2.1, x], [x + y, x - y, x + 0.1]]
        };
        let soup = scene(&(0..14).map(|t| turned(t, t % 3)).collect::<Vec<_>>());
        let leaves = Collapse { max_leaf: 3, ..Recipe::default().collapse };
        let recipe = Recipe { fit: Fit::Auto, collapse: leaves, ..Recipe::default() };
        let bvh = built(&quiet(), &soup, &recipe);
        assert!(bvh.axis_aligned.is_some() && bvh.nodes.len() > 2, "{bvh:?}");
        let bytes = bytes_of_tree(&bvh, &soup, &recipe);
        (soup, bytes)
    })
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

fn long(bytes: &[u8], at: usize) -> usize {
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize
}

fn put(bytes: &mut [u8], at: usize, new: impl bytemuck::NoUninit) {
    bytes[at..at + size_of_val(&new)].copy_from_slice(bytes_of(&new));
}

/// Where the nodes, those kept axis-aligned and the triangles begin.
fn sections(bytes: &[u8]) -> [usize; 3] {
    let nodes = HEADER + HEAD + long(bytes, TEXT_AT) + HEAD;
    let kept = nodes + NODE * long(bytes, NODES_AT) + HEAD;
    [nodes, kept, kept + NODE * long(bytes, AABB_AT) + HEAD]
}

/// The checksum becomes that of what is there now.
fn seal(bytes: &mut [u8]) {
    let (all, sum) = bytes.split_at_mut(bytes.len() - 32);
    sum.copy_from_slice(blake3::hash(all).as_bytes());
}

/// What is said of the small file after `doctor` has had its hands on it and made the checksum right.
fn forged(doctor: impl FnOnce(&mut Vec<u8>)) -> String {
    let mut bytes = small().1.clone();
    doctor(&mut bytes);
    seal(&mut bytes);
    parse(&bytes).unwrap_err().to_string()
}

fn says(wanted: &[&str], doctor: impl FnOnce(&mut Vec<u8>)) {
    let fault = forged(doctor);
    assert!(wanted.iter().all(|w| fault.contains(w)), "{fault}: no word of {wanted:?}");
}

#[test]
fn no_shorter_file_is_taken() {
    let bytes = &small().1;
    for length in 0..bytes.len() {
        let fault = parse(&bytes[..length]).unwrap_err();
        match length {
            0 => assert!(matches!(fault, Fault::Foreign { .. }), "{fault}"),
            _ => assert!(matches!(fault, Fault::Size { what: "cut short", .. }), "{length}: {fault}"),
        }
    }
    let longer = [&bytes[..], &[0]].concat();
    assert!(matches!(parse(&longer), Err(Fault::Size { what: "too long", .. })));
}

#[test]
fn no_flipped_bit_is_taken() {
    let mut bytes = small().1.clone();
    let (mut sums, mut others) = (0, 0);
    for bit in 0..8 * bytes.len() {
        bytes[bit / 8] ^= 1 << (bit % 8);
        match parse(&bytes) {
            Err(Fault::Checksum { .. }) => sums += 1,
            Err(_) => others += 1,
            Ok(_) => panic!("bit {} of byte {} is not missed", bit % 8, bit / 8),
        }
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    assert!(parse(&bytes).is_ok() && sums > others && others > 0, "{sums} by the checksum, {others} before");
}

#[test]
fn foreign_files_are_named() {
    let begins = |bytes: &[u8], wanted: &str| match parse(bytes) {
        Err(fault @ Fault::Foreign { .. }) => {
            let said = fault.to_string();
            assert!(said.contains(wanted) && said.contains("--save"), "{said}");
        }
        other => panic!("{other:?}"),
    };
    begins(b"", "it is empty");
    begins(b"ply\nformat binary_little_endian 1.0\n", r#""ply\nformat b""#);
    begins(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "89 50 4e 47");
    begins(&[0; 4096], r"\0\0");
    begins(b"boxwood", r#""boxwood""#);
    begins(b"glTF\x02\0\0\0", "glTF");
    // Copied as text.
    let text = small().1.iter().copied().filter(|b| *b != b'\r').collect::<Vec<_>>();
    begins(&text, "89 62 6f 78 77 6f 6f 64 0a");
}

#[test]
fn other_versions_are_refused() {
    says(&["written by a newer boxwood", "version 2", "reads version 1"], |b| {
        put(b, VERSION_AT, VERSION + 1)
    });
    says(&["newer"], |b| put(b, VERSION_AT, u32::MAX));
    says(&["no version 0"], |b| put(b, VERSION_AT, 0));
    says(&["byte order"], |b| put(b, 16, 0x0403_0201u32));
    says(&["bytes of the header", "0x90"], |b| put(b, 20, 144u32));
    says(&["bytes of a node", "0x30"], |b| put(b, 24, 48u32));
    says(&["words of a triangle"], |b| put(b, 28, 9u32));
}

#[test]
fn huge_counts_are_no_work() {
    // Should anything be allocated for these, no machine has as much.
    for at in [NODES_AT, AABB_AT, TRIANGLES_AT, TEXT_AT] {
        for count in [1u64 << 60, u64::MAX, 1 << 32, (1 << 58) + 1] {
            says(&["cut short", "bytes and should have"], |b| put(b, at, count));
        }
        says(&["too long"], |b| put(b, at, 0u64));
    }
    // A hundred bytes.
    let mut bytes = small().1[..HEADER].to_vec();
    put(&mut bytes, NODES_AT, 1u64 << 60);
    assert!(matches!(parse(&bytes), Err(Fault::Size { .. })));
    // Of the right length, yet other sections than by the header.
    says(&["byte 136", "section text"], |b| put(b, HEADER + 8, 1u64));
    let [nodes, kept, triangles] = sections(&small().1);
    says(&["section nodes"], |b| b[nodes - HEAD] = b'N');
    says(&["section aabb"], |b| put(b, kept - 8, 0u64));
    says(&["section corners"], |b| put(b, triangles - 8, u64::MAX));
    says(&["section blake3"], |b| {
        let at = b.len() - 32 - HEAD;
        b[at] = b'B';
    });
}

#[test]
fn forged_headers_are_refused() {
    says(&["root is 0xffffffff"], |b| put(b, ROOT_AT, INVALID));
    says(&["root is 0x80000000"], |b| put(b, ROOT_AT, LEAF_BIT));
    says(&["its child is node 77"], |b| put(b, ROOT_AT, 77u32));
    says(&["bits of a leaf's size"], |b| put(b, LEAF_BITS_AT, 31u32));
    says(&["levels, and 1 are claimed"], |b| put(b, DEPTH_AT, 1u32));
    for exponent in [i32::MIN, 127, -127, i32::MAX] {
        says(&["header, exponent"], |b| put(b, EXPONENT_AT, exponent));
    }
    for k in 0..3 {
        says(&["header, anchor", "NaN"], |b| put(b, ANCHOR_AT + 4 * k, f32::NAN));
        says(&["header, bounds"], |b| put(b, BOUNDS_AT + 4 * k, f32::INFINITY));
        says(&["header, bounds"], |b| put(b, BOUNDS_AT + 4 * k, 1e9f32));
    }
    for reach in [f32::NAN, f32::INFINITY, -1.0] {
        says(&["header, reach"], |b| put(b, REACH_AT, reach));
    }
    for sah in [f64::NAN, f64::INFINITY, -1.0] {
        says(&["header, SAH cost"], |b| put(b, SAH_AT, sah));
    }
    says(&["header, triangles", "too many"], |b| put(b, LEFT_OUT_AT, u32::MAX));
    let oriented = word(&small().1, ORIENTED_AT);
    says(&["kept axis-aligned"], |b| put(b, ORIENTED_AT, 0u32));
    says(&["have a frame"], |b| put(b, ORIENTED_AT, oriented + 1));
}

#[test]
fn forged_nodes_are_refused() {
    let [nodes, kept, _] = sections(&small().1);
    let count = long(&small().1, NODES_AT) as u32;
    let triangles = long(&small().1, TRIANGLES_AT) as u32;
    let root = word(&small().1, ROOT_AT);
    let bits = leaf_bits(3);
    let leaf = |first: u32, size: u32| LEAF_BIT | (size - 1) << (31 - bits) | first;
    for (section, what) in [(nodes, "nodes: "), (kept, "nodes kept axis-aligned: ")] {
        let at = section + NODE * root as usize;
        let child = |k: usize| at + 40 + 4 * k;
        let inner = (0..4).map(|k| word(&small().1, child(k))).find(|c| c & LEAF_BIT == 0).unwrap();
        says(&[what, "its child is node", &count.to_string()], |b| put(b, child(0), count));
        says(&[what, "its child is node"], |b| put(b, child(0), LEAF_BIT - 1));
        says(&[what, "is reached twice"], |b| put(b, child(0), root));
        says(&[what, "is reached twice"], |b| put(b, section + NODE * inner as usize + 44, root));
        says(&[what, "a leaf of triangles"], |b| put(b, child(0), leaf(triangles, 3)));
        says(&[what, "a leaf of triangles"], |b| put(b, child(0), leaf((1 << (31 - bits)) - 1, 1)));
        says(&[what, "a leaf of 4 triangles, where 3 are the most"], |b| put(b, child(0), leaf(0, 4)));
        says(&[what, "begins at triangle 1"], |b| put(b, child(0), leaf(1, 1)));
        says(&[what, "no child"], |b| put(b, child(0), INVALID));
        says(&[what, "not finite"], |b| put(b, at, f32::NAN));
        says(&[what, "exponents"], |b| put(b, at + 12, u32::MAX));
        says(&[what, "ends before"], |b| (put(b, at + 16, 0xffu32), put(b, at + 28, 0u32)).0);
    }
    let plain = |b: &[u8]| (0..count as usize).find(|i| word(b, nodes + NODE * i + 12) & ORIENTED_BIT == 0);
    let turned = |b: &[u8]| (0..count as usize).find(|i| word(b, nodes + NODE * i + 12) & ORIENTED_BIT != 0);
    let (plain, turned) = (plain(&small().1), turned(&small().1).unwrap());
    says(&["at odds"], |b| put(b, nodes + NODE * turned + 56, [0u32; 2]));
    says(&["rotation"], |b| put(b, nodes + NODE * turned + 56, words([1_048_575; 3])));
    if let Some(plain) = plain {
        says(&["at odds"], |b| put(b, nodes + NODE * plain + 56, [1u32, 0]));
    }
    says(&["kept axis-aligned", "have a frame"], |b| {
        let exponents = word(b, kept + 12) | ORIENTED_BIT;
        put(b, kept + 12, exponents);
        put(b, kept + 56, [1u32, 0]);
    });
}

#[test]
fn forged_triangles_and_texts_are_refused() {
    let [.., triangles] = sections(&small().1);
    says(&["corners", "triangle 2 is the scene's 14, which has 14"], |b| put(b, triangles + 80 + 36, 14u32));
    says(&["corners", "triangle 0", "which has 14"], |b| put(b, triangles + 36, INVALID));
    says(&["corners", "triangle 1 has a corner nowhere"], |b| put(b, triangles + 40 + 12, f32::NAN));
    says(&["corners", "in the tree twice"], |b| {
        let index = word(b, triangles + 36);
        put(b, triangles + 40 + 36, index);
    });
    let text = |b: &[u8]| String::from_utf8(b[HEADER + HEAD..][..long(b, TEXT_AT)].to_vec()).unwrap();
    let edit = |from: &str, to: &str| {
        let (from, to) = (from.to_owned(), to.to_owned());
        move |b: &mut Vec<u8>| {
            assert!(from.len() == to.len() && text(b).contains(&from), "{from}: {}", text(b));
            let new = text(b).replacen(&from, &to, 1);
            b[HEADER + HEAD..][..new.len()].copy_from_slice(new.as_bytes());
        }
    };
    says(&["text", "byte 152"], edit("{", "["));
    says(&["text", "unknown field `racipe`"], edit("recipe", "racipe"));
    says(&["text", "unknown variant `plac`"], edit("ploc", "plac"));
    says(&["text, recipe", "radius is 0"], edit("\"radius\":8", "\"radius\":0"));
    says(&["bits of a leaf's size"], edit("\"max_leaf\":3", "\"max_leaf\":1"));
    says(&["text"], |b| b[HEADER + HEAD + 2] = 0xff);
    let deep = |b: &mut Vec<u8>| {
        let length = long(b, TEXT_AT);
        b[HEADER + HEAD..][..length].fill(b'[');
    };
    says(&["text", "byte 152"], deep);
}

#[test]
fn other_scenes_are_refused() {
    let (soup, bytes) = small();
    let device = quiet();
    let tree = loaded(&device, bytes);
    assert!(tree.require_scene(soup).is_ok());
    let mut nudged = soup.clone();
    nudged.positions[5][1] = f32::from_bits(nudged.positions[5][1].to_bits() ^ 1);
    let mut fewer = soup.clone();
    fewer.triangles.pop();
    let mut swapped = soup.clone();
    swapped.triangles.swap(3, 4);
    for other in [nudged, fewer, swapped, scene(&[])] {
        let fault = tree.require_scene(&other).unwrap_err().to_string();
        assert!(fault.contains("another one") && fault.contains("14 triangles"), "{fault}");
    }
    // The same corners otherwise indexed, by another name: the same tree.
    let shared =
        Scene { name: "other".into(), ..scene(&(0..14).map(|t| soup.corners(t)).collect::<Vec<_>>()) };
    assert!(tree.require_scene(&shared).is_ok());
    // What is loaded is as sound as what was built.
    let claims = Claims::of(&tree.bvh, tree.origin.recipe.collapse);
    validate(soup, &tree.bvh.read().unwrap(), &claims).unwrap();
}

/// Bytes that a mutation may set anywhere: what is likely to pass, and what is likely to break.
fn odd_word() -> impl Strategy<Value = u32> {
    prop_oneof![
        any::<u32>(),
        0..20u32,
        (0..20u32).prop_map(|i| LEAF_BIT | i),
        (0..20u32, 0..4u32).prop_map(|(first, size)| LEAF_BIT | size << 29 | first),
        Just(INVALID),
        any::<f32>().prop_map(f32::to_bits),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(1500) })]
    #[test]
    fn whatever_is_taken_can_be_traced(
        words in prop::collection::vec((0..10_000usize, odd_word()), 1..4),
        flips in prop::collection::vec((0..10_000usize, 0..8u32), 0..3),
    ) {
        let mut bytes = small().1.clone();
        let length = bytes.len();
        for (at, word) in words {
            // Words lie at multiples of four from the header, and behind the text from its end.
            let from = if at % 3 == 0 { 32 } else { sections(&small().1)[0] };
            let at = from + at * 4 % (length - 36 - from) / 4 * 4;
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        for (at, bit) in flips {
            bytes[at % length] ^= 1 << bit;
        }
        seal(&mut bytes);
        if let Ok(parsed) = parse(&bytes) {
            let device = quiet();
            let tree = loaded(&device, &bytes);
            let rays = random_rays(64, 5);
            for boxes in Boxes::of(&tree.bvh) {
                let options = Options { boxes: *boxes, ..Options::default() };
                for hit in hits(&device, &tree.bvh, &rays, options) {
                    let there = u64::from(hit.triangle) < parsed.header.scene_triangles();
                    prop_assert!(there || hit.triangle == INVALID, "{hit:?}");
                }
            }
        }
    }

    #[test]
    fn no_bytes_are_too_much(bytes in prop::collection::vec(any::<u8>(), 0..600), keep in 0..200usize) {
        let begin = &small().1[..keep];
        prop_assert!(parse(&[begin, &bytes].concat()).is_err());
    }
}

fn json(out: &std::process::Output) -> serde_json::Value {
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).unwrap()
}

#[test]
fn programs_save_and_query() {
    let folder = Folder::new();
    let build =
        ["build", "two.tri", "--runs", "1", "--builder", "lbvh", "--max-leaf", "1", "--save", "t.boxwood"];
    let report = json(&folder.run(&build));
    let file = fs::read(folder.path("t.boxwood")).unwrap();
    assert_eq!(report["saved"]["bytes"], file.len());
    assert!(report["saved"]["ms"].as_f64().is_some_and(|ms| ms > 0.0), "{report}");

    let query = |args: &[&'static str]| [&["query", "--rays", "a.rays", "--runs", "1"][..], args].concat();
    let fresh =
        json(&folder.run(&query(&["two.tri", "--out", "b.hits", "--builder", "lbvh", "--max-leaf", "1"])));
    let out = folder.run(&query(&["--tree", "t.boxwood", "--out", "a.hits", "--explain"]));
    let stderr = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(stderr.contains("nothing built, no scene read") && stderr.contains("loaded in"), "{stderr}");
    let loaded = json(&out);
    assert_eq!(fs::read(folder.path("a.hits")).unwrap(), fs::read(folder.path("b.hits")).unwrap());
    for key in ["tree_hash", "scene", "triangles", "left_out", "builder", "max_leaf", "nodes", "sah", "hits"]
    {
        assert_eq!(loaded[key], fresh[key], "{key}");
    }
    assert_eq!((&loaded["loaded"], &loaded["loaded_bytes"]), (&"t.boxwood".into(), &file.len().into()));
    assert!(loaded["loaded_ms"].as_f64().is_some_and(|ms| ms > 0.0), "{loaded}");
    assert!(loaded["built_by"].as_str().is_some_and(|by| by.contains(env!("CARGO_PKG_VERSION"))), "{loaded}");
    for key in ["build_ms", "build_wall_ms", "scratch_bytes"] {
        assert!(loaded[key].is_null() && !fresh[key].is_null(), "{key}: {loaded}");
    }
    let checked =
        json(&folder.run(&query(&["two.tri", "--tree", "t.boxwood", "--out", "a.hits", "--check"])));
    assert_eq!(
        (&checked["check"]["tree"]["leaves"], &checked["check"]["hits"]["rays"]),
        (&2.into(), &3.into())
    );
}

#[test]
fn programs_refuse_and_leave_nothing() {
    let folder = Folder::new();
    json(&folder.run(&["build", "two.tri", "--runs", "1", "--save", "t.boxwood"]));
    let file = fs::read(folder.path("t.boxwood")).unwrap();
    fs::write(folder.path("short.boxwood"), &file[..file.len() - 1]).unwrap();
    let mut flipped = file.clone();
    flipped[file.len() / 2] ^= 4;
    fs::write(folder.path("flipped.boxwood"), flipped).unwrap();
    let mut newer = file.clone();
    newer[VERSION_AT] += 1;
    fs::write(folder.path("newer.boxwood"), newer).unwrap();
    folder.write("one.tri", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);

    let query =
        |args: &[&'static str]| [&["query", "--rays", "a.rays", "--out", "a.hits"][..], args].concat();
    for (tree, words) in [
        ("short.boxwood", "short.boxwood: cut short"),
        ("flipped.boxwood", "flipped.boxwood: damaged"),
        ("newer.boxwood", "written by a newer boxwood"),
        ("two.tri", "no tree saved by boxwood"),
        ("none.boxwood", "can't load the tree none.boxwood: No such file"),
        (".", "it is a directory"),
        ("/dev/null", "no regular file"),
    ] {
        folder.fails(&query(&["--tree", tree]), 1, words);
    }
    folder.fails(&query(&["--tree", "t.boxwood", "--check"]), 1, "--check compares with the scene");
    folder.fails(&query(&["one.tri", "--tree", "t.boxwood"]), 1, "its scene is another one");
    folder.fails(&query(&["two.tri", "--scale", "2", "--tree", "t.boxwood"]), 1, "its scene is another one");
    // What makes no sense together.
    folder.fails(&query(&["--tree", "t.boxwood", "--builder", "ploc"]), 2, "cannot be used with");
    folder.fails(&query(&["--tree", "t.boxwood", "--node-cost", "4"]), 2, "cannot be used with");
    folder.fails(&query(&["--tree", "t.boxwood", "--sample", "4"]), 2, "cannot be used with");
    folder.fails(&query(&["--tree", "t.boxwood", "--scale", "2"]), 2, "required");
    folder.fails(&query(&[]), 2, "required");
    // Disks and permissions.
    let save = |to: &'static str| ["build", "two.tri", "--runs", "1", "--save", to];
    folder.fails(&save("none/t.boxwood"), 1, "can't write none/t.boxwood");
    folder.fails(&save("/dev/full"), 1, "can't write /dev/full: No space left");
    folder.fails(&save("."), 1, "it is a directory");
    assert_eq!(fs::read(folder.path("t.boxwood")).unwrap(), file);
}
