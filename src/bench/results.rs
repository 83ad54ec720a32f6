//! What a run measured, as its file has it: a line of JSON a row, after one that says what was measured on what.

use super::images::ImageRow;
use super::pictures::PictureRow;
use super::row::{BuildRow, Header, RayRow};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::{fs, io};

/// A line of the file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "row", rename_all = "lowercase")]
pub(super) enum Line {
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
    /// Another process adds to it.
    #[error("another boxwood writes {}: wait until it is done, or give another --out", path.display())]
    Busy {
        /// The file.
        path: PathBuf,
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

pub(super) type Result<T> = std::result::Result<T, RowsError>;

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
    pub(super) fn new(header: Header) -> Self {
        Self { header, builds: vec![], rays: vec![], images: vec![], pictures: vec![] }
    }

    /// Of the file of rows at `path`; a last line that was cut off is left out.
    ///
    /// # Errors
    /// It can't be read, or holds a line that is none of ours.
    pub fn read(path: &Path) -> Result<Self> {
        let io = |source| RowsError::Io { doing: "read", path: path.to_owned(), source };
        let bytes = fs::read(path).map_err(io)?;
        let mut results = Self::parse(path, &bytes[..whole_lines(&bytes)])?;
        results.read_pictures(path);
        Ok(results)
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
        self.pictures
            .iter()
            .filter_map(move |row| Some((folder.join(Path::new(&row.file).file_name()?), &row.png[..])))
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

    /// Of `bytes`, whole lines that are in the file of rows at `path`; the files of its pictures are not read.
    ///
    /// # Errors
    /// [`RowsError::Line`]: a line that is none of ours.
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self> {
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
                    // Taken again, where its file was lost.
                    results.pictures.retain(|r| r.key() != row.key());
                    results.pictures.push(*row);
                }
            }
        }
        Ok(results)
    }

    /// Reads the files of its pictures, where its rows are at `path`; without its file a picture counts as not taken.
    pub(super) fn read_pictures(&mut self, path: &Path) {
        self.pictures.retain_mut(|row| {
            // A name, not a way to elsewhere.
            let name = Path::new(&row.file).file_name().unwrap_or_default();
            let file = pictures_beside(path).join(name);
            let read = fs::read(&file);
            if let Err(e) = &read {
                let (file, what) = (file.display(), row.key());
                tracing::warn!("can't read {file}: {e}; {what} is left out: `bench --resume` takes it again");
            }
            row.png = read.unwrap_or_default();
            !row.png.is_empty()
        });
    }
}

/// The folder of the pictures of the rows at `path`.
pub(super) fn pictures_beside(path: &Path) -> PathBuf {
    path.with_file_name("pictures")
}

/// Bytes of the lines that are there whole.
pub(super) fn whole_lines(bytes: &[u8]) -> usize {
    bytes.iter().rposition(|b| *b == b'\n').map_or(0, |last| last + 1)
}
