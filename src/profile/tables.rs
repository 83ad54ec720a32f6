//! A profile as tables for people.

use super::{Active, KernelRow, Part, Profile};
use crate::bench::Table;
use std::fmt;

/// Sums of passes may be this far off the outer stamps, per cent, before it is remarked on.
const MOST_OFF: f64 = 5.0;

/// `digits` digits; a dash where there is nothing.
fn number(x: Option<f64>, digits: usize) -> String {
    x.map_or_else(|| "–".into(), |x| format!("{x:.digits$}"))
}

fn count(x: Option<u64>) -> String {
    x.map_or_else(|| "–".into(), |x| x.to_string())
}

fn megabytes(bytes: Option<u64>) -> String {
    number(bytes.map(|b| b as f64 * 1e-6), 2)
}

impl Profile {
    /// By kernel; the copy last.
    pub fn kernels(&self) -> Table {
        let header =
            ["of", "kernel", "calls", "ms", "%", "MB of buffers", "GB/s", "% of copy", "invocations"];
        let mut rows = vec![];
        for part in &self.parts {
            rows.extend(part.kernels.iter().map(|row| kernel(part, row)));
        }
        let copy = &self.copy;
        rows.push(vec![
            "copy".into(),
            "of a buffer, read and written".into(),
            "1".into(),
            format!("{:.3}", copy.ms.median),
            "–".into(),
            megabytes(Some(copy.bytes)),
            number(Some(copy.gb_s), 2),
            "100.0".into(),
            "–".into(),
        ]);
        Table { header: header.map(String::from).to_vec(), words: 2, rows }
    }

    /// Sums of passes against outer stamps.
    pub fn sums(&self) -> Table {
        let header = [
            "of",
            "passes",
            "their sum, ms",
            "outer stamps, ms",
            "off by %",
            "stamps cost, ms",
            "without them, ms",
            "differs by %",
        ];
        let row = |part: &Part| {
            vec![
                part.name.to_owned(),
                part.calls().to_string(),
                format!("{:.3}", part.sum_ms.median),
                format!("{:.3}", part.outer_ms.median),
                format!("{:+.2}", part.off_percent),
                format!("{:.3}", part.stamps_ms),
                format!("{:.3}", part.unstamped_ms.median),
                part.differs_percent().map_or_else(|| number(None, 1), |x| format!("{x:+.1}")),
            ]
        };
        let rows = self.parts.iter().map(row).collect();
        Table { header: header.map(String::from).to_vec(), words: 1, rows }
    }

    /// How full subgroups are.
    pub fn lanes(&self) -> Table {
        let header = ["rays", "walk", "node steps", "lanes", "%", "triangle steps", "lanes", "%"];
        let cells = |active: &Active, subgroup: u32| {
            let percent = active.mean().map(|mean| 100.0 * mean / f64::from(subgroup));
            [active.steps.to_string(), number(active.mean(), 2), number(percent, 1)]
        };
        let row = |l: &super::Lanes| {
            let sorted = if l.sorted { ", sorted" } else { "" };
            let mut row = vec![format!("{} {}{sorted}", l.count, l.rays), l.kernel.to_owned()];
            row.extend(cells(&l.nodes, l.subgroup));
            row.extend(cells(&l.triangles, l.subgroup));
            row
        };
        Table {
            header: header.map(String::from).to_vec(),
            words: 2,
            rows: self.lanes.iter().map(row).collect(),
        }
    }

