//! Fuzz targets of boxwood's readers.

pub mod targets;

/// Keeps rayon on the thread that fuzzes: handing a small mesh to another takes longer than reading it.
pub fn alone() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("rayon starts");
}
