//! What the benchmark found: as JSON, as CSV, and as tables for people.

use super::images::ImageRow;
use super::pictures::PictureRow;
use super::results::Results;
use super::row::{BuildRow, Header, RayRow, Survey};
use super::{Table, TestTotals, Views};
use crate::trace::Precision;

/// The rows of a run that are there, in the order of its plan.
#[derive(Debug, serde::Serialize)]
pub struct Report<'r> {
    #[serde(flatten)]
    header: &'r Header,
    builds: Vec<&'r BuildRow>,
    rays: Vec<&'r RayRow>,
    images: Vec<&'r ImageRow>,
    #[serde(skip)]
    pictures: &'r [PictureRow],
}

/// A line of the CSV: a build and, where rays were traced, a set of a view.
#[derive(serde::Serialize)]
struct Line<'a> {
    device: &'a str,
    commit: &'a str,
    scene: &'a str,
    builder: &'a str,
    triangles: usize,
    build_ms: f64,
    build_ms_min: f64,
    build_spread_percent: f64,
    build_wall_ms: f64,
    sah: Option<f64>,
    epo: Option<f64>,
    epo_error: Option<f64>,
    leaves_per_ray: Option<f64>,
    lcv: Option<f64>,
    inner_area: Option<f64>,
    node_area: Option<f64>,
    leaf_area: Option<f64>,
    triangles_per_leaf: Option<f64>,
    aabb_boxes: Option<f64>,
    aabb_box_area: Option<f64>,
    inner_area_share: Option<f64>,
    leaf_area_share: Option<f64>,
    total_area_share: Option<f64>,
    memory_share: Option<f64>,
    mixed_cost: Option<f64>,
    aabb_cost: Option<f64>,
    binary_mixed_cost: Option<f64>,
    binary_aabb_cost: Option<f64>,
    depth: Option<u32>,
    bvh_bytes: u64,
    scratch_bytes: u64,
    tree_hash: Option<&'a str>,
    view: Option<usize>,
    set: Option<&'a str>,
    kernel: Option<&'a str>,
    boxes: Option<&'a str>,
    sorted: Option<bool>,
    rays: Option<usize>,
    hits: Option<usize>,
    mrays_s: Option<f64>,
    mrays_s_best: Option<f64>,
    mrays_spread_percent: Option<f64>,
    boxes_per_ray: Option<f64>,
    triangles_per_ray: Option<f64>,
    cost_per_ray_ns: Option<f64>,
    checked_rays: Option<usize>,
    faults: Option<usize>,
    unsure: Option<usize>,
    missed: Option<usize>,
    false_hits: Option<usize>,
    leaked: Option<usize>,
    wrong_triangle: Option<usize>,
}

/// Of what a row lacks.
fn none() -> String {
    "–".to_owned()
}

impl<'r> Report<'r> {
    /// Of `results`.
    pub fn new(results: &'r Results) -> Self {
        let Results { header, builds, rays, images, pictures } = results;
        // What no list has comes last, as it came.
        let place =
            |list: &[String], name: &String| list.iter().position(|n| n == name).unwrap_or(list.len());
        let order = &header.order;
        let mut builds: Vec<&BuildRow> = builds.iter().collect();
        builds.sort_by_key(|b| (place(&order.scenes, &b.scene), place(&order.builders, &b.builder)));
        let mut rays: Vec<&RayRow> = rays.iter().collect();
        rays.sort_by_key(|r| {
            let [scene, set] = [(&order.scenes, &r.scene), (&order.sets, &r.set)].map(|(l, n)| place(l, n));
            (scene, set, r.view, place(&order.builders, &r.builder))
        });
        let mut images: Vec<&ImageRow> = images.iter().collect();
        images.sort_by_key(|i| place(&order.scenes, &i.scene));
        Self { header, builds, rays, images, pictures }
    }

