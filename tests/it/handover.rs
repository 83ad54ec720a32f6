//! Kernels whose invocations hand values to each other, or deal out places by sums, a thousand times each, alone: in
//! workgroups so small that nearly every arrival is another one's, and in larger ones. Each run is recorded anew, and every
//! bit compared with what the twin says. What these kernels say in SPIR-V: see `shaders`.

#![allow(clippy::unwrap_used)]

mod dealt;

use crate::gpu::quiet;
use crate::matrix::first_difference;
use crate::orient::slivers;
use crate::soup::{random, scene};
use boxwood::abi::*;
use boxwood::bvh::frame::{Frame, words};
use boxwood::bvh::raw::HostRawTree;
use boxwood::bvh::{Collapse, HostTree, Morton, Recipe, SceneBuffers};
use boxwood::device::{Buffer, Device, Recorder, Timing};
use boxwood::kernels;
use boxwood::oracle::{collapse, dito, layout, lbvh, morton, ploc, recut, sort};
use boxwood::scene::Scene;
use std::sync::Arc;

const RUNS: usize = 1000;
/// Invocations of a workgroup, and items of each.
const SHAPES: [(u32, u32); 3] = [(1, 1), (8, 2), (64, 1)];
const POINTS: u32 = 14;

/// Calls `run` with its name, a shape as constants, and the items of a workgroup.
fn a_thousand_times(mut run: impl FnMut(&str, [(u32, u32); 2], u32)) {
    for i in 0..RUNS {
        let (workgroup, items) = SHAPES[i % SHAPES.len()];
        let what = format!("run {i}, {workgroup} invocations of {items}");
        run(&what, [(SPEC_WG, workgroup), (SPEC_ITEMS, items)], workgroup * items);
    }
}

/// A scene, and what stands before any builder.
struct Sorted {
    scene: Scene,
    space: morton::Space,
    order: Vec<u32>,
    keys: Vec<u64>,
    costs: Collapse,
}

impl Sorted {
    fn new(scene: Scene) -> Self {
        let (bounds, hittable) = morton::bounds(&scene);
        let (order, keys) = sort::by_code(&scene, &bounds, hittable, Morton::Bits30);
        Self {
            scene,
            space: morton::space(&bounds, hittable),
            order,
            keys,
            costs: Recipe::default().collapse,
        }
    }

    fn count(&self) -> u32 {
        self.order.len() as u32
    }

    /// The binary tree over it, not yet collapsed.
    fn binary(&self) -> HostRawTree {
        lbvh::climb(&self.scene, &self.order, &self.keys, &self.space, &self.costs).unwrap()
    }

    /// The packed tree of a binary one, whose nodes gain their bits.
    fn packed(&self, tree: &mut HostRawTree) -> HostTree {
        collapse::expand(tree);
        let kept = collapse::number(tree, &self.costs);
        layout::pack(&self.scene, &self.order, &self.space, self.costs.max_leaf, Some((tree, &kept)))
    }
}

/// A packed tree on the device, the slot above each node, and counters of who has arrived there.
struct Hung {
    nodes: Buffer<Node>,
    triangles: Buffer<u32>,
    parents: Buffer<u32>,
    arrived: Buffer<u32>,
    count: u32,
}

impl Hung {
    fn new(device: &Arc<Device>, tree: &HostTree) -> Self {
        let count = tree.nodes.len();
        let mut parents = vec![4 * count as u32; count];
        for (i, node) in (0..).zip(&tree.nodes) {
            for (k, child) in (0..).zip(node.children).filter(|(_, child)| *child < LEAF_BIT) {
                parents[child as usize] = 4 * i + k;
            }
        }
        Self {
            nodes: Buffer::from_slice(device, "nodes", &tree.nodes).unwrap(),
            triangles: Buffer::from_slice(device, "triangles", &tree.triangles).unwrap(),
            parents: Buffer::from_slice(device, "parents", &parents).unwrap(),
            arrived: Buffer::new(device, "arrived", count).unwrap(),
            count: count as u32,
        }
    }

    /// A recorder with the counters cleared.
    fn recorder(&self, device: &Arc<Device>) -> Recorder {
        let mut rec = Recorder::new(device, Timing::Off).unwrap();
        rec.fill(&self.arrived, self.arrived.len(), 0);
        rec
    }
}

/// A binary tree's nodes, cuts and root on the device.
struct Raw {
    nodes: Buffer<RawNode>,
    cuts: Buffer<RawCut>,
    root: Buffer<RawRoot>,
}

impl Raw {
    fn new(device: &Arc<Device>, count: u32) -> Self {
        let inner = count as usize - 1;
        Self {
            nodes: Buffer::new(device, "nodes", inner).unwrap(),
            cuts: Buffer::new(device, "cuts", inner).unwrap(),
            root: Buffer::new(device, "root", 1).unwrap(),
        }
    }

