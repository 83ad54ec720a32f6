//! `boxwood boxes`: the boxes of a level of a scene's tree, as a picture and as meshes for programs that model
//! \[VEVERKOVA24\].

mod picture;
mod shown;

use super::Global;
use super::choices::{RecipeArgs, SceneArgs};
use super::files::{Output, emit};
use super::render::ViewArgs;
use crate::bvh::{Level, SceneBuffers, build};
use crate::device::Timing;
use crate::scene::write::{glb, mtl, obj};
use anyhow::{Result, bail};
use shown::{Kind, Shown};
use std::path::PathBuf;

/// Draw the boxes of a level of a scene's tree, or write them as meshes: axis-aligned ones blue, oriented ones orange.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Which boxes: 0 is the scene's, N those N steps below and of leaves on the way; `leaves` is all leaves'. Nodes are
    /// packed, with up to four children: a level is about two of a binary tree's.
    #[arg(long, value_name = "N|leaves", value_parser = level, allow_hyphen_values = true)]
    level: Level,
    /// A picture (.png), or a mesh (.glb, or .obj and its .mtl); may be given several times.
    #[arg(long, required = true, value_name = "PNG|GLB|OBJ")]
    out: Vec<PathBuf>,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Write the JSON to this file as well.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

fn level(text: &str) -> Result<Level, String> {
    if text == "leaves" {
        return Ok(Level::Leaves);
    }
    let number = text.parse().map(Level::Depth);
    number.map_err(|_| "write a whole number from 0, the scene's box, or leaves".to_owned())
}

/// A file to be written.
enum File<'p> {
    Picture(Output<'p>),
    Glb(Output<'p>),
    /// Mesh, materials, and the name of their file.
    Obj(Output<'p>, Output<'p>, String),
}

impl<'p> File<'p> {
    /// Prepares to write `path`, and `library` where materials get a file.
    fn new((path, library): &'p (PathBuf, PathBuf)) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("png") => Ok(Self::Picture(Output::new(path)?)),
            Some("glb") => Ok(Self::Glb(Output::new(path)?)),
            Some("obj") => {
                let name = library.file_name().unwrap_or_default().to_string_lossy().into_owned();
                Ok(Self::Obj(Output::new(path)?, Output::new(library)?, name))
            }
            _ => bail!("can't write {}: give a name that ends in .png, .glb or .obj", path.display()),
        }
    }
}

/// What is reported.
#[derive(serde::Serialize)]
struct Report<'a> {
    device: &'a str,
    commit: &'static str,
    scene: &'a str,
    builder: &'static str,
    fit: &'static str,
    /// As typed.
    level: String,
    boxes: usize,
    oriented: usize,
    /// Those of leaves.
    leaves: usize,
    /// Of the boxes' surfaces.
    triangles: usize,
    /// Sum of the boxes' areas, over that of the scene's.
    area: f64,
    files: &'a [PathBuf],
}

/// Runs the command.
pub(super) fn run(global: &Global, args: &Args) -> Result<()> {
    let beside = |path: &PathBuf| (path.clone(), path.with_extension("mtl"));
    let paths: Vec<(PathBuf, PathBuf)> = args.out.iter().map(beside).collect();
    let files = paths.iter().map(File::new).collect::<Result<Vec<_>>>()?;
    let json = args.json.as_deref().map(Output::new).transpose()?;

    let device = global.open_device()?;
    let recipe = args.recipe.recipe(global, &device)?;
    let scene = global.open_scene_for(&args.scene, &device, recipe.builder)?;
    let buffers = SceneBuffers::upload(&device, &scene)?;
    let bvh = build(&device, &buffers, &recipe, Timing::Off)?.bvh;
    let shown = Shown::new(&bvh, args.level)?;
    if shown.boxes.is_empty() {
        bail!("{}: no triangle of it can be hit, so its tree has no box", scene.name);
    }
    shown.remark(global);
    // All that can fail on the device comes before the first file.
    let mut picture = vec![];
    if files.iter().any(|file| matches!(file, File::Picture(_))) {
        picture = picture::draw(&device, &scene, &bvh, &shown, args.view.of(&scene))?.png()?;
    }
    for (file, (path, library)) in files.into_iter().zip(&paths) {
        match file {
            File::Picture(output) => output.finish(&picture)?,
            File::Glb(output) => output.finish(&glb(&shown.title(), &shown.parts())?)?,
            File::Obj(output, materials, name) => {
                let parts = shown.parts();
                materials.finish(&mtl(&parts))?;
                global.remark(library.display());
                output.finish(&obj(&parts, &name))?;
            }
        }
        global.remark(path.display());
    }
    let report = Report {
        device: &device.info().name,
        commit: env!("BOXWOOD_COMMIT"),
        scene: &scene.name,
        builder: recipe.builder.name(),
        fit: recipe.fit.name(),
        level: shown.level(),
        boxes: shown.boxes.len(),
        oriented: shown.count(Kind::Oriented),
        leaves: shown.leaves(),
        triangles: 12 * shown.boxes.len(),
        area: shown.area,
        files: &args.out,
    };
    emit(&report, json)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_numbers_or_leaves() {
        assert_eq!((level("0"), level("17")), (Ok(Level::Depth(0)), Ok(Level::Depth(17))));
        assert_eq!(level("leaves"), Ok(Level::Leaves));
        for bad in ["", "-1", "1.5", "leaf", "99999999999"] {
            assert!(level(bad).is_err_and(|e| e.contains("leaves")), "{bad}");
        }
    }
}
