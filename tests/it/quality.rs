//! Quality metrics against their definitions, tried node by node and triangle by triangle.

#![allow(clippy::unwrap_used)]

use crate::matrix::max_leaf;
use crate::soup::{Corners, grid, moved, named, random, scene, sphere};
use boxwood::abi::{Aabb, INVALID, TRIANGLE_WORDS};
use boxwood::bvh::{Child, Collapse, HostTree, Recipe};
use boxwood::oracle;
use boxwood::oracle::quality::{Budget, Overlap, Quality, Survey, lines, measure};
use boxwood::oracle::validate::{Claims, validate};
use boxwood::scene::Scene;

type Point = [f64; 3];
type Bounds = [Point; 2];

/// The twin's tree and what a build would say of it.
fn tree(scene: &Scene, recipe: &Recipe) -> (HostTree, Claims) {
    let built = oracle::build(scene, recipe);
    let (bounds, depth, sah) = match &built.raw {
        Some((raw, kept)) => (raw.root.bounds, raw.root.levels.max(1), kept.sah),
        None => (Aabb { lo: [0.0; 3], hi: [0.0; 3] }, 1, 0.0),
    };
    let space = built.space;
    let claims = Claims {
        exponent: space.exponent,
        anchor: space.anchor,
        reach: space.reach,
        bounds,
        depth,
        sah,
        left_out: (scene.triangles.len() - built.order.len()) as u32,
        collapse: recipe.collapse,
    };
    (built.tree, claims)
}

fn half_area(b: &Bounds) -> f64 {
    let e: Point = std::array::from_fn(|k| b[1][k] - b[0][k]);
    e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
}

// ---- definitions -----------------------------------------------------------------------------

/// A node or leaf, with all above it below the root: which triangles are below, and its box.
struct Place {
    child: Child,
    path: Vec<(Vec<u32>, Bounds)>,
}

impl Place {
    /// What its box and those above it that don't hold triangle `t` have in common; none where it holds `t` itself.
    fn region(&self, t: u32) -> Option<Bounds> {
        let foreign = self.path.iter().filter(|(below, _)| !below.contains(&t)).map(|(_, b)| *b);
        let common = |a: Bounds, b: Bounds| {
            let greatest = std::array::from_fn(|k| a[0][k].max(b[0][k]));
            [greatest, std::array::from_fn(|k| a[1][k].min(b[1][k]))]
        };
        // A node that holds it has only such above it.
        foreign.reduce(common)
    }
}

fn below(tree: &HostTree, child: Child) -> Vec<u32> {
    match child {
        Child::Leaf { first, count } => (first..first + count).collect(),
        Child::Node(i) => {
            tree.children(&tree.nodes[i as usize]).iter().flat_map(|(c, _)| below(tree, *c)).collect()
        }
    }
}

/// Every node and leaf but the root.
fn places(tree: &HostTree) -> Vec<Place> {
    fn walk(tree: &HostTree, node: u32, path: &[(Vec<u32>, Bounds)], found: &mut Vec<Place>) {
        for (child, bounds) in tree.children(&tree.nodes[node as usize]) {
            let path = [path, &[(below(tree, child), bounds.corners)]].concat();
            if let Child::Node(node) = child {
                walk(tree, node, &path, found);
            }
            found.push(Place { child, path });
        }
    }
    let mut found = vec![];
    if !tree.nodes.is_empty() {
        walk(tree, tree.root, &[], &mut found);
    }
    found
}

fn corners(tree: &HostTree, claims: &Claims, place: u32) -> [Point; 3] {
    let word = |i: usize| f32::from_bits(tree.triangles[(place * TRIANGLE_WORDS) as usize + i]);
    std::array::from_fn(|c| std::array::from_fn(|k| f64::from(word(3 * c + k) - claims.anchor[k])))
}

fn area(t: &[Point; 3]) -> f64 {
    let [p, q]: [Point; 2] = [1, 2].map(|i| std::array::from_fn(|k| t[i][k] - t[0][k]));
    let n: Point = std::array::from_fn(|k| p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3]);
    n.iter().map(|x| x * x).sum::<f64>().sqrt() / 2.0
}

/// The part of triangle `t` on one side of a plane, as triangles.
fn side(t: [Point; 3], k: usize, plane: f64, sign: f64) -> Vec<[Point; 3]> {
    let inside = |p: &Point| sign * (p[k] - plane) >= 0.0;
    let cut = |p: Point, q: Point| {
        let s = (p[k] - plane) / (p[k] - q[k]);
        std::array::from_fn(|i| if i == k { plane } else { p[i] * (1.0 - s) + q[i] * s })
    };
    let count = t.iter().filter(|p| inside(p)).count();
    // Turned so that the odd one comes first.
    let odd = (0..3).find(|i| inside(&t[*i]) == (count == 1)).unwrap_or(0);
    let [a, b, c] = std::array::from_fn(|i| t[(odd + i) % 3]);
    match count {
        0 => vec![],
        1 => vec![[a, cut(a, b), cut(a, c)]],
        2 => vec![[b, c, cut(b, a)], [c, cut(c, a), cut(b, a)]],
        _ => vec![t],
    }
}

