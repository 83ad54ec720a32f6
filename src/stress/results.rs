//! What a run comes to.

use super::{Case, Setting, Total};
use crate::trace::Options;
use serde::Serialize;

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

    pub(super) fn fail(&mut self, failure: Failure) {
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