    fn assert_twin(&self, what: &str, twin: &HostRawTree) {
        first_difference(&format!("{what}: node"), &self.nodes.read().unwrap(), &twin.nodes);
        first_difference(&format!("{what}: cut"), &self.cuts.read().unwrap(), &twin.cuts);
        first_difference(&format!("{what}: root"), &self.root.read().unwrap(), &[twin.root]);
    }
}

#[test]
fn lbvh_climbs() {
    let device = quiet();
    let sorted = Sorted::new(scene(&random(300, 0.1, 1)));
    let twin = sorted.binary();
    let (count, raw) = (sorted.count(), Raw::new(&device, sorted.count()));
    let inner = count as usize - 1;
    let scene = SceneBuffers::upload(&device, &sorted.scene).unwrap();
    let order = Buffer::from_slice(&device, "order", &sorted.order).unwrap();
    let keys: Vec<u32> = sorted.keys.iter().map(|key| *key as u32).collect();
    let keys = Buffer::from_slice(&device, "keys", &keys).unwrap();
    let climbers = Buffer::<Climber>::new(&device, "climbers", 2 * inner).unwrap();
    let arrived = Buffer::<u32>::new(&device, "arrived", inner).unwrap();
    a_thousand_times(|what, constants, tile| {
        let mut rec = Recorder::new(&device, Timing::Off).unwrap();
        rec.fill(&arrived, inner, 0);
        let args = LbvhClimbArgs {
            triangles: scene.triangles.ptr().cast(),
            order: order.ptr(),
            keys: keys.ptr(),
            low_keys: Ptr::new(0),
            nodes: raw.nodes.ptr_shared(),
            cuts: raw.cuts.ptr_mut(),
            climbers: climbers.ptr_shared(),
            arrived: arrived.ptr_shared(),
            root: raw.root.ptr_mut(),
            count,
            scale: sorted.space.scale,
            anchor: sorted.space.anchor,
            node_cost: sorted.costs.node_cost,
            triangle_cost: sorted.costs.triangle_cost,
            max_leaf: sorted.costs.max_leaf,
            wide: 0,
        };
        rec.dispatch(&kernels::LBVH_CLIMB, &constants, count.div_ceil(tile), args).unwrap();
        rec.submit().unwrap();
        raw.assert_twin(what, &twin);
    });
}

#[test]
fn plocs_tail_hands_over_in_its_workgroup() {
    let device = quiet();
    let sorted = Sorted::new(scene(&random(200, 0.1, 2)));
    let (radius, count) = (8, sorted.count());
    let twin = ploc::cluster(&sorted.scene, &sorted.order, &sorted.space, radius, &sorted.costs).unwrap();
    let leaves = ploc::leaves(&sorted.scene, &sorted.order, &sorted.space, &sorted.costs);
    let boxes: Vec<Aabb> = leaves.iter().map(|leaf| leaf.bounds).collect();
    let boxes = Buffer::from_slice(&device, "boxes", &boxes).unwrap();
    let alone: Vec<Cluster> = leaves.iter().map(|leaf| leaf.cluster).collect();
    let alone = Buffer::from_slice(&device, "alone", &alone).unwrap();
    let bounds = Buffer::<Aabb>::new(&device, "bounds", 2 * leaves.len()).unwrap();
    let clusters = Buffer::<Cluster>::new(&device, "clusters", 2 * leaves.len()).unwrap();
    let nearest = Buffer::<u32>::new(&device, "nearest", leaves.len()).unwrap();
    let state = PlocState { groups: [0; 3], clusters: count, rounds: 0 };
    let state = Buffer::from_slice(&device, "state", &[state]).unwrap();
    let raw = Raw::new(&device, count);
    for i in 0..RUNS {
        let workgroup = [4, 32, 128][i % 3];
        let mut rec = Recorder::new(&device, Timing::Off).unwrap();
        rec.copy(&boxes, &bounds);
        rec.copy(&alone, &clusters);
        let args = PlocTailArgs {
            nearest: nearest.ptr_shared(),
            bounds: bounds.ptr_shared(),
            clusters: clusters.ptr_shared(),
            state: state.ptr(),
            nodes: raw.nodes.ptr_mut(),
            cuts: raw.cuts.ptr_shared(),
            root: raw.root.ptr_mut(),
            round: 0,
            capacity: count,
            node_cost: sorted.costs.node_cost,
            triangle_cost: sorted.costs.triangle_cost,
            max_leaf: sorted.costs.max_leaf,
        };
        let constants = [(SPEC_WG, workgroup), (SPEC_RADIUS, radius)];
        rec.dispatch(&kernels::PLOC_TAIL, &constants, 1, args).unwrap();
        rec.submit().unwrap();
        raw.assert_twin(&format!("run {i}, {workgroup} invocations"), &twin);
    }
}

