//! What must hold of a packed tree's nodes for a ray to find its way through them: no kernel reads beyond a buffer, walks
//! in a circle or runs out of stack in a tree that passes. Knows neither scene nor device; takes any bytes, allocates in
//! proportion to the nodes, and doesn't recurse.

use super::frame::{Frame, is_oriented};
use super::tree::{Child, child_of};
use crate::abi::{INVALID, LEAF_BIT, MAX_LEAF, Node, ORIENTED_BIT, WIDTH};

/// What is claimed of a tree.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// As [`super::Bvh::root`].
    pub root: u32,
    /// As [`super::Bvh::leaf_bits`].
    pub leaf_bits: u32,
    /// Levels of nodes at most, as [`super::Bvh::depth`].
    pub depth: u32,
    /// Triangles of a leaf at most.
    pub max_leaf: u32,
    /// Triangles of the tree.
    pub triangles: usize,
}

/// What a sound tree is like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Walked {
    /// Levels of nodes.
    pub depth: u32,
    /// Nodes whose boxes are oriented.
    pub oriented: u32,
}

/// Something that does not hold.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// Leaf references that can't be read.
    #[error("leaf references have {0} bits for their size: at most 6")]
    LeafBits(u32),
    /// A tree over nothing, or no tree over something.
    #[error("{nodes} nodes over {triangles} triangles, and the root is {root:#x}")]
    Root {
        /// Nodes.
        nodes: usize,
        /// Triangles.
        triangles: usize,
        /// Root reference.
        root: u32,
    },
    /// A reference to a node that isn't there.
    #[error("node {parent}: its child is node {child}, and there are {nodes}")]
    NoSuchNode {
        /// Where.
        parent: u32,
        /// The child.
        child: u32,
        /// Nodes.
        nodes: usize,
    },
    /// A node with two parents, or above itself.
    #[error("node {0} is reached twice")]
    Twice(u32),
    /// Nodes without a parent.
    #[error("{unreached} of {nodes} nodes can't be reached, node {first} first")]
    Unreached {
        /// How many.
        unreached: usize,
        /// Of how many.
        nodes: usize,
        /// The first.
        first: usize,
    },
    /// A node that says what can't be.
    #[error("node {node}: {what}")]
    Node {
        /// Which.
        node: u32,
        /// What is wrong with it.
        what: &'static str,
    },
    /// A leaf of too many triangles.
    #[error("node {node}: a leaf of {count} triangles, where {max_leaf} are the most")]
    LeafSize {
        /// Its parent.
        node: u32,
        /// Triangles.
        count: u32,
        /// Largest leaf asked for.
        max_leaf: u32,
    },
    /// A leaf beyond the triangles.
    #[error("node {node}: a leaf of triangles {first}..{end}, and the tree has {triangles}")]
    LeafRange {
        /// Its parent.
        node: u32,
        /// First triangle.
        first: u64,
        /// One beyond the last.
        end: u64,
        /// There are.
        triangles: usize,
    },
    /// A leaf that doesn't go on where the one to its left ends.
    #[error("node {node}: a leaf begins at triangle {first}, and the one before it ends at {end}")]
    LeafOrder {
        /// Its parent.
        node: u32,
        /// Where it begins.
        first: u32,
        /// Where it should.
        end: u64,
    },
    /// Triangles behind the last leaf.
    #[error("the last leaf ends at triangle {end}, and the tree has {triangles}")]
    Left {
        /// One beyond the last in a leaf.
        end: u64,
        /// There are.
        triangles: usize,
    },
    /// A deeper tree than its stack is made for.
    #[error("the tree has {depth} levels, and {claimed} are claimed")]
    Depth {
        /// Levels.
        depth: u32,
        /// Claimed.
        claimed: u32,
    },
}

