//! What the benchmark does: a preset with its parents' values filled in, and what the command line changes.

use super::images;
use super::row::Order;
use crate::abi::{Aabb, Ray};
use crate::bvh::{Fit, Recipe};
use crate::ray_query::TriangleOrder;
use crate::scene::Transform;
use crate::trace::rays::{Aimed, Light, Secondary};
use crate::trace::{BATCH, Precision, Query, RayOrder};
use std::fmt;
use std::ops::{Range, RangeInclusive};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

/// Parts of a picture from which a sample of its secondary rays is taken.
const SPANS: usize = 8;

/// A kind of rays that is made from a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RayKind {
    /// From the camera, a ray a pixel: nearest hit.
    Primary,
    /// Ambient occlusion, 32 a hit: any hit within reach.
    Ao,
    /// Diffuse, 32 a hit: nearest hit.
    Diffuse,
    /// From each hit to four lights above the scene, where it faces them: any hit.
    Shadow,
}

impl RayKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Primary, Self::Ao, Self::Diffuse, Self::Shadow];

    /// As typed and reported.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Ao => "ao",
            Self::Diffuse => "diffuse",
            Self::Shadow => "shadow",
        }
    }

    /// What is asked of its rays.
    pub fn query(self) -> Query {
        match self {
            Self::Primary | Self::Diffuse => Query::Closest,
            Self::Ao | Self::Shadow => Query::Any,
        }
    }

    /// How its rays leave the primaries' hits in a scene within `bounds`; none for primaries.
    pub fn secondary(self, bounds: &Aabb) -> Option<Secondary> {
        match self {
            Self::Primary => None,
            Self::Ao => Some(Secondary::ao(bounds)),
            Self::Diffuse => Some(Secondary::diffuse()),
            Self::Shadow => Some(Secondary::shadow(Light::above(bounds))),
        }
    }
}

/// Rays of a file, as `boxwood query` takes them.
#[derive(Debug, Clone)]
pub struct RayFile {
    /// As the user named it.
    pub path: PathBuf,
    /// Its rays.
    pub rays: Arc<[Ray]>,
    /// What is asked of them.
    pub query: Query,
}

/// Rays to be traced.
#[derive(Debug, Clone)]
pub enum RaySet {
    /// Made from each view.
    Made(RayKind),
    /// Aimed at a part of the scene: the same whatever the view.
    Aimed(Aimed),
    /// From a file: likewise.
    File(RayFile),
}

impl RaySet {
    /// Whether each view has its own.
    pub fn is_of_views(&self) -> bool {
        matches!(self, Self::Made(_))
    }
}

impl fmt::Display for RaySet {
    /// As typed: `ao`, `file:a.rays`, `any:a.rays`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Made(kind) => f.write_str(kind.name()),
            Self::Aimed(aimed) => f.write_str(aimed.name()),
            Self::File(file) => {
                let query = match file.query {
                    Query::Closest => "file",
                    Query::Any => "any",
                };
                write!(f, "{query}:{}", file.path.display())
            }
        }
    }
}

/// Which of a picture's secondary rays are traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coverage {
    /// All, in batches that take about half a second at most.
    All,
    /// A sample: runs of neighbouring hits at evenly spaced places of the picture.
    Spans {
        /// Places.
        count: usize,
        /// Rays of each, at most.
        rays: usize,
    },
}

impl Coverage {
    /// `rays` rays at most from eight places; all where it is 0.
    pub fn sample(rays: usize) -> Self {
        match rays {
            0 => Self::All,
            _ => Self::Spans { count: SPANS, rays: rays.div_ceil(SPANS).clamp(1, BATCH) },
        }
    }
}

/// Who builds a contender's tree, and traces it.
#[derive(Debug, Clone, PartialEq)]
pub enum Maker {
    /// Boxwood, by a recipe.
    Boxwood(Recipe),
    /// The device's driver, given triangles in some order.
    Driver(TriangleOrder),
}

/// A builder of the benchmark.
#[derive(Debug, Clone, PartialEq)]
pub struct Contender {
    /// As `--builders` takes it; of a driver's structure [`TriangleOrder::name`].
    pub name: String,
    /// How it builds.
    pub maker: Maker,
    /// Which triangle test its rays take, where that is boxwood's to say.
    pub precision: Precision,
}

impl Contender {
    /// Whether it has axis-aligned boxes alone, as far as anybody can tell.
    fn is_aligned(&self) -> bool {
        matches!(&self.maker, Maker::Boxwood(recipe) if recipe.fit == Fit::Aabb)
    }
}

