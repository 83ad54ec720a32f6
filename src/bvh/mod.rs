//! Builds trees on the device: `morton → sort → ploc → collapse → layout`. Knows no files and no command line.
//! Instead of `ploc` stands `odop` or `lbvh`, or `binned` instead of all before `collapse`; `recut` may come before that,
//! and `odopfit` and `dito → orient` may follow `layout`.
//!
//! # How to add a builder
//! 1. Give it a place in [`Builder`] and a name in [`Method::ALL`]: arguments, presets, help and tables follow from these.
//!    A choice of its own (a degree, a number of bins) goes to [`Recipe`], with its range in `Recipe::check`.
//! 2. `src/abi/arguments/`: a struct a kernel, marked `@kernel "stage/verb"`. `build.rs` makes its GLSL and refuses a kernel
//!    whose offsets differ.
//! 3. `glsl/<stage>/<verb>.comp`, a dispatch each, of any subgroup size, in which no workgroup waits for another. What
//!    invocations of a dispatch hand to each other lies behind `PtrShared` and passes `glsl/lib/handover.glsl`.
//! 4. `src/bvh/<stage>.rs` records them into `Build`'s recorder and returns a `RawTree` over the triangles in some order:
//!    one node fewer than triangles, each numbered by the rank at which it splits, so that trees are the same everywhere,
//!    and how each is best cut. Leaves, packing and orienting are done for every builder by what follows; a `match` in
//!    `run` says where yours stands.
//! 5. `src/oracle/<stage>.rs`: the same on the CPU, slow and obvious, which `tests/it/<stage>.rs` compares bit for bit, on
//!    the soups of `tests/it/adversarial.rs` too. Until both agree and the validation layers are silent it is not done.
//! 6. `note` what it did and what it skipped, a sentence each: `--explain` and the report show them. `memory_needed` says
//!    what it takes at most.
//! 7. A recipe in `scenes/bench.toml` puts it beside the others: `boxwood bench --builders ploc,yours`.

pub mod auto;
pub mod bases;
pub mod binned;
mod boxes;
mod builder;
mod collapse;
mod directions;
mod dito;
mod fit;
pub mod frame;
mod layout;
mod lbvh;
mod method;
mod morton;
mod odop;
mod odopfit;
mod orient;
pub mod orientation;
mod ploc;
mod radix;
pub mod raw;
mod recipe;
mod recut;
mod slabs;
mod sort;
pub mod structure;
mod tree;

pub use bases::{Bases, Generator};
pub use boxes::{FACES, Level, NodeBox, PlacedBox};
pub use builder::{Builder, Morton};
pub use directions::Directions;
pub use fit::Fit;
pub use method::Method;
pub use orientation::Orientations;
pub(crate) use radix::Radix;
pub use recipe::{Collapse, Moment, Recipe};
pub use tree::{Bvh, Child, HostTree, SceneBuffers, Volume, leaf_bits};

use crate::abi::{INVALID, RAW_MASK, RawCut, RawNode, RawRoot};
use crate::device::{Buffer, Device, DeviceError, Recorder, Times, Timing};
use std::sync::Arc;
use std::time::Instant;

/// A tree and what it took.
#[derive(Debug)]
pub struct Built {
    /// The tree.
    pub bvh: Bvh,
    /// Device times of all its submits, and of what ran on the host in their stead.
    pub times: Times,
    /// Wall time of the whole build, ms.
    pub wall_ms: f64,
    /// Most device memory held at once beside the scene and the tree, bytes.
    pub scratch_bytes: u64,
    /// What the build did and what it skipped, a sentence each.
    pub explain: Vec<String>,
}

