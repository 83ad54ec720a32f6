//! Rows as they are finished: each goes to its file at once, and a run that was cut off goes on from there.

use super::images::ImageRow;
use super::pictures::PictureRow;
use super::plan::Key;
use super::results::{Line, Result, Results, RowsError, pictures_beside, whole_lines};
use super::row::{BuildRow, Header, RayRow};
use crate::output;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Rows that are finished, in memory and in their file, which this process alone writes.
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
    /// [`RowsError::Io`], and [`RowsError::Busy`] where another process writes it.
    pub fn create(path: &Path, header: &Header) -> Result<Self> {
        let io = |doing| move |source| RowsError::Io { doing, path: path.to_owned(), source };
        if path.exists() {
            held(path, &File::open(path).map_err(io("read"))?)?;
            let mut old = path.as_os_str().to_owned();
            old.push(".old");
            fs::rename(path, old).map_err(io("rename"))?;
        }
        let file = OpenOptions::new().append(true).create_new(true).open(path).map_err(io("make"))?;
        held(path, &file)?;
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
    /// The file is damaged, of another run than `header` says, or written by another process.
    pub fn resume(path: &Path, header: &Header) -> Result<Self> {
        let io = |doing| move |source| RowsError::Io { doing, path: path.to_owned(), source };
        let file = match OpenOptions::new().append(true).open(path) {
            Ok(file) => file,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Self::create(path, header),
            Err(e) => return Err(io("write")(e)),
        };
        held(path, &file)?;
        let bytes = fs::read(path).map_err(io("read"))?;
        let whole = whole_lines(&bytes);
        if whole == 0 {
            drop(file);
            return Self::create(path, header);
        }
        file.set_len(whole as u64).map_err(io("write"))?;
        let mut results = Results::parse(path, &bytes[..whole])?;
        results.read_pictures(path);
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
        let before = self.file.metadata().map_err(io)?.len();
        // One write, so that a line is there whole or is the last and cut off.
        self.file.write_all(&text).and_then(|()| self.file.sync_data()).map_err(|e| {
            // What the disk had no room for; `resume` drops it too, where even that fails.
            let _ = self.file.set_len(before);
            io(e)
        })
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
        output::write(&path, &row.png).map_err(io)?;
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

/// Takes `file`, at `path`, for this process, until it is closed. Where locks are not known nobody is kept out.
fn held(path: &Path, file: &File) -> Result<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(RowsError::Busy { path: path.to_owned() }),
        _ => Ok(()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bench::{Costs, KernelTime, Order, Spread, Survey};
    use crate::oracle::mixed::Mixed;
    use crate::oracle::quality::Quality;
    use crate::oracle::tight::Tightness;
    use crate::oracle::validate::Stats;

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
        drop(rows);
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
    fn rows_as_deep_as_one_likes_are_refused() {
        for text in [
            "[".repeat(100_000),
            "{\"row\":".repeat(100_000),
            "{\"row\":\"header\",\"x\":".to_owned() + &"[".repeat(100_000),
        ] {
            assert!(
                Results::parse(Path::new("rows.jsonl"), text.as_bytes())
                    .unwrap_err()
                    .to_string()
                    .contains("line 1")
            );
        }
    }

    #[test]
    fn one_process_writes() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rows.jsonl");
        let mut rows = Rows::create(&path, &header("c")).unwrap();
        rows.push_build(row("a")).unwrap();
        let before = fs::read(&path).unwrap();
        for other in [Rows::create(&path, &header("c")), Rows::resume(&path, &header("c"))] {
            let error = other.unwrap_err().to_string();
            assert!(error.contains("another boxwood writes") && error.contains("rows.jsonl"), "{error}");
        }
        assert!(fs::read(&path).unwrap() == before && !dir.path().join("rows.jsonl.old").exists());
        drop(rows);
        assert_eq!(Rows::resume(&path, &header("c")).unwrap().count(), 1);
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
