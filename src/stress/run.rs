//! Scenes × builders × precisions × queries × walks: what answers, and whether the answers are right.

use super::judge::{Arena, Known, Segment, Total};
use super::{Case, Effort, RaySet, SETS};
use crate::abi::Hit;
use crate::bvh::{Bvh, Collapse, Method, Morton, Recipe};
use crate::device::{Device, DeviceError, Timing};
use crate::oracle::reference::Reference;
use crate::trace::{self, Batch, Boxes, Options, Precision, Query, RayOrder, Walk};
use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;

/// What to try.
#[derive(Debug, Clone)]
pub struct Plan {
    /// How much.
    pub effort: Effort,
    /// Builders.
    pub methods: Vec<Method>,
    /// Triangle tests.
    pub precisions: Vec<Precision>,
    /// Rays of a set.
    pub rays: usize,
    /// Of all that is by chance.
    pub seed: u64,
}

/// How a tree is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting {
    /// Builder and boxes.
    pub method: Method,
    /// Codes.
    pub morton: Morton,
    /// Triangles that a leaf may hold.
    pub max_leaf: u32,
}

impl Setting {
    /// For the library.
    pub fn recipe(&self) -> Recipe {
        let book = Recipe::default();
        let collapse = Collapse { max_leaf: self.max_leaf, ..book.collapse };
        let (builder, fit) = (self.method.builder, self.method.fit);
        Recipe { builder, fit, morton: self.morton, collapse, ..book }
    }

    /// Arguments of `boxwood query` and `boxwood build` for the same.
    pub fn arguments(&self) -> Vec<String> {
        let (morton, leaf) = (self.morton.name(), self.max_leaf.to_string());
        ["--builder", self.method.name, "--morton", morton, "--max-leaf", &leaf].map(str::to_owned).to_vec()
    }

    /// A word.
    pub fn name(&self) -> String {
        let usual = Recipe::default();
        let mut name = self.method.name.to_owned();
        if self.morton != usual.morton {
            name += &format!("-{}", self.morton.name());
        }
        if self.max_leaf != usual.collapse.max_leaf {
            name += &format!("-leaf{}", self.max_leaf);
        }
        name
    }
}

/// Traces a batch and reads its hits: [`traced`], or what a test puts in its place.
pub type Answer<'a> =
    &'a (dyn Fn(&Arc<Device>, &Bvh, &Batch, Options) -> Result<Vec<Hit>, DeviceError> + Sync);

/// What the device answers.
///
/// # Errors
/// A failed Vulkan call; a tree deeper than any stack.
pub fn traced(
    device: &Arc<Device>,
    bvh: &Bvh,
    batch: &Batch,
    options: Options,
) -> Result<Vec<Hit>, DeviceError> {
    trace::trace(device, bvh, batch, options, Timing::Off)?;
    batch.hits.read()
}

/// How something failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// No tree was built.
    Build,
    /// The tree is not sound.
    Tree,
    /// Rays were not traced.
    Trace,
    /// Hits are wrong.
    Hits,
    /// Hits are not those of another tree or walk.
    Differ,
}

impl Kind {
    /// A word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Build => "build",
            Self::Tree => "tree",
            Self::Trace => "trace",
            Self::Hits => "hits",
            Self::Differ => "differ",
        }
    }
}

/// What failed first of a scene, in one way, by one test and query.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// How.
    pub kind: Kind,
    /// By which tree.
    pub setting: Setting,
    /// By which trace.
    pub options: Options,
    /// Of [`Kind::Differ`]: what it differs from.
    pub other: Option<(Setting, Options)>,
    /// A ray that shows it, by its place among the scene's.
    pub ray: Option<usize>,
    /// What is wrong.
    pub what: String,
    /// How many cases of the scene failed so.
    pub cases: usize,
}

/// How a scene fared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// Nothing was wrong.
    Pass,
    /// Nothing was wrong, and some tree was too deep to be traced.
    Refused,
    /// Something was wrong.
    Fail,
}

impl Outcome {
    /// As tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Refused => "refused",
            Self::Fail => "FAIL",
        }
    }
}

/// A scene, tried in all ways.
#[derive(Debug, Clone)]
pub struct Row {
    /// Which.
    pub case: &'static Case,
    /// Triangles.
    pub triangles: usize,
    /// Levels of the deepest tree.
    pub depth: u32,
    /// Trees × traces.
    pub cases: usize,
    /// Rays answered for.
    pub rays: usize,
    /// What the robust test's answers are like.
    pub robust: Total,
    /// What the fast one's are like.
    pub fast: Total,
    /// Trees that were too deep for any stack.
    pub refusals: usize,
    /// What the first refusal said.
    pub refused: Option<String>,
    /// What failed.
    pub failures: Vec<Failure>,
    /// How long it took.
    pub seconds: f64,
}