    /// What a reader should know of the figures, a sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = vec![];
        for part in &self.parts {
            let Part { name, off_percent, stamps_ms, .. } = part;
            if off_percent.abs() > MOST_OFF {
                remarks.push(format!(
                    "{name}: the sum of its passes is {off_percent:+.1} % off the outer stamps of the same run: something \
                     between them has no stamp"
                ));
            }
            let fast = |row: &&KernelRow| row.percent_of_copy.is_some_and(|x| x > 100.0);
            let fast: Vec<&str> = part.kernels.iter().filter(fast).map(|row| row.name.as_str()).collect();
            if !fast.is_empty() {
                remarks.push(format!(
                    "{name}: {} seem faster than a copy: they look at a part of their buffers, or find them in caches",
                    fast.join(", ")
                ));
            }
            let share = 100.0 * stamps_ms / part.outer_ms.median;
            if share > MOST_OFF {
                remarks.push(format!(
                    "{name}: its stamps, of {:.4} ms each, are {share:.1} % of the time: kernels of short passes take less \
                     than it seems, and all of them the time without stamps",
                    self.stamp_ms
                ));
            }
            if let Some(differs) = part.differs_percent().filter(|x| x.abs() > MOST_OFF) {
                remarks.push(format!(
                    "{name}: runs with a stamp a pass differ by {differs:+.1} % from those without, beside what stamps \
                     cost: take more runs, on a quieter machine"
                ));
            }
        }
        remarks
    }
}

fn kernel(part: &Part, row: &KernelRow) -> Vec<String> {
    vec![
        part.name.to_owned(),
        row.name.clone(),
        row.calls.to_string(),
        format!("{:.3}", row.ms.median),
        format!("{:.1}", row.percent),
        megabytes(row.bytes),
        number(row.gb_s, 2),
        number(row.percent_of_copy, 1),
        count(row.invocations),
    ]
}

impl fmt::Display for Profile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\nOf traversals MB are what rays ask for, counted.", self.kernels())?;
        writeln!(f, "\n{}", self.sums())?;
        if !self.lanes.is_empty() {
            writeln!(
                f,
                "\nActive lanes a step, of {} a subgroup:\n{}",
                self.lanes[0].subgroup,
                self.lanes()
            )?;
        }
        self.remarks().iter().try_for_each(|remark| writeln!(f, "\n{remark}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::Spread;
    use crate::device::Times;
    use crate::profile::Copied;
    use std::time::Instant;

    /// A part whose runs took these, ms.
    fn part([sum, outer, stamps, without]: [f64; 4]) -> Part {
        let of = |ms| Spread::of(&[ms]);
        Part {
            name: "build",
            kernels: vec![],
            sum_ms: of(sum),
            outer_ms: of(outer),
            stamps_ms: stamps,
            unstamped_ms: of(without),
            off_percent: 100.0 * (sum / outer - 1.0),
            last: (Times::default(), [Instant::now(); 2]),
        }
    }

    fn remarks(part: Part) -> Vec<String> {
        let copy = Copied { bytes: 1, ms: Spread::default(), gb_s: 1.0 };
        let profile = Profile {
            device: String::new(),
            driver: String::new(),
            commit: "",
            scene: String::new(),
            triangles: 0,
            runs: 1,
            stamp_ms: 0.05,
            copy,
            parts: vec![part],
            lanes: vec![],
            began: Instant::now(),
        };
        profile.remarks()
    }

    #[test]
    fn what_is_more_than_5_percent_off_is_said() {
        assert!(remarks(part([99.0, 100.0, 2.0, 97.0])).is_empty());
        for (ms, words) in [
            ([90.0, 100.0, 2.0, 98.0], "has no stamp"),
            ([99.0, 100.0, 10.0, 90.0], "10.0 % of the time"),
            ([99.0, 100.0, 2.0, 80.0], "+22.5 %"),
            ([99.0, 100.0, 2.0, 110.0], "-10.9 %"),
        ] {
            let said = remarks(part(ms));
            assert!(said.len() == 1 && said[0].contains(words), "{words}: {said:?}");
        }
    }

    #[test]
    fn what_seems_faster_than_a_copy_is_said() {
        let row = |name: &str, percent| KernelRow {
            name: name.into(),
            calls: 1,
            ms: Spread::default(),
            percent: 50.0,
            bytes: Some(1),
            gb_s: Some(1.0),
            percent_of_copy: Some(percent),
            invocations: None,
            asked: None,
        };
        let kernels = vec![row("a/b", 99.0), row("a/c", 101.0)];
        let said = remarks(Part { kernels, ..part([99.0, 100.0, 2.0, 97.0]) });
        assert!(said.len() == 1 && said[0].contains("a/c seem") && !said[0].contains("a/b"), "{said:?}");
    }
}