/// What the stages of a build hand on, read back: for tests, which compare it with `oracle::build`.
#[derive(Debug, Clone, Default)]
pub struct Stages {
    /// Codes in input order: of 30 bits, or the upper 31 of 63. With [`Morton::Auto`] the 30-bit ones;
    /// none where the builder goes without.
    pub keys: Vec<u32>,
    /// Low words of 63-bit codes; empty with 30-bit ones.
    pub low_keys: Vec<u32>,
    /// Triangles in the builder's order, without those that can't be hit.
    pub order: Vec<u32>,
    /// Scale to unit space.
    pub scale: f32,
    /// The binary tree.
    pub nodes: Vec<RawNode>,
    /// How each of its nodes is cut.
    pub cuts: Vec<RawCut>,
    /// Its root; none where there is no triangle.
    pub root: Option<RawRoot>,
    /// The raw nodes that are kept, in order.
    pub kept: Vec<u32>,
    /// Packed index of each raw node; what isn't kept holds anything.
    pub packed: Vec<u32>,
    /// First triangle below each kept node, by raw node, likewise.
    pub firsts: Vec<u32>,
}

/// Triangles along the Morton curve.
#[derive(Debug)]
pub struct Ordered {
    /// Input indices; those that can't be hit come last.
    pub triangles: Buffer<u32>,
    /// Triangles that can be hit.
    pub count: u32,
    /// Device times of all submits.
    pub times: Times,
    /// What was done and what was skipped, a sentence each.
    pub explain: Vec<String>,
}

/// State of a build: where passes are recorded to, and what has been learnt.
struct Build<'a> {
    device: &'a Arc<Device>,
    scene: &'a SceneBuffers,
    recipe: &'a Recipe,
    timing: Timing,
    times: Times,
    explain: Vec<String>,
    /// Memory in use before the build, bytes.
    before: u64,
    /// Most memory in use before the tree's own was allocated, bytes.
    peak_before_tree: u64,
}

impl Build<'_> {
    fn recorder(&self) -> Result<Recorder> {
        Ok(Recorder::new(self.device, self.timing)?)
    }

    fn run(&mut self, recorder: Recorder) -> Result<()> {
        self.times.append(recorder.submit()?);
        Ok(())
    }

    /// Memory that the build holds, bytes.
    fn scratch(&self) -> u64 {
        self.device.memory_in_use().saturating_sub(self.before)
    }

    fn buffer<T: bytemuck::NoUninit>(&self, name: &str, len: usize) -> Result<Buffer<T>> {
        Ok(Buffer::new(self.device, name, len)?)
    }

    /// Runs `work` on the host, as a pass whose time is the wall's.
    fn on_host<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let done = work();
        self.times.append(Times::on_host(name, start.elapsed(), self.timing));
        done
    }

    /// Whether the builder looks at codes once they are sorted.
    fn compares_codes(&self) -> bool {
        self.recipe.builder == Builder::Lbvh
    }

    fn note(&mut self, sentence: impl Into<String>) {
        self.explain.push(sentence.into());
    }
}

/// A build that can't be done.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// A scene in a plane, too far away for its size.
    #[error(
        "the scene lies in the plane {axis} = {at:e}, more than 2^126 times as far away as it is long ({longest:e}): no \
         unit of length holds both; move it nearer (--translate)"
    )]
    TooFar {
        /// Of x, y and z.
        axis: char,
        /// Coordinate that all corners share.
        at: f32,
        /// Longest edge of the scene's box.
        longest: f32,
    },
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A recipe's value is out of range.
    #[error("{what} is {value}; it must be {range}")]
    Recipe {
        /// Which.
        what: &'static str,
        /// As given.
        value: String,
        /// What is allowed.
        range: &'static str,
    },
    /// Too many triangles for 32-bit references.
    #[error(
        "{count} triangles: at most {limit} with leaves of up to {max_leaf} (the leaf's size takes bits of its reference)"
    )]
    TooMany {
        /// Triangles.
        count: usize,
        /// Largest count.
        limit: u64,
        /// Largest leaf.
        max_leaf: u32,
    },
    /// Not even the boxes of one basis have room.
    #[error(
        "odop: {} MiB are wanted, though boxes be kept in one basis at a time; {} MiB are allowed and {} MiB free on the device: allow more (--memory), or use a smaller scene or another builder", needed.div_ceil(1 << 20), allowed >> 20, free >> 20
    )]
    Bases {
        /// Boxes in one basis and all else, bytes.
        needed: u64,
        /// [`Recipe::memory`], bytes.
        allowed: u64,
        /// Free, bytes.
        free: u64,
    },
    /// PLOC or ODOP made no progress: a fault of the device or the driver.
    #[error(
        "{builder}: {clusters} clusters were left after {rounds} rounds and none merged: the device computes wrong results (`boxwood devices` may tell why)"
    )]
    Stalled {
        /// Which.
        builder: &'static str,
        /// Rounds done.
        rounds: u32,
        /// Clusters left.
        clusters: u32,
    },
}

