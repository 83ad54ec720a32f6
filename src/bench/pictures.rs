//! Pictures beside the rows: the scene as it looks, and what each builder's tree costs the ray of each pixel.

use super::plan::Key;
use super::run::{Progress, Stage};
use super::{Costs, Result, Rows};
use crate::abi::Tests;
use crate::picture::{PictureError, heat_map, scale_end};
use serde::{Deserialize, Serialize};

/// A picture of a scene's first view, in a file beside the rows.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PictureRow {
    /// As the plan has it.
    pub scene: String,
    /// Whose rays' costs it maps; empty: it shows the scene.
    pub builder: String,
    /// Name of the PNG file in the folder `pictures` beside the rows.
    pub file: String,
    /// Of a map: what a ray's tests cost in the mean, ns.
    pub mean_ns: f64,
    /// The file's bytes.
    #[serde(skip)]
    pub png: Vec<u8>,
}

impl PictureRow {
    /// What it is about.
    pub fn key(&self) -> Key {
        Key::picture(&self.scene, &self.builder)
    }
}

/// Takes the pictures of the scene that `rows` lacks.
pub(super) fn take(stage: &Stage, size: [u32; 2], rows: &mut Rows, progress: Progress) -> Result<()> {
    let trees: Vec<_> = stage.own_trees().collect();
    let missing = |rows: &Rows, builder: &str| !rows.has(&Key::picture(stage.spec, builder));
    let mut builders = std::iter::once("").chain(trees.iter().map(|(c, _)| c.name.as_str()));
    let Some((_, first)) = trees.first().filter(|_| builders.any(|b| missing(rows, b))) else {
        return Ok(());
    };
    progress(&format!("{}: pictures", stage.spec), rows);
    let studio = stage.studio(size, first)?;
    // Numbers, not names: what files may be called differs from system to system.
    let scene = stage.plan.scenes.iter().position(|s| s == stage.spec).unwrap_or(0) + 1;
    if missing(rows, "") {
        let row = PictureRow { scene: stage.spec.to_owned(), ..PictureRow::default() };
        let png = studio.shaded().png().map_err(PictureError::from)?;
        rows.push_picture(PictureRow { file: format!("{scene}.png"), png, ..row })?;
    }
    let maps = trees.iter().map(|(_, tree)| Ok(nanoseconds(&studio.tests(tree)?, stage.costs)));
    let maps = maps.collect::<Result<Vec<_>>>()?;
    // One scale, so that trees can be compared.
    let end = maps.iter().map(|map| scale_end(map)).fold(0.0, f64::max);
    for ((contender, _), map) in trees.iter().zip(&maps) {
        if missing(rows, &contender.name) {
            let place = stage.plan.contenders.iter().position(|c| c.name == contender.name).unwrap_or(0) + 1;
            let png = heat_map(size[0] as usize, map, "ns a ray", end).png().map_err(PictureError::from)?;
            rows.push_picture(PictureRow {
                scene: stage.spec.to_owned(),
                builder: contender.name.clone(),
                file: format!("{scene}-{place}.png"),
                mean_ns: map.iter().map(|ns| f64::from(*ns)).sum::<f64>() / map.len().max(1) as f64,
                png,
            })?;
        }
    }
    Ok(())
}

/// What the tests of each pixel's ray cost.
fn nanoseconds(tests: &[Tests], costs: Costs) -> Vec<f32> {
    let [boxes, oriented, triangles] = costs.to_array();
    let cost = |t: &Tests| {
        f64::from(t.boxes) * boxes + f64::from(t.oriented) * oriented + f64::from(t.triangles) * triangles
    };
    tests.iter().map(|t| cost(t) as f32).collect()
}
