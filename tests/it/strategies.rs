//! Pinned trees. `.ci/test` runs this on subgroups of 4, 8 and 16 lanes: each must give these very bytes.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::matrix::build;
use crate::soup::{grid, named, random, scene};
use boxwood::bvh::{Morton, Recipe};
use sha2::{Digest, Sha256};

/// Name, digest of the corners, digest of the tree: the first 16 digits each.
const PINNED: &[(&str, &str, &str)] = &[
    ("random", "52427f89e88e88a4", "a9e900d7b60be2d6"),
    ("grid", "7bb5d1ef3e955e1b", "2d3e9fd502f7c779"),
    ("city:5000", "fbb5dc19937bf0ad", "59616c03863d7b88"),
];

#[test]
fn trees_are_those_pinned() {
    let device = quiet();
    let soups = [
        ("random", scene(&random(5000, 0.1, 1))),
        ("grid", scene(&grid(5000))),
        ("city:5000", named("city:5000")),
    ];
    let mut seen = vec![];
    for (name, soup) in &soups {
        let mut corners = Sha256::new();
        for i in 0..soup.triangles.len() {
            corners.update(bytemuck::bytes_of(&soup.corners(i)));
        }
        let corners: String = corners.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect();
        let tree = build(&device, soup, &Recipe { morton: Morton::Bits63, ..Recipe::default() }).0.bvh;
        let tree = tree.read().unwrap().hash();
        seen.push((*name, corners, tree[..16].to_owned()));
    }
    let pinned: Vec<_> = PINNED.iter().map(|p| (p.0, p.1.to_owned(), p.2.to_owned())).collect();
    assert_eq!(seen, pinned, "a change of the corners is the scene's, one of the tree alone the build's");
}
