//! Rows of a benchmark, a build's and a set of rays', and the header that says what was measured on what.

use super::plan::Key;
use super::{Costs, KernelTime, Plan, Spread, TestTotals};
use crate::device::DeviceInfo;
use crate::kernels::RAY_QUERY_TRACE;
use crate::oracle::compare::{Quantiles, Verdict};
use crate::oracle::excess::Excess;
use crate::oracle::mixed::Mixed;
use crate::oracle::quality::Quality;
use crate::oracle::tight::Tightness;
use crate::oracle::validate::Stats;
use serde::{Deserialize, Serialize};

/// What a run was about: the first line.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Header {
    /// Device name.
    pub device: String,
    /// Driver name and version.
    pub driver: String,
    /// Commit that was measured.
    pub commit: String,
    /// As [`Plan::fingerprint`].
    pub plan: String,
    /// What the device's tests cost, ns: of the run that began the file, should it be measured anew meanwhile.
    pub costs: Costs,
    /// Scenes, builders and sets of rays in the plan's order.
    #[serde(default)]
    pub order: Order,
    /// What was typed.
    #[serde(default)]
    pub command: Vec<String>,
}

/// The order in which rows are reported.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Order {
    /// As the plan has them.
    pub scenes: Vec<String>,
    /// Contenders' names.
    pub builders: Vec<String>,
    /// View and set of the rays that each contender traces in each scene.
    #[serde(default)]
    pub cell: Vec<(usize, String)>,
    /// Likewise of the pictures whose error is measured.
    #[serde(default)]
    pub images: Vec<(usize, String)>,
    /// Through whose trees these are taken.
    #[serde(default)]
    pub painter: Option<String>,
    /// Sets of rays as typed.
    pub sets: Vec<String>,
    /// The first builder whose boxes are all axis-aligned: what others are held against.
    pub aligned: Option<String>,
}

impl Header {
    /// Of `plan` on a device whose tests cost `costs`.
    pub fn new(device: &DeviceInfo, plan: &Plan, costs: Costs) -> Self {
        Self {
            device: device.name.clone(),
            driver: device.driver.clone(),
            commit: env!("BOXWOOD_COMMIT").to_owned(),
            plan: plan.fingerprint(),
            costs,
            order: plan.order(),
            command: std::env::args().collect(),
        }
    }

    /// The first thing in which a run can't be one with `other`: its name, here, there.
    pub(super) fn difference<'a>(&'a self, other: &'a Self) -> Option<[&'a str; 3]> {
        [
            ["device", &self.device, &other.device],
            ["driver", &self.driver, &other.driver],
            ["commit", &self.commit, &other.commit],
            ["plan", &self.plan, &other.plan],
        ]
        .into_iter()
        .find(|[_, a, b]| a != b)
    }
}

/// A tree of a scene, and what building it took.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct BuildRow {
    /// As the plan has it.
    pub scene: String,
    /// The contender's name.
    pub builder: String,
    /// Triangles, those left out included.
    pub triangles: usize,
    /// Device time of a build, ms.
    pub build_ms: Spread,
    /// Wall time of a build, ms.
    pub build_wall_ms: Spread,
    /// Bytes of the tree.
    pub bvh_bytes: u64,
    /// Most memory held beside scene and tree while building, bytes.
    pub scratch_bytes: u64,
    /// What the tree is like; none of a driver's, which nobody can look at.
    #[serde(flatten)]
    pub survey: Option<Survey>,
    /// Build time by kernel, of one run with a stamp a kernel.
    pub kernels: Vec<KernelTime>,
    /// What the build did and what it skipped, a sentence each.
    #[serde(default)]
    pub explain: Vec<String>,
}

/// What is known of a tree that can be looked at.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Survey {
    /// What the tree is like.
    pub tree: Stats,
    /// How good it is beside its SAH cost.
    pub quality: Quality,
    /// How tight its boxes are.
    pub tight: Tightness,
    /// What its binary tree would cost, were the boxes of its nodes chosen one by one; none where all are axis-aligned.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub mixed: Option<Mixed>,
    /// How much larger its boxes are than they need be, of a sample; none where the plan doesn't ask.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub excess: Option<Excess>,
    /// SHA-256 of the tree.
    pub tree_hash: String,
}

