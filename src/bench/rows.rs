//! Rows of a benchmark, and the file that gets each of them the moment it is finished: a line of JSON a row, after one
//! that says what was measured on what. A run that was cut off goes on from there.

use super::images::ImageRow;
use super::pictures::PictureRow;
use super::plan::Key;
use super::{Costs, KernelTime, Plan, Spread, TestTotals};
use crate::device::DeviceInfo;
use crate::kernels::RAY_QUERY_TRACE;
use crate::oracle::compare::{Quantiles, Verdict};
use crate::oracle::excess::Excess;
use crate::oracle::mixed::Mixed;
use crate::oracle::quality::Quality;
use crate::oracle::tight::Tightness;
use crate::oracle::validate::Stats;
use serde::{Deserialize, Serialize};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What a run was about: the first line.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Header {
    /// Device name.
    pub device: String,
    /// Driver name and version.
    pub driver: String,
    /// Commit that was measured.
    pub commit: String,
    /// As [`Plan::fingerprint`].
    pub plan: String,
    /// What the device's tests cost, ns: of the run that began the file, should it be measured anew meanwhile.
    pub costs: Costs,
    /// Scenes, builders and sets of rays in the plan's order.
    #[serde(default)]
    pub order: Order,
    /// What was typed.
    #[serde(default)]
    pub command: Vec<String>,
}

/// The order in which rows are reported.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Order {
    /// As the plan has them.
    pub scenes: Vec<String>,
    /// Contenders' names.
    pub builders: Vec<String>,
    /// View and set of the rays that each contender traces in each scene.
    #[serde(default)]
    pub cell: Vec<(usize, String)>,
    /// Likewise of the pictures whose error is measured.
    #[serde(default)]
    pub images: Vec<(usize, String)>,
    /// Through whose trees these are taken.
    #[serde(default)]
    pub painter: Option<String>,
    /// Sets of rays as typed.
    pub sets: Vec<String>,
    /// The first builder whose boxes are all axis-aligned: what others are held against.
    pub aligned: Option<String>,
}

impl Header {
    /// Of `plan` on a device whose tests cost `costs`.
    pub fn new(device: &DeviceInfo, plan: &Plan, costs: Costs) -> Self {
        Self {
            device: device.name.clone(),
            driver: device.driver.clone(),
            commit: env!("BOXWOOD_COMMIT").to_owned(),
            plan: plan.fingerprint(),
            costs,
            order: plan.order(),
            command: std::env::args().collect(),
        }
    }

    /// The first thing in which a run can't be one with `other`: its name, here, there.
    fn difference<'a>(&'a self, other: &'a Self) -> Option<[&'a str; 3]> {
        [
            ["device", &self.device, &other.device],
            ["driver", &self.driver, &other.driver],
            ["commit", &self.commit, &other.commit],
            ["plan", &self.plan, &other.plan],
        ]
        .into_iter()
        .find(|[_, a, b]| a != b)
    }
}

/// A tree of a scene, and what building it took.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct BuildRow {
    /// As the plan has it.
    pub scene: String,
    /// The contender's name.
    pub builder: String,
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
    /// What the tree is like; none of a driver's, which nobody can look at.
    #[serde(flatten)]
    pub survey: Option<Survey>,
    /// Build time by kernel, of one run with a stamp a kernel.
    pub kernels: Vec<KernelTime>,
    /// What the build did and what it skipped, a sentence each.
    #[serde(default)]
    pub explain: Vec<String>,
}

/// What is known of a tree that can be looked at.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Survey {
    /// What the tree is like.
    pub tree: Stats,
    /// How good it is beside its SAH cost.
    pub quality: Quality,
    /// How tight its boxes are.
    pub tight: Tightness,
    /// What its binary tree would cost, were the boxes of its nodes chosen one by one; none where all are axis-aligned.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub mixed: Option<Mixed>,
    /// How much larger its boxes are than they need be, of a sample; none where the plan doesn't ask.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub excess: Option<Excess>,
    /// SHA-256 of the tree.
    pub tree_hash: String,
}

