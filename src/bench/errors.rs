//! The tables of errors: of hits against the f64 reference, of pictures against converged ones.

use super::{Report, Table, Views};
use crate::trace::Precision;

impl Report<'_> {
    /// Judged hits, a row a scene, builder and set: how many of a million are wrong, unsure ones among them, the error of
    /// t, and what a ray takes.
    pub fn error_table(&self) -> Table {
        let titles = [
            "scene",
            "builder",
            "rays",
            "ns/ray",
            "judged",
            "missed/M",
            "false/M",
            "other surface/M",
            "other triangle/M",
            "no excuse/M",
            "t error, median",
            "99 %",
            "most",
        ];
        let mut table = Table::new(3, titles);
        for v in self.sets().iter().filter(|v| v.check.rays > 0) {
            let c = &v.check;
            let per_million = |n: usize| match 1e6 * n as f64 / c.rays as f64 {
                0.0 => "0".to_owned(),
                x => format!("{x:.1}"),
            };
            // Hits alone tell t, and the nearest of them.
            let error = |x: f64| if c.t_error.max > 0.0 { format!("{x:.1e}") } else { "–".into() };
            let mut row = vec![v.scene.to_owned(), v.builder.to_owned(), v.set.to_owned()];
            row.push(format!("{:.0}", v.ns_a_ray()));
            row.push(c.rays.to_string());
            row.extend([c.missed, c.false_hits, c.leaked, c.wrong_triangle, c.faults].map(per_million));
            row.extend([c.t_error.p50, c.t_error.p99, c.t_error.max].map(error));
            table.push(row);
        }
        table
    }

    /// Pictures, a row each.
    pub fn image_table(&self) -> Table {
        let titles = ["scene", "shows", "samples by", "builder", "samples", "pixels", "ms", "± %", "RMSE"];
        let mut table = Table::new(4, titles);
        for i in self.images() {
            let words = [&i.scene, &i.shows, &i.sampler, &i.builder].map(String::clone);
            let numbers = [
                i.samples.to_string(),
                i.pixels.to_string(),
                format!("{:.2}", i.trace_ms.median),
                format!("{:.1}", i.trace_ms.percent()),
                format!("{:.5}", i.rmse),
            ];
            table.push(words.into_iter().chain(numbers));
        }
        table
    }
}

impl Views<'_> {
    /// Whether triangles were tested by what leaks at edges.
    pub fn is_fast(&self) -> bool {
        self.precision == Precision::Fast.name()
    }

    /// Device time of a ray, ns.
    pub fn ns_a_ray(&self) -> f64 {
        self.trace_ms.median * 1e6 / self.rays.max(1) as f64
    }

    /// Judged hits of a million that are wrong, those among them that rounding may excuse; none where none was judged.
    pub fn wrong_per_million(&self) -> Option<f64> {
        let c = &self.check;
        let wrong = c.missed + c.false_hits + c.leaked + c.wrong_triangle;
        (c.rays > 0).then(|| 1e6 * wrong as f64 / c.rays as f64)
    }
}
