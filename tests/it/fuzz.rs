//! What the fuzzers know, without them: the whole corpus, and every input that ever failed, replayed; and changes of each
//! by seeded dice: flipped bits, numbers at the edges, cuts, splices.

#![allow(clippy::unwrap_used)]

use rayon::prelude::*;
use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

#[allow(clippy::expect_used, clippy::unnecessary_operation)]
#[path = "../../fuzz/src/targets.rs"]
mod targets;

use targets::{LARGEST, TARGETS, Target};

/// Changed files of each target.
const CHANGES: usize = 500;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz")
}

/// What is in the files of a folder, by name; none where there is no folder.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let Ok(entries) = fs::read_dir(folder) else { return vec![] };
    let paths = entries.map(|e| e.unwrap().path());
    let named = |p: PathBuf| (p.strip_prefix(root()).unwrap().display().to_string(), fs::read(p).unwrap());
    let mut files: Vec<_> = paths.map(named).collect();
    files.sort();
    files
}

/// Seeds and finds, then what failed once.
fn inputs(target: &str) -> Vec<(String, Vec<u8>)> {
    ["corpus", "regressions"].iter().flat_map(|kind| files(&root().join(kind).join(target))).collect()
}

/// Hands `bytes` to a target. If it fails, they are kept.
fn survives(&(name, target): &Target, bytes: &[u8], origin: &str) {
    if catch_unwind(|| target(bytes)).is_err() {
        let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-failed"));
        fs::write(&kept, bytes).unwrap();
        panic!("{name} fails at {origin}; mend it, and keep {} in fuzz/regressions/{name}", kept.display());
    }
}

#[test]
fn the_corpus_is_replayed() {
    TARGETS.par_iter().for_each(|target| {
        for (path, bytes) in inputs(target.0) {
            survives(target, &bytes, &path);
        }
    });
}

#[test]
fn changes_of_the_corpus_are_survived() {
    TARGETS.par_iter().for_each(|target| {
        let inputs = inputs(target.0);
        let mut dice = Dice(0xB0C5);
        for i in 0..CHANGES {
            let (path, file) = &inputs[i % inputs.len()];
            let (_, other) = &inputs[dice.below(inputs.len())];
            survives(target, &dice.changed(file, other), &format!("change {i}, of {path}"));
        }
    });
}

#[test]
fn targets_and_folders_are_the_same() {
    let sources = fs::read_dir(root().join("fuzz_targets")).unwrap().map(|e| e.unwrap().path());
    let mut names: Vec<_> = sources.map(|p| p.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    names.sort();
    let mut known = TARGETS.map(|t| t.0);
    known.sort();
    assert_eq!(names, known);
    let mut all = 0;
    for name in known {
        assert!(!files(&root().join("corpus").join(name)).is_empty(), "{name} has no corpus");
        for (path, bytes) in inputs(name) {
            assert!(bytes.len() <= LARGEST, "{path}: {} bytes", bytes.len());
            all += bytes.len();
        }
    }
    assert!(all <= 600 << 10, "{all} bytes");
}

/// Numbers as texts have them.
const NUMBERS: [&str; 10] = [
    "0",
    "-1",
    "2147483648",
    "4294967295",
    "18446744073709551615",
    "9223372036854775808",
    "1e39",
    "nan",
    "1e-46",
    "-0",
];

/// SplitMix64.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn below(&mut self, n: usize) -> usize {
        (self.roll() % n.max(1) as u64) as usize
    }

    /// `file`, changed at up to four places, with parts of `other`.
    fn changed(&mut self, file: &[u8], other: &[u8]) -> Vec<u8> {
        let mut bytes = file.to_vec();
        for _ in 0..=self.below(4) {
            self.change(&mut bytes, other);
        }
        bytes.truncate(LARGEST);
        bytes
    }

    fn change(&mut self, bytes: &mut Vec<u8>, other: &[u8]) {
        let at = self.below(bytes.len());
        let end = at + self.below((bytes.len() - at).min(64) + 1);
        match self.below(8) {
            _ if bytes.is_empty() => bytes.extend_from_slice(other),
            0 => bytes[at] ^= 1 << self.below(8),
            1 => bytes[at] = self.roll() as u8,
            2 => {
                // A count or a length, of any width and byte order.
                let number =
                    [0, 1, 1 << 31, (1 << 31) - 1, u64::MAX, u64::MAX >> 1, u64::MAX - 7][self.below(7)];
                let width = 1 << self.below(4);
                let number = if self.below(2) == 0 { number.to_le_bytes() } else { number.to_be_bytes() };
                bytes[at..].iter_mut().zip(&number[..width]).for_each(|(b, n)| *b = *n);
            }
            3 => {
                let digits = |b: &&u8| b.is_ascii_digit();
                let start = at + bytes[at..].iter().take_while(|b| !b.is_ascii_digit()).count();
                let end = start + bytes[start..].iter().take_while(digits).count();
                bytes.splice(start..end, NUMBERS[self.below(NUMBERS.len())].bytes());
            }
            4 => bytes.truncate(at),
            5 => drop(bytes.drain(at..end)),
            6 => {
                let part = bytes[at..end].repeat(1 + self.below(8));
                bytes.splice(at..end, part);
            }
            _ => {
                let from = self.below(other.len());
                let part = &other[from..];
                bytes.splice(at..end, part.iter().copied());
            }
        }
    }
}