/// A set of rays, traced through a tree.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RayRow {
    /// As the plan has it.
    pub scene: String,
    /// The contender's name.
    pub builder: String,
    /// The view, from 1; 0: of a file.
    pub view: usize,
    /// Which rays, as typed.
    pub set: String,
    /// Kernel that traced them.
    pub kernel: String,
    /// Whether they were sorted first; times have the sort in them.
    pub sorted: bool,
    /// Through which boxes, of a tree that keeps both: `mixed`, `axis-aligned`; none of a driver's.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub boxes: Option<String>,
    /// With which triangle test: `robust`, `fast`.
    #[serde(default)]
    pub precision: String,
    /// Rays of a run.
    pub rays: usize,
    /// Those that hit something.
    pub hits: usize,
    /// Device time, ms.
    pub trace_ms: Spread,
    /// Tests of each ray walking alone, of all rays; none of a driver's traversal, which counts none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub tests: Option<TestTotals>,
    /// What those of a ray cost in the mean, ns: by [`Header::costs`].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub cost_per_ray: Option<f64>,
    /// Time by kernel, of one run with a stamp a kernel.
    pub kernels: Vec<KernelTime>,
    /// Hits against the reference, on a sample of the rays.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub check: Option<Check>,
}

impl BuildRow {
    /// How much larger its boxes are than they need be, where that was asked for.
    pub fn excess(&self) -> Option<&Excess> {
        self.survey.as_ref()?.excess.as_ref()
    }

    /// What it is about.
    pub fn key(&self) -> Key {
        Key { scene: self.scene.clone(), builder: self.builder.clone(), rays: None }
    }
}

impl RayRow {
    /// What it is about.
    pub fn key(&self) -> Key {
        let rays = Some((self.view, self.set.clone()));
        Key { scene: self.scene.clone(), builder: self.builder.clone(), rays }
    }

    /// Whether a driver traced them, whose faults are not boxwood's.
    pub fn is_drivers(&self) -> bool {
        self.kernel == RAY_QUERY_TRACE.name
    }

    /// Millions of rays a second.
    pub fn mrays_s(&self) -> Spread {
        self.trace_ms.rate(self.rays)
    }
}

/// A verdict in numbers.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Check {
    /// Rays judged.
    pub rays: usize,
    /// Hits that the reference contradicts and rounding doesn't excuse; and faults of the reference itself.
    pub faults: usize,
    /// Hits that it contradicts where rounding may be the reason.
    pub unsure: usize,
    /// Missed hits, unsure ones too.
    pub missed: usize,
    /// Hits where there is none, unsure ones too.
    pub false_hits: usize,
    /// Hits on another surface, unsure ones too.
    pub leaked: usize,
    /// Hits on a triangle that no tie explains, unsure ones too.
    pub wrong_triangle: usize,
    /// Error of t relative to t, of hits on the reference's own triangle.
    #[serde(default)]
    pub t_error: Quantiles,
    /// The whole verdict, where there are faults.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub verdict: Option<String>,
}

impl From<&Verdict> for Check {
    fn from(v: &Verdict) -> Self {
        let stable = v.missed_stable + v.false_stable + v.leaked_stable + v.wrong_triangle_stable;
        let all = v.missed + v.false_hits + v.leaked + v.wrong_triangle;
        Self {
            rays: v.rays,
            faults: stable + v.malformed + v.brute.map_or(0, |b| b.disagreements),
            unsure: all - stable,
            missed: v.missed,
            false_hits: v.false_hits,
            leaked: v.leaked,
            wrong_triangle: v.wrong_triangle,
            t_error: v.t_error,
            verdict: (!v.is_clean()).then(|| v.to_string()),
        }
    }
}