impl Row {
    /// How it fared.
    pub fn outcome(&self) -> Outcome {
        match (self.failures.is_empty(), self.refusals) {
            (false, _) => Outcome::Fail,
            (true, 0) => Outcome::Pass,
            (true, _) => Outcome::Refused,
        }
    }

    fn fail(&mut self, failure: Failure) {
        let alike = |f: &&mut Failure| {
            let of = |f: &Failure| (f.kind, f.options.precision, f.options.query);
            of(f) == of(&failure)
        };
        match self.failures.iter_mut().find(alike) {
            Some(first) => first.cases += 1,
            None => self.failures.push(failure),
        }
    }
}

/// What a run tells while it goes on.
#[derive(Debug)]
pub enum Step<'a> {
    /// A scene is next.
    Begun(&'a Case),
    /// A tree is next, and rays through it where it is there.
    Trying(&'a Case, &'a Setting, Option<&'a Options>),
    /// A scene is done.
    Done(&'a Row),
}

/// Tries `cases` by `plan` on `device`. A row a case.
pub fn run(
    device: &Arc<Device>,
    cases: &[&'static Case],
    plan: &Plan,
    answer: Answer,
    told: &dyn Fn(Step),
) -> Vec<Row> {
    let one = |case: &&'static Case| {
        told(Step::Begun(case));
        let row = try_case(device, case, plan, answer, told);
        told(Step::Done(&row));
        row
    };
    cases.iter().map(one).collect()
}

/// Rays of all sets over a scene, and which are whose.
pub fn rays_of(case: &Case, reference: &Reference, plan: &Plan) -> (Vec<crate::abi::Ray>, Vec<Segment>) {
    let (mut rays, mut segments) = (vec![], vec![]);
    for set in SETS {
        let RaySet { name, .. } = *set;
        let first = rays.len();
        rays.extend(set.rays(reference, plan.rays.min(case.most_rays), plan.seed));
        segments.push(Segment { name, range: first..rays.len() });
    }
    (rays, segments)
}

/// How trees over a scene of `case` are built.
fn settings(case: &Case, plan: &Plan) -> Vec<Setting> {
    let usual = Recipe::default().morton;
    let variants = case.variants(plan.effort);
    let of = |method: &Method| {
        let method = *method;
        // A builder without codes has no choice of them.
        let sensible = variants.iter().filter(move |v| method.builder.wants_codes() || v.0 == usual);
        sensible.map(move |&(morton, max_leaf)| Setting { method, morton, max_leaf }).collect::<Vec<_>>()
    };
    plan.methods.iter().flat_map(of).collect()
}

/// How rays are traced through `bvh`.
fn traces(plan: &Plan, bvh: &Bvh) -> Vec<Options> {
    let mut all = vec![];
    for &precision in &plan.precisions {
        let plain = Options { precision, ..Options::default() };
        let any = Options { query: Query::Any, ..plain };
        let walks = |options: Options, walks: &[Walk]| {
            walks.iter().map(move |&walk| Options { walk, ..options }).collect::<Vec<_>>()
        };
        match (precision, plan.effort) {
            (Precision::Robust, effort) => {
                all.extend(walks(plain, &Walk::ALL));
                all.push(Options { order: RayOrder::Sorted, ..plain });
                if Boxes::of(bvh).len() > 1 {
                    all.push(Options { boxes: Boxes::AxisAligned, ..plain });
                }
                let few = [Walk::Single, Walk::Packet];
                all.extend(walks(any, if effort == Effort::Whole { &Walk::ALL } else { &few }));
            }
            (Precision::Fast, Effort::Quick) => all.push(plain),
            (Precision::Fast, Effort::Whole) => {
                all.extend(walks(plain, &Walk::ALL));
                all.push(any);
            }
        }
    }
    all
}

fn try_case(
    device: &Arc<Device>,
    case: &'static Case,
    plan: &Plan,
    answer: Answer,
    told: &dyn Fn(Step),
) -> Row {
    let start = Instant::now();
    let scene = case.scene(plan.effort, plan.seed);
    let reference = Reference::new(&scene);
    let (rays, segments) = rays_of(case, &reference, plan);
    let mut row = Row {
        case,
        triangles: scene.triangles.len(),
        depth: 0,
        cases: 0,
        rays: 0,
        robust: Total::default(),
        fast: Total::default(),
        refusals: 0,
        refused: None,
        failures: vec![],
        seconds: 0.0,
    };
    let settings = settings(case, plan);
    match Arena::new(device, answer, &reference, &rays, &segments) {
        Ok(arena) => try_settings(&mut row, &arena, &settings, plan, told),
        Err(e) => {
            let failure = Failure {
                kind: Kind::Build,
                setting: settings[0],
                options: Options::default(),
                other: None,
                ray: None,
                what: e.to_string(),
                cases: 1,
            };
            row.fail(failure);
        }
    }
    row.seconds = start.elapsed().as_secs_f64();
    row
}

fn try_settings(row: &mut Row, arena: &Arena, settings: &[Setting], plan: &Plan, told: &dyn Fn(Step)) {
    let mut known: Vec<Known> = vec![];
    for &setting in settings {
        let failed =
            |kind, options, what| Failure { kind, setting, options, other: None, ray: None, what, cases: 1 };
        told(Step::Trying(row.case, &setting, None));
        let bvh = match arena.build(&setting) {
            Ok(bvh) => bvh,
            Err((kind, what)) => {
                row.cases += 1;
                row.fail(failed(kind, Options::default(), what));
                continue;
            }
        };
        row.depth = row.depth.max(bvh.depth);
        if trace::stack_entries(&bvh) > trace::MAX_STACK {
            row.refusals += 1;
        }
        for options in traces(plan, &bvh) {
            row.cases += 1;
            told(Step::Trying(row.case, &setting, Some(&options)));
            let hits = match arena.hits(&bvh, options) {
                Ok(Ok(hits)) => hits,
                Ok(Err(refused)) => {
                    row.refused.get_or_insert(refused);
                    continue;
                }
                Err(what) => {
                    row.fail(failed(Kind::Trace, options, what));
                    continue;
                }
            };
            row.rays += hits.len();
            let at = arena.judged(&mut known, setting, options, hits);
            let total = match options.precision {
                Precision::Robust => &mut row.robust,
                Precision::Fast => &mut row.fast,
            };
            total.add(&known[at].total);
            let alike =
                |k: &Known| (k.options.query, k.options.precision) == (options.query, options.precision);
            let Some(first) = known.iter().find(|k| alike(k)) else { continue };
            let differing = first.differing(&known[at].hits);
            total.differing += differing.len();
            if let (Some(&ray), Precision::Robust) = (differing.first(), options.precision) {
                let what = format!(
                    "{} of {} hits differ from those of {} by {}; ray {ray}: {:?} and {:?}",
                    differing.len(),
                    first.hits.len(),
                    first.setting.name(),
                    first.options.walk.kernel_name(),
                    known[at].hits[ray],
                    first.hits[ray]
                );
                let other = Some((first.setting, first.options));
                row.fail(Failure { other, ray: Some(ray), ..failed(Kind::Differ, options, what) });
            }
            if let Some((ray, what)) = known[at].fault.clone() {
                row.fail(Failure { ray, ..failed(Kind::Hits, options, what) });
            }
        }
    }
}

/// All rows together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Scenes.
    pub scenes: usize,
    /// Those that passed.
    pub passed: usize,
    /// Those of which a tree was refused, and nothing failed.
    pub refused: usize,
    /// Those that failed.
    pub failed: usize,
    /// Trees × traces.
    pub cases: usize,
    /// Rays answered for.
    pub rays: usize,
    /// Of the robust test.
    pub robust: Total,
    /// Of the fast one.
    pub fast: Total,
    /// How long it took.
    pub seconds: f64,
}

impl Summary {
    /// Of `rows`.
    pub fn of(rows: &[Row]) -> Self {
        let count = |outcome| rows.iter().filter(|r| r.outcome() == outcome).count();
        let total = |of: fn(&Row) -> &Total| {
            rows.iter().fold(Total::default(), |mut sum, row| {
                sum.add(of(row));
                sum.differing += of(row).differing;
                sum
            })
        };
        Self {
            scenes: rows.len(),
            passed: count(Outcome::Pass),
            refused: count(Outcome::Refused),
            failed: count(Outcome::Fail),
            cases: rows.iter().map(|r| r.cases).sum(),
            rays: rows.iter().map(|r| r.rays).sum(),
            robust: total(|r| &r.robust),
            fast: total(|r| &r.fast),
            seconds: rows.iter().map(|r| r.seconds).sum(),
        }
    }
}

/// The cases whose family or title holds one of `patterns`; all where there are none.
pub fn chosen(patterns: &[String]) -> Vec<&'static Case> {
    let wanted = |case: &&Case| {
        let title = case.title();
        patterns.is_empty() || patterns.iter().any(|p| title.contains(p.as_str()))
    };
    super::CASES.iter().filter(wanted).collect()
}
