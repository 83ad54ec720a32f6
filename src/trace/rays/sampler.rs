//! Where the samples of a hit lie in the unit square.

use crate::abi::Pair;

/// Points of the unit square, the same for every hit, which turns them about by its own hash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampler {
    /// Halton's sequence in bases 2 and 3 (Halton60), so many points left out at its start.
    Halton(u32),
    /// Independent points from this seed: what Halton's are to be held against.
    Random(u64),
}

impl Default for Sampler {
    fn default() -> Self {
        Self::Halton(0)
    }
}

impl Sampler {
    /// The `i`th point, from 0 on: 24-bit fixed point, rounded down.
    pub fn point(self, i: u32) -> Pair {
        match self {
            Self::Halton(skipped) => halton(skipped + i + 1),
            Self::Random(seed) => {
                let word = mixed(seed.wrapping_add(u64::from(i).wrapping_mul(0x9e37_79b9_7f4a_7c15)));
                [(word >> 40) as u32, (word >> 8) as u32 & 0xff_ffff]
            }
        }
    }
}

/// The `index`th point of Halton's sequence in bases 2 and 3, 24-bit fixed point, rounded down.
fn halton(index: u32) -> Pair {
    let inverse = |base: u64| {
        let (mut rest, mut digits, mut scale) = (u64::from(index), 0, 1);
        while rest > 0 {
            digits = digits * base + rest % base;
            scale *= base;
            rest /= base;
        }
        ((digits << 24) / scale) as u32
    };
    [inverse(2), inverse(3)]
}

/// The output function of SplitMix64 (Steele14).
pub(crate) fn mixed(z: u64) -> u64 {
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(p: Pair) -> [f64; 2] {
        p.map(|x| f64::from(x) / f64::from(1 << 24))
    }

    #[test]
    fn halton_points() {
        for (index, u, v) in [(1, 1.0 / 2.0, 1.0 / 3.0), (2, 1.0 / 4.0, 2.0 / 3.0), (5, 5.0 / 8.0, 7.0 / 9.0)]
        {
            let p = share(halton(index));
            assert!((p[0] - u).abs() < 1e-7 && (p[1] - v).abs() < 1e-7, "{index}: {p:?}");
            assert_eq!(Sampler::Halton(1).point(index - 1), halton(index + 1));
        }
    }

    /// How far the share of the first `n` points within each of 16 × 16 boxes from the corner is from its area, at most.
    fn discrepancy(sampler: Sampler, n: u32) -> f64 {
        let points: Vec<[f64; 2]> = (0..n).map(|i| share(sampler.point(i))).collect();
        let corners =
            (1..=256).map(|c| [f64::from((c - 1) % 16 + 1) / 16.0, f64::from((c - 1) / 16 + 1) / 16.0]);
        let off = |[x, y]: [f64; 2]| {
            let inside = points.iter().filter(|p| p[0] < x && p[1] < y).count();
            (inside as f64 / f64::from(n) - x * y).abs()
        };
        corners.map(off).fold(0.0, f64::max)
    }

    #[test]
    fn random_points_fill_the_square_as_chance_does() {
        // Of chance about 0.8 / √n; of Halton's points log²n / n.
        for seed in 0..4 {
            let by_chance = discrepancy(Sampler::Random(seed), 4096);
            assert!((0.003..0.04).contains(&by_chance), "{seed}: {by_chance}");
        }
        for skipped in [0, 8192] {
            let even = discrepancy(Sampler::Halton(skipped), 4096);
            assert!(even < 0.003, "{skipped}: {even}");
        }
    }
}
