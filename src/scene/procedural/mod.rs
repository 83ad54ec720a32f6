//! Generated scenes: the same bits on every machine and thread count. Integer hashes, + − × ÷ and square roots only
//! (IEEE 754 rounds those alike everywhere; sine and its kin differ between libraries).

mod city;
mod hairball;
mod noise;
mod sphere;

use super::{Progress, Scene, SceneError};

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
    pub const ALL: &[Self] = &[Self::Hairball, Self::City, Self::CityRotated, Self::Sphere];

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
        }
    }
}

/// `n` default values, or an error where there is no memory for them.
fn zeros<T: Clone + Default>(name: &str, n: usize) -> Result<Vec<T>, SceneError> {
    let mut v = Vec::new();
    v.try_reserve_exact(n).map_err(|_| SceneError::TooLarge {
        name: name.to_owned(),
        what: format!("{n} elements of {} bytes don't fit in memory", size_of::<T>()),
    })?;
    v.resize(n, T::default());
    Ok(v)
}

#[cfg(test)]
mod tests {
    use sha2::{Digest, Sha256};

    use super::Generator::*;
    use super::*;

    fn digest(scene: &Scene) -> String {
        let mut sha = Sha256::new();
        sha.update(bytemuck::cast_slice(&scene.positions));
        sha.update(bytemuck::cast_slice(&scene.triangles));
        sha.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect()
    }

    /// Asked for, got, first half of the SHA-256 of positions and triangles. A change here changes every result.
    const PINNED: &[(Generator, u64, usize, &str)] = &[
        (Hairball, 1, 8, "3668b7dea4e1f8f3"),
        (Hairball, 10_000, 10_000, "6024021b244324ec"),
        (City, 1, 228, "aed162b6ec233e48"),
        (City, 10_000, 9_844, "03e9fd58619b9807"),
        (City, 200_000, 201_260, "5a5155c6867c4f7c"),
        (CityRotated, 10_000, 9_844, "5165ea0e8beb6534"),
        (Sphere, 1, 12, "342265177f7cae9b"),
        (Sphere, 10_000, 10_092, "1c6d9f52d44a69ee"),
    ];

    fn generate(g: Generator, n: u64) -> Scene {
        g.generate(g.name(), n, Progress::Quiet).unwrap()
    }

    #[test]
    fn pinned() {
        let got: Vec<_> = PINNED
            .iter()
            .map(|&(g, n, _, _)| {
                let s = generate(g, n);
                assert!(s.positions.iter().flatten().all(|x| x.is_finite()), "{g:?}:{n}");
                assert!(s.triangles.iter().flatten().all(|&v| (v as usize) < s.positions.len()), "{g:?}:{n}");
                assert!(!s.views.is_empty());
                (g, n, s.triangles.len(), digest(&s))
            })
            .collect();
        let want: Vec<_> = PINNED.iter().map(|&(g, n, t, d)| (g, n, t, d.to_owned())).collect();
        assert_eq!(got, want);
    }

    #[test]
    fn one_thread_gives_the_same_bits() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        for &g in Generator::ALL {
            let (many, one) = (generate(g, 30_000), pool.install(|| generate(g, 30_000)));
            assert_eq!(digest(&many), digest(&one), "{g:?}");
        }
    }

    #[test]
    fn sphere_is_closed() {
        for n in [1, 48, 108, 5000] {
            let s = generate(Generator::Sphere, n);
            let mut edges = std::collections::HashSet::new();
            for t in &s.triangles {
                for k in 0..3 {
                    assert!(edges.insert((t[k], t[(k + 1) % 3])), "edge of {t:?} twice");
                }
            }
            assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
            assert_eq!(s.positions.len() + s.triangles.len(), edges.len() / 2 + 2, "Euler");
            // Outward: the signed volume is positive.
            let volume: f32 = (0..s.triangles.len())
                .map(|i| {
                    let [a, b, c] = s.corners(i).map(glam::Vec3::from);
                    a.dot(b.cross(c))
                })
                .sum();
            assert!(volume > 0.0);
        }
    }

    #[test]
    fn counts_are_near() {
        for &g in Generator::ALL {
            for n in [50_000, 100_000, 300_000] {
                let got = generate(g, n).triangles.len() as f64;
                assert!((got / n as f64 - 1.0).abs() < 0.02, "{g:?}:{n} gave {got}");
            }
        }
    }
}
