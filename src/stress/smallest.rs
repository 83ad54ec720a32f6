//! The least case of a failure: fewer rays, then fewer triangles, as long as it fails in the same way; and files of it.

use super::judge::{Arena, Segment};
use super::plan::rays_of;
use super::{Answer, Failure, Kind, Plan, Row, Setting};
use crate::abi::Ray;
use crate::device::Device;
use crate::oracle::reference::Reference;
use crate::scene::{Scene, write};
use crate::trace::{Options, Query};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long to look.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// Cases tried at most.
    pub tries: usize,
    /// And for about this long.
    pub time: Duration,
}

impl Default for Budget {
    fn default() -> Self {
        Self { tries: 1000, time: Duration::from_secs(10) }
    }
}

/// A case that fails, as small as was found.
#[derive(Debug)]
pub struct Smallest {
    /// Triangles.
    pub scene: Scene,
    /// Rays.
    pub rays: Vec<Ray>,
    /// What is wrong with it; of a failure that did not show again: what was wrong.
    pub what: String,
    /// Whether the scene alone, as made anew, failed again.
    pub again: Again,
}

/// Whether a failure showed when it was looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Again {
    /// It did.
    Failed,
    /// It did not: it depends on what ran before, or on chance.
    Passed,
}

/// A search that goes on.
struct Hunt<'a> {
    device: &'a Arc<Device>,
    answer: Answer<'a>,
    failure: &'a Failure,
    /// Which set the ray is of.
    set: &'static str,
    tries: usize,
    until: Instant,
}

impl Hunt<'_> {
    /// What is wrong, where these rays and triangles fail in the same way.
    fn wrong(&mut self, scene: &Scene, rays: &[Ray]) -> Option<String> {
        if self.tries == 0 || Instant::now() >= self.until {
            return None;
        }
        self.tries -= 1;
        let Failure { kind, setting, options, other, .. } = self.failure;
        let reference = Reference::new(scene);
        let segments = [Segment { name: self.set, range: 0..rays.len() }];
        let arena = Arena::new(self.device, self.answer, &reference, rays, &segments).ok()?;
        let bvh = match arena.build(setting) {
            Ok(bvh) => bvh,
            Err((found, what)) => return (found == *kind).then_some(what),
        };
        let hits = match (arena.hits(&bvh, *options), kind) {
            (Err(what), Kind::Trace) => return Some(what),
            (Ok(Ok(hits)), Kind::Hits | Kind::Differ) => hits,
            _ => return None,
        };
        let Some((other, options)) = other else {
            return arena.judge(*options, &hits).1.map(|(_, what)| what);
        };
        let others = arena.hits(&arena.build(other).ok()?, *options).ok()?.ok()?;
        let differ = |i: &usize| bytemuck::bytes_of(&hits[*i]) != bytemuck::bytes_of(&others[*i]);
        let ray = (0..hits.len()).find(differ)?;
        Some(format!("ray {ray}: {:?}, and {:?} in the other tree or walk", hits[ray], others[ray]))
    }
}

/// `items` without those that `fails` does without; at least one stays.
fn reduced<T: Clone>(mut items: Vec<T>, mut fails: impl FnMut(&[T]) -> bool) -> Vec<T> {
    // Again as long as some go: what one held, another may have let go of.
    loop {
        let (before, mut chunk) = (items.len(), items.len() / 2);
        while chunk > 0 {
            let mut at = 0;
            while at < items.len() {
                let end = (at + chunk).min(items.len());
                let rest = [&items[..at], &items[end..]].concat();
                if !rest.is_empty() && fails(&rest) {
                    items = rest;
                } else {
                    at = end;
                }
            }
            chunk /= 2;
        }
        if items.len() == before {
            return items;
        }
    }
}

/// The least case of `failure`, which `row` has.
pub fn smallest(
    device: &Arc<Device>,
    answer: Answer,
    plan: &Plan,
    row: &Row,
    failure: &Failure,
    budget: Budget,
) -> Smallest {
    let mut scene = row.case.scene(plan.effort, plan.seed);
    let (mut rays, segments) = rays_of(row.case, &Reference::new(&scene), plan);
    let shown = failure.ray.unwrap_or(0);
    let set = segments.iter().find(|s| s.range.contains(&shown)).map_or("", |s| s.name);
    let until = Instant::now() + budget.time;
    let mut hunt = Hunt { device, answer, failure, set, tries: budget.tries, until };
    let one = vec![rays[shown]];
    // A tree has no rays: any will do.
    if matches!(failure.kind, Kind::Build | Kind::Tree) || hunt.wrong(&scene, &one).is_some() {
        rays = one;
    } else if hunt.wrong(&scene, &rays).is_some() {
        rays = reduced(rays, |rays| hunt.wrong(&scene, rays).is_some());
    } else {
        return Smallest { scene, rays, what: failure.what.clone(), again: Again::Passed };
    }
    let all = std::mem::take(&mut scene.triangles);
    let triangles = reduced(all, |some| {
        let scene = Scene { triangles: some.to_vec(), ..scene.clone() };
        hunt.wrong(&scene, &rays).is_some()
    });
    let scene = Scene { triangles, ..scene };
    hunt.tries += 1;
    hunt.until = Instant::now() + Duration::from_secs(1);
    let (what, again) = match hunt.wrong(&scene, &rays) {
        Some(what) => (what, Again::Failed),
        None => (failure.what.clone(), Again::Passed),
    };
    Smallest { scene, rays, what, again }
}

