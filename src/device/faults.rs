//! Faults on demand, for tests: what a driver says once its memory is full or the device is lost, at any call.

use super::error::{Context, DeviceError, Result};
use super::{Device, lock};
use ash::vk;
use std::str::FromStr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Which calls fail. Written `allocation:17`, `submit:3`, `fence:3`, `budget:64MiB`, or several with commas between.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Faults {
    /// From this one on, counted from 1, every call that takes device memory finds none: buffers, pools, fences, queries,
    /// pipelines, structures, commands, submits.
    pub allocation: Option<u64>,
    /// This submit, counted from 1, is refused: the device is lost, and stays so.
    pub submit: Option<u64>,
    /// Likewise, but this submit runs, and the device is lost before its fence tells.
    pub fence: Option<u64>,
    /// Device memory that all buffers may hold at once, bytes.
    pub budget: Option<u64>,
}

impl Faults {
    /// Those of `BOXWOOD_FAULT`, by which tests have the program fail; none where it is not set.
    ///
    /// # Errors
    /// [`DeviceError::NoSuchFault`].
    pub fn from_env() -> Result<Self> {
        match std::env::var_os("BOXWOOD_FAULT").filter(|text| !text.is_empty()) {
            None => Ok(Self::default()),
            Some(text) => text.to_string_lossy().parse(),
        }
    }
}

impl FromStr for Faults {
    type Err = DeviceError;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = || DeviceError::NoSuchFault { given: text.into() };
        let mut faults = Self::default();
        for fault in text.split(',') {
            let (name, number) = fault.split_once(':').ok_or_else(wrong)?;
            let (place, number) = match name {
                "allocation" => (&mut faults.allocation, number),
                "submit" => (&mut faults.submit, number),
                "fence" => (&mut faults.fence, number),
                "budget" => (&mut faults.budget, number.strip_suffix("MiB").ok_or_else(wrong)?),
                _ => return Err(wrong()),
            };
            let unit = if name == "budget" { 1 << 20 } else { 1 };
            let digits = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
            let number = number.parse::<u64>().ok().filter(|n| digits && *n > 0);
            let number = number.and_then(|n| n.checked_mul(unit)).ok_or_else(wrong)?;
            if place.replace(number).is_some() {
                return Err(wrong());
            }
        }
        Ok(faults)
    }
}

/// The faults of a device, and how far it is from them.
#[derive(Default)]
pub(super) struct Due {
    faults: Mutex<Faults>,
    allocations: AtomicU64,
    submits: AtomicU64,
}

impl Due {
    pub(super) fn new(faults: Faults) -> Self {
        Self { faults: Mutex::new(faults), ..Self::default() }
    }

    /// Counts a call that takes device memory.
    pub(super) fn allocation(&self) -> std::result::Result<(), vk::Result> {
        let number = self.allocations.fetch_add(1, Ordering::Relaxed) + 1;
        match lock(&self.faults).allocation {
            Some(first) if number >= first => Err(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY),
            _ => Ok(()),
        }
    }

    /// Counts a submit; its number.
    pub(super) fn submit(&self) -> std::result::Result<u64, vk::Result> {
        let number = self.submits.fetch_add(1, Ordering::Relaxed) + 1;
        match lock(&self.faults).submit {
            Some(fatal) if number == fatal => Err(vk::Result::ERROR_DEVICE_LOST),
            _ => Ok(number),
        }
    }

    /// What comes after submit `number` has run.
    pub(super) fn fence(&self, number: u64) -> std::result::Result<(), vk::Result> {
        match lock(&self.faults).fence {
            Some(fatal) if number == fatal => Err(vk::Result::ERROR_DEVICE_LOST),
            _ => Ok(()),
        }
    }

    /// All the device memory there is, where that is less than what the driver has.
    pub(super) fn budget(&self) -> Option<u64> {
        lock(&self.faults).budget
    }
}

impl Device {
    /// From now on these calls fail, none of them: none does. They count from here, with no buffer spare.
    pub fn inject(&self, faults: Faults) {
        self.free_spare();
        *lock(&self.due.faults) = faults;
        self.due.allocations.store(0, Ordering::Relaxed);
        self.due.submits.store(0, Ordering::Relaxed);
    }

    /// Makes a call that takes device memory, `what` for.
    pub(super) fn taking<T>(
        &self,
        what: &str,
        call: impl FnOnce() -> std::result::Result<T, vk::Result>,
    ) -> Result<T> {
        match self.due.allocation().and_then(|()| call()) {
            Err(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY) => Err(self.full(what)),
            other => other.context(what),
        }
    }

    /// No memory for what only the driver knows the size of.
    pub(super) fn full(&self, what: &str) -> DeviceError {
        let (available, device) = (self.memory_free() >> 20, self.info.name.clone());
        DeviceError::Full { what: what.into(), available, device }
    }

    /// Bytes of all buffers, spare ones too.
    fn held(&self) -> u64 {
        lock(&self.buffers).values().sum()
    }

    /// Counts a buffer's memory, which may be more than the budget has.
    pub(super) fn take_budget(&self, bytes: u64) -> std::result::Result<(), vk::Result> {
        self.due.allocation()?;
        match self.due.budget() {
            Some(budget) if self.held() + bytes > budget => Err(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY),
            _ => Ok(()),
        }
    }

    /// What is free of `driver`'s bytes within the budget.
    pub(super) fn within_budget(&self, driver: u64) -> u64 {
        self.due.budget().map_or(driver, |budget| driver.min(budget.saturating_sub(self.held())))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::Faults;

    #[test]
    fn faults_are_named_and_absurd_ones_refused() {
        let all = "allocation:17,submit:3,fence:1,budget:64MiB".parse::<Faults>().unwrap();
        let wanted = Faults { allocation: Some(17), submit: Some(3), fence: Some(1), budget: Some(64 << 20) };
        assert_eq!(all, wanted);
        for bad in [
            "",
            "allocation",
            "allocation:",
            "allocation:0",
            "allocation:-1",
            "allocation:+1",
            "allocation:1.5",
            "allocation:99999999999999999999",
            "allocation:1,allocation:2",
            "allocation:1,",
            "submit:x",
            "fence: 1",
            "budget:64",
            "budget:0MiB",
            "budget:99999999999999MiB",
            "memory:1",
        ] {
            let error = bad.parse::<Faults>().unwrap_err().to_string();
            assert!(error.contains("BOXWOOD_FAULT") && error.contains("allocation:N"), "{bad}: {error}");
        }
    }
}