fn area_inside(t: [Point; 3], bounds: &Bounds) -> f64 {
    if (0..3).any(|k| bounds[0][k] > bounds[1][k]) {
        return 0.0;
    }
    let mut parts = vec![t];
    for (bound, sign) in bounds.iter().zip([1.0, -1.0]) {
        for (k, plane) in bound.iter().enumerate() {
            parts = parts.into_iter().flat_map(|t| side(t, k, *plane, sign)).collect();
        }
    }
    parts.iter().map(area).sum()
}

/// Σ_n C_n · A((S \ Q(n)) ∩ n) / A(S), inner nodes and leaves.
fn overlap(tree: &HostTree, claims: &Claims) -> [f64; 2] {
    let count = tree.triangles.len() as u32 / TRIANGLE_WORDS;
    let all: Vec<[Point; 3]> = (0..count).map(|t| corners(tree, claims, t)).collect();
    let surface: f64 = all.iter().map(area).sum();
    let Collapse { traversal_cost, triangle_cost, .. } = claims.collapse;
    let mut sums = [0.0; 2];
    for n in places(tree) {
        let (term, cost) = match n.child {
            Child::Node(i) => {
                (0, f64::from(traversal_cost) / 2.0 * tree.children(&tree.nodes[i as usize]).len() as f64)
            }
            Child::Leaf { count, .. } => (1, f64::from(triangle_cost) * f64::from(count)),
        };
        for (t, corners) in (0..count).zip(&all) {
            if let Some(region) = n.region(t) {
                sums[term] += cost * area_inside(*corners, &region);
            }
        }
    }
    sums.map(|s| if surface > 0.0 { s / surface } else { 0.0 })
}

fn exact(tree: &HostTree, claims: &Claims) -> Overlap {
    Survey::new(tree, claims).overlap(&Budget::unlimited()).unwrap()
}

fn assert_near(what: &str, got: f64, wanted: f64, share: f64) {
    assert!((got - wanted).abs() <= share * wanted.abs(), "{what}: {got:e}, not {wanted:e}");
}

/// Soups that boxes of one another overlap, in planes, on lines, alike, or hardly at all.
fn soups() -> Vec<(String, Vec<Corners>)> {
    let mut soups = vec![("grid".into(), grid(300))];
    for (i, n) in [1, 2, 3, 5, 17, 64, 300].into_iter().enumerate() {
        for size in [0.02, 0.3, 1.0] {
            soups.push((format!("random {n}, {size}"), random(n, size, 10 + i as u64)));
        }
    }
    let some = random(120, 0.3, 3);
    soups.push(("flat".into(), moved(&some, |p| [p[0], 0.0, p[2]])));
    soups.push(("on steps".into(), moved(&some, |p| p.map(|x| (4.0 * x).round()))));
    soups.push(("a line".into(), moved(&some, |p| [p[0], 0.0, 0.0])));
    soups.push(("far off".into(), moved(&some, |p| p.map(|x| 1e4 + x))));
    soups.push(("tiny".into(), moved(&some, |p| p.map(|x| 1e-30 * x))));
    soups.push(("thin".into(), moved(&some, |p| [p[0], 1e-6 * p[1], p[2]])));
    soups.push(("alike".into(), [vec![some[0]; 60], some[..20].to_vec()].concat()));
    soups.push(("none can be hit".into(), vec![[[1.0; 3]; 3]; 9]));
    soups.push(("none".into(), vec![]));
    soups
}

// ---- end-point overlap -----------------------------------------------------------------------

#[test]
fn overlap_is_its_definition() {
    for (what, soup) in soups() {
        for leaf in [1, 4] {
            let (tree, claims) = tree(&scene(&soup), &max_leaf(leaf));
            let (got, [inner, leaf]) = (exact(&tree, &claims), overlap(&tree, &claims));
            assert_near(&format!("{what}: inner"), got.inner, inner, 1e-12);
            assert_near(&format!("{what}: leaf"), got.leaf, leaf, 1e-12);
        }
    }
}

