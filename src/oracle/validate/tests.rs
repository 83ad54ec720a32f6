#![allow(clippy::unwrap_used)]

use super::*;
use crate::abi::{LEAF_BIT, Node};

/// Bits of a leaf reference for its count less one.
const LEAF_BITS: u32 = 1;

fn leaf(first: u32, count: u32) -> u32 {
    LEAF_BIT | (count - 1) << (31 - LEAF_BITS) | first
}

fn boxed(lo: f32, hi: f32) -> Aabb {
    Aabb { lo: [lo, 0.0, 0.0], hi: [hi, 1.0, 0.0] }
}

/// A node whose children lie between `from` and `to` of x, on a grid of 32nds.
fn node(children: &[(u32, u32, u32)]) -> Node {
    let mut node = Node {
        origin: [0.0; 3],
        exponents: 0x7a_7a_7a,
        lo: [u32::MAX; 3],
        hi: [0; 3],
        children: [INVALID; 4],
        frame: [0; 2],
    };
    for (k, (from, to, child)) in children.iter().enumerate() {
        let byte = 0xff << (8 * k);
        node.lo = [(node.lo[0] & !byte) | ((32 * from) << (8 * k)), node.lo[1] & !byte, node.lo[2] & !byte];
        node.hi = [node.hi[0] | ((32 * to) << (8 * k)), node.hi[1] | (32 << (8 * k)), node.hi[2]];
        node.children[k] = *child;
    }
    node
}

/// Four triangles side by side along x, one that can't be hit between them: root → (node 0 → (leaf 0, leaf 1), leaf of
/// 2). Unit space is scene space.
fn sound() -> (Scene, HostTree, Claims) {
    let triangle = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
    let corners =
        [triangle(0.0), triangle(1.0), [[0.0; 3], [f32::NAN; 3], [1.0; 3]], triangle(2.0), triangle(3.0)];
    let triangles = (0..5).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let scene = Scene { positions: corners.as_flattened().to_vec(), triangles, ..Scene::default() };
    let mut words = vec![];
    for t in [0, 1, 3, 4] {
        words.extend(scene.corners(t).as_flattened().iter().map(|x| x.to_bits()));
        words.push(t as u32);
    }
    let nodes = vec![node(&[(0, 1, leaf(0, 1)), (1, 2, leaf(1, 1))]), node(&[(0, 2, 0), (2, 4, leaf(2, 2))])];
    let tree = HostTree { nodes, triangles: words, root: 1, leaf_bits: LEAF_BITS };
    let collapse = Collapse { traversal_cost: 3.0, node_cost: 4.0, triangle_cost: 2.0, max_leaf: 2 };
    let claims = Claims {
        exponent: 0,
        anchor: [0.0; 3],
        reach: 4.0,
        bounds: boxed(0.0, 4.0),
        depth: 2,
        // Half areas 4 (root), 2 (node 0), 1, 1 and 2 (leaves).
        sah: (3.0 * (4.0 + 2.0) + 2.0 * (1.0 + 1.0 + 2.0 * 2.0)) / 4.0,
        left_out: 1,
        collapse,
    };
    (scene, tree, claims)
}

/// What is wrong after `doctor` has had its hands on a sound tree.
fn after(doctor: impl FnOnce(&mut Scene, &mut HostTree, &mut Claims)) -> Result<Stats, Invalid> {
    let (mut scene, mut tree, mut claims) = sound();
    doctor(&mut scene, &mut tree, &mut claims);
    validate(&scene, &tree, &claims)
}

#[test]
fn a_sound_tree_is_described() {
    let s = after(|_, _, _| {}).unwrap();
    assert_eq!((s.nodes, s.leaves, s.triangles, s.left_out, s.depth), (2, 3, 4, 1, 2));
    assert_eq!((s.node_area, s.inner_area, s.leaf_area), (1.5, 1.5, 1.0));
    assert_eq!(s.triangles_per_leaf, 4.0 / 3.0);
    assert_eq!(s.area_by_level, [1.0, 1.0, 0.5]);
    assert_eq!((s.sah, s.bytes), (7.5, 2 * 64 + 4 * 40));
}

