//! From what the user typed to a scene: a file by its extension, or a name.

use std::path::{Path, PathBuf};

use super::fetch::{self, Wanted};
use super::manifest::{Entry, Source, manifest};
use super::siblings::Siblings;
use super::{MAX_TRIANGLES, Progress, Scene, SceneError, gltf, mesh, obj, packed, ply, stl, terrain, tri};

/// How scenes are opened.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Bars on stderr while reading, fetching and generating.
    pub progress: Progress,
    /// Where fetched scenes and devices' costs are kept; none: `$BOXWOOD_CACHE`, or else boxwood's folder in the user's
    /// cache directory.
    pub cache: Option<PathBuf>,
}

/// What to type for the scenes that have a name: `dragon`, `hairball:N`. N is optional and may end in k or M.
pub fn names() -> Vec<String> {
    manifest().scenes.iter().map(Entry::spec).collect()
}

/// About how many triangles `spec` will have, where it is the name of a scene and says so.
pub fn triangles_of(spec: &str) -> Option<usize> {
    let (name, count) = spec.split_once(':').map_or((spec, None), |(name, count)| (name, Some(count)));
    let entry = manifest().entry(name)?;
    let count = count.map_or(Some(entry.triangles), |text| triangle_count(spec, name, text).ok());
    count.and_then(|n| usize::try_from(n).ok())
}

/// The files that [`open`] reads, in words.
pub const FILES: &str = "a .glb, .gltf, .obj, .ply, .stl or .tri file, plain or packed as .gz or .zst";

/// Opens a mesh file, see [`FILES`], or a scene by name: see [`names`]. It has five views.
///
/// # Errors
/// [`SceneError`]: names the file and the place in it, or what was tried to fetch a scene.
pub fn open(spec: &str, options: &Options) -> Result<Scene, SceneError> {
    let (head, count) = match spec.split_once(':') {
        Some((head, count)) => (head, Some(count)),
        None => (spec, None),
    };
    let entry = manifest().entry(head);
    let (scene, views) = match (entry, entry.map(|e| &e.source)) {
        (Some(entry), Some(Source::Generated(generator))) => {
            let count = count.map_or(Ok(entry.triangles), |text| triangle_count(spec, head, text))?;
            let scene = generator.generate(spec, count, options.progress)?;
            let views = entry.views(&scene);
            (scene, views)
        }
        (Some(entry), Some(Source::Fetched(mesh))) if count.is_none() => {
            let (path, bytes) = fetch::get(Wanted { name: head, mesh }, options)?;
            let scene = parse(&path, &bytes, Siblings::None, options.progress)?;
            let scene = Scene { name: spec.to_owned(), ..scene };
            let views = entry.views(&scene);
            (scene, views)
        }
        _ => {
            let scene = file(spec, options.progress)?;
            let views = scene.views_or_default().to_vec();
            (scene, views)
        }
    };
    Ok(Scene { views, ..scene })
}

/// Sees to it that the fetched scene `name` is in the cache and sound, and says where; nothing is fetched twice.
///
/// # Errors
/// [`SceneError::UnknownName`] for any other name; [`SceneError::Fetch`], [`SceneError::Cache`].
pub fn fetch(name: &str, options: &Options) -> Result<PathBuf, SceneError> {
    match manifest().entry(name).map(|e| &e.source) {
        Some(Source::Fetched(mesh)) => Ok(fetch::get(Wanted { name, mesh }, options)?.0),
        _ => {
            let fetched = |e: &&Entry| matches!(e.source, Source::Fetched(_));
            let known: Vec<_> = manifest().scenes.iter().filter(fetched).map(Entry::spec).collect();
            Err(SceneError::UnknownName { spec: name.to_owned(), known: known.join(", ") })
        }
    }
}

/// Whether the cache has the scene; always, where it is generated.
pub fn is_cached(entry: &Entry, options: &Options) -> bool {
    match &entry.source {
        Source::Generated(_) => true,
        Source::Fetched(mesh) => fetch::is_cached(Wanted { name: &entry.name, mesh }, options),
    }
}

