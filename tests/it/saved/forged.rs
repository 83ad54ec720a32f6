//! Files that are not as they were written: cut, flipped, foreign, forged with the right checksum.

use super::{hits, loaded, small};
use crate::gpu::quiet;
use crate::soup::random_rays;
use boxwood::abi::{INVALID, LEAF_BIT, ORIENTED_BIT};
use boxwood::bvh::frame::words;
use boxwood::bvh::leaf_bits;
use boxwood::saved::{Fault, VERSION, parse};
use boxwood::trace::{Boxes, Options};
use bytemuck::bytes_of;
use proptest::prelude::*;

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

#[test]
fn words_of_a_file_are_told_in_a_line() {
    // JSON takes that character, and a terminal obeys it.
    let fault = forged(|bytes| {
        let at = bytes.windows(8).position(|w| w == b"\"commit\"").unwrap();
        bytes[at + 1..at + 7].copy_from_slice(b"c\x7fmmit");
    });
    assert!(!fault.contains(char::is_control), "{fault:?}");
    assert!(fault.contains("text, at byte"), "{fault}");
}
