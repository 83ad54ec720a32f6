//! The one device of all tests, and the guard that fails a test whose passes the validation layers object to.

#![allow(clippy::unwrap_used)]

use boxwood::device::{Device, Options};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// How tests open devices: `BOXWOOD_VALIDATION` turns the validation layers on.
pub fn options() -> Options {
    Options::from_env()
}

/// The device, opened once.
pub fn gpu() -> &'static Arc<Device> {
    static DEVICE: OnceLock<Arc<Device>> = OnceLock::new();
    DEVICE.get_or_init(|| Device::open(&options()).unwrap())
}

/// Holds the devices for one test, so that a message is the fault of the test that runs; checks that there is none.
pub struct Quiet<'a> {
    device: &'a Arc<Device>,
    messages: usize,
    _turn: MutexGuard<'static, ()>,
}

/// [`gpu`] to oneself until the guard goes.
pub fn quiet() -> Quiet<'static> {
    quiet_on(gpu)
}

/// Another device likewise; `device` is called once the turn has come.
pub fn quiet_on<'a>(device: impl FnOnce() -> &'a Arc<Device>) -> Quiet<'a> {
    static TURN: Mutex<()> = Mutex::new(());
    let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let device = device();
    Quiet { device, messages: device.messages().len(), _turn: turn }
}

impl std::ops::Deref for Quiet<'_> {
    type Target = Arc<Device>;
    fn deref(&self) -> &Arc<Device> {
        self.device
    }
}

impl Drop for Quiet<'_> {
    fn drop(&mut self) {
        let messages = self.device.messages();
        if !std::thread::panicking() {
            assert!(messages.len() == self.messages, "validation: {}", messages[self.messages..].join("\n"));
        }
    }
}
