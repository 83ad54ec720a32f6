//! What can go wrong on a device, in words that say where and what to do.

use ash::vk;

/// A failure of the device layer.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// The Vulkan loader is missing.
    #[error("no Vulkan loader: {0}; install libvulkan1 (Debian), or run `make setup`")]
    NoLoader(String),
    /// No device can be used.
    #[error(
        "no Vulkan device can run boxwood ({tried}); run `make setup` for a software device, set VK_DRIVER_FILES, or see `boxwood devices`"
    )]
    NoDevice {
        /// Each device and why not.
        tried: String,
    },
    /// `--device` names none of them.
    #[error("--device {wanted}: no usable device of that number or name (there are: {there})")]
    NoSuchDevice {
        /// As given.
        wanted: String,
        /// The usable ones.
        there: String,
    },
    /// The validation layers were asked for and aren't there.
    #[error("VK_LAYER_KHRONOS_validation is not installed; run `make setup`, or unset BOXWOOD_VALIDATION")]
    NoValidation,
    /// The device stopped.
    #[error(
        "{pass}: device lost (last pass that finished: {finished}); a driver fault or a watchdog: try a smaller scene, a newer driver, or another --device"
    )]
    Lost {
        /// Where the loss was noticed.
        pass: String,
        /// The last pass known to have finished.
        finished: String,
    },
    /// Not enough memory.
    #[error(
        "{what} needs {needed} MiB of device memory, {available} MiB are free on {device}; use a smaller scene or another --device"
    )]
    Memory {
        /// What for.
        what: String,
        /// Needed, MiB.
        needed: u64,
        /// Free, MiB.
        available: u64,
        /// Device name.
        device: String,
    },
    /// Not enough memory for something of which only the driver knows the size.
    #[error(
        "{what}: {device} is out of device memory, though {available} MiB are said to be free; use a smaller scene or another --device, or end what else uses it"
    )]
    Full {
        /// What for.
        what: String,
        /// Said to be free, MiB.
        available: u64,
        /// Device name.
        device: String,
    },
    /// BOXWOOD_FAULT is none.
    #[error(
        "BOXWOOD_FAULT is {given:?}, which is no fault; write allocation:N, submit:N or fence:N, N from 1, or budget:NMiB, commas between several; or unset it, for it is for tests"
    )]
    NoSuchFault {
        /// As given.
        given: String,
    },
    /// A device limit.
    #[error("{what}: {wanted} exceeds this device's limit of {limit}")]
    Limit {
        /// What.
        what: String,
        /// Wanted.
        wanted: u64,
        /// The limit.
        limit: u64,
    },
    /// A feature that only some devices have.
    #[error(
        "{device} has no {what}: choose another --device (`boxwood devices` lists what each has), or do without"
    )]
    Lacking {
        /// Device name.
        device: String,
        /// Vulkan's name of it.
        what: String,
    },
    /// Any other failed call.
    #[error("{call}: {result}")]
    Vulkan {
        /// The call, or the pass it was made for.
        call: String,
        /// What Vulkan said.
        result: vk::Result,
    },
    /// The allocator refused.
    #[error("allocating {what} ({bytes} bytes): {source}")]
    Allocation {
        /// Buffer name.
        what: String,
        /// Bytes.
        bytes: u64,
        /// The allocator's reason.
        source: gpu_allocator::AllocationError,
    },
}

/// Result of the device layer.
pub type Result<T> = std::result::Result<T, DeviceError>;

/// Adds what was being done to a Vulkan result.
pub(super) trait Context<T> {
    /// The same, with the call's name.
    fn context(self, call: &str) -> Result<T>;
}

impl<T> Context<T> for std::result::Result<T, vk::Result> {
    fn context(self, call: &str) -> Result<T> {
        self.map_err(|result| match result {
            vk::Result::ERROR_DEVICE_LOST => {
                DeviceError::Lost { pass: call.into(), finished: "unknown".into() }
            }
            result => DeviceError::Vulkan { call: call.into(), result },
        })
    }
}
