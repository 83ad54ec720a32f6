//! `boxwood scenes`: what has a name, whose it is, what is here already; fetching it; writing any scene as a mesh file.

use super::choices::SceneArgs;
use super::files::Output;
use super::{Global, in_one_line};
use crate::scene::{self, Entry, Manifest, Scene, Source, write};
use anyhow::{Result, bail};
use clap::Subcommand;
use comfy_table::{ContentArrangement, Table, presets};
use std::io::Write;
use std::path::{Path, PathBuf};

/// List, fetch and write scenes.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List the scenes that have a name, and the sets that they make.
    List {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Fetch scenes into the cache, by the clients of their registries; what is there already is left alone.
    Fetch {
        /// Names, or `all`.
        #[arg(required = true, value_name = "NAME")]
        names: Vec<String>,
    },
    /// Write a scene, generated or not, as a mesh file. Positions are written bit for bit.
    Generate {
        #[command(flatten)]
        scene: SceneArgs,
        /// File to write: binary .ply, or .tri (nine little-endian f32 a triangle).
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    match &args.action {
        Action::List { json } => list(global, *json),
        Action::Fetch { names } => fetch(global, names),
        Action::Generate { scene, out } => generate(global, scene, out),
    }
}

/// A scene, as it is listed.
#[derive(serde::Serialize)]
struct Row<'a> {
    name: &'a str,
    /// What to type, `:N` for the count.
    spec: String,
    triangles: u64,
    kind: &'static str,
    /// The package of a fetched one.
    #[serde(skip_serializing_if = "Option::is_none")]
    package: Option<String>,
    /// Whether a fetched one is in the cache.
    #[serde(skip_serializing_if = "Option::is_none")]
    cached: Option<bool>,
    what: &'a str,
    licence: &'a str,
    credit: &'a str,
}

impl<'a> Row<'a> {
    fn new(entry: &'a Entry, options: &scene::Options) -> Self {
        let fetched = match &entry.source {
            Source::Generated(_) => None,
            Source::Fetched(f) => Some(f),
        };
        Self {
            name: &entry.name,
            spec: entry.spec(),
            triangles: entry.triangles,
            kind: if fetched.is_some() { "fetched" } else { "generated" },
            package: fetched.map(|f| format!("{} {} {}", f.registry.name(), f.package, f.version)),
            cached: fetched.map(|_| scene::is_cached(entry, options)),
            what: &entry.what,
            licence: &entry.licence,
            credit: &entry.credit,
        }
    }

    fn cells(&self) -> [String; 6] {
        let here = match self.cached {
            None => "generated",
            Some(true) => "fetched, cached",
            Some(false) => "to be fetched",
        };
        let here = self.package.as_ref().map_or(here.to_owned(), |p| format!("{here}: {p}"));
        let [what, licence, credit] = [self.what, self.licence, self.credit].map(str::to_owned);
        [self.spec.clone(), self.triangles.to_string(), here, what, licence, credit]
    }
}

fn list(global: &Global, json: bool) -> Result<()> {
    let Manifest { scenes, sets } = scene::manifest();
    let options = global.scene_options();
    let rows: Vec<Row> = scenes.iter().map(|s| Row::new(s, &options)).collect();
    let mut out = std::io::stdout().lock();
    if json {
        let all = serde_json::json!({ "scenes": rows, "sets": sets });
        writeln!(out, "{}", serde_json::to_string_pretty(&all)?)?;
        return Ok(());
    }
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(["scene", "triangles", "from", "what", "licence", "credit"]);
    for row in &rows {
        table.add_row(row.cells());
    }
    writeln!(out, "{}", table.trim_fmt())?;
    writeln!(
        out,
        "\nN is a triangle count, such as 100000, 500k or 2M; without it, as many as above.\nSets:"
    )?;
    for (name, specs) in sets {
        writeln!(out, "  {name}: {}", specs.join(", "))?;
    }
    Ok(())
}

fn fetch(global: &Global, names: &[String]) -> Result<()> {
    let options = global.scene_options();
    let all = names.iter().any(|n| n == "all");
    let fetched = scene::manifest().scenes.iter().filter(|s| matches!(s.source, Source::Fetched(_)));
    let names: Vec<&str> = match all {
        true => fetched.map(|s| s.name.as_str()).collect(),
        false => names.iter().map(String::as_str).collect(),
    };
    let mut failed = vec![];
    for name in &names {
        match scene::fetch(name, &options) {
            Ok(path) => writeln!(std::io::stdout().lock(), "{name}\t{}", path.display())?,
            Err(e) if names.len() == 1 => return Err(e.into()),
            Err(e) => {
                tracing::warn!("{}", in_one_line(&e.into()));
                failed.push(*name);
            }
        }
    }
    if failed.is_empty() {
        return Ok(());
    }
    bail!("{} of {} scenes could not be fetched: {}", failed.len(), names.len(), failed.join(", "))
}

fn generate(global: &Global, args: &SceneArgs, path: &Path) -> Result<()> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let bytes: fn(&Scene) -> Vec<u8> = match extension.as_deref() {
        Some("ply") => write::ply,
        Some("tri") => write::tri,
        _ => bail!("can't write {}: give a name that ends in .ply or .tri", path.display()),
    };
    let output = Output::new(path)?;
    let scene = global.open_scene(args)?;
    output.finish(&bytes(&scene))?;
    global.remark(format_args!("{}: {} triangles, {}", path.display(), scene.triangles.len(), scene.name));
    Ok(())
}
