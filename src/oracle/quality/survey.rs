//! A tree walked once: which leaves are below which node, where the surface is, areas by level.

use super::super::validate::{Box64, Claims, EMPTY, half_area, merged};
use crate::abi::{INVALID, Node, TRIANGLE_WORDS};
use crate::bvh::{Child, HostTree};

/// Nodes and leaves as far from the root as each other. Areas are over that of the scene's box, and of the boxes as they
/// were before they went to a node's grid.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Level {
    /// Packed nodes; the one above a scene of one leaf counts, but has no area, and its leaf is of its level.
    pub nodes: usize,
    /// Sum of their areas.
    pub node_area: f64,
    /// Leaves.
    pub leaves: usize,
    /// Sum of their areas.
    pub leaf_area: f64,
    /// Triangles in these leaves.
    pub triangles: usize,
}

/// A leaf, in the order of a walk from the root, children in order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leaf {
    pub(super) first: u32,
    pub(super) count: u32,
    /// Surface of the leaves before it.
    pub(super) area_before: f64,
}

/// What a walk over a tree finds.
#[derive(Debug)]
pub struct Survey<'a> {
    pub(super) tree: &'a HostTree,
    pub(super) claims: &'a Claims,
    pub(super) leaves: Vec<Leaf>,
    /// Surface of all triangles.
    pub(super) surface: f64,
    /// Leaves below each node: the first, and one beyond the last.
    spans: Vec<[u32; 2]>,
    levels: Vec<Level>,
    /// SAH cost of the packed tree, times the scene's area.
    cost: f64,
    /// Children of each node times triangles below it, summed.
    least_tests: u64,
    scene_area: f64,
}

/// Corners of a triangle, unit space.
pub(super) type Corners = [[f64; 3]; 3];

impl<'a> Survey<'a> {
    /// Walks `tree`, which must be sound.
    pub fn new(tree: &'a HostTree, claims: &'a Claims) -> Self {
        let mut survey = Self {
            tree,
            claims,
            leaves: vec![],
            surface: 0.0,
            spans: vec![[0; 2]; tree.nodes.len()],
            levels: vec![],
            cost: 0.0,
            least_tests: 0,
            scene_area: half_area(&[claims.bounds.lo, claims.bounds.hi].map(|p| p.map(f64::from))),
        };
        if tree.root != INVALID {
            survey.node(tree.root, 0);
        }
        survey
    }

    /// Areas by level, the root's first.
    pub fn into_levels(self) -> Vec<Level> {
        self.levels
    }

    /// SAH cost of the packed tree.
    pub fn wide_sah(&self) -> f64 {
        self.share(self.cost)
    }

    /// Box tests of [`Self::overlap`] were no triangle in a box of others.
    pub fn least_tests(&self) -> u64 {
        self.least_tests
    }

    /// Cost of testing `boxes` children.
    pub(super) fn box_cost(&self, boxes: f64) -> f64 {
        f64::from(self.claims.collapse.traversal_cost) / 2.0 * boxes
    }

    /// Cost of testing `triangles`.
    pub(super) fn triangle_cost(&self, triangles: f64) -> f64 {
        f64::from(self.claims.collapse.triangle_cost) * triangles
    }

    /// Whether leaf `rank`, of triangles from `first` on, is `child` or below it.
    pub(super) fn is_below(&self, rank: u32, first: u32, child: Child) -> bool {
        match child {
            Child::Leaf { first: its, .. } => its == first,
            Child::Node(node) => {
                let [from, end] = self.spans[node as usize];
                (from..end).contains(&rank)
            }
        }
    }

    /// The triangle at `place`.
    pub(super) fn corners(&self, place: u32) -> Corners {
        let words = &self.tree.triangles[(place * TRIANGLE_WORDS) as usize..];
        let at = |corner: usize, k: usize| f32::from_bits(words[3 * corner + k]) - self.claims.anchor[k];
        std::array::from_fn(|corner| std::array::from_fn(|k| f64::from(at(corner, k))))
    }

    /// Visits everything below `node`; returns the box and the number of its triangles.
    fn node(&mut self, index: u32, level: usize) -> (Box64, u64) {
        let children = self.tree.children(&self.tree.nodes[index as usize]);
        let one_leaf = children.len() == 1;
        let (first, mut bounds, mut triangles) = (self.leaves.len() as u32, EMPTY, 0);
        for (child, _) in &children {
            let (below, count) = match *child {
                Child::Node(child) => self.node(child, level + 1),
                Child::Leaf { first, count } => self.leaf(first, count, level + usize::from(!one_leaf)),
            };
            bounds = merged(&bounds, &below);
            triangles += count;
        }
        self.spans[index as usize] = [first, self.leaves.len() as u32];
        self.least_tests += children.len() as u64 * triangles;
        let area = if one_leaf { 0.0 } else { half_area(&bounds) };
        self.cost += self.box_cost(children.len() as f64) * area;
        let share = self.share(area);
        let level = self.level(level);
        level.nodes += 1;
        level.node_area += share;
        (bounds, triangles)
    }

    fn leaf(&mut self, first: u32, count: u32, level: usize) -> (Box64, u64) {
        self.leaves.push(Leaf { first, count, area_before: self.surface });
        let mut bounds = EMPTY;
        for place in first..first + count {
            let corners = self.corners(place);
            self.surface += area_of(&corners);
            bounds = merged(&bounds, &box_of(&corners));
        }
        let area = half_area(&bounds);
        self.cost += self.triangle_cost(f64::from(count)) * area;
        let share = self.share(area);
        let level = self.level(level);
        level.leaves += 1;
        level.leaf_area += share;
        level.triangles += count as usize;
        (bounds, count.into())
    }

    fn share(&self, area: f64) -> f64 {
        if self.scene_area > 0.0 { area / self.scene_area } else { 0.0 }
    }

    fn level(&mut self, level: usize) -> &mut Level {
        self.levels.resize(self.levels.len().max(level + 1), Level::default());
        &mut self.levels[level]
    }
}

/// Children of a packed node.
pub(super) fn child_count(node: &Node) -> usize {
    node.children.iter().filter(|child| **child != INVALID).count()
}

/// The box of a triangle.
pub(super) fn box_of(corners: &Corners) -> Box64 {
    corners.iter().fold(EMPTY, |all, p| merged(&all, &[*p, *p]))
}

/// Area of a convex polygon.
pub(super) fn area_of(corners: &[[f64; 3]]) -> f64 {
    let Some((a, rest)) = corners.split_first() else { return 0.0 };
    let mut sum = [0.0; 3];
    for edge in rest.windows(2) {
        let [p, q]: [[f64; 3]; 2] = [0, 1].map(|i| std::array::from_fn(|k| edge[i][k] - a[k]));
        for (k, sum) in sum.iter_mut().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            *sum += p[i] * q[j] - p[j] * q[i];
        }
    }
    (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt() / 2.0
}
