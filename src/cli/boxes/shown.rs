//! The boxes that are shown: what they are, their colours, their surfaces.

use crate::bvh::{Bvh, Child, FACES, Level, NodeBox, PlacedBox};
use crate::cli::Global;
use crate::picture::oklch;
use crate::scene::Scene;
use crate::scene::write::{Part, halves};
use anyhow::Result;
use glam::Vec3;

/// How much of what is behind it a box of a mesh hides.
const OPACITY: f32 = 0.4;

/// Which way a box stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Aligned,
    Oriented,
}

impl Kind {
    pub(super) const ALL: [Self; 2] = [Self::Aligned, Self::Oriented];

    /// For people.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Aligned => "axis-aligned",
            Self::Oriented => "oriented",
        }
    }

    /// Its colours, linear light, by a share in [0, 1]: blues from green to violet, or orange from red to yellow. Blue and
    /// orange stay apart for colour-blind eyes.
    pub(super) fn color(self, share: f32) -> Vec3 {
        let (lightness, chroma, hue) = match self {
            Self::Aligned => (0.56, 0.15, 225.0 + 60.0 * share),
            Self::Oriented => (0.66, 0.17, 25.0 + 60.0 * share),
        };
        oklch(lightness, chroma, hue).clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// The boxes of a level, where they stand.
pub(super) struct Shown {
    level: Level,
    pub(super) boxes: Vec<NodeBox>,
    /// One a box.
    pub(super) placed: Vec<PlacedBox>,
    /// Sum of their areas, over that of the scene's box.
    pub(super) area: f64,
}

impl Shown {
    pub(super) fn new(bvh: &Bvh, level: Level) -> Result<Self> {
        let tree = bvh.read()?;
        let area = |boxes: &[NodeBox]| boxes.iter().map(|b| b.volume.half_area()).sum::<f64>();
        let whole = area(&tree.boxes(Level::Depth(0), &bvh.bounds));
        let boxes = tree.boxes(level, &bvh.bounds);
        let placed = boxes.iter().map(|b| PlacedBox::of(bvh, &b.volume)).collect();
        let area = if whole > 0.0 { area(&boxes) / whole } else { 0.0 };
        Ok(Self { level, boxes, placed, area })
    }

    pub(super) fn kind(&self, i: usize) -> Kind {
        if self.boxes[i].volume.frame.is_some() { Kind::Oriented } else { Kind::Aligned }
    }

    /// Boxes of that kind.
    pub(super) fn count(&self, kind: Kind) -> usize {
        (0..self.boxes.len()).filter(|i| self.kind(*i) == kind).count()
    }

    /// Leaves' boxes.
    pub(super) fn leaves(&self) -> usize {
        self.boxes.iter().filter(|b| matches!(b.child, Child::Leaf { .. })).count()
    }

    /// The level as typed.
    pub(super) fn level(&self) -> String {
        match self.level {
            Level::Depth(depth) => depth.to_string(),
            Level::Leaves => "leaves".to_owned(),
        }
    }

    /// What is shown, in a few words.
    pub(super) fn title(&self) -> String {
        let level = match self.level {
            Level::Depth(depth) => format!("level {depth}"),
            Level::Leaves => "leaves".to_owned(),
        };
        let n = self.boxes.len();
        format!(
            "{level}: {n} box{}, area {:.3} of the scene's box",
            if n == 1 { "" } else { "es" },
            self.area
        )
    }

    /// For people: what is shown, and that there is nothing deeper.
    pub(super) fn remark(&self, global: &Global) {
        let (oriented, leaves) = (self.count(Kind::Oriented), self.leaves());
        global.remark(format_args!("{}; {oriented} oriented, {leaves} leaves", self.title()));
        let deepest = self.boxes.iter().map(|b| b.depth).max().unwrap_or(0);
        if matches!(self.level, Level::Depth(depth) if depth > deepest) {
            global.remark(format_args!("the tree ends at level {deepest}: these are all leaves' boxes"));
        }
    }

    /// The boxes of each kind as a mesh.
    pub(super) fn parts(&self) -> [Part; 2] {
        let part = |kind, name: &str| {
            let color = Kind::color(kind, 0.5).extend(OPACITY).to_array();
            let boxes = self.placed.iter().enumerate().filter(|(i, _)| self.kind(*i) == kind);
            let (positions, faces) = surfaces(boxes.map(|(_, b)| b));
            Part { name: name.to_owned(), color, positions, faces }
        };
        [part(Kind::Aligned, "aabb"), part(Kind::Oriented, "oriented")]
    }

    /// All boxes as a mesh to be traced: twelve triangles a box, two a face, in order.
    pub(super) fn scene(&self) -> Scene {
        let (positions, faces) = surfaces(self.placed.iter());
        Scene { positions, triangles: faces.into_iter().flat_map(halves).collect(), ..Scene::default() }
    }
}

/// Vertices and faces of boxes.
fn surfaces<'a>(boxes: impl Iterator<Item = &'a PlacedBox>) -> (Vec<[f32; 3]>, Vec<[u32; 4]>) {
    let (mut positions, mut faces) = (vec![], vec![]);
    for placed in boxes {
        let first = positions.len() as u32;
        positions.extend(placed.vertices());
        faces.extend(FACES.map(|f| f.map(|v| first + v)));
    }
    (positions, faces)
}
