//! Time by kernel: the dispatches of one kernel are one row.

use crate::device::Pass;
use std::borrow::Cow;

/// All dispatches of one kernel.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct KernelTime {
    /// `stage/verb`; of work on the host likewise.
    pub name: Cow<'static, str>,
    /// Dispatches.
    pub count: usize,
    /// Device time of all of them, ms; wall time of work on the host.
    pub ms: f64,
}

/// One row a kernel, in order of first use.
pub fn by_kernel(passes: &[Pass]) -> Vec<KernelTime> {
    let mut rows = vec![];
    add_kernels(&mut rows, passes);
    rows
}

/// Adds `passes` to their kernels' rows.
pub(super) fn add_kernels(rows: &mut Vec<KernelTime>, passes: &[Pass]) {
    for pass in passes {
        match rows.iter_mut().find(|r| r.name == pass.name) {
            Some(row) => {
                row.count += 1;
                row.ms += pass.ms;
            }
            None => rows.push(KernelTime { name: pass.name.into(), count: 1, ms: pass.ms }),
        }
    }
}
