//! Numbers by chance, the same on every machine.

use glam::DVec3;

/// SplitMix64.
#[derive(Debug, Clone)]
pub(super) struct Random(u64);

impl Random {
    /// A stream for `seed` and what it is used for.
    pub(super) fn new(seed: u64, salt: &str) -> Self {
        // FNV-1a: streams of neighbouring seeds and names have nothing in common after a step.
        let hash = salt
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
        Self(seed.wrapping_mul(0xd134_2543_de82_ef95) ^ hash)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// From 0 to 1.
    pub(super) fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// From −1 to 1.
    pub(super) fn unit(&mut self) -> f64 {
        2.0 * self.share() - 1.0
    }

    /// From 0 to n − 1; n is above 0.
    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// One of `all`, which isn't empty.
    pub(super) fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// In a cube of edge 2 about the origin.
    pub(super) fn point(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }

    /// Unit vector.
    pub(super) fn direction(&mut self) -> DVec3 {
        loop {
            let p = self.point();
            if (1e-3..=1.0).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }
}