/// Walks from the root to every leaf, left to right.
///
/// # Errors
/// The first thing found that does not hold.
pub fn check(nodes: &[Node], shape: &Shape) -> Result<Walked, Fault> {
    let Shape { root, leaf_bits, depth: claimed, max_leaf, triangles } = *shape;
    if leaf_bits > super::leaf_bits(MAX_LEAF) {
        return Err(Fault::LeafBits(leaf_bits));
    }
    let none = root == INVALID;
    if none != nodes.is_empty() || none != (triangles == 0) {
        return Err(Fault::Root { nodes: nodes.len(), triangles, root });
    }
    let mut walked = Walked { depth: 0, oriented: 0 };
    let mut reached = vec![false; nodes.len()];
    let mut end = 0;
    // Parent, reference, level. What waits are children of reached nodes, each reached once: at most three a node.
    let mut waiting = if none { vec![] } else { vec![(root, root & !LEAF_BIT, 1)] };
    if !none && root & LEAF_BIT != 0 {
        return Err(Fault::Root { nodes: nodes.len(), triangles, root });
    }
    while let Some((parent, reference, level)) = waiting.pop() {
        match child_of(reference, leaf_bits) {
            Child::Leaf { first, count } => {
                let next = u64::from(first) + u64::from(count);
                if count > max_leaf {
                    return Err(Fault::LeafSize { node: parent, count, max_leaf });
                }
                if next > triangles as u64 {
                    let (first, end) = (first.into(), next);
                    return Err(Fault::LeafRange { node: parent, first, end, triangles });
                }
                if u64::from(first) != end {
                    return Err(Fault::LeafOrder { node: parent, first, end });
                }
                end = next;
            }
            Child::Node(child) => {
                let there = nodes.get(child as usize);
                let node = there.ok_or(Fault::NoSuchNode { parent, child, nodes: nodes.len() })?;
                if std::mem::replace(&mut reached[child as usize], true) {
                    return Err(Fault::Twice(child));
                }
                if level > claimed {
                    return Err(Fault::Depth { depth: level, claimed });
                }
                fields(node).map_err(|what| Fault::Node { node: child, what })?;
                if node.children[1] == INVALID && (node.children[0] & LEAF_BIT == 0 || nodes.len() > 1) {
                    let what = "it has one child, which only a leaf of the whole scene may be";
                    return Err(Fault::Node { node: child, what });
                }
                walked.depth = walked.depth.max(level);
                walked.oriented += u32::from(is_oriented(node.frame));
                let there = node.children.into_iter().rev().filter(|c| *c != INVALID);
                waiting.extend(there.map(|c| (child, c, level + 1)));
            }
        }
    }
    if let Some(first) = reached.iter().position(|r| !r) {
        let unreached = reached.iter().filter(|r| !**r).count();
        return Err(Fault::Unreached { unreached, nodes: nodes.len(), first });
    }
    if end != triangles as u64 {
        return Err(Fault::Left { end, triangles });
    }
    Ok(walked)
}

/// What is wrong with a node whoever its children are.
fn fields(node: &Node) -> Result<(), &'static str> {
    if node.children[0] == INVALID {
        return Err("it has no child");
    }
    if node.children.windows(2).any(|pair| pair[0] == INVALID && pair[1] != INVALID) {
        return Err("it has a child behind a gap");
    }
    if node.origin.iter().any(|x| !x.is_finite()) {
        return Err("its corner is not finite");
    }
    if node.exponents & !(ORIENTED_BIT | 0xff_ffff) != 0 || (0..3).any(|k| axis(node.exponents, k) == 0xff) {
        return Err("its grid's exponents are none");
    }
    let there = (0..WIDTH).filter(|k| node.children[*k as usize] != INVALID);
    if there.into_iter().any(|k| (0..3).any(|i| axis(node.lo[i], k) > axis(node.hi[i], k))) {
        return Err("a child's box ends before it begins");
    }
    let oriented = is_oriented(node.frame);
    if (node.exponents & ORIENTED_BIT != 0) != oriented {
        return Err("its frame and what its exponents say of it are at odds");
    }
    if oriented && (Frame::of(node.frame).stretch() >= MOST_STRETCH || node.frame[1] >> 31 != 0) {
        return Err("its frame is no least rotation of a box");
    }
    Ok(())
}

/// Of every frame less: components within √2 − 1, see [`super::bases`].
const MOST_STRETCH: f32 = 1.52;