#[test]
fn known_overlaps() {
    let big = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let small = [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]];
    let aside = moved(&[big], |p| [p[0], p[1], p[2] + 1.0])[0];
    let of = |corners: &[Corners]| {
        let (tree, claims) = tree(&scene(corners), &max_leaf(1));
        measure(&tree, &claims)
    };
    let apart = of(&[big, aside]);
    assert_eq!((apart.epo, apart.epo_sampled), (0.0, 0));
    let alike = of(&[big, big]);
    assert_eq!((alike.epo_inner, alike.epo_leaf), (0.0, 2.0), "all in the other's leaf, at c_I = 2");
    // Of the big one's 8 the small one's box holds 1; of the small one's ½ the big one's box holds all.
    let one_in_other = of(&[big, small]);
    assert_near("one in the other", one_in_other.epo, 2.0 * 1.5 / 8.5, 1e-15);
    // Two boxes tested at the root, area 16; leaves of areas 16 and 1.
    assert_near("SAH cost", one_in_other.wide_sah, 3.0 + 2.0 * (16.0 + 1.0) / 16.0, 1e-15);
}

#[test]
fn all_alike_overlap_all() {
    let soup = scene(&vec![random(1, 1.0, 1)[0]; 100]);
    let (tree, claims) = tree(&soup, &max_leaf(1));
    let inner = places(&tree).into_iter().filter_map(|n| match n.child {
        Child::Node(i) => {
            let foreign = 100 - n.path.last().unwrap().0.len();
            Some(1.5 * tree.children(&tree.nodes[i as usize]).len() as f64 * foreign as f64 / 100.0)
        }
        Child::Leaf { .. } => None,
    });
    let got = exact(&tree, &claims);
    assert_near("inner", got.inner, inner.sum(), 1e-13);
    assert_near("leaf", got.leaf, 2.0 * 99.0, 1e-13);
}

#[test]
fn estimates_agree_with_the_exact() {
    for (what, soup) in [
        ("random", scene(&random(20_000, 0.05, 7))),
        ("large ones among small", scene(&[random(30, 2.0, 1), random(3000, 0.02, 2)].concat())),
        ("sphere", sphere(70, [0.0; 3], 1.0)),
        ("city", named("city:20k")),
    ] {
        let (tree, claims) = tree(&soup, &Recipe::default());
        let survey = Survey::new(&tree, &claims);
        let exact = survey.overlap(&Budget::unlimited()).unwrap();
        let truth = exact.inner + exact.leaf;
        let mut errors = vec![];
        for points in [512, 1 << 15] {
            let got = survey.estimate(points, &Budget::unlimited()).unwrap();
            let off = got.inner + got.leaf - truth;
            assert!(off.abs() <= 5.0 * got.error, "{what}: off by {off}, error {}", got.error);
            assert_eq!(got.points, points);
            errors.push(got.error);
        }
        // Eight times smaller with 64 times the points, or better where strata get finer.
        assert!(errors[1] > 0.0 && errors[1] < errors[0] / 4.0, "{what}: {errors:?}");
        assert!(errors[1] < 0.02 * truth, "{what}: {errors:?} of {truth}");
        assert!(
            survey.estimate(512, &Budget::new(1000)).is_none()
                && survey.overlap(&Budget::new(1000)).is_none()
        );
    }
}

// ---- leaf-count variability ------------------------------------------------------------------

/// Whether a line meets a box, by separating axes.
fn meets(o: &Point, d: &Point, b: &Bounds) -> bool {
    let m: Point = std::array::from_fn(|k| o[k] - (b[0][k] + b[1][k]) / 2.0);
    let h: Point = std::array::from_fn(|k| (b[1][k] - b[0][k]) / 2.0);
    (0..3).all(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        (m[j] * d[k] - m[k] * d[j]).abs() <= h[j] * d[k].abs() + h[k] * d[j].abs()
    })
}

#[test]
fn leaves_are_counted_right() {
    for (what, soup) in soups() {
        let (tree, claims) = tree(&scene(&soup), &max_leaf(4));
        let survey = Survey::new(&tree, &claims);
        let lines = lines(&claims.bounds, 300);
        let leaves: Vec<Place> =
            places(&tree).into_iter().filter(|n| matches!(n.child, Child::Leaf { .. })).collect();
        let got = survey.leaves_met(&lines, &Budget::unlimited()).unwrap();
        for (line, got) in lines.iter().zip(&got) {
            let met = |n: &&Place| n.path.iter().all(|(_, b)| meets(&line.origin, &line.direction, b));
            assert_eq!(*got as usize, leaves.iter().filter(met).count(), "{what}: {line:?}");
        }
        assert_eq!(got.len(), lines.len());
    }
}