/// What was written of a failure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Saved {
    /// Triangles, rays, and what is said of them.
    pub files: Vec<PathBuf>,
    /// Triangles.
    pub triangles: usize,
    /// Rays.
    pub rays: usize,
    /// Commands that show it, to be run in the folder.
    pub replay: Vec<String>,
}

/// What the file beside a saved case says.
#[derive(Serialize)]
struct Note<'a> {
    scene: String,
    why: &'static str,
    kind: Kind,
    what: &'a str,
    again: Again,
    setting: String,
    query: &'static str,
    precision: &'static str,
    walk: &'static str,
    /// Of hits that differ: what from.
    #[serde(skip_serializing_if = "Option::is_none")]
    other: Option<String>,
    triangles: usize,
    rays: usize,
    seed: u64,
    device: &'a str,
    driver: &'a str,
    replay: &'a [String],
}

/// Writes the least case of `failure` to `folder`, which it makes: NAME.tri, NAME.rays and NAME.json.
///
/// # Errors
/// A file that can't be written.
pub fn save(
    folder: &Path,
    device: &Device,
    plan: &Plan,
    row: &Row,
    failure: &Failure,
    smallest: &Smallest,
) -> std::io::Result<Saved> {
    let Failure { kind, setting, options, other, .. } = failure;
    let Smallest { scene, rays, what, again } = smallest;
    let query = name_of(options.query);
    let precision = options.precision.name();
    let name = format!("{}-{}-{precision}-{query}-{}", row.case.name, setting.name(), kind.name());
    let replay = replay(&name, failure);
    let told = |o: &Options| format!("{} {}", o.walk.kernel_name(), o.boxes.name());
    let note = Note {
        scene: row.case.title(),
        why: row.case.why,
        kind: *kind,
        what,
        again: *again,
        setting: setting.name(),
        query,
        precision,
        walk: options.walk.kernel_name(),
        other: other.as_ref().map(|(setting, options)| format!("{} {}", setting.name(), told(options))),
        triangles: scene.triangles.len(),
        rays: rays.len(),
        seed: plan.seed,
        device: &device.info().name,
        driver: &device.info().driver,
        replay: &replay,
    };
    std::fs::create_dir_all(folder)?;
    let words = rays.iter().flat_map(|r| bytemuck::cast::<Ray, [f32; 8]>(*r));
    let ray_bytes: Vec<u8> = words.flat_map(f32::to_le_bytes).collect();
    let json = serde_json::to_string_pretty(&note)? + "\n";
    let mut files = vec![];
    for (ending, bytes) in [("tri", write::tri(scene)), ("rays", ray_bytes), ("json", json.into_bytes())] {
        let path = folder.join(format!("{name}.{ending}"));
        std::fs::write(&path, bytes)?;
        files.push(path);
    }
    Ok(Saved { files, triangles: scene.triangles.len(), rays: rays.len(), replay })
}

/// A word for a query.
pub fn name_of(query: Query) -> &'static str {
    match query {
        Query::Closest => "closest",
        Query::Any => "any",
    }
}

/// Commands that show `failure`, saved as `name`.
fn replay(name: &str, failure: &Failure) -> Vec<String> {
    let command = |setting: &Setting, options: &Options, hits: &str| {
        let any = if options.query == Query::Any { " --any" } else { "" };
        format!(
            "boxwood query {name}.tri --rays {name}.rays --out {hits} {} --precision {}{any} --runs 1 --check",
            setting.arguments().join(" "),
            options.precision.name(),
        )
    };
    let mut commands = vec![command(&failure.setting, &failure.options, &format!("{name}.hits"))];
    if let Some((setting, options)) = &failure.other {
        commands.push(command(setting, options, &format!("{name}-other.hits")));
        commands.push(format!("cmp {name}.hits {name}-other.hits"));
    }
    commands
}

#[cfg(test)]
mod tests {
    use super::reduced;

    #[test]
    fn what_is_not_needed_goes() {
        let all: Vec<u32> = (0..1000).collect();
        let mut tries = 0;
        let least = reduced(all.clone(), |some| {
            tries += 1;
            some.contains(&17) && some.contains(&801)
        });
        assert_eq!(least, [17, 801]);
        assert!(tries < 100, "{tries}");
        assert_eq!(reduced(all, |_| true).len(), 1);
        // Either of two, but not none.
        assert_eq!(reduced(vec![1, 2, 3], |some| some.len() >= 2).len(), 2);
    }
}
