//! `scenes/scenes.toml`, which is part of the binary: every scene that has a name, where it comes from, whose it is, from
//! where it is looked at, and which make a set.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Deserializer, Serialize};

use super::{Camera, Generator, Scene, Transform};

/// The scenes that have a name, and sets of them.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Scenes, in the file's order.
    #[serde(rename = "scene")]
    pub scenes: Vec<Entry>,
    /// Scenes as typed (`tree:313k`), by the name of their set.
    pub sets: BTreeMap<String, Vec<String>>,
}

/// A scene that has a name.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// As typed.
    pub name: String,
    /// What it is, in a line; where the file says nothing, what its generator says.
    #[serde(default)]
    pub what: String,
    /// On what terms it may be used, and by whose word; or that nothing is known.
    pub licence: String,
    /// Whose it is.
    pub credit: String,
    /// Triangles: all of a fetched scene; of a generated one, about as many where none are asked for.
    pub triangles: u64,
    /// Where it comes from.
    pub source: Source,
    /// Degrees about x, y and z by which the scene is turned: its views are those of the scene turned back.
    #[serde(default)]
    turned: [f64; 3],
    views: Views,
}

/// Where a scene comes from.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// Made here, at any size.
    #[serde(deserialize_with = "generator")]
    Generated(Generator),
    /// Out of a published package.
    Fetched(Fetched),
}

/// A mesh in a published package.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fetched {
    /// Whose client gets it.
    pub registry: Registry,
    /// The package.
    pub package: String,
    /// The one version that is meant.
    pub version: String,
    /// Path in the package. `.gz` and `.zst` are unpacked.
    pub member: String,
    /// Size of the mesh file, unpacked.
    pub bytes: u64,
    /// Its SHA-256, in hexadecimal.
    pub sha256: String,
    /// A generated scene of about the same size.
    pub instead: String,
}

/// A package registry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Registry {
    /// JavaScript's.
    Npm,
    /// Rust's.
    Cargo,
    /// Python's.
    Pypi,
}

impl Registry {
    /// As written in the manifest.
    pub fn name(self) -> &'static str {
        match self {
            Self::Npm => "npm",
            Self::Cargo => "cargo",
            Self::Pypi => "pypi",
        }
    }
}

/// Five views of a scene.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Views {
    /// Those of another scene, at the same places of its own box.
    Of(String),
    /// Its own.
    Own(Box<[Look; 5]>),
}

/// A view of a scene of any size.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Look {
    /// By name.
    Named(NamedLook),
    /// By coordinates.
    At(At),
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum NamedLook {
    /// The one that the generator gives, or else the three-quarter view of the bounds.
    Standard,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct At {
    #[serde(default)]
    units: Units,
    eye: [f64; 3],
    target: [f64; 3],
    #[serde(default = "y_up")]
    up: [f64; 3],
    /// Degrees.
    #[serde(default = "normal_fov")]
    fov_y: f32,
}

/// What coordinates of a view are in.
#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Units {
    /// Edges of the scene's box: 0 to 1 inside, on each axis.
    #[default]
    Box,
    /// Scene units.
    Scene,
}

fn y_up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

fn normal_fov() -> f32 {
    45.0
}

fn generator<'de, D: Deserializer<'de>>(from: D) -> Result<Generator, D::Error> {
    let name = String::deserialize(from)?;
    let found = Generator::ALL.iter().find(|g| g.name() == name);
    found.copied().ok_or_else(|| serde::de::Error::custom(format!("there is no generator {name:?}")))
}

/// What is in `scenes/scenes.toml`.
pub fn manifest() -> &'static Manifest {
    static MANIFEST: LazyLock<Manifest> = LazyLock::new(|| {
        let parsed = Manifest::parse(include_str!("../../scenes/scenes.toml"));
        parsed.unwrap_or_else(|e| panic!("scenes/scenes.toml, which is part of this program: {e}"))
    });
    &MANIFEST
}

/// The scenes of the set `name`, as typed; none: there is no such set.
pub fn set(name: &str) -> Option<&'static [String]> {
    manifest().sets.get(name).map(Vec::as_slice)
}

/// A manifest that can't be used.
#[derive(Debug, thiserror::Error)]
pub enum ManifestError {
    /// It is no TOML, or says what no manifest has.
    #[error(transparent)]
    Toml(#[from] Box<toml::de::Error>),
    /// Views of a scene that isn't there, or that has none of its own either.
    #[error("the scene {name:?} takes the views of {of:?}, which has none of its own")]
    Views {
        /// The scene.
        name: String,
        /// Whose views it takes.
        of: String,
    },
}

impl Manifest {
    /// That of a TOML text like `scenes/scenes.toml`.
    ///
    /// # Errors
    /// [`ManifestError`], with the line or the scene.
    pub fn parse(text: &str) -> Result<Self, ManifestError> {
        let mut manifest: Self = toml::from_str(text).map_err(Box::new)?;
        for entry in &mut manifest.scenes {
            if let (true, Source::Generated(generator)) = (entry.what.is_empty(), &entry.source) {
                entry.what = generator.what().to_owned();
            }
        }
        for entry in &manifest.scenes {
            if let Views::Of(of) = &entry.views
                && !manifest.entry(of).is_some_and(|other| matches!(other.views, Views::Own(_)))
            {
                return Err(ManifestError::Views { name: entry.name.clone(), of: of.clone() });
            }
        }
        Ok(manifest)
    }