/// A line of the file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "row", rename_all = "lowercase")]
enum Line {
    Header(Box<Header>),
    Build(Box<BuildRow>),
    Rays(Box<RayRow>),
    Image(Box<ImageRow>),
    Picture(Box<PictureRow>),
}

/// A file of rows that can't be used.
#[derive(Debug, thiserror::Error)]
pub enum RowsError {
    /// It can't be read or written.
    #[error("can't {doing} {}: {source}", path.display())]
    Io {
        /// What was tried.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// A line is none of ours.
    #[error("{}, line {line}: {why}; give another --out, or leave out --resume", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// What is wrong.
        why: String,
    },
    /// Its rows are of another run.
    #[error(
        "can't go on with {}: its {what} is {there}, and here it is {here}; give the same arguments, another --out, or leave out --resume", path.display()
    )]
    Other {
        /// The file.
        path: PathBuf,
        /// In what it differs.
        what: String,
        /// What the file says.
        there: String,
        /// What this run says.
        here: String,
    },
}

type Result<T> = std::result::Result<T, RowsError>;

/// What a run measured, as its file has it: whole or as far as it came.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub struct Results {
    /// What it was about.
    #[serde(flatten)]
    pub header: Header,
    /// Builds as they finished.
    pub builds: Vec<BuildRow>,
    /// Sets of rays likewise.
    pub rays: Vec<RayRow>,
    /// Pictures likewise.
    #[serde(default)]
    pub images: Vec<ImageRow>,
    /// Pictures of scenes and of what their rays cost.
    #[serde(skip)]
    pub pictures: Vec<PictureRow>,
}

impl Results {
    /// None yet.
    fn new(header: Header) -> Self {
        Self { header, builds: vec![], rays: vec![], images: vec![], pictures: vec![] }
    }

    /// Of the file of rows at `path`; a last line that was cut off is left out.
    ///
    /// # Errors
    /// It can't be read, or holds a line that is none of ours.
    pub fn read(path: &Path) -> Result<Self> {
        let io = |source| RowsError::Io { doing: "read", path: path.to_owned(), source };
        let bytes = fs::read(path).map_err(io)?;
        Self::parse(path, &bytes[..whole_lines(&bytes)])
    }

    /// Runs of one plan, one device and one commit made into one, in the order in which the first of each comes. Of rows
    /// about the same the first stays.
    pub fn joined(all: Vec<Self>) -> Vec<Self> {
        let mut runs: Vec<Self> = vec![];
        for results in all {
            match runs.iter_mut().find(|run| run.is_of_run(&results)) {
                None => runs.push(results),
                Some(run) => run.take_in(results),
            }
        }
        runs
    }

    /// Whether both are parts of one run.
    pub(super) fn is_of_run(&self, other: &Self) -> bool {
        self.header.difference(&other.header).is_none()
    }

    fn take_in(&mut self, other: Self) {
        for row in other.builds {
            if !self.builds.iter().any(|r| r.key() == row.key()) {
                self.builds.push(row);
            }
        }
        for row in other.rays {
            if !self.rays.iter().any(|r| r.key() == row.key()) {
                let cost_per_ray = row.tests.map(|tests| self.header.costs.per_ray(&tests, row.rays));
                self.rays.push(RayRow { cost_per_ray, ..row });
            }
        }
        for row in other.images {
            if !self.images.iter().any(|r| r.key() == row.key()) {
                self.images.push(row);
            }
        }
        for row in other.pictures {
            if !self.pictures.iter().any(|r| r.key() == row.key()) {
                self.pictures.push(row);
            }
        }
    }

    /// Rows there are.
    pub fn count(&self) -> usize {
        self.builds.len() + self.rays.len() + self.images.len() + self.pictures.len()
    }

