//! The tree of [`super::Reference`]: binned SAH. \[WALD07\] "On fast construction of SAH-based bounding volume
//! hierarchies". Differs: triangles that can't be told apart are kept once, and where planes don't separate, or from
//! [`SAH_DEPTH`] on, splits are medians, so that no input makes it deep or quadratic.

use crate::scene::Scene;

/// Most triangles in a leaf, but for those that can't be told apart.
const LEAF: usize = 4;
/// Bins an axis.
const BINS: usize = 16;
/// Depth from which on splits are medians, which end within 32 levels.
const SAH_DEPTH: u32 = 56;
/// Depth that no tree exceeds.
pub const MAX_DEPTH: usize = SAH_DEPTH as usize + 32;
/// Subtrees of at least this many triangles are built in parallel.
const PARALLEL: usize = 1 << 14;
/// A box as its two corners, exact.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Least corner.
    pub lo: [f32; 3],
    /// Greatest corner.
    pub hi: [f32; 3],
}

impl Bounds {
    const EMPTY: Bounds = Bounds { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };

    /// Bounds of a triangle.
    pub fn of(corners: &[[f32; 3]; 3]) -> Self {
        corners.iter().fold(Self::EMPTY, |b, &c| b.merged(&Bounds { lo: c, hi: c }))
    }

    fn merged(&self, o: &Bounds) -> Self {
        Bounds {
            lo: std::array::from_fn(|k| if o.lo[k] < self.lo[k] { o.lo[k] } else { self.lo[k] }),
            hi: std::array::from_fn(|k| if o.hi[k] > self.hi[k] { o.hi[k] } else { self.hi[k] }),
        }
    }

    /// Twice the centre along `axis`, f64 so that it can't overflow.
    fn centre(&self, axis: usize) -> f64 {
        f64::from(self.lo[axis]) + f64::from(self.hi[axis])
    }

    /// Half the surface area; 0 where empty.
    fn half_area(&self) -> f64 {
        let e: [f64; 3] = std::array::from_fn(|k| (f64::from(self.hi[k]) - f64::from(self.lo[k])).max(0.0));
        e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
    }
}

/// A node: a leaf of `count` triangles from `first`, or, where `count` is 0, the parent of nodes `first` and
/// `first + 1`.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// Bounds of all below.
    pub bounds: Bounds,
    /// First item, or first child.
    pub first: u32,
    /// Items; 0 in a parent.
    pub count: u32,
}

impl Node {
    const EMPTY: Node = Node { bounds: Bounds::EMPTY, first: 0, count: 0 };
}

/// A triangle while the tree is built.
#[derive(Debug, Clone, Copy)]
pub struct Item {
    /// Its box.
    pub bounds: Bounds,
    /// Its place in the input.
    pub index: u32,
}

/// Orders `items` into a tree; returns its nodes, root first. An empty tree is one node that nothing enters.
pub fn build(scene: &Scene, items: &mut [Item]) -> Vec<Node> {
    tree(scene, items, 0, 0)
}

/// Orders `items`, which are those from `base` on, into a subtree and writes its root to `nodes[at]`.
fn grow(scene: &Scene, nodes: &mut Vec<Node>, at: usize, items: &mut [Item], base: usize, depth: u32) {
    let extent = Extent::of(items);
    let (bounds, axis) = (extent.bounds, extent.widest());
    let alike = extent.spread(axis) <= 0.0;
    let sorted = depth >= SAH_DEPTH;
    let items = if alike && !sorted && items.len() > LEAF { distinct(scene, items) } else { items };
    let split = if alike || sorted { None } else { cheapest(items, &extent) };
    if items.len() <= LEAF && split.is_none() {
        nodes[at] = Node { bounds, first: base as u32, count: items.len() as u32 };
        return;
    }
    let middle = match split {
        Some(split) => partition(items, |i| split.bin(i) <= split.last),
        None => {
            let middle = items.len() / 2;
            let centre = |i: &Item| i.bounds.centre(axis);
            items.select_nth_unstable_by(middle, |a, b| {
                centre(a).total_cmp(&centre(b)).then(a.index.cmp(&b.index))
            });
            middle
        }
    };
    let children = nodes.len();
    nodes[at] = Node { bounds, first: children as u32, count: 0 };
    nodes.extend([Node::EMPTY; 2]);
    // Centres all alike stay so: medians from here on.
    let depth = if alike { depth.max(SAH_DEPTH) } else { depth + 1 };
    let parallel = items.len() >= PARALLEL;
    let (left, right) = items.split_at_mut(middle);
    if parallel {
        let (left, right) =
            rayon::join(|| tree(scene, left, base, depth), || tree(scene, right, base + middle, depth));
        graft(nodes, children, &left);
        graft(nodes, children + 1, &right);
    } else {
        grow(scene, nodes, children, left, base, depth);
        grow(scene, nodes, children + 1, right, base + middle, depth);
    }
}