    /// The scene called `name`, without a count.
    pub fn entry(&self, name: &str) -> Option<&Entry> {
        self.scenes.iter().find(|s| s.name == name)
    }
}

impl Entry {
    /// What to type: the name, with `:N` where a count may follow.
    pub fn spec(&self) -> String {
        match self.source {
            Source::Generated(_) => format!("{}:N", self.name),
            Source::Fetched(_) => self.name.clone(),
        }
    }

    fn looks(&self) -> &[Look] {
        match &self.views {
            Views::Own(looks) => looks.as_slice(),
            Views::Of(name) => manifest().entry(name).map_or(&[], Entry::looks),
        }
    }

    /// The five views of `scene`, which is this one at some size.
    pub(super) fn views(&self, scene: &Scene) -> Vec<Camera> {
        let pose = Transform { rotate: self.turned, ..Transform::default() };
        let matrix = pose.matrix();
        let (lo, hi) = if pose.is_identity() {
            let b = scene.bounds();
            (DVec3::from_array(b.lo.map(f64::from)), DVec3::from_array(b.hi.map(f64::from)))
        } else {
            bounds_turned_back(scene, &matrix)
        };
        let look = |look: &Look| match look {
            Look::Named(NamedLook::Standard) => scene.view(),
            Look::At(at) => pose.view(&matrix, &at.camera(lo, hi)),
        };
        self.looks().iter().map(look).collect()
    }
}

impl At {
    fn camera(&self, lo: DVec3, hi: DVec3) -> Camera {
        let place = |p: [f64; 3]| {
            let p = DVec3::from_array(p);
            match self.units {
                Units::Box => lo + p * (hi - lo),
                Units::Scene => p,
            }
        };
        let narrow = |p: DVec3| p.as_vec3().to_array();
        Camera {
            eye: narrow(place(self.eye)),
            target: narrow(place(self.target)),
            up: self.up.map(|x| x as f32),
            fov_y: self.fov_y,
        }
    }
}

/// Bounds of what `scene` was before it was turned by `matrix`.
fn bounds_turned_back(scene: &Scene, matrix: &DMat3) -> (DVec3, DVec3) {
    let back = matrix.transpose();
    let points = scene.positions.iter().map(|p| back * DVec3::from_array(p.map(f64::from)));
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.filter(|p| p.is_finite()).fold(empty, |(lo, hi), p| (lo.min(p), hi.max(p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_whole() {
        let manifest = manifest();
        for (i, s) in manifest.scenes.iter().enumerate() {
            let (name, texts) = (&s.name, [&s.what, &s.licence, &s.credit]);
            assert!(manifest.scenes[..i].iter().all(|other| other.name != *name), "{name} twice");
            assert!(
                name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-'),
                "{name}"
            );
            assert!(texts.iter().all(|t| !t.is_empty() && !t.contains('\n')) && s.triangles > 0, "{name}");
            assert_eq!(s.looks().len(), 5, "{name}: views of a scene that isn't there");
            let f = match &s.source {
                Source::Generated(g) => {
                    assert_eq!(g.name(), name);
                    continue;
                }
                Source::Fetched(f) => f,
            };
            assert!(f.sha256.len() == 64 && f.sha256.bytes().all(|b| b.is_ascii_hexdigit()), "{name}");
            let (instead, count) = f.instead.split_once(':').unwrap();
            let instead = manifest.entry(instead).unwrap();
            assert!(matches!(instead.source, Source::Generated(_)), "{name}");
            assert_eq!(count.parse::<u64>().unwrap(), s.triangles, "{name}");
        }
    }

    #[test]
    fn every_generator_has_a_name() {
        for generator in Generator::ALL {
            assert!(
                manifest().entry(generator.name()).is_some(),
                "{generator:?} is not in scenes/scenes.toml"
            );
        }
    }

    #[test]
    fn sets_name_scenes() {
        for (set, specs) in &manifest().sets {
            assert!(manifest().entry(set).is_none(), "{set} is a scene too");
            for spec in specs {
                let name = spec.split(':').next().unwrap();
                assert!(manifest().entry(name).is_some(), "{set}: {spec}");
            }
        }
        assert_eq!(set("nonesuch"), None);
    }

    #[test]
    fn views_follow_the_box_and_its_turn() {
        let entry = |turned: &str| -> Entry {
            let view = "{ eye = [0, 0.5, 2], target = [0.5, 0.5, 0.5], fov_y = 30 }";
            let text = format!(
                "name = 's'\nwhat = 's'\nlicence = ''\ncredit = ''\ntriangles = 1\nsource.generated = 'sphere'\n{turned}\n\
                 views = ['standard', {view}, {view}, {view}, {{ units = 'scene', eye = [1, 2, 3], target = [0, 0, 0] }}]"
            );
            toml::from_str(&text).unwrap()
        };
        let positions = vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 4.0], [0.0, 2.0, 0.0]];
        let scene = Scene { positions, triangles: vec![[0, 1, 2]], ..Scene::default() };
        let views = entry("").views(&scene);
        assert_eq!((views.len(), views[0]), (5, scene.view()));
        assert_eq!(
            (views[1].eye, views[1].target, views[1].fov_y),
            ([-1.0, 1.0, 8.0], [0.0, 1.0, 2.0], 30.0)
        );
        assert_eq!((views[4].eye, views[4].fov_y), ([1.0, 2.0, 3.0], 45.0));
        // The same scene turned by 90° about y has the same views, turned.
        let pose = Transform { rotate: [0.0, 90.0, 0.0], ..Transform::default() };
        let turned = entry("turned = [0, 90, 0]").views(&pose.apply(scene).unwrap());
        assert_eq!((turned[1].eye, turned[1].target), ([8.0, 1.0, 1.0], [2.0, 1.0, 0.0]));
    }
}