/// What slots that have a child hold, `each` of it, one after the other.
fn of_children<T: Copy>(ranges: &[Range], all: &[T], each: usize) -> Vec<T> {
    let there = ranges.iter().zip(all.chunks(each)).filter(|(range, _)| range.count > 0);
    there.flat_map(|(_, of_slot)| of_slot).copied().collect()
}

fn flat(slots: &[dito::Slot]) -> Vec<f32> {
    let none = vec![glam::Vec3::ZERO; POINTS as usize];
    let points = |slot: &dito::Slot| if slot.points.is_empty() { none.clone() } else { slot.points.clone() };
    slots.iter().flat_map(points).flat_map(|p| p.to_array()).collect()
}

#[test]
fn extremal_points_climb() {
    let device = quiet();
    let sorted = Sorted::new(scene(&slivers(500, 3)));
    let tree = sorted.packed(&mut sorted.binary());
    let twin = dito::fit(&tree, sorted.space.anchor, POINTS, &Recipe::default());
    let twin_ranges: Vec<Range> = twin.iter().map(|slot| slot.range).collect();
    let each = 3 * POINTS as usize;
    let twin_points = of_children(&twin_ranges, &flat(&twin), each);
    let hung = Hung::new(&device, &tree);
    let points = Buffer::<f32>::new(&device, "points", each * twin.len()).unwrap();
    let ranges = Buffer::<Range>::new(&device, "ranges", twin.len()).unwrap();
    a_thousand_times(|what, [workgroup, items], tile| {
        let mut rec = hung.recorder(&device);
        rec.fill(&ranges, 2 * twin.len(), 0);
        let args = DitoExtremesArgs {
            nodes: hung.nodes.ptr(),
            triangles: hung.triangles.ptr().cast(),
            parents: hung.parents.ptr(),
            arrived: hung.arrived.ptr_shared(),
            points: points.ptr_shared().cast(),
            coordinates: points.ptr_shared(),
            ranges: ranges.ptr_shared(),
            directions: Ptr::new(0),
            count: hung.count,
            most: u32::MAX,
            anchor: sorted.space.anchor,
        };
        let constants = [workgroup, items, (SPEC_POINTS, POINTS), (SPEC_LEAF_BITS, tree.leaf_bits)];
        rec.dispatch(&kernels::DITO_EXTREMES, &constants, hung.count.div_ceil(tile), args).unwrap();
        rec.submit().unwrap();
        let found = ranges.read().unwrap();
        first_difference(&format!("{what}: range of slot"), &found, &twin_ranges);
        let found = of_children(&found, &points.read().unwrap(), each);
        first_difference(&format!("{what}: coordinate"), &found, &twin_points);
    });
}