/// [`grow`] into nodes of its own.
fn tree(scene: &Scene, items: &mut [Item], base: usize, depth: u32) -> Vec<Node> {
    let mut nodes = Vec::with_capacity(items.len());
    nodes.push(Node::EMPTY);
    grow(scene, &mut nodes, 0, items, base, depth);
    nodes
}

/// Puts the root of `tree` at `nodes[at]` and the rest at the end.
fn graft(nodes: &mut Vec<Node>, at: usize, tree: &[Node]) {
    let shift = (nodes.len() - 1) as u32;
    let moved = |n: &Node| if n.count > 0 { *n } else { Node { first: n.first + shift, ..*n } };
    let mut moved = tree.iter().map(moved);
    if let Some(root) = moved.next() {
        nodes[at] = root;
    }
    nodes.extend(moved);
}

/// Bounds of some items and of their (doubled) centres.
struct Extent {
    bounds: Bounds,
    low: [f64; 3],
    high: [f64; 3],
}

impl Extent {
    fn of(items: &[Item]) -> Self {
        let mut e = Extent { bounds: Bounds::EMPTY, low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        for item in items {
            e.bounds = e.bounds.merged(&item.bounds);
            for axis in 0..3 {
                let centre = item.bounds.centre(axis);
                e.low[axis] = e.low[axis].min(centre);
                e.high[axis] = e.high[axis].max(centre);
            }
        }
        e
    }

    /// How far the centres spread along `axis`; not positive where they are alike.
    fn spread(&self, axis: usize) -> f64 {
        self.high[axis] - self.low[axis]
    }

    /// The axis along which the centres spread most.
    fn widest(&self) -> usize {
        [1, 2].into_iter().fold(0, |best, k| if self.spread(k) > self.spread(best) { k } else { best })
    }
}

/// A plane between two bins.
struct Split {
    axis: usize,
    low: f64,
    scale: f64,
    /// Last bin before the plane.
    last: usize,
}

impl Split {
    fn bin(&self, item: &Item) -> usize {
        (((item.bounds.centre(self.axis) - self.low) * self.scale) as usize).min(BINS - 1)
    }
}

/// The split of least cost; none where no plane splits, or where at most [`LEAF`] items are cheaper as a leaf.
fn cheapest(items: &[Item], extent: &Extent) -> Option<Split> {
    // A node costs as much as a triangle.
    let leaf_cost = (items.len() as f64 - 1.0) * extent.bounds.half_area();
    let mut least = if items.len() <= LEAF { leaf_cost } else { f64::INFINITY };
    let mut best = None;
    for axis in 0..3 {
        if extent.spread(axis) <= 0.0 {
            continue;
        }
        let split =
            |last| Split { axis, low: extent.low[axis], scale: BINS as f64 / extent.spread(axis), last };
        let binner = split(0);
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for item in items {
            let bin = &mut bins[binner.bin(item)];
            *bin = (bin.0.merged(&item.bounds), bin.1 + 1);
        }
        let sum = |a: (Bounds, usize), b: &(Bounds, usize)| (a.0.merged(&b.0), a.1 + b.1);
        let cost = |side: &(Bounds, usize)| side.0.half_area() * side.1 as f64;
        let mut right_costs = [0.0; BINS];
        let mut right = (Bounds::EMPTY, 0);
        for last in (0..BINS - 1).rev() {
            right = sum(right, &bins[last + 1]);
            right_costs[last] = cost(&right);
        }
        let mut left = (Bounds::EMPTY, 0);
        for last in 0..BINS - 1 {
            left = sum(left, &bins[last]);
            let both = left.1 > 0 && left.1 < items.len();
            if both && cost(&left) + right_costs[last] < least {
                least = cost(&left) + right_costs[last];
                best = Some(split(last));
            }
        }
    }
    best
}

/// Brings the items that `first` holds of to the front; returns how many.
fn partition(items: &mut [Item], first: impl Fn(&Item) -> bool) -> usize {
    let mut middle = 0;
    for i in 0..items.len() {
        if first(&items[i]) {
            items.swap(i, middle);
            middle += 1;
        }
    }
    middle
}

/// Brings one item of each set of identical triangles, that of lowest index, to the front; returns those.
fn distinct<'i>(scene: &Scene, items: &'i mut [Item]) -> &'i mut [Item] {
    let corners = |i: &Item| scene.corners(i.index as usize).map(|c| c.map(f32::to_bits));
    items.sort_unstable_by_key(|i| (corners(i), i.index));
    let mut kept = 0;
    for i in 0..items.len() {
        if kept == 0 || corners(&items[i]) != corners(&items[kept - 1]) {
            items.swap(i, kept);
            kept += 1;
        }
    }
    &mut items[..kept]
}
