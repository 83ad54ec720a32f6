//! The table of boxes: Table 6.1's measures of trees against axis-aligned ones.

use super::row::BuildRow;
use super::{Report, Survey, Table};

impl Report<'_> {
    /// Boxes, a row a scene and builder: shares and areas of the same tree with axis-aligned boxes, per cent; memory of
    /// the tree of the plan's first axis-aligned builder; costs with (c_T, c_OBB, c_I) = (3, 4, 2), and beside them the
    /// same with axis-aligned boxes; area above that of near-optimal boxes, where a sample was held against them.
    pub fn volume_table(&self) -> Table {
        let titles = [
            "scene",
            "builder",
            "AABB boxes %",
            "by area %",
            "inner area %",
            "leaf area %",
            "total area %",
            "memory %",
            "cost (3,4,2)",
            "AABB's",
            "ratio",
            "node by node",
            "AABB's",
            "ratio",
            "above optimal %",
        ];
        let mut table = Table::new(2, titles);
        for b in self.builds() {
            let Some(Survey { tight: t, mixed, excess, .. }) = &b.survey else { continue };
            let percent = |share: f64| format!("{:.2}", 100.0 * share);
            let pair = |cost: f64, aabb: f64| {
                let ratio = if aabb > 0.0 { format!("{:.3}", cost / aabb) } else { "–".into() };
                [format!("{cost:.2}"), format!("{aabb:.2}"), ratio]
            };
            let none = || ["–"; 3].map(str::to_owned);
            let mut row = vec![b.scene.clone(), b.builder.clone()];
            row.extend(
                [t.aabb_share, t.aabb_area_share, t.inner_area, t.leaf_area, t.total_area].map(percent),
            );
            row.push(self.memory_share(b).map_or("–".into(), percent));
            row.extend(pair(t.cost, t.aabb_cost));
            row.extend(mixed.map_or_else(none, |m| pair(m.cost, m.aabb_cost)));
            row.push(excess.map_or("–".into(), |e| format!("{:.2}", e.total)));
            table.push(row);
        }
        table
    }

    /// Bytes of a tree over those of the same scene by the plan's first axis-aligned builder, where that has a row.
    pub fn memory_share(&self, row: &BuildRow) -> Option<f64> {
        let name = self.header().order.aligned.as_deref()?;
        let same = |b: &&&BuildRow| b.scene == row.scene && b.builder == name;
        let bytes = self.builds().iter().find(same)?.bvh_bytes;
        (bytes > 0).then(|| row.bvh_bytes as f64 / bytes as f64)
    }
}