#[test]
fn boxes_in_bases_climb() {
    let device = quiet();
    let sorted = Sorted::new(scene(&slivers(500, 4)));
    let tree = sorted.packed(&mut sorted.binary());
    let frames = [[0; 2], words([300_000, -700_000, 868_000])];
    let bases = frames.len();
    // Triangles below each node, whose boxes are what the device hands over.
    let slots = dito::fit(&tree, sorted.space.anchor, POINTS, &Recipe::default());
    let mut below = vec![Range { first: 0, count: 0 }; tree.nodes.len()];
    for (slot, child) in tree.nodes.iter().flat_map(|node| node.children).enumerate() {
        if child < LEAF_BIT {
            below[child as usize] = slots[slot].range;
        }
    }
    below[tree.root as usize] = slots[slots.len() - 1].range;
    let corners = |range: &Range| -> Vec<glam::Vec3> {
        let all = range.first..range.first + range.count;
        all.flat_map(|t| dito::corners(&tree, sorted.space.anchor, t)).collect()
    };
    let of_frames = |range| frames.map(|words| dito::extent(Frame::of(words).rows, &corners(range)));
    let but_the_root = |boxes: Vec<Aabb>| -> Vec<Aabb> {
        let root = bases * tree.root as usize;
        [&boxes[..root], &boxes[root + bases..]].concat()
    };
    let twin = but_the_root(below.iter().flat_map(of_frames).collect());
    let hung = Hung::new(&device, &tree);
    let boxes = Buffer::<Aabb>::new(&device, "boxes", bases * tree.nodes.len()).unwrap();
    let counts = Buffer::<u32>::new(&device, "counts", tree.nodes.len()).unwrap();
    let least = Buffer::<f32>::new(&device, "least", tree.nodes.len()).unwrap();
    let chosen = Buffer::<Pair>::new(&device, "chosen", tree.nodes.len()).unwrap();
    let extents = Buffer::<OrderedBounds>::new(&device, "extents", 4 * tree.nodes.len()).unwrap();
    let frames = Buffer::from_slice(&device, "bases", &frames).unwrap();
    let mut first = None;
    a_thousand_times(|what, [workgroup, items], tile| {
        let mut rec = hung.recorder(&device);
        let args = OdopfitClimbArgs {
            nodes: hung.nodes.ptr(),
            triangles: hung.triangles.ptr().cast(),
            parents: hung.parents.ptr(),
            arrived: hung.arrived.ptr_shared(),
            boxes: boxes.ptr_shared(),
            counts: counts.ptr_shared(),
            bases: frames.ptr(),
            least: least.ptr_mut(),
            chosen: chosen.ptr_mut(),
            extents: extents.ptr_mut(),
            count: hung.count,
            first: 0,
            // All nodes, but counts are handed over too.
            above: 1,
            anchor: sorted.space.anchor,
            node_cost: sorted.costs.node_cost,
            oriented_cost: 1.1 * sorted.costs.node_cost,
            triangle_cost: sorted.costs.triangle_cost,
        };
        let constants = [workgroup, items, (SPEC_LEAF_BITS, tree.leaf_bits), (SPEC_BASES, bases as u32)];
        rec.dispatch(&kernels::ODOPFIT_CLIMB, &constants, hung.count.div_ceil(tile), args).unwrap();
        rec.submit().unwrap();
        first_difference(&format!("{what}: box"), &but_the_root(boxes.read().unwrap()), &twin);
        let (least, chosen) = (least.read().unwrap(), chosen.read().unwrap());
        assert!(chosen.iter().any(|words| *words != [0; 2]));
        let (least_first, chosen_first) = first.get_or_insert((least.clone(), chosen.clone()));
        first_difference(&format!("{what}: least cost"), &least, least_first);
        first_difference(&format!("{what}: frame"), &chosen, chosen_first);
    });
}

#[test]
fn costs_of_cuts_climb() {
    let device = quiet();
    let sorted = Sorted::new(scene(&slivers(300, 5)));
    let recipe = Recipe::default();
    let mut twin = sorted.binary();
    recut::choose(&sorted.scene, &sorted.order, &sorted.space, &mut twin, POINTS, &recipe);
    // As packed nodes of two children.
    let mut binary = sorted.binary();
    binary.cuts.iter_mut().for_each(|cut| cut.choices = 2);
    binary.root.node &= !COLLAPSED_BIT;
    let tree = sorted.packed(&mut binary);
    let slots = dito::fit(&tree, sorted.space.anchor, POINTS, &recipe);
    let hung = Hung::new(&device, &tree);
    let raw = Raw::new(&device, sorted.count());
    raw.nodes.write(&binary.nodes).unwrap();
    let points = Buffer::from_slice(&device, "points", &flat(&slots)).unwrap();
    let ranges: Vec<Range> = slots.iter().map(|slot| slot.range).collect();
    let ranges = Buffer::from_slice(&device, "ranges", &ranges).unwrap();
    let frames: Vec<Pair> = slots.iter().map(|slot| slot.frame).collect();
    let frames = Buffer::from_slice(&device, "frames", &frames).unwrap();
    let costs = Buffer::<f32>::new(&device, "costs", 3 * tree.nodes.len()).unwrap();
    a_thousand_times(|what, [workgroup, items], tile| {
        let mut rec = hung.recorder(&device);
        rec.update(&raw.root, &[binary.root]);
        let args = RecutClimbArgs {
            nodes: hung.nodes.ptr(),
            raw: raw.nodes.ptr(),
            parents: hung.parents.ptr(),
            points: points.ptr().cast(),
            ranges: ranges.ptr(),
            frames: frames.ptr(),
            arrived: hung.arrived.ptr_shared(),
            costs: costs.ptr_shared(),
            cuts: raw.cuts.ptr_mut(),
            root: raw.root.ptr_mut(),
            count: hung.count,
            node_cost: sorted.costs.node_cost,
            triangle_cost: sorted.costs.triangle_cost,
            max_leaf: sorted.costs.max_leaf,
            dearer: recipe.oriented_cost / sorted.costs.node_cost,
        };
        let constants = [workgroup, items, (SPEC_POINTS, POINTS), (SPEC_LEAF_BITS, tree.leaf_bits)];
        rec.dispatch(&kernels::RECUT_CLIMB, &constants, hung.count.div_ceil(tile), args).unwrap();
        rec.submit().unwrap();
        first_difference(&format!("{what}: cut"), &raw.cuts.read().unwrap(), &twin.cuts);
        first_difference(&format!("{what}: root"), &raw.root.read().unwrap(), &[twin.root]);
    });
}
