//! Generated scenes: the same bits on every machine and thread count. Integer hashes, + − × ÷ and square roots only
//! (IEEE 754 rounds those alike everywhere; sine and its kin differ between libraries).

mod assembly;
mod city;
mod conference;
mod crown;
mod dragon_like;
mod hairball;
mod noise;
mod pipes;
mod power_plant;
mod shapes;
mod soup;
mod sphere;
mod tree;
pub(super) mod trig;

use super::{Progress, Scene, SceneError, memory};

/// A scene made at any size. All sizes have one character: more objects, not finer ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Generator {
    /// Tangled strands.
    Hairball,
    /// Voxel city on the axes.
    City,
    /// Voxel city turned about all axes.
    CityRotated,
    /// Displaced closed sphere.
    Sphere,
    /// A tree on wide ground.
    Tree,
    /// The insides of a power plant.
    PowerPlant,
    /// A conference room, furnished.
    Conference,
    /// A jewelled crown.
    Crown,
    /// A knotted body as a scanner gives it.
    DragonLike,
    /// Thin pipes in all directions.
    Pipes,
    /// Triangles at random.
    Soup,
}

/// What is said of a generator.
struct About {
    /// As typed, `:N` for the count.
    spec: &'static str,
    what: &'static str,
    full_size: u64,
}

impl Generator {
    /// All of them, in the order of listings.
    pub const ALL: &[Self] = &[
        Self::Hairball,
        Self::City,
        Self::CityRotated,
        Self::Sphere,
        Self::Tree,
        Self::PowerPlant,
        Self::Conference,
        Self::Crown,
        Self::DragonLike,
        Self::Pipes,
        Self::Soup,
    ];

    const fn about(self) -> About {
        match self {
            Self::Hairball => About {
                spec: "hairball:N",
                what: "tangled strands: long thin triangles, much overlap",
                full_size: 2_880_000,
            },
            Self::City => About {
                spec: "city:N",
                what: "voxel city on the axes: equal centroids and costs",
                full_size: 6_820_096,
            },
            Self::CityRotated => About {
                spec: "city-rotated:N",
                what: "the same city turned by 45° about each axis",
                full_size: 6_820_096,
            },
            Self::Sphere => About {
                spec: "sphere:N",
                what: "displaced closed sphere: small even triangles",
                full_size: 868_332,
            },
            Self::Tree => About {
                spec: "tree:N",
                what: "tree or forest on wide ground: tubes and loose leaves, most space empty",
                full_size: tree::FULL,
            },
            Self::PowerPlant => About {
                spec: "power-plant:N",
                what: "pipes, tubes and beams, uncut along their length; clusters of tiny parts",
                full_size: power_plant::FULL,
            },
            Self::Conference => About {
                spec: "conference:N",
                what: "furnished rooms from inside: huge walls, 1 mm slats, flush books",
                full_size: conference::FULL,
            },
            Self::Crown => About {
                spec: "crown:N",
                what: "crowns: bands, scrolls and turned gems sunk in them, empty middle",
                full_size: crown::FULL,
            },
            Self::DragonLike => About {
                spec: "dragon-like:N",
                what: "knotted scanned body, closed: small irregular triangles",
                full_size: dragon_like::FULL,
            },
            Self::Pipes => About {
                spec: "pipes:N",
                what: "thin pipes in all directions: triangles a hundred times as long as wide",
                full_size: 1_000_000,
            },
            Self::Soup => {
                About { spec: "soup:N", what: "small triangles at random in a cube", full_size: 1_000_000 }
            }
        }
    }

    /// What a scene of it is called, `:N` standing for the count: `hairball:N`.
    pub const fn spec(self) -> &'static str {
        self.about().spec
    }

    /// Its name, without a count: `hairball`.
    pub fn name(self) -> &'static str {
        self.spec().trim_end_matches(":N")
    }

    /// What it makes, in one line.
    pub const fn what(self) -> &'static str {
        self.about().what
    }

    /// Triangles of the known scene that it stands in for, or nearly.
    pub const fn full_size(self) -> u64 {
        self.about().full_size
    }

    /// About `count` triangles (1 to 2^30), named `spec`.
    ///
    /// # Errors
    /// [`SceneError::TooLarge`] where the memory does not suffice.
    pub fn generate(self, spec: &str, count: u64, progress: Progress) -> Result<Scene, SceneError> {
        match self {
            Self::Hairball => hairball::generate(spec, count, progress),
            Self::City => city::generate(spec, count, city::Pose::Upright, progress),
            Self::CityRotated => city::generate(spec, count, city::Pose::Rotated, progress),
            Self::Sphere => sphere::generate(spec, count, progress),
            Self::Tree => tree::generate(spec, count, progress),
            Self::PowerPlant => power_plant::generate(spec, count, progress),
            Self::Conference => conference::generate(spec, count, progress),
            Self::Crown => crown::generate(spec, count, progress),
            Self::DragonLike => dragon_like::generate(spec, count, progress),
            Self::Pipes => pipes::generate(spec, count, progress),
            Self::Soup => soup::generate(spec, count, progress),
        }
    }
}

/// `n` default values, or an error where there is no memory for them.
fn zeros<T: Clone + Default>(name: &str, n: usize) -> Result<Vec<T>, SceneError> {
    let mut v = Vec::new();
    let too_large = |what| SceneError::TooLarge { name: name.to_owned(), what };
    let bytes = (n as u64).saturating_mul(size_of::<T>() as u64);
    memory::must_hold(bytes).map_err(|why| too_large(format!("{n} of its elements {why}")))?;
    v.try_reserve_exact(n)
        .map_err(|_| too_large(format!("{n} elements of {} bytes don't fit in memory", size_of::<T>())))?;
    v.resize(n, T::default());
    Ok(v)
}

#[cfg(test)]
mod tests;
