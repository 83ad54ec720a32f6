//! Scenes × builders × precisions × queries × walks: what answers, and whether the answers are right.

use super::judge::{Arena, Known, Total};
use super::plan::{rays_of, settings, traces};
use super::{Case, Failure, Kind, Plan, Row, Setting};
use crate::abi::Hit;
use crate::bvh::Bvh;
use crate::device::{Device, DeviceError, Timing};
use crate::oracle::reference::Reference;
use crate::trace::{self, Batch, Options, Precision};
use std::sync::Arc;
use std::time::Instant;

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

/// What a run tells while it goes on.
#[derive(Debug)]
pub enum Step<'a> {
    /// A scene is next.
    Begun(&'a Case),
    /// A tree is next, and rays through it where it is there.
    Trying(&'a Case, &'a Setting, Option<&'a Options>),
    /// A scene is done: all rows so far, its own last.
    Done(&'a [Row]),
}

/// Tries `cases` by `plan` on `device`. A row a case.
pub fn run(
    device: &Arc<Device>,
    cases: &[&'static Case],
    plan: &Plan,
    answer: Answer,
    told: &dyn Fn(Step),
) -> Vec<Row> {
    let mut rows = vec![];
    for case in cases {
        told(Step::Begun(case));
        rows.push(try_case(device, case, plan, answer, told));
        told(Step::Done(&rows));
    }
    rows
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
        for options in traces(row.case, plan, &bvh) {
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
