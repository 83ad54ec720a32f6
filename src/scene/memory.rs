//! Whether there is memory for what a scene takes, asked before it is taken: many systems promise more than they have,
//! and end the program that believes them.

use sysinfo::System;

/// Bytes that are there wherever boxwood runs.
const SMALL: u64 = 64 << 20;

/// Bytes of memory that are free, of the machine and of the container that boxwood runs in; all, where nobody says.
pub(super) fn free() -> u64 {
    let mut system = System::new();
    system.refresh_memory();
    let machine = match system.available_memory() {
        0 => u64::MAX,
        bytes => bytes,
    };
    system.cgroup_limits().map_or(machine, |limits| machine.min(limits.free_memory))
}

/// Fails where there are fewer than `bytes` free.
///
/// # Errors
/// In words that follow what takes them.
pub(super) fn must_hold(bytes: u64) -> Result<(), String> {
    if bytes <= SMALL {
        return Ok(());
    }
    match free() {
        free if bytes <= free => Ok(()),
        free => Err(format!("take {bytes} bytes of memory, and {free} are free")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_machine_holds_all() {
        assert!(must_hold(SMALL).is_ok());
        assert!(must_hold(SMALL + 1).is_ok() || free() < 2 * SMALL);
        let error = must_hold(u64::MAX - 1).unwrap_err();
        assert!(error.starts_with("take 18446744073709551614 bytes of memory, and "), "{error}");
    }
}
