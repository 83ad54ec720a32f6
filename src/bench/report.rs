//! What the benchmark found: as JSON, as CSV, and as tables for people.

use super::{Coverage, KernelTime, RayKind, Spread};
use crate::oracle::compare::Verdict;
use crate::oracle::validate::Stats;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

/// All of it.
#[derive(Debug, serde::Serialize)]
pub struct Report {
    /// Device name.
    pub device: String,
    /// Driver name and version.
    pub driver: String,
    /// Commit that was measured.
    pub commit: &'static str,
    /// Rounds that count.
    pub runs: usize,
    /// Picture width and height, pixels.
    pub size: [u32; 2],
    /// Which secondary rays were traced.
    pub coverage: Coverage,
    /// One a scene.
    pub scenes: Vec<SceneReport>,
}

/// A scene, its tree and its rays.
#[derive(Debug, serde::Serialize)]
pub struct SceneReport {
    /// Its name.
    pub scene: String,
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
    /// What the tree is like.
    pub tree: Stats,
    /// SHA-256 of the tree.
    pub tree_hash: String,
    /// Build time by kernel, of one run with a stamp a kernel.
    pub kernels: Vec<KernelTime>,
    /// One a kind of rays.
    pub sets: Vec<SetReport>,
}

/// A set of rays.
#[derive(Debug, serde::Serialize)]
pub struct SetReport {
    /// Kind.
    pub kind: RayKind,
    /// Kernel that traced it.
    pub kernel: &'static str,
    /// Rays of a round.
    pub rays: usize,
    /// Those that hit something.
    pub hits: usize,
    /// Device time, ms.
    pub trace_ms: Spread,
    /// Millions of rays a second.
    pub mrays_s: Spread,
    /// Mean box tests of a ray.
    pub boxes_per_ray: f64,
    /// Mean triangle tests of a ray.
    pub triangles_per_ray: f64,
    /// Hits against the reference, on a sample of the rays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub check: Option<Verdict>,
}

/// A line of the CSV: a scene and a kind of rays.
#[derive(serde::Serialize)]
struct Line<'a> {
    device: &'a str,
    commit: &'a str,
    scene: &'a str,
    triangles: usize,
    build_ms: f64,
    build_ms_min: f64,
    build_spread_percent: f64,
    build_wall_ms: f64,
    sah: f64,
    inner_area: f64,
    node_area: f64,
    leaf_area: f64,
    triangles_per_leaf: f64,
    depth: u32,
    bvh_bytes: u64,
    scratch_bytes: u64,
    rays_kind: &'a str,
    rays: usize,
    hits: usize,
    mrays_s: f64,
    mrays_s_best: f64,
    mrays_spread_percent: f64,
    boxes_per_ray: f64,
    triangles_per_ray: f64,
    checked_rays: usize,
    missed: usize,
    false_hits: usize,
    leaked: usize,
    wrong_triangle: usize,
    faults_stable: usize,
}

/// Faults that rounding doesn't excuse.
fn faults(v: &Verdict) -> usize {
    v.missed_stable + v.false_stable + v.leaked_stable + v.wrong_triangle_stable + v.malformed
}

impl Report {
    /// Whether every hit that was checked is right.
    pub fn is_clean(&self) -> bool {
        self.verdicts().all(|(_, _, v)| v.is_clean())
    }

    /// Scene, kind and verdict of every set that was checked.
    pub fn verdicts(&self) -> impl Iterator<Item = (&str, RayKind, &Verdict)> {
        let sets = self.scenes.iter().flat_map(|s| s.sets.iter().map(move |t| (s, t)));
        sets.filter_map(|(s, t)| Some((s.scene.as_str(), t.kind, t.check.as_ref()?)))
    }

