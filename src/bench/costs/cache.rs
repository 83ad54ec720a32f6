//! Measured costs, kept: a small file a device, driver, commit and kernel shape in boxwood's cache folder.

use super::Costs;
use crate::device::Device;
use crate::output;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What costs hang on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Key {
    device: String,
    driver: String,
    commit: String,
    /// Of kernels, the number of threads among it, and whether they have 64-bit numbers.
    shape: String,
}

/// A file of the cache.
#[derive(Serialize, Deserialize)]
struct Kept {
    #[serde(flatten)]
    key: Key,
    /// ns.
    costs: Costs,
    /// SHA-256 of all else.
    sha256: String,
}

impl Key {
    /// Of `device`, by this boxwood.
    pub(super) fn of(device: &Device) -> Self {
        Self {
            device: device.info().name.clone(),
            driver: device.info().driver.clone(),
            commit: env!("BOXWOOD_COMMIT").to_owned(),
            shape: format!("{:?}, wide: {}", device.shape(), device.is_wide()),
        }
    }

    fn path(&self, folder: &Path) -> PathBuf {
        let Self { device, driver, commit, shape } = self;
        let sum = hex(format!("{device}\n{driver}\n{commit}\n{shape}"));
        folder.join(format!("costs-{}.json", &sum[..16]))
    }

    /// Of this key with `costs`, bit for bit.
    fn sum(&self, costs: &Costs) -> String {
        hex(format!("{self:?} {:x?}", costs.to_array().map(f64::to_bits)))
    }

    /// What is kept; none where there is nothing, or something else.
    pub(super) fn read(&self, folder: &Path) -> Option<Costs> {
        let Kept { key, costs, sha256 } = serde_json::from_slice(&fs::read(self.path(folder)).ok()?).ok()?;
        let sound = costs.to_array().iter().all(|c| c.is_finite() && *c > 0.0);
        (sound && key == *self && sha256 == self.sum(&costs)).then_some(costs)
    }

    /// Keeps `costs`: the file is there whole or not at all.
    pub(super) fn write(&self, folder: &Path, costs: &Costs) -> io::Result<()> {
        fs::create_dir_all(folder)?;
        let kept = Kept { key: self.clone(), costs: *costs, sha256: self.sum(costs) };
        output::write(&self.path(folder), &serde_json::to_vec_pretty(&kept)?)
    }
}

/// SHA-256 of a text.
fn hex(text: String) -> String {
    Sha256::digest(text).iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_meant_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let cache = folder.path().join("not there yet");
        let key = |driver: &str| Key {
            device: "d".into(),
            driver: driver.into(),
            commit: "c".into(),
            shape: "s".into(),
        };
        let costs = Costs { boxes: 0.1, oriented: 0.2, triangles: 0.1 + 0.2 };
        assert_eq!(key("1").read(&cache), None);
        key("1").write(&cache, &costs).unwrap();
        assert_eq!((key("1").read(&cache), key("2").read(&cache)), (Some(costs), None));
        assert_eq!(fs::read_dir(&cache).unwrap().count(), 1);
        // Of another key under this one's name, damaged, senseless.
        fs::copy(key("1").path(&cache), key("2").path(&cache)).unwrap();
        assert_eq!(key("2").read(&cache), None);
        let text = fs::read_to_string(key("1").path(&cache)).unwrap();
        for bad in [&text[..text.len() / 2], "", &text.replace("0.1", "-0.1"), &text.replace("0.1", "0.3")] {
            fs::write(key("1").path(&cache), bad).unwrap();
            assert_eq!(key("1").read(&cache), None, "{bad}");
        }
        // Cut anywhere, and any bit of any byte flipped: never anything but what was kept.
        let whole = text.as_bytes();
        for at in 0..whole.len() {
            fs::write(key("1").path(&cache), &whole[..at]).unwrap();
            assert_eq!(key("1").read(&cache), None, "cut at {at}");
            let mut flipped = whole.to_vec();
            flipped[at] ^= 1 << (at % 8);
            fs::write(key("1").path(&cache), flipped).unwrap();
            assert!(key("1").read(&cache).is_none_or(|read| read == costs), "a bit of byte {at}");
        }
        key("1").write(&cache, &costs).unwrap();
        assert_eq!(key("1").read(&cache), Some(costs));
    }
}