    /// Files of its pictures, where its rows are at `path`, and what is in them.
    pub fn files_beside<'a>(&'a self, path: &Path) -> impl Iterator<Item = (PathBuf, &'a [u8])> {
        let folder = pictures_beside(path);
        let there = self.pictures.iter().filter(|row| !row.png.is_empty());
        there.filter_map(move |row| Some((folder.join(Path::new(&row.file).file_name()?), &row.png[..])))
    }

    /// As a file of rows.
    ///
    /// # Errors
    /// None in practice: it writes to memory.
    pub fn to_lines(&self) -> serde_json::Result<Vec<u8>> {
        let builds = self.builds.iter().map(|row| Line::Build(Box::new(row.clone())));
        let rays = self.rays.iter().map(|row| Line::Rays(Box::new(row.clone())));
        let images = self.images.iter().map(|row| Line::Image(Box::new(row.clone())));
        let header = [Line::Header(Box::new(self.header.clone()))];
        let mut bytes = vec![];
        let pictures = self.pictures.iter().map(|row| Line::Picture(Box::new(row.clone())));
        for line in header.into_iter().chain(builds).chain(rays).chain(images).chain(pictures) {
            serde_json::to_writer(&mut bytes, &line)?;
            bytes.push(b'\n');
        }
        Ok(bytes)
    }

    fn parse(path: &Path, bytes: &[u8]) -> Result<Self> {
        let mut lines = bytes.split(|b| *b == b'\n').enumerate().filter(|(_, text)| !text.is_empty());
        let wrong = |line: usize, why: String| RowsError::Line { path: path.to_owned(), line: line + 1, why };
        let line = |i: usize, text: &[u8]| serde_json::from_slice(text).map_err(|e| wrong(i, e.to_string()));
        let no_beginning = || wrong(0, "it does not begin with what was measured".into());
        let (first, text) = lines.next().ok_or_else(no_beginning)?;
        let Line::Header(header) = line(first, text)? else { return Err(no_beginning()) };
        let mut results = Self::new(*header);
        for (i, text) in lines {
            match line(i, text)? {
                Line::Header(_) => return Err(wrong(i, "a second beginning".into())),
                Line::Build(row) => results.builds.push(*row),
                Line::Rays(row) => results.rays.push(*row),
                Line::Image(row) => results.images.push(*row),
                Line::Picture(row) => {
                    // A name, not a way to elsewhere.
                    let name = Path::new(&row.file).file_name().unwrap_or_default();
                    let png = fs::read(pictures_beside(path).join(name)).unwrap_or_default();
                    results.pictures.push(PictureRow { png, ..*row });
                }
            }
        }
        Ok(results)
    }
}

/// The folder of the pictures of the rows at `path`.
fn pictures_beside(path: &Path) -> PathBuf {
    path.with_file_name("pictures")
}

/// Bytes of the lines that are there whole.
fn whole_lines(bytes: &[u8]) -> usize {
    bytes.iter().rposition(|b| *b == b'\n').map_or(0, |last| last + 1)
}

/// Rows that are finished, in memory and in their file.
#[derive(Debug)]
pub struct Rows {
    path: PathBuf,
    file: File,
    results: Results,
}

impl Rows {
    /// A new file at `path`; one that is there already gets `.old` at its name's end.
    ///
    /// # Errors
    /// [`RowsError::Io`].
    pub fn create(path: &Path, header: &Header) -> Result<Self> {
        let io = |doing| move |source| RowsError::Io { doing, path: path.to_owned(), source };
        if path.exists() {
            let mut old = path.as_os_str().to_owned();
            old.push(".old");
            fs::rename(path, old).map_err(io("rename"))?;
        }
        let file = OpenOptions::new().append(true).create_new(true).open(path).map_err(io("make"))?;
        let mut rows = Self::of(path, file, header);
        rows.write(&Line::Header(Box::new(header.clone())))?;
        Ok(rows)
    }

    fn of(path: &Path, file: File, header: &Header) -> Self {
        Self { path: path.to_owned(), file, results: Results::new(header.clone()) }
    }

    /// What there is.
    pub fn results(&self) -> &Results {
        &self.results
    }