    /// A line a scene and kind of rays.
    ///
    /// # Errors
    /// None in practice: it writes to memory.
    pub fn csv(&self) -> std::result::Result<Vec<u8>, csv::Error> {
        let mut out = csv::Writer::from_writer(vec![]);
        for s in &self.scenes {
            for t in &s.sets {
                let count = |f: fn(&Verdict) -> usize| t.check.as_ref().map_or(0, f);
                out.serialize(Line {
                    device: &self.device,
                    commit: self.commit,
                    scene: &s.scene,
                    triangles: s.triangles,
                    build_ms: s.build_ms.median,
                    build_ms_min: s.build_ms.min,
                    build_spread_percent: s.build_ms.percent(),
                    build_wall_ms: s.build_wall_ms.median,
                    sah: s.tree.sah,
                    inner_area: s.tree.inner_area,
                    node_area: s.tree.node_area,
                    leaf_area: s.tree.leaf_area,
                    triangles_per_leaf: s.tree.triangles_per_leaf,
                    depth: s.tree.depth,
                    bvh_bytes: s.bvh_bytes,
                    scratch_bytes: s.scratch_bytes,
                    rays_kind: t.kind.name(),
                    rays: t.rays,
                    hits: t.hits,
                    mrays_s: t.mrays_s.median,
                    mrays_s_best: t.mrays_s.max,
                    mrays_spread_percent: t.mrays_s.percent(),
                    boxes_per_ray: t.boxes_per_ray,
                    triangles_per_ray: t.triangles_per_ray,
                    checked_rays: count(|v| v.rays),
                    missed: count(|v| v.missed),
                    false_hits: count(|v| v.false_hits),
                    leaked: count(|v| v.leaked),
                    wrong_triangle: count(|v| v.wrong_triangle),
                    faults_stable: count(faults),
                })?;
            }
        }
        out.into_inner().map_err(|e| csv::Error::from(e.into_error()))
    }

    /// Builds, a row a scene.
    pub fn build_table(&self) -> String {
        let mut table = table(&[
            "scene",
            "triangles",
            "build ms",
            "± %",
            "wall ms",
            "SAH cost",
            "inner area",
            "node area",
            "leaf area",
            "tri/leaf",
            "levels",
            "tree B/tri",
            "scratch B/tri",
        ]);
        for s in &self.scenes {
            let n = s.triangles.max(1) as f64;
            table.add_row([
                s.scene.clone(),
                s.triangles.to_string(),
                format!("{:.1}", s.build_ms.median),
                format!("{:.1}", s.build_ms.percent()),
                format!("{:.1}", s.build_wall_ms.median),
                format!("{:.2}", s.tree.sah),
                format!("{:.2}", s.tree.inner_area),
                format!("{:.2}", s.tree.node_area),
                format!("{:.2}", s.tree.leaf_area),
                format!("{:.2}", s.tree.triangles_per_leaf),
                s.tree.depth.to_string(),
                format!("{:.0}", s.bvh_bytes as f64 / n),
                format!("{:.0}", s.scratch_bytes as f64 / n),
            ]);
        }
        finish(table)
    }

    /// Rays, a row a scene and kind. Faults: of stable rays, then of all; of how many checked.
    pub fn ray_table(&self) -> String {
        let mut table = table(&[
            "scene",
            "rays",
            "count",
            "hits",
            "Mrays/s",
            "± %",
            "best",
            "boxes/ray",
            "tri/ray",
            "faults",
            "unsure",
            "checked",
        ]);
        for s in &self.scenes {
            for t in &s.sets {
                let unsure = |v: &Verdict| {
                    v.missed + v.false_hits + v.leaked + v.wrong_triangle + v.malformed - faults(v)
                };
                let checked =
                    |f: fn(&Verdict) -> usize| t.check.as_ref().map_or("–".into(), |v| f(v).to_string());
                table.add_row([
                    s.scene.clone(),
                    t.kind.name().to_owned(),
                    t.rays.to_string(),
                    t.hits.to_string(),
                    format!("{:.2}", t.mrays_s.median),
                    format!("{:.1}", t.mrays_s.percent()),
                    format!("{:.2}", t.mrays_s.max),
                    format!("{:.1}", t.boxes_per_ray),
                    format!("{:.1}", t.triangles_per_ray),
                    checked(faults),
                    t.check.as_ref().map_or("–".into(), |v| unsure(v).to_string()),
                    checked(|v| v.rays),
                ]);
            }
        }
        finish(table)
    }

    /// Build time by kernel, a column a scene, ms and dispatches.
    pub fn kernel_table(&self) -> String {
        let mut names: Vec<&str> = vec![];
        for k in self.scenes.iter().flat_map(|s| &s.kernels) {
            if !names.contains(&k.name) {
                names.push(k.name);
            }
        }
        let header: Vec<&str> =
            ["kernel"].into_iter().chain(self.scenes.iter().map(|s| s.scene.as_str())).collect();
        let mut table = table(&header);
        for name in names {
            let cell = |s: &SceneReport| {
                let row = s.kernels.iter().find(|k| k.name == name);
                row.map_or("–".into(), |k| format!("{:.2} ms ×{}", k.ms, k.count))
            };
            table.add_row([name.to_owned()].into_iter().chain(self.scenes.iter().map(cell)));
        }
        finish(table)
    }
}

fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.iter().copied());
    table
}

/// Words to the left, numbers to the right.
fn finish(mut table: Table) -> String {
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}