/// Result of a build.
pub type Result<T> = std::result::Result<T, BuildError>;

/// Device memory that `builder` over `triangles` triangles takes at most, beside the scene's own, bytes. What orienting
/// takes is told once the nodes are counted; ODOP takes more, up to [`Recipe::memory`], where the device has it.
pub fn memory_needed(builder: Builder, triangles: usize) -> u64 {
    // Of each: raw nodes and cuts (64), order (4).
    let scratch = 68
        + match builder {
            // Boxes and clusters twice, nearest.
            Builder::Ploc => 96 + 4,
            // Likewise, slots twice, pairs, lists of triangles, and boxes in a basis.
            Builder::Odop(_) => 96 + 4 + 8 + 4 + 8 + 24,
            // Climbers, arrived, keys of two words.
            Builder::Lbvh => 48 + 4 + 8,
            // What collapse queues and numbers: in the others, memory that the builder has done with.
            Builder::Binned => 12,
        };
    // The packed tree: at most a node (64) and a triangle (40) each; a little for counters.
    triangles as u64 * (scratch + 104) + (4 << 20)
}

/// Refuses a scene of `triangles` triangles, and `builder` over it, that the device has no room for: what is known before
/// the scene itself is there.
///
/// # Errors
/// [`DeviceError::Memory`].
pub fn require_memory(
    device: &Device,
    builder: Builder,
    triangles: usize,
) -> std::result::Result<(), DeviceError> {
    let what = format!("a scene of {triangles} triangles, and building over it with {},", builder.name());
    device.require_memory(&what, tree::scene_bytes(triangles) + memory_needed(builder, triangles))
}

/// Builds the tree of `scene` by `recipe`.
///
/// # Errors
/// [`BuildError`].
pub fn build(device: &Arc<Device>, scene: &SceneBuffers, recipe: &Recipe, timing: Timing) -> Result<Built> {
    run(device, scene, recipe, timing, None)
}

/// As [`build`], with every stage's result read back.
///
/// # Errors
/// [`BuildError`].
pub fn stages(device: &Arc<Device>, scene: &SceneBuffers, recipe: &Recipe) -> Result<(Built, Stages)> {
    let mut stages = Stages::default();
    let built = run(device, scene, recipe, Timing::Off, Some(&mut stages))?;
    Ok((built, stages))
}