/// Pictures whose error is measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImagePlan {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples a hit of each picture.
    pub samples: Vec<u32>,
    /// Samples a hit of the picture that they are held against.
    pub converged: u32,
}

/// A benchmark.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Scenes: files or names.
    pub scenes: Vec<String>,
    /// What is done to each scene.
    pub transform: Transform,
    /// How trees are built, each in turn.
    pub contenders: Vec<Contender>,
    /// Which part of it is measured here.
    pub shard: Shard,
    /// Rays that each of them traces.
    pub rays: Vec<RaySet>,
    /// Orders that rays but primaries are tried in.
    pub orders: &'static [RayOrder],
    /// Views of each scene, 1–5.
    pub views: usize,
    /// Picture width and height, pixels.
    pub size: [u32; 2],
    /// Unmeasured runs, at most: they end once times settle.
    pub warm_ups: usize,
    /// Measured runs, at most: they end once times settle.
    pub runs: usize,
    /// Which secondary rays.
    pub coverage: Coverage,
    /// Rays of each set, at most, that the f64 reference judges.
    pub check: usize,
    /// Rays of each set that is aimed at something.
    pub aimed: usize,
    /// Boxes of each tree that are held against near-optimal ones; 0: none.
    pub boxes: usize,
    /// Pictures whose error is measured, through the first contender's tree.
    pub images: Option<ImagePlan>,
    /// Width and height of pictures of the scene and of what each tree costs its rays, pixels.
    pub pictures: Option<[u32; 2]>,
}

/// A part of a plan. Its cells, scenes by builders, go scene by scene, and a shard takes a run of them, so that builders of
/// a scene are measured side by side where that is possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which one, from 1.
    index: usize,
    /// Of how many.
    count: usize,
}

impl Shard {
    /// All there is.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Which of `cells` are its: those of all shards are all of them, and none has more than one more than another.
    fn cells(self, cells: usize) -> Range<usize> {
        let start = |index: usize| index * cells / self.count;
        start(self.index - 1)..start(self.index)
    }
}

impl FromStr for Shard {
    type Err = String;

    /// From `2/4`: the second of four.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("{text:?} is no shard; give its number and how many there are, such as 2/4");
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let [index, count] = [index, count].map(|n| n.parse().map_err(|_| wrong()));
        let (index, count): (usize, usize) = (index?, count?);
        if (1..=count).contains(&index) && count <= 1 << 20 {
            Ok(Self { index, count })
        } else {
            Err(wrong())
        }
    }
}

/// What a row is about: at most one row of a run has it.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
pub struct Key {
    /// As the plan has it.
    pub scene: String,
    /// The contender's name.
    pub builder: String,
    /// Rays and their view; none: of the build. Rays of a file belong to view 0.
    pub rays: Option<(usize, String)>,
}

impl Key {
    /// Of a map of what rays cost, or of the scene where `builder` is empty.
    pub fn picture(scene: &str, builder: &str) -> Self {
        let what = Some((0, "picture".to_owned()));
        Self { scene: scene.to_owned(), builder: builder.to_owned(), rays: what }
    }

    /// Of a picture.
    pub fn image(scene: &str, builder: &str, shows: &str, sampler: &str, samples: u32) -> Self {
        let what = format!("{shows}, {sampler}, {samples} samples");
        Self { scene: scene.to_owned(), builder: builder.to_owned(), rays: Some((0, what)) }
    }
}

impl fmt::Display for Key {
    /// `dragon, ploc, view 1, ao`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}", self.scene, self.builder)?;
        match &self.rays {
            None => Ok(()),
            Some((0, set)) => write!(f, ", {set}"),
            Some((view, set)) => write!(f, ", view {view}, {set}"),
        }
    }
}

impl Plan {
    /// Rows of a whole run, in the order in which they are reported.
    pub fn keys(&self) -> Vec<Key> {
        self.scenes.iter().flat_map(|scene| self.keys_of(scene)).collect()
    }

    /// Contenders that build `scene` here: those of the shard.
    pub fn contenders_of(&self, scene: &str) -> &[Contender] {
        let Some(at) = self.scenes.iter().position(|s| s == scene) else { return &[] };
        let n = self.contenders.len();
        let cells = self.shard.cells(self.scenes.len() * n);
        let [from, to] = [cells.start, cells.end].map(|cell| cell.clamp(at * n, (at + 1) * n) - at * n);
        &self.contenders[from..to]
    }