    /// What the run was about.
    pub fn header(&self) -> &'r Header {
        self.header
    }

    /// Builds.
    pub fn builds(&self) -> &[&'r BuildRow] {
        &self.builds
    }

    /// Sets of rays, the views of each together.
    pub fn sets(&self) -> Vec<Views<'r>> {
        Views::of_all(&self.rays)
    }

    /// Pictures, scene by scene, each sampler's in the order in which they were taken.
    pub fn images(&self) -> &[&'r ImageRow] {
        &self.images
    }

    /// Of a scene its picture and maps of what its rays cost, as builders come.
    pub fn pictures(&self, scene: &str) -> Vec<&'r PictureRow> {
        let place = |p: &&PictureRow| self.header.order.builders.iter().position(|b| *b == p.builder);
        let mut of: Vec<&PictureRow> = self.pictures.iter().filter(|p| p.scene == scene).collect();
        of.sort_by_key(place);
        of
    }

    /// What is wrong with checked hits of boxwood: scene, builder, set and verdict of each row with faults. Where the fast triangle
    /// test was asked for, faults are what is measured, and not told.
    pub fn faults(&self) -> Vec<String> {
        self.wrong(|r| !r.is_drivers())
    }

    /// Hits of boxwood's robust test that were judged.
    pub fn checked(&self) -> usize {
        let own = self.rays.iter().filter(|r| !r.is_drivers() && r.precision != Precision::Fast.name());
        own.filter_map(|r| r.check.as_ref()).map(|c| c.rays).sum()
    }

    /// What is wrong with those of a driver's traversal, which need not be watertight, and no faults of boxwood.
    pub fn drivers_faults(&self) -> Vec<String> {
        self.wrong(RayRow::is_drivers)
    }

    fn wrong(&self, whose: fn(&RayRow) -> bool) -> Vec<String> {
        let said = |r: &&RayRow| {
            if r.precision == Precision::Fast.name() {
                return None;
            }
            let verdict = r.check.as_ref()?.verdict.as_ref()?;
            Some(format!("{}, {}, view {}, {}: {}", r.scene, r.builder, r.view, r.set, verdict.trim_end()))
        };
        self.rays.iter().filter(|r| whose(r)).filter_map(said).collect()
    }

    /// A line a set of rays; of a build without any, one as well.
    ///
    /// # Errors
    /// None in practice: it writes to memory.
    pub fn csv(&self) -> std::result::Result<Vec<u8>, csv::Error> {
        let mut out = csv::Writer::from_writer(vec![]);
        for b in &self.builds {
            let of_build = |r: &&&RayRow| (&r.scene, &r.builder) == (&b.scene, &b.builder);
            let rays: Vec<&RayRow> = self.rays.iter().filter(of_build).copied().collect();
            if rays.is_empty() {
                out.serialize(self.line(b, None))?;
            }
            for r in rays {
                out.serialize(self.line(b, Some(r)))?;
            }
        }
        out.into_inner().map_err(|e| csv::Error::from(e.into_error()))
    }

    fn line<'a>(&'a self, b: &'a BuildRow, r: Option<&'a RayRow>) -> Line<'a> {
        let check = r.and_then(|r| r.check.as_ref());
        let survey = b.survey.as_ref();
        let per_ray = |count: fn(&TestTotals) -> u64| {
            r.and_then(|r| Some(count(&r.tests?) as f64 / r.rays.max(1) as f64))
        };
        Line {
            device: &self.header.device,
            commit: &self.header.commit,
            scene: &b.scene,
            builder: &b.builder,
            triangles: b.triangles,
            build_ms: b.build_ms.median,
            build_ms_min: b.build_ms.min,
            build_spread_percent: b.build_ms.percent(),
            build_wall_ms: b.build_wall_ms.median,
            sah: survey.map(|s| s.tree.sah),
            epo: survey.map(|s| s.quality.epo),
            epo_error: survey.map(|s| s.quality.epo_error),
            leaves_per_ray: survey.map(|s| s.quality.leaves_per_ray),
            lcv: survey.map(|s| s.quality.lcv),
            inner_area: survey.map(|s| s.tree.inner_area),
            node_area: survey.map(|s| s.tree.node_area),
            leaf_area: survey.map(|s| s.tree.leaf_area),
            triangles_per_leaf: survey.map(|s| s.tree.triangles_per_leaf),
            aabb_boxes: survey.map(|s| s.tight.aabb_share),
            aabb_box_area: survey.map(|s| s.tight.aabb_area_share),
            inner_area_share: survey.map(|s| s.tight.inner_area),
            leaf_area_share: survey.map(|s| s.tight.leaf_area),
            total_area_share: survey.map(|s| s.tight.total_area),
            memory_share: self.memory_share(b),
            mixed_cost: survey.map(|s| s.tight.cost),
            aabb_cost: survey.map(|s| s.tight.aabb_cost),
            binary_mixed_cost: survey.and_then(|s| s.mixed).map(|m| m.cost),
            binary_aabb_cost: survey.and_then(|s| s.mixed).map(|m| m.aabb_cost),
            depth: survey.map(|s| s.tree.depth),
            bvh_bytes: b.bvh_bytes,
            scratch_bytes: b.scratch_bytes,
            tree_hash: survey.map(|s| s.tree_hash.as_str()),
            view: r.map(|r| r.view),
            set: r.map(|r| r.set.as_str()),
            kernel: r.map(|r| r.kernel.as_str()),
            boxes: r.and_then(|r| r.boxes.as_deref()),
            sorted: r.map(|r| r.sorted),
            rays: r.map(|r| r.rays),
            hits: r.map(|r| r.hits),
            mrays_s: r.map(|r| r.mrays_s().median),
            mrays_s_best: r.map(|r| r.mrays_s().max),
            mrays_spread_percent: r.map(|r| r.trace_ms.percent()),
            boxes_per_ray: per_ray(|t| t.boxes + t.oriented),
            triangles_per_ray: per_ray(|t| t.triangles),
            cost_per_ray_ns: r.and_then(|r| r.cost_per_ray),
            checked_rays: check.map(|c| c.rays),
            faults: check.map(|c| c.faults),
            unsure: check.map(|c| c.unsure),
            missed: check.map(|c| c.missed),
            false_hits: check.map(|c| c.false_hits),
            leaked: check.map(|c| c.leaked),
            wrong_triangle: check.map(|c| c.wrong_triangle),
        }
    }

    /// Builds, a row a scene and builder.
    pub fn build_table(&self) -> Table {
        let titles = [
            "scene",
            "builder",
            "triangles",
            "build ms",
            "± %",
            "wall ms",
            "SAH cost",
            "EPO",
            "LCV",
            "inner area",
            "node area",
            "leaf area",
            "tri/leaf",
            "levels",
            "tree B/tri",
            "scratch B/tri",
        ];
        let mut table = Table::new(2, titles);
        for b in &self.builds {
            let n = b.triangles.max(1) as f64;
            let two = |f: fn(&Survey) -> f64| b.survey.as_ref().map_or(none(), |s| format!("{:.2}", f(s)));
            table.push([
                b.scene.clone(),
                b.builder.clone(),
                b.triangles.to_string(),
                format!("{:.1}", b.build_ms.median),
                format!("{:.1}", b.build_ms.percent()),
                format!("{:.1}", b.build_wall_ms.median),
                two(|s| s.tree.sah),
                two(|s| s.quality.epo),
                two(|s| s.quality.lcv),
                two(|s| s.tree.inner_area),
                two(|s| s.tree.node_area),
                two(|s| s.tree.leaf_area),
                two(|s| s.tree.triangles_per_leaf),
                b.survey.as_ref().map_or(none(), |s| s.tree.depth.to_string()),
                format!("{:.0}", b.bvh_bytes as f64 / n),
                format!("{:.0}", b.scratch_bytes as f64 / n),
            ]);
        }
        table
    }

    /// Rays, a row a scene, builder and set: all its views together.
    pub fn ray_table(&self) -> Table {
        let titles = [
            "scene",
            "builder",
            "rays",
            "count",
            "hits",
            "Mrays/s",
            "± %",
            "best",
            "boxes/ray",
            "tri/ray",
            "cost/ray ns",
            "faults",
            "unsure",
            "checked",
            "kernel",
        ];
        let mut table = Table::new(3, titles);
        for all in self.sets() {
            let n = all.rays.max(1) as f64;
            let rate = all.mrays_s();
            let checked = |count: usize| if all.check.rays > 0 { count.to_string() } else { none() };
            let tests = |f: &dyn Fn(&TestTotals) -> String| all.tests.as_ref().map_or(none(), f);
            table.push([
                all.scene.to_owned(),
                all.builder.to_owned(),
                all.set.to_owned(),
                all.rays.to_string(),
                all.hits.to_string(),
                format!("{:.2}", rate.median),
                format!("{:.1}", all.trace_ms.percent()),
                format!("{:.2}", rate.max),
                tests(&|t| format!("{:.1}", (t.boxes + t.oriented) as f64 / n)),
                tests(&|t| format!("{:.1}", t.triangles as f64 / n)),
                tests(&|t| format!("{:.0}", self.header.costs.per_ray(t, all.rays))),
                checked(all.check.faults),
                checked(all.check.unsure),
                checked(all.check.rays),
                all.kernels.join("; "),
            ]);
        }
        table
    }

    /// Build time by kernel, a column a scene and builder, ms and dispatches.
    pub fn kernel_table(&self) -> Table {
        let mut names: Vec<&str> = vec![];
        for k in self.builds.iter().flat_map(|b| &b.kernels) {
            if !names.contains(&k.name.as_ref()) {
                names.push(&k.name);
            }
        }
        let titles = self.builds.iter().map(|b| format!("{}, {}", b.scene, b.builder));
        let mut table = Table::new(1, ["kernel".to_owned()].into_iter().chain(titles));
        for name in names {
            let cell = |b: &&BuildRow| {
                let row = b.kernels.iter().find(|k| k.name == name);
                row.map_or(none(), |k| format!("{:.2} ms ×{}", k.ms, k.count))
            };
            table.push([name.to_owned()].into_iter().chain(self.builds.iter().map(cell)));
        }
        table
    }
}