/// Uniform lines through a box meet a box within it as often as their areas are to each other.
#[test]
fn lines_are_uniform() {
    for soup in [random(2000, 0.1, 4), moved(&random(2000, 0.1, 5), |p| [p[0], 0.1 * p[1], 0.01 * p[2]])] {
        let (tree, claims) = tree(&scene(&soup), &max_leaf(2));
        let lines = lines(&claims.bounds, 1 << 14);
        let scene = [claims.bounds.lo, claims.bounds.hi].map(|p| p.map(f64::from));
        let edge: Point = std::array::from_fn(|k| scene[1][k] - scene[0][k]);
        for (i, at) in [[0.5; 3], [0.1, 0.5, 0.9], [0.9, 0.2, 0.4]].into_iter().enumerate() {
            let size = [0.5, 0.2, 0.1][i];
            let b: Bounds = [-1.0, 1.0]
                .map(|s| std::array::from_fn(|k| scene[0][k] + edge[k] * (at[k] + s * size / 2.0)));
            let share = half_area(&b) / half_area(&scene);
            let got = lines.iter().filter(|l| meets(&l.origin, &l.direction, &b)).count() as f64 / 16384.0;
            let error = (share * (1.0 - share) / 16384.0).sqrt();
            assert!((got - share).abs() < 5.0 * error, "{got}, not {share} ± {error}");
        }
        let Quality { leaves_per_ray, lcv, lines, levels, .. } = measure(&tree, &claims);
        let least: f64 = levels.iter().map(|l| l.leaf_area).sum();
        let boxes = |n: &Place| half_area(&n.path.last().unwrap().1) / half_area(&scene);
        let leaves = places(&tree).into_iter().filter(|n| matches!(n.child, Child::Leaf { .. }));
        let most: f64 = leaves.map(|n| boxes(&n)).sum();
        let error = 5.0 * lcv / (lines as f64).sqrt();
        assert!(least - error < leaves_per_ray && leaves_per_ray < most + error, "{leaves_per_ray}");
        assert!(most < 1.1 * least, "{least} {most}");
    }
}

// ---- all of it -------------------------------------------------------------------------------

#[test]
fn levels_are_those_of_the_check() {
    for (what, soup) in soups() {
        for leaf in [1, 64] {
            let soup = scene(&soup);
            let (tree, claims) = tree(&soup, &max_leaf(leaf));
            let stats = validate(&soup, &tree, &claims).unwrap();
            let levels = measure(&tree, &claims).levels;
            let count = |of: fn(&oracle::quality::Level) -> usize| levels.iter().map(of).sum::<usize>();
            assert_eq!(count(|l| l.nodes), stats.nodes, "{what}");
            assert_eq!(count(|l| l.leaves), stats.leaves, "{what}");
            assert_eq!(count(|l| l.triangles), stats.triangles, "{what}");
            let area = |of: fn(&oracle::quality::Level) -> f64| levels.iter().map(of).sum::<f64>();
            assert_near(&format!("{what}: nodes"), area(|l| l.node_area), stats.node_area, 1e-5);
            assert_near(&format!("{what}: leaves"), area(|l| l.leaf_area), stats.leaf_area, 1e-5);
            assert_eq!(levels.len(), stats.area_by_level.len(), "{what}");
            for (level, area) in levels.iter().zip(&stats.area_by_level) {
                assert_near(&format!("{what}: level"), level.node_area + level.leaf_area, *area, 1e-5);
            }
        }
    }
}

#[test]
fn scale_and_threads_change_nothing() {
    for (what, soup) in soups().into_iter().filter(|(what, _)| what != "tiny") {
        let of = |corners: &[Corners]| {
            let (tree, claims) = tree(&scene(corners), &Recipe::default());
            measure(&tree, &claims)
        };
        let quality = of(&soup);
        assert_eq!(quality, of(&moved(&soup, |p| p.map(|x| 2.0 * x))), "{what}");
        let terms = [quality.epo, quality.lcv, quality.leaves_per_ray, quality.wide_sah];
        assert!(terms.iter().all(|x| x.is_finite() && *x >= 0.0), "{what}: {quality:?}");
    }
    let (tree, claims) = tree(&scene(&random(5000, 0.1, 9)), &Recipe::default());
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let estimate = Survey::new(&tree, &claims).estimate(4096, &Budget::unlimited());
            (measure(&tree, &claims), estimate)
        })
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn looser_boxes_overlap_more() {
    let (tree, claims) = tree(&scene(&random(3000, 0.1, 8)), &max_leaf(4));
    let mut loose = tree.clone();
    for node in &mut loose.nodes {
        let there: u32 = (0..4).filter(|k| node.children[*k] != INVALID).map(|k| 0xff << (8 * k)).sum();
        node.lo = node.lo.map(|planes| planes & !there);
        node.hi = node.hi.map(|planes| planes | there);
    }
    let (tight, loose) = (measure(&tree, &claims), measure(&loose, &claims));
    assert!(loose.epo_inner > tight.epo_inner && loose.epo_leaf > tight.epo_leaf, "{loose:?} {tight:?}");
    assert!(loose.leaves_per_ray > tight.leaves_per_ray);
    assert_eq!((loose.wide_sah, loose.levels), (tight.wide_sah, tight.levels), "of the triangles' own boxes");
}
