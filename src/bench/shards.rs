//! Parts of one run: what they have twice, and what is missing of the whole.

use super::images::ImageRow;
use super::plan::Key;
use super::results::Results;
use super::row::{BuildRow, RayRow};

impl Results {
    /// Rows that the plan asks for and that are not there: of shards that are not, or of a run that was cut off. None of a
    /// file that doesn't say what was planned. Pictures in files beside the rows are not asked for.
    pub fn missing(&self) -> Vec<Key> {
        let order = &self.header.order;
        let (builds, rays) = (self.builds.iter().map(BuildRow::key), self.rays.iter().map(RayRow::key));
        let there: Vec<Key> = builds.chain(rays).chain(self.images.iter().map(ImageRow::key)).collect();
        let cells = order.scenes.iter().flat_map(|s| order.builders.iter().map(move |b| (s, b)));
        let key = |scene: &String, builder: &String, rays| Key {
            scene: scene.clone(),
            builder: builder.clone(),
            rays,
        };
        let wanted = cells.flat_map(|(scene, builder)| {
            let images = order.images.iter().filter(move |_| order.painter.as_ref() == Some(builder));
            let traced = order.cell.iter().chain(images);
            let traced = traced.map(move |of| key(scene, builder, Some(of.clone())));
            [key(scene, builder, None)].into_iter().chain(traced)
        });
        wanted.filter(|key| !there.contains(key)).collect()
    }

    /// Rows about the same that parts of one run in `all` have measured anew: [`Results::joined`] keeps the first.
    pub fn measured_twice(all: &[Self]) -> Vec<Key> {
        let mut keys = vec![];
        for (i, later) in all.iter().enumerate() {
            for earlier in all[..i].iter().filter(|earlier| earlier.is_of_run(later)) {
                let anew = |row: &&BuildRow| earlier.builds.iter().any(|r| r.key() == row.key() && r != *row);
                keys.extend(later.builds.iter().filter(anew).map(BuildRow::key));
                // What a ray costs is by the prices of its own part.
                let same =
                    |a: &RayRow, b: &RayRow| *a == RayRow { cost_per_ray: a.cost_per_ray, ..b.clone() };
                let anew = |row: &&RayRow| earlier.rays.iter().any(|r| r.key() == row.key() && !same(r, row));
                keys.extend(later.rays.iter().filter(anew).map(RayRow::key));
                let anew = |row: &&ImageRow| earlier.images.iter().any(|r| r.key() == row.key() && r != *row);
                keys.extend(later.images.iter().filter(anew).map(ImageRow::key));
            }
        }
        keys.sort();
        keys.dedup();
        keys
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bench::{Costs, Header, Order, PictureRow, TestTotals};

    /// Of two scenes, a builder and two views; `builders` of them there, each with the first view.
    fn results(scenes: &[&str]) -> Results {
        let names = |names: &[&str]| names.iter().map(|n| n.to_string()).collect();
        let cell = vec![(1, "ao".to_owned()), (2, "ao".to_owned())];
        let order =
            Order { scenes: names(&["a", "b"]), builders: names(&["ploc"]), cell, ..Order::default() };
        let costs = Costs { boxes: 1.0, oriented: 1.0, triangles: 1.0 };
        let key = |scene: &&str| (scene.to_string(), "ploc".to_owned());
        let build = |s| {
            let (scene, builder) = key(s);
            BuildRow { scene, builder, ..BuildRow::default() }
        };
        let rays = |s| {
            let (scene, builder) = key(s);
            let tests = Some(TestTotals { boxes: 30, ..TestTotals::default() });
            let (set, cost_per_ray) = ("ao".to_owned(), Some(3.0));
            RayRow { scene, builder, view: 1, set, rays: 10, tests, cost_per_ray, ..RayRow::default() }
        };
        Results {
            header: Header { order, costs, ..Header::default() },
            builds: scenes.iter().map(build).collect(),
            rays: scenes.iter().map(rays).collect(),
            ..Results::default()
        }
    }

    fn said(keys: &[Key]) -> Vec<String> {
        keys.iter().map(Key::to_string).collect()
    }

    #[test]
    fn what_is_missing_is_named() {
        let missing = ["a, ploc, view 2, ao", "b, ploc", "b, ploc, view 1, ao", "b, ploc, view 2, ao"];
        assert_eq!(said(&results(&["a"]).missing()), missing);
        let joined = Results::joined(vec![results(&["b"]), results(&["a"])]);
        assert_eq!(said(&joined[0].missing()), ["a, ploc, view 2, ao", "b, ploc, view 2, ao"]);
        let mut with_images = results(&["a", "b"]);
        with_images.header.order.builders.push("lbvh".into());
        with_images.header.order.images = vec![(0, "ao, halton, 4 samples".into())];
        with_images.header.order.painter = Some("ploc".into());
        with_images.header.order.cell.truncate(1);
        let missing = said(&with_images.missing());
        assert_eq!(missing[..3], ["a, ploc, ao, halton, 4 samples", "a, lbvh", "a, lbvh, view 1, ao"]);
        let unsaid = Results { header: Header::default(), ..results(&["a"]) };
        assert_eq!(unsaid.missing(), []);
    }

    #[test]
    fn what_is_measured_twice_is_named() {
        let (first, mut again) = (results(&["a", "b"]), results(&["b"]));
        assert_eq!(Results::measured_twice(&[first.clone(), again.clone()]), []);
        // Prices of the part's own are no other measurement.
        (again.header.costs.boxes, again.rays[0].cost_per_ray) = (2.0, Some(6.0));
        assert_eq!(Results::measured_twice(&[first.clone(), again.clone()]), []);
        again.rays[0].hits += 1;
        again.builds[0].bvh_bytes += 1;
        let twice = Results::measured_twice(&[first.clone(), again.clone()]);
        assert_eq!(said(&twice), ["b, ploc", "b, ploc, view 1, ao"]);
        again.header.device = "another".into();
        assert_eq!(Results::measured_twice(&[first, again]), [], "two runs");
    }

    #[test]
    fn what_is_written_is_read() {
        let mut run = results(&["a", "b"]);
        let picture = |file: &str, png: &[u8]| PictureRow {
            scene: file.into(),
            file: file.into(),
            png: png.to_vec(),
            ..PictureRow::default()
        };
        run.pictures = vec![picture("1.png", b"sun"), picture("gone.png", b"star")];
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rows.jsonl");
        std::fs::write(&path, run.to_lines().unwrap()).unwrap();
        for (file, bytes) in run.files_beside(&path) {
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, bytes).unwrap();
        }
        assert_eq!(Results::read(&path).unwrap(), run);
        std::fs::remove_file(dir.path().join("pictures/gone.png")).unwrap();
        run.pictures.truncate(1);
        assert_eq!(Results::read(&path).unwrap(), run, "without its file a picture is not there");
        run.pictures = vec![picture("../../1.png", b"moon")];
        let (file, _) = run.files_beside(&path).next().unwrap();
        assert_eq!(file, dir.path().join("pictures/1.png"), "nowhere else");
    }

    #[test]
    fn parts_take_the_prices_of_the_first() {
        let (first, mut second) = (results(&["a"]), results(&["b"]));
        (second.header.costs.boxes, second.rays[0].cost_per_ray) = (2.0, Some(6.0));
        let joined = Results::joined(vec![first, second]);
        assert_eq!(joined[0].rays[1].cost_per_ray, Some(3.0));
    }
}
