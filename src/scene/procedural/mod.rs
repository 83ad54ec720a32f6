//! Generated scenes: the same bits on every machine and thread count. Integer hashes, + − × ÷ and square roots only
//! (IEEE 754 rounds those alike everywhere; sine and its kin differ between libraries).

pub(super) mod city;
pub(super) mod hairball;
mod noise;
pub(super) mod sphere;

use super::SceneError;

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

    use super::*;
    use crate::scene::{Progress, Scene};

    fn digest(scene: &Scene) -> String {
        let mut sha = Sha256::new();
        sha.update(bytemuck::cast_slice(&scene.positions));
        sha.update(bytemuck::cast_slice(&scene.triangles));
        sha.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect()
    }

    /// Name, asked for, got, first half of the SHA-256 of positions and triangles. A change here changes every result.
    const PINNED: &[(&str, u64, usize, &str)] = &[
        ("hairball", 1, 8, "3668b7dea4e1f8f3"),
        ("hairball", 10_000, 10_000, "6024021b244324ec"),
        ("city", 1, 228, "aed162b6ec233e48"),
        ("city", 10_000, 9_844, "03e9fd58619b9807"),
        ("city", 200_000, 201_260, "5a5155c6867c4f7c"),
        ("city-rotated", 10_000, 9_844, "5165ea0e8beb6534"),
        ("sphere", 1, 12, "342265177f7cae9b"),
        ("sphere", 10_000, 10_092, "1c6d9f52d44a69ee"),
    ];

    fn generate(name: &str, n: u64) -> Scene {
        let p = Progress::Quiet;
        match name {
            "hairball" => hairball::generate(name, n, p),
            "city" => city::generate(name, n, city::Pose::Upright, p),
            "city-rotated" => city::generate(name, n, city::Pose::Rotated, p),
            _ => sphere::generate(name, n, p),
        }
        .unwrap()
    }

    #[test]
    fn pinned() {
        let got: Vec<_> = PINNED
            .iter()
            .map(|&(name, n, _, _)| {
                let s = generate(name, n);
                assert!(s.positions.iter().flatten().all(|x| x.is_finite()), "{name}:{n}");
                assert!(
                    s.triangles.iter().flatten().all(|&v| (v as usize) < s.positions.len()),
                    "{name}:{n}"
                );
                assert!(!s.views.is_empty());
                (name, n, s.triangles.len(), digest(&s))
            })
            .collect();
        let want: Vec<_> = PINNED.iter().map(|&(name, n, t, d)| (name, n, t, d.to_owned())).collect();
        assert_eq!(got, want);
    }

    #[test]
    fn one_thread_gives_the_same_bits() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        for name in ["hairball", "city", "city-rotated", "sphere"] {
            let (many, one) = (generate(name, 30_000), pool.install(|| generate(name, 30_000)));
            assert_eq!(digest(&many), digest(&one), "{name}");
        }
    }

    #[test]
    fn sphere_is_closed() {
        for n in [1, 48, 108, 5000] {
            let s = generate("sphere", n);
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
        for name in ["hairball", "city", "sphere"] {
            for n in [50_000, 100_000, 300_000] {
                let got = generate(name, n).triangles.len() as f64;
                assert!((got / n as f64 - 1.0).abs() < 0.02, "{name}:{n} gave {got}");
            }
        }
    }
}
