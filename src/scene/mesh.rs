//! What the readers share: a file in memory, faces that become triangles, the last checks.

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use rayon::prelude::*;

use super::{MAX_TRIANGLES, Progress, Scene, SceneError, Warning, memory};

/// Bytes read between two steps of the bar.
const CHUNK: usize = 4 << 20;

/// The whole of a regular file.
///
/// # Errors
/// [`SceneError::Read`] for a missing file, a directory, a device, a pipe, and where reading fails.
pub(super) fn read(path: &Path, progress: Progress) -> Result<Vec<u8>, SceneError> {
    let fail = |source, fix| SceneError::Read { path: path.to_owned(), source, fix };
    let meta = std::fs::metadata(path).map_err(|e| fail(e, "check the path"))?;
    if !meta.is_file() {
        let kind = if meta.is_dir() { "it is a directory" } else { "it is not a regular file" };
        return Err(fail(io::Error::new(io::ErrorKind::InvalidInput, kind), "name a mesh file"));
    }
    let mut file = File::open(path).map_err(|e| fail(e, "check its permissions"))?;
    let mut bytes = Vec::new();
    let size = usize::try_from(meta.len()).unwrap_or(usize::MAX);
    let too_large = |what| SceneError::TooLarge { name: path.display().to_string(), what };
    memory::must_hold(meta.len()).map_err(|why| too_large(format!("its contents {why}")))?;
    bytes.try_reserve_exact(size).map_err(|_| too_large(format!("its {size} bytes don't fit in memory")))?;
    let bar = progress.bytes(format!("reading {}", path.display()), meta.len());
    loop {
        let got = (&mut file)
            .take(CHUNK as u64)
            .read_to_end(&mut bytes)
            .map_err(|e| fail(e, "copy it to a sound disk"))?;
        bar.set_position(bytes.len() as u64);
        if got == 0 {
            bar.finish_and_clear();
            return Ok(bytes);
        }
    }
}

/// Where in a file: `face 12 (line 40)`, `line 40`. Faces and vertices count from 0, lines from 1, bytes from 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Element and its number.
    pub(super) item: Option<(&'static str, u64)>,
    /// Line or byte.
    pub(super) unit: &'static str,
    pub(super) at: u64,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.item {
            Some((element, n)) => write!(f, "{element} {n} ({} {})", self.unit, self.at),
            None => write!(f, "{} {}", self.unit, self.at),
        }
    }
}

/// Something odd, counted, with the first place it was seen.
#[derive(Default)]
pub(super) struct Tally {
    count: u64,
    first: Option<Place>,
}

impl Tally {
    pub(super) fn add(&mut self, place: Place) {
        self.count += 1;
        self.first.get_or_insert(place);
    }

    /// The warning, if anything was counted.
    pub(super) fn warning(&self, what: &str) -> Option<Warning> {
        let first = self.first?;
        Some(Warning { what: what.to_owned(), count: self.count, first: first.to_string() })
    }
}

/// Polygons, cut into fans as they come.
#[derive(Default)]
pub(super) struct Faces {
    triangles: Vec<[u32; 3]>,
    short: Tally,
    /// The largest index and where it stood. Checked at the end, for faces may come before their vertices.
    largest: Option<(u32, Place)>,
}

impl Faces {
    /// Makes room for `n` triangles, as far as memory allows; `n` must be bounded by the file's size.
    pub(super) fn reserve(&mut self, n: usize) {
        // A failure here comes back at the push that needs the room.
        let _ = self.triangles.try_reserve(n);
    }

    /// Takes a face, 0-based. Fewer than three corners: left out and counted.
    pub(super) fn push(&mut self, corners: &[u32], place: Place) {
        for &c in corners {
            if self.largest.is_none_or(|(l, _)| c > l) {
                self.largest = Some((c, place));
            }
        }
        if corners.len() < 3 {
            self.short.add(place);
        }
        for w in 1..corners.len().saturating_sub(1) {
            self.triangles.push([corners[0], corners[w], corners[w + 1]]);
        }
    }

    /// The scene, once all faces and vertices are known.
    ///
    /// # Errors
    /// An index beyond the vertices, too many triangles, none at all.
    pub(super) fn finish(
        self,
        path: &Path,
        positions: Vec<[f32; 3]>,
        mut warnings: Vec<Warning>,
    ) -> Result<Scene, SceneError> {
        if let Some((largest, place)) = self.largest
            && largest as usize >= positions.len()
        {
            return Err(SceneError::invalid(
                path,
                place.to_string(),
                format!("a face names vertex {largest}, and there are {}", positions.len()),
                "the file is damaged or cut short: get it again, or mend the index",
            ));
        }
        warnings.extend(self.short.warning("faces of fewer than 3 vertices, left out"));
        scene(path, positions, self.triangles, warnings)
    }
}

/// A file without a triangle: says what it has instead.
pub(super) fn empty(path: &Path, vertices: usize, warnings: &[Warning]) -> SceneError {
    let odd: String = warnings.iter().map(|w| format!(", {} {}", w.count, w.what)).collect();
    SceneError::Empty { path: path.to_owned(), what: format!("{vertices} vertices{odd}") }
}

/// The last checks of every file: some triangles, not too many, and how many of them are not finite.
pub(super) fn scene(
    path: &Path,
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    mut warnings: Vec<Warning>,
) -> Result<Scene, SceneError> {
    if triangles.is_empty() {
        return Err(empty(path, positions.len(), &warnings));
    }
    if triangles.len() as u64 > MAX_TRIANGLES {
        let what = format!("{} triangles are more than 2^30", triangles.len());
        return Err(SceneError::TooLarge { name: path.display().to_string(), what });
    }
    let name = path.display().to_string();
    let scene = Scene { name, positions, triangles, ..Scene::default() };
    let odd = |i: &usize| scene.corners(*i).iter().flatten().any(|x| !x.is_finite());
    if let Some(first) = (0..scene.triangles.len()).into_par_iter().find_first(|i| odd(i)) {
        let count = (first..scene.triangles.len()).into_par_iter().filter(odd).count() as u64;
        let what = "triangles with a NaN or infinite vertex, kept in the numbering and never hit".to_owned();
        warnings.push(Warning { what, count, first: format!("triangle {first}") });
    }
    Ok(Scene { warnings, ..scene })
}