/// A set of rays, traced through a tree.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RayRow {
    /// As the plan has it.
    pub scene: String,
    /// The contender's name.
    pub builder: String,
    /// The view, from 1; 0: of a file.
    pub view: usize,
    /// Which rays, as typed.
    pub set: String,
    /// Kernel that traced them.
    pub kernel: String,
    /// Whether they were sorted first; times have the sort in them.
    pub sorted: bool,
    /// Through which boxes, of a tree that keeps both: `mixed`, `axis-aligned`; none of a driver's.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub boxes: Option<String>,
    /// With which triangle test: `robust`, `fast`.
    #[serde(default)]
    pub precision: String,
    /// Rays of a run.
    pub rays: usize,
    /// Those that hit something.
    pub hits: usize,
    /// Device time, ms.
    pub trace_ms: Spread,
    /// Tests of each ray walking alone, of all rays; none of a driver's traversal, which counts none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub tests: Option<TestTotals>,
    /// What those of a ray cost in the mean, ns: by [`Header::costs`].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub cost_per_ray: Option<f64>,
    /// Time by kernel, of one run with a stamp a kernel.
    pub kernels: Vec<KernelTime>,
    /// Hits against the reference, on a sample of the rays.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub check: Option<Check>,
}

impl BuildRow {
    /// How much larger its boxes are than they need be, where that was asked for.
    pub fn excess(&self) -> Option<&Excess> {
        self.survey.as_ref()?.excess.as_ref()
    }

    /// What it is about.
    pub fn key(&self) -> Key {
        Key { scene: self.scene.clone(), builder: self.builder.clone(), rays: None }
    }
}

impl RayRow {
    /// What it is about.
    pub fn key(&self) -> Key {
        let rays = Some((self.view, self.set.clone()));
        Key { scene: self.scene.clone(), builder: self.builder.clone(), rays }
    }

    /// Whether a driver traced them, whose faults are not boxwood's.
    pub fn is_drivers(&self) -> bool {
        self.kernel == RAY_QUERY_TRACE.name
    }

    /// Millions of rays a second.
    pub fn mrays_s(&self) -> Spread {
        self.trace_ms.rate(self.rays)
    }
}

/// A verdict in numbers.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Check {
    /// Rays judged.
    pub rays: usize,
    /// Hits that the reference contradicts and rounding doesn't excuse; and faults of the reference itself.
    pub faults: usize,
    /// Hits that it contradicts where rounding may be the reason.
    pub unsure: usize,
    /// Missed hits, unsure ones too.
    pub missed: usize,
    /// Hits where there is none, unsure ones too.
    pub false_hits: usize,
    /// Hits on another surface, unsure ones too.
    pub leaked: usize,
    /// Hits on a triangle that no tie explains, unsure ones too.
    pub wrong_triangle: usize,
    /// Error of t relative to t, of hits on the reference's own triangle.
    #[serde(default)]
    pub t_error: Quantiles,
    /// The whole verdict, where there are faults.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub verdict: Option<String>,
}

impl From<&Verdict> for Check {
    fn from(v: &Verdict) -> Self {
        let stable = v.missed_stable + v.false_stable + v.leaked_stable + v.wrong_triangle_stable;
        let all = v.missed + v.false_hits + v.leaked + v.wrong_triangle;
        Self {
            rays: v.rays,
            faults: stable + v.malformed + v.brute.map_or(0, |b| b.disagreements),
            unsure: all - stable,
            missed: v.missed,
            false_hits: v.false_hits,
            leaked: v.leaked,
            wrong_triangle: v.wrong_triangle,
            t_error: v.t_error,
            verdict: (!v.is_clean()).then(|| v.to_string()),
        }
    }
}