    /// Rows of `scene`: builds, then rays by set and view.
    pub fn keys_of(&self, scene: &str) -> Vec<Key> {
        let contenders = self.contenders_of(scene);
        let key = |c: &Contender, rays| Key { scene: scene.to_owned(), builder: c.name.clone(), rays };
        let mut keys: Vec<Key> = contenders.iter().map(|c| key(c, None)).collect();
        for set in &self.rays {
            for view in self.views_of(set) {
                keys.extend(contenders.iter().map(|c| key(c, Some((view, set.to_string())))));
            }
        }
        let own: Vec<&Contender> =
            contenders.iter().filter(|c| matches!(c.maker, Maker::Boxwood(_))).collect();
        if let Some(painter) = self.painter_of(scene) {
            keys.extend(self.image_names().into_iter().map(|image| key(painter, Some(image))));
        }
        if self.pictures.is_some() && !own.is_empty() {
            let names = own.iter().map(|c| c.name.as_str());
            keys.extend(std::iter::once("").chain(names).map(|name| Key::picture(scene, name)));
        }
        keys
    }

    /// Views that have rays of `set`.
    fn views_of(&self, set: &RaySet) -> RangeInclusive<usize> {
        if set.is_of_views() { 1..=self.views } else { 0..=0 }
    }

    /// Whose trees the pictures whose error is measured are taken through: the first contender's of ours.
    fn painter(&self) -> Option<&Contender> {
        self.contenders.iter().find(|c| matches!(c.maker, Maker::Boxwood(_)))
    }

    /// The same, where the shard builds its tree of `scene`.
    pub(super) fn painter_of(&self, scene: &str) -> Option<&Contender> {
        self.painter().filter(|painter| self.contenders_of(scene).contains(painter))
    }

    /// View and name of each picture whose error is measured.
    fn image_names(&self) -> Vec<(usize, String)> {
        let Some(images) = &self.images else { return vec![] };
        let of = |[shows, sampler]: [&'static str; 2]| {
            images.samples.iter().filter_map(move |n| Key::image("", "", shows, sampler, *n).rays)
        };
        images::kinds().flat_map(of).collect()
    }

    /// Of the rows that it makes.
    pub fn order(&self) -> Order {
        let plain = self.contenders.iter().find(|c| c.is_aligned());
        Order {
            scenes: self.scenes.clone(),
            builders: self.contenders.iter().map(|c| c.name.clone()).collect(),
            cell: self
                .rays
                .iter()
                .flat_map(|set| self.views_of(set).map(move |view| (view, set.to_string())))
                .collect(),
            images: self.image_names(),
            painter: self.painter().map(|c| c.name.clone()),
            sets: self.rays.iter().map(RaySet::to_string).collect(),
            aligned: plain.map(|c| c.name.clone()),
        }
    }

    /// What a run must share with one that it resumes, and a shard with its others, as text.
    pub fn fingerprint(&self) -> String {
        let rays: Vec<String> = self
            .rays
            .iter()
            .map(|set| match set {
                RaySet::Made(_) => set.to_string(),
                RaySet::Aimed(_) => format!("{set} ({} rays)", self.aimed),
                RaySet::File(file) => format!("{set} ({} rays)", file.rays.len()),
            })
            .collect();
        format!(
            "scenes {:?}, {:?}; builders {:?}; rays {rays:?} {:?}; {} views of {:?} pixels; {} warm-ups, {} runs; {:?}; {} checked; {} boxes; {:?}; pictures {:?}",
            self.scenes,
            self.transform,
            self.contenders,
            self.orders,
            self.views,
            self.size,
            self.warm_ups,
            self.runs,
            self.coverage,
            self.check,
            self.boxes,
            self.images,
            self.pictures
        )
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_all_cells() {
        for cells in [0, 1, 5, 12, 48] {
            for count in [1, 2, 3, 7, 50] {
                let shards = (1..=count).map(|index| Shard { index, count }.cells(cells));
                let ranges: Vec<_> = shards.collect();
                assert_eq!((ranges[0].start, ranges[count - 1].end), (0, cells));
                assert!(ranges.windows(2).all(|w| w[0].end == w[1].start), "{ranges:?}");
                let sizes = || ranges.iter().map(Range::len);
                assert!(sizes().max().unwrap() - sizes().min().unwrap() <= 1, "{ranges:?}");
            }
        }
    }

    #[test]
    fn shards_are_read() {
        assert_eq!("2/4".parse(), Ok(Shard { index: 2, count: 4 }));
        for wrong in ["", "2", "0/4", "5/4", "a/4", "1/0", "-1/2", "1/2/3"] {
            assert!(wrong.parse::<Shard>().unwrap_err().contains("no shard"), "{wrong}");
        }
    }
}