fn triangle_count(spec: &str, name: &str, text: &str) -> Result<u64, SceneError> {
    let bad = |what: String| SceneError::BadSize { spec: spec.to_owned(), name: name.to_owned(), what };
    let (digits, unit) = match text.strip_suffix(['k', 'K']) {
        Some(digits) => (digits, 1_000),
        None => text.strip_suffix(['m', 'M']).map_or((text, 1), |digits| (digits, 1_000_000)),
    };
    let digits: String = digits.chars().filter(|c| !matches!(c, '_' | ',')).collect();
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return Err(bad(format!("{text:?} is no triangle count")));
    }
    match digits.parse::<u64>().ok().and_then(|n| n.checked_mul(unit)) {
        Some(0) => Err(bad("a scene needs a triangle".to_owned())),
        Some(n) if n <= MAX_TRIANGLES => Ok(n),
        _ => Err(bad(format!("{text} triangles are more than 2^30"))),
    }
}

fn file(spec: &str, progress: Progress) -> Result<Scene, SceneError> {
    let path = Path::new(spec);
    if matches!(format(path), None | Some(Format::Npz)) {
        if path.is_dir() {
            mesh::read(path, progress)?; // says that it is a directory
        }
        return Err(unknown(spec));
    }
    parse(path, &mesh::read(path, progress)?, Siblings::Of(path), progress)
}

fn unknown(spec: &str) -> SceneError {
    SceneError::UnknownName { spec: spec.to_owned(), known: names().join(", ") }
}

#[derive(Clone, Copy)]
enum Format {
    Gltf,
    /// Of terrains that are fetched alone: no mesh file.
    Npz,
    Obj,
    Ply,
    Stl,
    Tri,
}

fn format(path: &Path) -> Option<Format> {
    match packed::inside(path).extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "glb" | "gltf" => Some(Format::Gltf),
        "npz" => Some(Format::Npz),
        "obj" => Some(Format::Obj),
        "ply" => Some(Format::Ply),
        "stl" => Some(Format::Stl),
        "tri" => Some(Format::Tri),
        _ => None,
    }
}

/// Reads `bytes`, what is in the file called `path`: a mesh file, see [`FILES`], or the `.npz` of a fetched terrain.
/// Nothing but `siblings` is looked for on disk. It has no views.
///
/// # Errors
/// [`SceneError`]: names the file and the place in it.
pub fn parse(
    path: &Path,
    bytes: &[u8],
    siblings: Siblings<'_>,
    progress: Progress,
) -> Result<Scene, SceneError> {
    let Some(format) = format(path) else { return Err(unknown(&path.display().to_string())) };
    let bytes = &packed::unpack(path, bytes, progress)?;
    match format {
        Format::Gltf => gltf::parse(path, bytes, siblings, progress),
        Format::Npz => terrain::parse(path, bytes),
        Format::Obj => obj::parse(path, bytes, siblings, progress),
        Format::Ply => ply::parse(path, bytes, progress),
        Format::Stl => stl::parse(path, bytes, progress),
        Format::Tri => tri::parse(path, bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_triangles() {
        assert_eq!(triangles_of("sphere:2k"), Some(2000));
        assert_eq!(triangles_of("dragon"), Some(871_414));
        for none in ["sphere:0", "sphere:x", "a.obj", "nonesuch", "nonesuch:9"] {
            assert_eq!(triangles_of(none), None, "{none}");
        }
    }

    #[test]
    fn counts() {
        let parse = |t| triangle_count("s", "s", t).ok();
        assert_eq!(parse("1"), Some(1));
        assert_eq!(parse("500k"), Some(500_000));
        assert_eq!(parse("2M"), Some(2_000_000));
        assert_eq!(parse("1_000"), Some(1000));
        assert_eq!(parse("1073741824"), Some(1 << 30));
        for bad in
            ["", "0", "k", "-1", "1.5", "1073741825", "99999999999999999999", "18446744073709551615M", "x"]
        {
            assert_eq!(parse(bad), None, "{bad}");
        }
    }
}