    /// What the run is about, as its first part has it.
    pub fn header(&self) -> &Header {
        &self.results.header
    }

    /// Goes on with the file at `path`, or begins it where there is none. A last line that was cut off is dropped.
    ///
    /// # Errors
    /// The file is damaged, or of another run than `header` says.
    pub fn resume(path: &Path, header: &Header) -> Result<Self> {
        let io = |doing| move |source| RowsError::Io { doing, path: path.to_owned(), source };
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Self::create(path, header),
            Err(e) => return Err(io("read")(e)),
        };
        let whole = whole_lines(&bytes);
        if whole == 0 {
            return Self::create(path, header);
        }
        let file = OpenOptions::new().append(true).open(path).map_err(io("write"))?;
        file.set_len(whole as u64).map_err(io("write"))?;
        let results = Results::parse(path, &bytes[..whole])?;
        if let Some([what, there, here]) = results.header.difference(header) {
            let (what, there, here) = (what.into(), there.into(), here.into());
            return Err(RowsError::Other { path: path.to_owned(), what, there, here });
        }
        Ok(Self { path: path.to_owned(), file, results })
    }

    fn write(&mut self, line: &Line) -> Result<()> {
        let io = |source| RowsError::Io { doing: "write", path: self.path.clone(), source };
        let mut text = serde_json::to_vec(line).map_err(|e| io(e.into()))?;
        text.push(b'\n');
        // One write, so that a line is there whole or is the last and cut off.
        self.file.write_all(&text).and_then(|()| self.file.sync_data()).map_err(io)
    }

    /// Adds a finished build.
    ///
    /// # Errors
    /// [`RowsError::Io`].
    pub fn push_build(&mut self, row: BuildRow) -> Result<()> {
        let line = Line::Build(Box::new(row));
        self.write(&line)?;
        if let Line::Build(row) = line {
            self.results.builds.push(*row);
        }
        Ok(())
    }

    /// Adds a finished set of rays.
    ///
    /// # Errors
    /// [`RowsError::Io`].
    pub fn push_rays(&mut self, row: RayRow) -> Result<()> {
        let line = Line::Rays(Box::new(row));
        self.write(&line)?;
        if let Line::Rays(row) = line {
            self.results.rays.push(*row);
        }
        Ok(())
    }

    /// Adds a finished picture.
    ///
    /// # Errors
    /// [`RowsError::Io`].
    pub fn push_image(&mut self, row: ImageRow) -> Result<()> {
        let line = Line::Image(Box::new(row));
        self.write(&line)?;
        if let Line::Image(row) = line {
            self.results.images.push(*row);
        }
        Ok(())
    }

    /// Writes a picture's file, and adds its row.
    ///
    /// # Errors
    /// [`RowsError::Io`].
    pub fn push_picture(&mut self, row: PictureRow) -> Result<()> {
        let folder = pictures_beside(&self.path);
        let path = folder.join(&row.file);
        let io = |source| RowsError::Io { doing: "write", path: path.clone(), source };
        fs::create_dir_all(&folder).map_err(io)?;
        let mut file = tempfile::NamedTempFile::new_in(&folder).map_err(io)?;
        file.write_all(&row.png).map_err(io)?;
        file.persist(&path).map_err(|e| io(e.error))?;
        let line = Line::Picture(Box::new(row));
        self.write(&line)?;
        if let Line::Picture(row) = line {
            self.results.pictures.push(*row);
        }
        Ok(())
    }

    /// Rows there are.
    pub fn count(&self) -> usize {
        self.results.count()
    }

    /// Whether the row of `key` is there.
    pub fn has(&self, key: &Key) -> bool {
        match &key.rays {
            None => self.build(key).is_some(),
            Some(_) => {
                let Results { images, pictures, .. } = &self.results;
                let image = || images.iter().any(|r| r.key() == *key);
                self.rays(key).is_some() || image() || pictures.iter().any(|r| r.key() == *key)
            }
        }
    }

    /// The build of `key`.
    pub fn build(&self, key: &Key) -> Option<&BuildRow> {
        self.results.builds.iter().find(|r| r.key() == *key)
    }

    /// The rays of `key`.
    pub fn rays(&self, key: &Key) -> Option<&RayRow> {
        self.results.rays.iter().find(|r| r.key() == *key)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn header(commit: &str) -> Header {
        let costs = Costs { boxes: 0.1, oriented: 0.1 + 0.2, triangles: 0.7 };
        let (device, driver, commit, plan) = ("d".into(), "v".into(), commit.into(), "p".into());
        Header { device, driver, commit, plan, costs, order: Order::default(), command: vec![] }
    }

    fn row(scene: &str) -> BuildRow {
        BuildRow {
            scene: scene.into(),
            builder: "ploc".into(),
            triangles: 7,
            build_ms: Spread::of(&[0.1, 0.3]),
            build_wall_ms: Spread::of(&[0.7]),
            bvh_bytes: 1,
            scratch_bytes: 2,
            survey: Some(Survey {
                tree: Stats { sah: 1.0 / 3.0, area_by_level: vec![1.0, 0.1 + 0.2], ..Stats::default() },
                quality: Quality { epo: 0.7, ..Quality::default() },
                tight: Tightness { cost: 0.1 + 0.2, ..Tightness::default() },
                mixed: Some(Mixed { cost: 1.0 / 3.0, aabb_cost: 0.7 }),
                excess: None,
                tree_hash: "ff".into(),
            }),
            kernels: vec![KernelTime { name: "a/b".into(), count: 1, ms: 0.1 }],
            explain: vec!["said".into()],
        }
    }

    fn key(scene: &str) -> Key {
        Key { scene: scene.into(), builder: "ploc".into(), rays: None }
    }

    #[test]
    fn rows_outlive_a_cut() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rows.jsonl");
        let mut rows = Rows::create(&path, &header("c")).unwrap();
        rows.push_build(row("a")).unwrap();
        let kept = fs::metadata(&path).unwrap().len();
        rows.push_build(row("b")).unwrap();
        let whole = fs::read(&path).unwrap();
        // Cut anywhere within the last line: the first row is there, bit for bit, and the second can be added anew.
        for length in [kept, kept + 1, whole.len() as u64 - 1] {
            fs::write(&path, &whole[..length as usize]).unwrap();
            let mut again = Rows::resume(&path, &header("c")).unwrap();
            assert_eq!((again.count(), again.build(&key("a"))), (1, Some(&row("a"))));
            assert!(!again.has(&key("b")));
            again.push_build(row("b")).unwrap();
            assert_eq!(fs::read(&path).unwrap(), whole);
        }
        fs::write(&path, &whole[..5]).unwrap();
        assert_eq!(Rows::resume(&path, &header("c")).unwrap().count(), 0);
    }

    #[test]
    fn costs_are_those_of_the_run_that_began() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rows.jsonl");
        Rows::create(&path, &header("c")).unwrap();
        let anew = Header { costs: Costs::book(), ..header("c") };
        assert_eq!(Rows::resume(&path, &anew).unwrap().header(), &header("c"));
        assert_eq!(Rows::create(&path, &anew).unwrap().header(), &anew);
    }

    #[test]
    fn rows_of_another_run_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rows.jsonl");
        Rows::create(&path, &header("c")).unwrap().push_build(row("a")).unwrap();
        let error = Rows::resume(&path, &header("x")).unwrap_err().to_string();
        assert!(error.contains("its commit is c, and here it is x"), "{error}");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replace("bvh_bytes", "bvh_bites")).unwrap();
        assert!(Rows::resume(&path, &header("c")).unwrap_err().to_string().contains("line 2"));
        assert_eq!(Rows::create(&path, &header("c")).unwrap().count(), 0);
        assert!(dir.path().join("rows.jsonl.old").exists());
    }
}
