//! The command line: arguments, one file a subcommand, exit codes. Knows everything; nothing knows it.
//!
//! JSON and tables go to stdout, remarks, progress and errors to stderr. Exit code 0: done; 1: it failed, or a check
//! found a fault; 2: the arguments make no sense. A signal ends it at once, as any program: no file is then there in
//! part (see [`crate::output`]).

mod bench;
mod boxes;
mod build;
mod check;
mod choices;
mod compare;
mod devices;
mod explain;
mod files;
mod fits;
mod layouts;
mod profile;
mod query;
mod render;
mod report;
mod scenes;
mod stress;
mod tree;
mod values;

use crate::bvh::{Builder, require_memory};
use crate::device::{Device, Faults, Options};
use crate::scene::{self, Progress, Scene, printable};
use anyhow::Result;
use choices::{SceneArgs, TransformArgs};
use clap::{ArgAction, Args, Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use tracing_subscriber::EnvFilter;

/// Bounding volume hierarchies built and traced by Vulkan compute shaders, and measured honestly.
#[derive(Debug, Parser)]
#[command(name = "boxwood", version = concat!(env!("CARGO_PKG_VERSION"), " (", env!("BOXWOOD_COMMIT"), ")"))]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

/// What every subcommand takes.
#[derive(Debug, Args)]
struct Global {
    /// Device to use: its number or part of its name, see `boxwood devices`. Default: a real GPU before a software one.
    #[arg(long, global = true, value_name = "NAME|N")]
    device: Option<String>,
    /// No progress bars and no remarks; warnings and errors only.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Say more on stderr; twice: even more. RUST_LOG has the last word.
    #[arg(short, long, global = true, action = ArgAction::Count)]
    verbose: u8,
}

#[derive(Debug, Subcommand)]
enum Command {
    Devices(devices::Args),
    Build(build::Args),
    Query(query::Args),
    Render(render::Args),
    Boxes(boxes::Args),
    Bench(bench::Args),
    Compare(compare::Args),
    Report(report::Args),
    Fits(fits::Args),
    Layouts(layouts::Args),
    Profile(profile::Args),
    Stress(stress::Args),
    Scenes(scenes::Args),
}

/// Runs the command that the arguments name.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    log(cli.global.verbose);
    fail_at_file_size_limit();
    let done = match &cli.command {
        Command::Devices(args) => devices::run(&cli.global, args),
        Command::Build(args) => build::run(&cli.global, args),
        Command::Query(args) => query::run(&cli.global, args),
        Command::Render(args) => render::run(&cli.global, args),
        Command::Boxes(args) => boxes::run(&cli.global, args),
        Command::Bench(args) => bench::run(&cli.global, args),
        Command::Compare(args) => compare::run(args),
        Command::Report(args) => report::run(&cli.global, args),
        Command::Fits(args) => fits::run(&cli.global, args),
        Command::Layouts(args) => layouts::run(&cli.global, args),
        Command::Profile(args) => profile::run(&cli.global, args),
        Command::Stress(args) => stress::run(&cli.global, args),
        Command::Scenes(args) => scenes::run(&cli.global, args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) if closed_pipe(&e) => ExitCode::SUCCESS,
        Err(e) => {
            // All files are written by name, so what has none is stdout.
            let to =
                if e.is::<std::io::Error>() && e.chain().len() == 1 { "can't write to stdout: " } else { "" };
            eprintln!("error: {to}{}", printable(&in_one_line(&e)));
            ExitCode::FAILURE
        }
    }
}

/// Has a write beyond the limit of file sizes (`ulimit -f`) fail, as one to a full disk does: without a handler the signal
/// ends the program, and nobody learns why.
fn fail_at_file_size_limit() {
    #[cfg(unix)]
    {
        let seen = Arc::default();
        // Where it can't be registered all is as it was.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, seen);
    }
}

/// Sends the library's log to stderr: warnings, unless asked for more.
fn log(verbose: u8) {
    let level = match verbose {
        0 => "warn",
        1 => "boxwood=info,warn",
        _ => "boxwood=debug,info",
    };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(level));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).without_time().init();
}

/// Whether nobody reads stdout any more, as with `| head`: no failure of ours.
fn closed_pipe(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    io.is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

/// An error and its causes, leaving out a cause that the words before it already quote.
fn in_one_line(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |line, cause| match line.as_str() {
        "" => cause,
        said if said.contains(&cause) => line,
        _ => format!("{line}: {cause}"),
    })
}

impl Global {
    fn open_device(&self) -> Result<Arc<Device>> {
        let (device, faults) = (self.device.clone(), Faults::from_env()?);
        let device = Device::open(&Options { device, faults, ..Options::from_env() })?;
        tracing::info!("{}, {}", device.info().name, device.info().driver);
        Ok(device)
    }

    fn progress(&self) -> Progress {
        if self.quiet { Progress::Quiet } else { Progress::Bars }
    }

    fn scene_options(&self) -> scene::Options {
        scene::Options { progress: self.progress(), cache: None }
    }

    /// Where fetched scenes and the device's costs are kept; none where there is no home directory.
    fn cache(&self) -> Option<PathBuf> {
        scene::cache_folder(&self.scene_options())
    }

    fn open_scene(&self, args: &SceneArgs) -> Result<Scene> {
        self.open(&args.spec, &args.transform)
    }

    fn open(&self, spec: &str, transform: &TransformArgs) -> Result<Scene> {
        let scene = transform.transform().apply(scene::open(spec, &self.scene_options())?)?;
        warn_of(&scene);
        Ok(scene)
    }

    /// Likewise, to build over it with the builder `by`; refused before it is made or fetched where the device has no room.
    fn open_for(&self, spec: &str, transform: &TransformArgs, device: &Device, by: Builder) -> Result<Scene> {
        if let Some(triangles) = scene::triangles_of(spec) {
            require_memory(device, by, triangles)?;
        }
        self.open(spec, transform)
    }

    fn open_scene_for(&self, args: &SceneArgs, device: &Device, by: Builder) -> Result<Scene> {
        self.open_for(&args.spec, &args.transform, device, by)
    }

    /// A line on stderr, unless `--quiet`.
    fn remark(&self, line: impl std::fmt::Display) {
        if !self.quiet {
            eprintln!("{}", printable(&line.to_string()));
        }
    }
}

/// Logs what was odd about a scene.
fn warn_of(scene: &Scene) {
    for w in &scene.warnings {
        tracing::warn!("{}: {} {} (first: {})", scene.name, w.count, w.what, w.first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn arguments_are_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn causes_are_said_once() {
        let e = anyhow::anyhow!("no such file").context("can't read a: no such file").context("loading");
        assert_eq!(in_one_line(&e), "loading: can't read a: no such file");
    }
}