#[test]
fn nothing_and_one_leaf() {
    let (mut scene, _, claims) = sound();
    let none = HostTree { nodes: vec![], triangles: vec![], root: INVALID, leaf_bits: LEAF_BITS };
    assert!(matches!(validate(&scene, &none, &claims), Err(Invalid::Root { hittable: 4, .. })));
    scene.triangles.drain(..2);
    scene.triangles.drain(1..);
    assert_eq!(validate(&scene, &none, &Claims { sah: 0.0, depth: 1, ..claims }).unwrap().left_out, 1);

    let s = after(|scene, tree, claims| {
        scene.triangles.truncate(2);
        tree.nodes = vec![node(&[(0, 2, leaf(0, 2))])];
        tree.triangles.truncate(20);
        tree.root = 0;
        *claims = Claims { bounds: boxed(0.0, 2.0), sah: 4.0, left_out: 0, depth: 1, ..*claims };
    })
    .unwrap();
    assert_eq!((s.nodes, s.leaves, s.triangles, s.depth, s.leaf_area), (1, 1, 2, 1, 1.0));
    assert_eq!(s.area_by_level, [1.0]);
}

#[test]
fn structure_comes_first() {
    use Invalid as I;
    let child = after(|_, t, _| t.nodes[1].children[0] = 7);
    assert_eq!(child, Err(I::Structure(Fault::NoSuchNode { parent: 1, child: 7, nodes: 2 })));
    let size = Fault::LeafSize { node: 1, count: 2, max_leaf: 1 };
    assert_eq!(after(|_, _, c| c.collapse.max_leaf = 1), Err(I::Structure(size)));
    let depth = Fault::Depth { depth: 2, claimed: 1 };
    assert_eq!(after(|_, _, c| c.depth = 1), Err(I::Structure(depth)));
}

#[test]
fn triangles() {
    use Invalid as I;
    assert_eq!(after(|_, t, _| t.triangles.copy_within(..10, 10)), Err(I::TriangleTwice(0)));
    let missing = after(|_, t, _| {
        t.nodes[1].children[1] = leaf(2, 1);
        t.triangles.truncate(30);
    });
    assert_eq!(missing, Err(I::TriangleMissing { missing: 1, first: 4 }));
    let wrong = |t: u32, why| Err(I::TriangleWrong { node: 0, triangle: t, why });
    assert_eq!(after(|_, t, _| t.triangles[9] = 2), wrong(2, "can't be hit"));
    assert_eq!(after(|_, t, _| t.triangles[9] = 5), wrong(5, "is not in the scene"));
    assert_eq!(
        after(|_, t, _| t.triangles[0] = 2f32.to_bits()),
        wrong(0, "has other corners than in the scene")
    );
    assert_eq!(
        after(|_, t, _| t.triangles[0] = f32::NAN.to_bits()),
        wrong(0, "has other corners than in the scene")
    );
    assert!(matches!(after(|_, _, c| c.left_out = 0), Err(I::LeftOut { left_out: 1, claimed: 0 })));
}

#[test]
fn boxes() {
    use Invalid as I;
    let rounding = 4.0 * f64::from(f32::EPSILON);
    let inside = after(|_, t, _| t.nodes[0].origin[0] = 4.0 * f32::EPSILON);
    assert!(inside.is_ok(), "rounding is no fault: {inside:?}");
    let out = |node, slot, gap| Err(I::SticksOut { node, slot, gap, allowed: rounding });
    let cut = after(|_, t, _| t.nodes[0].hi[1] -= 8);
    assert_eq!(cut, out(0, 0, 0.25));
    let cut = after(|_, t, _| t.nodes[0].lo[0] += 8 << 8);
    assert_eq!(cut, out(0, 1, 0.25));
    // What sticks out of a node's box is seen though its own children's boxes contain it.
    let cut = after(|_, t, _| t.nodes[1].hi[0] -= 16);
    assert_eq!(cut, out(1, 0, 0.5));
}

#[test]
fn cost() {
    let wrong = |claimed| Err(Invalid::Cost { least: 7.5, most: 7.5, claimed });
    assert_eq!(after(|_, _, c| c.sah = 7.6), wrong(7.6));
    assert_eq!(after(|_, _, c| c.sah = 7.4), wrong(7.4));
    assert!(matches!(after(|_, _, c| c.sah = f64::NAN), Err(Invalid::Cost { .. })));
    assert!(after(|_, _, c| c.sah = 7.500_5).is_ok());
    // Three binary nodes in one, of which two may be of any size up to its own.
    let wide = |sah| {
        after(|_, t, c| {
            t.nodes = vec![node(&[(0, 1, leaf(0, 1)), (1, 2, leaf(1, 1)), (2, 4, leaf(2, 2))])];
            (t.root, c.depth, c.sah) = (0, 1, sah);
        })
    };
    assert_eq!((wide(6.0).unwrap().inner_area, wide(7.5).unwrap().inner_area), (1.0, 1.5));
    assert_eq!(wide(9.5), Err(Invalid::Cost { least: 6.0, most: 9.0, claimed: 9.5 }));
}