fn run(
    device: &Arc<Device>,
    scene: &SceneBuffers,
    recipe: &Recipe,
    timing: Timing,
    mut stages: Option<&mut Stages>,
) -> Result<Built> {
    recipe.check()?;
    let limit = (1u64 << (31 - leaf_bits(recipe.collapse.max_leaf))).min(RAW_MASK.into());
    if scene.count() as u64 > limit {
        let (count, max_leaf) = (scene.count(), recipe.collapse.max_leaf);
        return Err(BuildError::TooMany { count, limit, max_leaf });
    }
    device.require_memory(
        &format!("building over {} triangles with {}", scene.count(), recipe.builder.name()),
        memory_needed(recipe.builder, scene.count()),
    )?;

    let start = Instant::now();
    let before = device.track_memory();
    let mut build = Build {
        device,
        scene,
        recipe,
        timing,
        times: Times::default(),
        explain: vec![],
        before,
        peak_before_tree: 0,
    };
    let (order, mut tree, space) = match recipe.builder {
        Builder::Ploc => {
            let (order, space) = in_morton_order(&mut build, stages.as_deref_mut())?;
            let tree = ploc::cluster(&mut build, &order, &space)?;
            (order, tree, space)
        }
        Builder::Odop(bases) => {
            let (order, space) = in_morton_order(&mut build, stages.as_deref_mut())?;
            let tree = odop::cluster(&mut build, &order, &space, bases)?;
            (order, tree, space)
        }
        Builder::Lbvh => {
            let (mut order, space) = in_morton_order(&mut build, stages.as_deref_mut())?;
            let tree = lbvh::climb(&mut build, &mut order, &space)?;
            (order, tree, space)
        }
        Builder::Binned => binned::split(&mut build)?,
    };
    if let Some(points) = recipe.fit.points().filter(|_| recipe.collapsed == Moment::After) {
        recut::choose(&mut build, &order, &mut tree, &space, points)?;
    }
    let kept = collapse::number(&mut build, &tree)?;
    build.note(kept.summary(tree.nodes.len(), recipe.collapse.max_leaf));
    if let Some(s) = &mut stages {
        s.scale = space.scale;
        s.order = order.triangles.read_first(order.count as usize)?;
        s.nodes = tree.nodes.read()?;
        s.cuts = tree.cuts.read()?;
        s.root = (tree.count > 0).then_some(tree.root);
        s.kept = kept.nodes.read_first(kept.count as usize)?;
        s.packed = kept.packed.read()?;
        s.firsts = kept.firsts.read()?;
    }
    let mut bvh = layout::pack(&mut build, &order, &tree, &kept, &space)?;
    drop((order, tree, kept));
    if bvh.root != INVALID {
        orient(&mut build, &mut bvh)?;
    }
    let wall_ms = start.elapsed().as_secs_f64() * 1e3;
    let with_tree = device.peak_memory().saturating_sub(bvh.bytes());
    let scratch_bytes = with_tree.max(build.peak_before_tree).saturating_sub(before);
    Ok(Built { bvh, times: build.times, wall_ms, scratch_bytes, explain: build.explain })
}

/// Turns the boxes of nodes as the recipe says.
fn orient(build: &mut Build<'_>, bvh: &mut Bvh) -> Result<()> {
    let (fit, scene) = (build.recipe.fit, build.scene);
    let trials = match fit.asks_the_scene() {
        true => build.on_host("orientation", || auto::trials(fit, &scene.sample)),
        false => auto::trials(fit, &[]),
    };
    build.explain.extend(trials.why);
    let bases = trials.bases.iter().any(|words| frame::is_oriented(*words));
    if fit == Fit::Auto && (bases || trials.points.is_some()) {
        let kept = build.buffer("bvh.axis_aligned", bvh.nodes.len())?;
        let mut rec = build.recorder()?;
        rec.copy(&bvh.nodes, &kept);
        build.run(rec)?;
        bvh.axis_aligned = Some(kept);
    }
    if !trials.bases.is_empty() {
        odopfit::fit(build, bvh, &trials.bases)?;
    }
    if let Some(points) = trials.points {
        let slots = dito::fit(build, bvh, points)?;
        orient::orient(build, bvh, &slots, points)?;
    }
    if bvh.oriented == 0 {
        bvh.axis_aligned = None;
    }
    Ok(())
}

/// The triangles of `scene` in the order in which builders take them by default.
///
/// # Errors
/// [`BuildError::Device`].
pub fn morton_order(device: &Arc<Device>, scene: &SceneBuffers, timing: Timing) -> Result<Ordered> {
    let recipe = &Recipe::default();
    let (times, explain) = (Times::default(), vec![]);
    let before = device.memory_in_use();
    let mut build = Build { device, scene, recipe, timing, times, explain, before, peak_before_tree: 0 };
    let (order, _) = in_morton_order(&mut build, None)?;
    let Build { times, explain, .. } = build;
    Ok(Ordered { triangles: order.triangles, count: order.count, times, explain })
}

/// The triangles by their codes.
fn in_morton_order(
    build: &mut Build<'_>,
    stages: Option<&mut Stages>,
) -> Result<(sort::Order, morton::Space)> {
    let (codes, space) = morton::encode(build)?;
    if let Some(s) = stages {
        s.keys = codes.keys.read()?;
        s.low_keys = codes.low_keys.as_ref().map_or(Ok(vec![]), Buffer::read)?;
    }
    Ok((sort::by_code(build, codes)?, space))
}
