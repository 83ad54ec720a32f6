//! Presets of the benchmark: `scenes/bench.toml`, in which an entry takes what it doesn't say from its parent.

use super::ImagePlan;
use super::size::bytes_of;
use crate::bvh::{Collapse, Directions, Fit, Generator, Method, Moment, Morton, Recipe};
use crate::trace::Precision;
use crate::trace::rays::MOST_SAMPLES;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};

/// Rays of a set that is aimed at something, where the preset doesn't say.
const AIMED: usize = 1 << 17;
/// The presets that boxwood comes with.
const OWN: &str = include_str!("../../scenes/bench.toml");

/// A preset or recipe that can't be had.
#[derive(Debug, thiserror::Error)]
pub enum PresetError {
    /// The file is no TOML, or says what no preset has.
    #[error("the presets can't be read: {0}")]
    Toml(#[from] Box<toml::de::Error>),
    /// No such entry.
    #[error("no {what} is called {name:?}; there are: {known}")]
    Unknown {
        /// `preset` or `builder`.
        what: &'static str,
        /// As given.
        name: String,
        /// Those there are.
        known: String,
    },
    /// An entry is among its own parents.
    #[error("the {what} {name:?} is its own ancestor")]
    Circle {
        /// `preset` or `builder`.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// Neither an entry nor its parents say something.
    #[error("the {what} {name:?} and its parents don't say `{field}`")]
    Silent {
        /// `preset` or `builder`.
        what: &'static str,
        /// Its name.
        name: String,
        /// What is missing.
        field: &'static str,
    },
    /// A value that makes no sense.
    #[error("the {what} {name:?} says {field} = {value}: {want}")]
    Value {
        /// `preset` or `builder`.
        what: &'static str,
        /// Its name.
        name: String,
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would make sense.
        want: &'static str,
    },
}

type Result<T> = std::result::Result<T, PresetError>;

/// An entry that inherits.
trait Inherit: Clone {
    const WHAT: &'static str;
    fn parent(&self) -> Option<&str>;
    /// Fills in what this one doesn't say.
    fn or(self, parent: Self) -> Self;
}

macro_rules! entry {
    ($( #[doc = $doc:literal] )* $name:ident ($what:literal) { $( $field:ident : $kind:ty ),* $(,)? }) => {
        $( #[doc = $doc] )*
        #[derive(Debug, Clone, Default, Deserialize)]
        #[serde(deny_unknown_fields, rename_all = "kebab-case")]
        struct $name { parent: Option<String>, $( $field: Option<$kind> ),* }
        impl Inherit for $name {
            const WHAT: &'static str = $what;
            fn parent(&self) -> Option<&str> { self.parent.as_deref() }
            fn or(self, other: Self) -> Self {
                Self { parent: other.parent, $( $field: self.$field.or(other.$field) ),* }
            }
        }
    };
}

entry! {
    /// A `[recipes.NAME]`.
    RecipeEntry ("builder") {
        builder: String, morton: String, radius: u32, traversal_cost: f32, node_cost: f32,
        triangle_cost: f32, max_leaf: u32, fit: String, oriented_cost: f32, local_search: u32, bases: String,
        directions: String, collapse: String, threshold: u32, memory: String, precision: String,
    }
}
entry! {
    /// A `[presets.NAME]`.
    PresetEntry ("preset") {
        what: String, scenes: Vec<String>, builders: Vec<String>, rays: Vec<String>, views: usize, width: u32,
        height: u32, warm_ups: usize, runs: usize, sample: usize, check: usize, aimed: usize, boxes: usize,
        images: Vec<u32>, converged: u32, image_width: u32, image_height: u32,
        picture_width: u32, picture_height: u32,
    }
}

/// The whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Presets {
    recipes: BTreeMap<String, RecipeEntry>,
    presets: BTreeMap<String, PresetEntry>,
}

/// A preset with its parents' values; the words are those of `scenes/bench.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Preset {
    /// Files, names, or `set:NAME`.
    pub scenes: Vec<String>,
    /// Names of recipes.
    pub builders: Vec<String>,
    /// Ray sets.
    pub rays: Vec<String>,
    /// Views of each scene, 1–5.
    pub views: usize,
    /// Picture width and height, pixels.
    pub size: [u32; 2],
    /// Warm-ups at most.
    pub warm_ups: usize,
    /// Measured runs at most.
    pub runs: usize,
    /// Secondary rays of a view on software drivers; 0: all.
    pub sample: usize,
    /// Rays of a set that are checked; 0: none.
    pub check: usize,
    /// Rays of a set that is aimed at something.
    pub aimed: usize,
    /// Boxes of a tree that are held against near-optimal ones; 0: none.
    pub boxes: usize,
    /// Pictures whose error is measured.
    pub images: Option<ImagePlan>,
    /// Width and height of pictures of the scene and of what its rays cost, pixels.
    pub pictures: Option<[u32; 2]>,
}

impl Presets {
    /// Those that boxwood comes with.
    ///
    /// # Errors
    /// None in practice: a test reads them.
    pub fn own() -> Result<Self> {
        Self::parse(OWN)
    }

    /// Those of a TOML text like `scenes/bench.toml`.
    ///
    /// # Errors
    /// [`PresetError::Toml`] with the line.
    pub fn parse(text: &str) -> Result<Self> {
        toml::from_str(text).map_err(|e| PresetError::Toml(Box::new(e)))
    }

    /// Names of presets and what they are for.
    pub fn list(&self) -> impl Iterator<Item = (&str, &str)> {
        self.presets.iter().map(|(name, p)| (name.as_str(), p.what.as_deref().unwrap_or("")))
    }

    /// Names of recipes: what `--builders` takes.
    pub fn recipes(&self) -> impl Iterator<Item = &str> {
        self.recipes.keys().map(String::as_str).filter(|name| *name != "default")
    }

    /// The preset `name`.
    ///
    /// # Errors
    /// It or a parent isn't there, or leaves something open.
    pub fn preset(&self, name: &str) -> Result<Preset> {
        let p = resolve(&self.presets, name)?;
        let missing = |field| silent("preset", name, field);
        let preset = Preset {
            scenes: p.scenes.ok_or_else(missing("scenes"))?,
            builders: p.builders.ok_or_else(missing("builders"))?,
            rays: p.rays.ok_or_else(missing("rays"))?,
            views: p.views.ok_or_else(missing("views"))?,
            size: [p.width.ok_or_else(missing("width"))?, p.height.ok_or_else(missing("height"))?],
            warm_ups: p.warm_ups.ok_or_else(missing("warm-ups"))?,
            runs: p.runs.ok_or_else(missing("runs"))?,
            sample: p.sample.ok_or_else(missing("sample"))?,
            check: p.check.ok_or_else(missing("check"))?,
            aimed: p.aimed.unwrap_or(AIMED),
            boxes: p.boxes.unwrap_or_default(),
            pictures: p.picture_width.zip(p.picture_height).map(|(w, h)| [w, h]).filter(|s| !s.contains(&0)),
            images: match p.images.unwrap_or_default() {
                none if none.is_empty() => None,
                samples => Some(ImagePlan {
                    size: [
                        p.image_width.ok_or_else(missing("image-width"))?,
                        p.image_height.ok_or_else(missing("image-height"))?,
                    ],
                    samples,
                    converged: p.converged.ok_or_else(missing("converged"))?,
                }),
            },
        };
        let wrong = |field, value: usize, want| {
            Err(PresetError::Value {
                what: "preset",
                name: name.into(),
                field,
                value: value.to_string(),
                want,
            })
        };
        match &preset {
            p if !(1..=5).contains(&p.views) => wrong("views", p.views, "1 to 5 are there"),
            p if p.runs == 0 => wrong("runs", 0, "at least 1"),
            p if p.size.contains(&0) => wrong("width or height", 0, "at least 1"),
            Preset { images: Some(i), .. } if i.size.contains(&0) => {
                wrong("image-width or image-height", 0, "at least 1")
            }
            Preset { images: Some(i), .. } if i.samples.contains(&0) => wrong("images", 0, "at least 1"),
            Preset { images: Some(i), .. } if !(1..=MOST_SAMPLES).contains(&i.converged) => {
                wrong("converged", i.converged as usize, "1 to 8192")
            }
            _ => Ok(preset),
        }
    }

    /// The triangle test of the recipe `name`: robust where it doesn't say.
    ///
    /// # Errors
    /// It or a parent isn't there, or names no test.
    pub fn precision(&self, name: &str) -> Result<Precision> {
        let Some(said) = resolve(&self.recipes, name)?.precision else { return Ok(Precision::default()) };
        Precision::ALL.into_iter().find(|p| p.name() == said).ok_or_else(|| PresetError::Value {
            what: "builder",
            name: name.into(),
            field: "precision",
            value: said,
            want: "robust or fast",
        })
    }

    /// The recipe `name`.
    ///
    /// # Errors
    /// It or a parent isn't there, leaves something open, or is out of range.
    pub fn recipe(&self, name: &str) -> Result<Recipe> {
        let r = resolve(&self.recipes, name)?;
        let missing = |field| silent("builder", name, field);
        let wrong = |field, value: String, want| PresetError::Value {
            what: "builder",
            name: name.into(),
            field,
            value,
            want,
        };
        let morton = r.morton.ok_or_else(missing("morton"))?;
        let morton = Morton::ALL
            .into_iter()
            .find(|m| m.name() == morton)
            .ok_or_else(|| wrong("morton", morton, "see `boxwood build --help`"))?;
        let builder = r.builder.ok_or_else(missing("builder"))?;
        let method =
            Method::named(&builder).ok_or_else(|| wrong("builder", builder, "see `boxwood build --help`"))?;
        let collapse = Collapse {
            traversal_cost: r.traversal_cost.ok_or_else(missing("traversal-cost"))?,
            node_cost: r.node_cost.ok_or_else(missing("node-cost"))?,
            triangle_cost: r.triangle_cost.ok_or_else(missing("triangle-cost"))?,
            max_leaf: r.max_leaf.ok_or_else(missing("max-leaf"))?,
        };
        let fit = match r.fit {
            None => method.fit,
            Some(fit) => Fit::ALL
                .into_iter()
                .find(|f| f.name() == fit)
                .ok_or_else(|| wrong("fit", fit, "see `boxwood build --help`"))?,
        };
        let radius = r.radius.ok_or_else(missing("radius"))?;
        let oriented_cost = r.oriented_cost.ok_or_else(missing("oriented-cost"))?;
        let local_search = r.local_search.unwrap_or_default();
        let generator = match r.bases {
            None => Generator::default(),
            Some(bases) => Generator::ALL
                .into_iter()
                .find(|g| g.name() == bases)
                .ok_or_else(|| wrong("bases", bases, "see `boxwood build --help`"))?,
        };
        let directions = match r.directions {
            None => Directions::default(),
            Some(directions) => Directions::ALL
                .into_iter()
                .find(|d| d.name() == directions)
                .ok_or_else(|| wrong("directions", directions, "see `boxwood build --help`"))?,
        };
        let (builder, fit) = (method.builder.with_generator(generator), fit.with_generator(generator));
        let memory = match r.memory {
            None => Recipe::default().memory,
            Some(size) => {
                bytes_of(&size).ok_or_else(|| wrong("memory", size, "write a size such as 8GiB or 512MiB"))?
            }
        };
        let collapsed = match r.collapse {
            None => Moment::default(),
            Some(moment) => Moment::ALL
                .into_iter()
                .find(|m| m.name() == moment)
                .ok_or_else(|| wrong("collapse", moment, "see `boxwood build --help`"))?,
        };
        let recipe = Recipe {
            builder,
            morton,
            radius,
            collapse,
            collapsed,
            fit,
            threshold: r.threshold,
            oriented_cost,
            directions,
            local_search,
            memory,
        };
        recipe.check().map_err(|e| wrong("a value", e.to_string(), "see `boxwood build --help`"))?;
        Ok(recipe)
    }
}

fn silent(what: &'static str, name: &str, field: &'static str) -> impl FnOnce() -> PresetError {
    let name = name.to_owned();
    move || PresetError::Silent { what, name, field }
}

/// The entry `name` with what its parents say.
fn resolve<T: Inherit>(entries: &BTreeMap<String, T>, name: &str) -> Result<T> {
    let mut seen = BTreeSet::from([name.to_owned()]);
    let find = |name: &str| {
        entries.get(name).cloned().ok_or_else(|| PresetError::Unknown {
            what: T::WHAT,
            name: name.to_owned(),
            known: entries.keys().filter(|k| *k != "default").cloned().collect::<Vec<_>>().join(", "),
        })
    };
    let mut entry = find(name)?;
    while let Some(parent) = entry.parent().map(str::to_owned) {
        entry = entry.or(find(&parent)?);
        if !seen.insert(parent.clone()) {
            return Err(PresetError::Circle { what: T::WHAT, name: parent });
        }
    }
    Ok(entry)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bvh::{Bases, Builder};

    #[test]
    fn own_presets_are_whole() {
        let own = Presets::own().unwrap();
        for (name, what) in own.list() {
            let preset = own.preset(name).unwrap();
            assert!(!what.is_empty(), "{name}");
            for builder in &preset.builders {
                own.recipe(builder).unwrap();
            }
        }
        assert_eq!(own.recipe("ploc").unwrap(), Recipe::default());
        assert!(own.recipes().all(|r| own.recipe(r).is_ok()));
    }

    #[test]
    fn files_that_mean_harm_are_refused() {
        let deep = 100_000;
        for text in [
            format!("a = {}", "[".repeat(deep)),
            format!("{}a = 1", "a.".repeat(deep)),
            format!("[presets.{}a]", "a.".repeat(deep)),
        ] {
            assert!(Presets::parse(&text).is_err());
        }
        // Parents in a long line, and in a ring: each is asked once.
        let line: String = (0..5000).map(|i| format!("[recipes.r{i}]\nparent='r{}'\n", i + 1)).collect();
        let presets = Presets::parse(&format!("{line}[presets]")).unwrap();
        assert!(matches!(presets.recipe("r0"), Err(PresetError::Unknown { .. })));
        let presets =
            Presets::parse(&line.replace("'r5000'", "'r9'").replacen("[rec", "[presets]\n[rec", 1)).unwrap();
        assert!(matches!(presets.recipe("r0"), Err(PresetError::Circle { .. })));
    }

    #[test]
    fn children_say_what_differs() {
        let text = "[recipes.m]\nparent='a'\nbuilder='odop3'\nbases='zone'\nmemory='2GiB'\n\
                    [recipes.n]\nparent='a'\nmemory='2'\n[recipes.a]\nbuilder='ploc'\nmorton='30'\nradius=4\ntraversal-cost=1\nnode-cost=1\ntriangle-cost=1\nmax-leaf=4\n\
                    oriented-cost=5\n\
                    [recipes.b]\nparent='a'\nradius=9\n[recipes.c]\nparent='b'\nmorton='63'\n\
                    [recipes.o]\nparent='p'\n[recipes.p]\nparent='o'\n[recipes.s]\nmorton='30'\n\
                    [recipes.w]\nparent='a'\nradius=999\n[presets]";
        let presets = Presets::parse(text).unwrap();
        let c = presets.recipe("c").unwrap();
        assert_eq!((c.radius, c.morton, c.collapse.max_leaf), (9, Morton::Bits63, 4));
        let m = presets.recipe("m").unwrap();
        let zone = Builder::Odop(Bases { generator: Generator::Zone, degree: 3 });
        assert_eq!((m.builder, m.memory), (zone, 2 << 30));
        let error = |name: &str| presets.recipe(name).unwrap_err().to_string();
        assert!(error("o").contains("its own ancestor"), "{}", error("o"));
        assert!(error("n").contains("8GiB"), "{}", error("n"));
        assert!(error("x").contains("there are: a, b, c"), "{}", error("x"));
        assert!(error("s").contains("don't say"), "{}", error("s"));
        assert!(error("w").contains("999"), "{}", error("w"));
        assert!(
            Presets::parse("[recipes.a]\nradios=1\n[presets]").unwrap_err().to_string().contains("radios")
        );
    }
}