/// Byte `k` of `word`.
fn axis(word: u32, k: u32) -> u32 {
    word >> (8 * k) & 0xff
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bvh::frame::words;

    /// Bits of a leaf's size.
    const BITS: u32 = 2;

    fn leaf(first: u32, count: u32) -> u32 {
        LEAF_BIT | (count - 1) << (31 - BITS) | first
    }

    fn node(children: [u32; 4]) -> Node {
        Node { origin: [0.0; 3], exponents: 0x7a_7a_7a, lo: [0; 3], hi: [!0; 3], children, frame: [0; 2] }
    }

    /// Root 1 → (node 0 → (leaf of 1, leaf of 2), leaf of 3, node 2 → (leaf of 1, leaf of 1)).
    fn sound() -> (Vec<Node>, Shape) {
        let nodes = vec![
            node([leaf(0, 1), leaf(1, 2), INVALID, INVALID]),
            node([0, leaf(3, 3), 2, INVALID]),
            node([leaf(6, 1), leaf(7, 1), INVALID, INVALID]),
        ];
        (nodes, Shape { root: 1, leaf_bits: BITS, depth: 2, max_leaf: 3, triangles: 8 })
    }

    /// What comes of it after `doctor` has had its hands on a sound tree.
    fn after(doctor: impl FnOnce(&mut Vec<Node>, &mut Shape)) -> Result<Walked, Fault> {
        let (mut nodes, mut shape) = sound();
        doctor(&mut nodes, &mut shape);
        check(&nodes, &shape)
    }

    #[test]
    fn sound_trees_pass() {
        assert_eq!(after(|_, _| ()), Ok(Walked { depth: 2, oriented: 0 }));
        assert_eq!(after(|_, s| s.depth = 9), Ok(Walked { depth: 2, oriented: 0 }));
        let turned = after(|n, _| (n[2].frame, n[2].exponents) = (words([5, 0, 0]), 0x017a_7a7a));
        assert_eq!(turned, Ok(Walked { depth: 2, oriented: 1 }));
        let none = Shape { root: INVALID, leaf_bits: 0, depth: 1, max_leaf: 1, triangles: 0 };
        assert_eq!(check(&[], &none), Ok(Walked { depth: 0, oriented: 0 }));
        let one = [node([leaf(0, 3), INVALID, INVALID, INVALID])];
        let shape = Shape { root: 0, leaf_bits: BITS, depth: 1, max_leaf: 4, triangles: 3 };
        assert_eq!(check(&one, &shape), Ok(Walked { depth: 1, oriented: 0 }));
    }

    #[test]
    fn references_are_followed_once_and_within() {
        let no_such = |child| Err(Fault::NoSuchNode { parent: 1, child, nodes: 3 });
        assert_eq!(after(|n, _| n[1].children[0] = 3), no_such(3));
        assert_eq!(after(|_, s| s.root = 9), Err(Fault::NoSuchNode { parent: 9, child: 9, nodes: 3 }));
        assert_eq!(after(|n, _| n[1].children[0] = 1), Err(Fault::Twice(1)), "a circle of one");
        assert_eq!(after(|n, _| n[2].children[1] = 1), Err(Fault::Twice(1)), "a circle of two");
        let unreached = Err(Fault::Unreached { unreached: 1, nodes: 4, first: 3 });
        assert_eq!(after(|n, _| n.push(n[0])), unreached);
        assert_eq!(after(|_, s| s.depth = 1), Err(Fault::Depth { depth: 2, claimed: 1 }));
        for root in [INVALID, leaf(0, 1)] {
            assert_eq!(after(|_, s| s.root = root), Err(Fault::Root { nodes: 3, triangles: 8, root }));
        }
        let empty = Err(Fault::Root { nodes: 0, triangles: 8, root: 1 });
        assert_eq!(after(|n, _| n.clear()), empty);
        assert_eq!(after(|_, s| s.leaf_bits = 7), Err(Fault::LeafBits(7)));
        assert!(after(|_, s| s.leaf_bits = 31).is_err());
    }

    #[test]
    fn leaves_lie_side_by_side() {
        let size = Err(Fault::LeafSize { node: 1, count: 3, max_leaf: 2 });
        assert_eq!(after(|_, s| s.max_leaf = 2), size);
        let range = Err(Fault::LeafRange { node: 2, first: 7, end: 9, triangles: 8 });
        assert_eq!(after(|n, _| n[2].children[1] = leaf(7, 2)), range);
        let twice = Err(Fault::LeafOrder { node: 1, first: 2, end: 3 });
        assert_eq!(after(|n, _| n[1].children[1] = leaf(2, 3)), twice);
        let gap = Err(Fault::LeafOrder { node: 1, first: 4, end: 3 });
        assert_eq!(after(|n, _| n[1].children[1] = leaf(4, 2)), gap);
        assert_eq!(after(|_, s| s.triangles = 9), Err(Fault::Left { end: 8, triangles: 9 }));
    }

    #[test]
    fn fields_are_those_of_a_node() {
        let says = |wanted: &str, doctor: &dyn Fn(&mut Node)| {
            let fault = after(|n, _| doctor(&mut n[2])).unwrap_err().to_string();
            assert!(fault.starts_with("node 2: ") && fault.contains(wanted), "{fault}");
        };
        says("no child", &|n| n.children = [INVALID; 4]);
        says("no child", &|n| n.children[0] = INVALID);
        says("gap", &|n| n.children = [leaf(6, 1), INVALID, leaf(7, 1), INVALID]);
        says("one child", &|n| n.children = [leaf(6, 2), INVALID, INVALID, INVALID]);
        says("not finite", &|n| n.origin[1] = f32::NAN);
        says("not finite", &|n| n.origin[2] = f32::INFINITY);
        says("exponents", &|n| n.exponents |= 0xff_0000);
        says("exponents", &|n| n.exponents |= 0x8000_0000);
        says("ends before", &|n| (n.lo[2], n.hi[2]) = (0x200, 0x1ff));
        says("at odds", &|n| n.exponents |= ORIENTED_BIT);
        says("at odds", &|n| n.frame = [1, 0]);
        let turned = |n: &mut Node, frame| (n.frame, n.exponents) = (frame, n.exponents | ORIENTED_BIT);
        says("rotation", &|n| turned(n, words([1_048_575; 3])));
        says("rotation", &|n| turned(n, [1, 0x8000_0000]));
    }

    #[test]
    fn deep_trees_take_no_stack() {
        // A chain of a million nodes, each with a leaf of one before the next.
        let last = 1_000_000;
        let next = |i: u32| if i == last { leaf(i + 1, 1) } else { i + 1 };
        let nodes: Vec<Node> = (0..=last).map(|i| node([leaf(i, 1), next(i), INVALID, INVALID])).collect();
        let shape =
            Shape { root: 0, leaf_bits: BITS, depth: last + 1, max_leaf: 4, triangles: nodes.len() + 1 };
        assert_eq!(check(&nodes, &shape).unwrap().depth, last + 1);
    }
}
