//! Fuzz targets of boxwood's readers, and what they run in.

pub mod targets;

use std::alloc::{GlobalAlloc, Layout, System};

/// Most bytes that anything may take at once: a Zstandard window is half of it. Where it isn't asked whether there are as
/// many, the process ends, and the input is kept.
const LARGEST: usize = 256 << 20;

#[global_allocator]
static BOUNDED: Bounded = Bounded;

/// The system's, but for what is larger than [`LARGEST`]. (libFuzzer's own limit needs a sanitizer.)
struct Bounded;

// SAFETY: what the system's allocator promises, it keeps; null stands for what it doesn't give.
unsafe impl GlobalAlloc for Bounded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.size() > LARGEST {
            return std::ptr::null_mut();
        }
        // SAFETY: the caller's promises are handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(ptr, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if layout.size() > LARGEST {
            return std::ptr::null_mut();
        }
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, ptr: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if size > LARGEST {
            return std::ptr::null_mut();
        }
        // SAFETY: as above.
        unsafe { System.realloc(ptr, layout, size) }
    }
}

/// Keeps rayon on the thread that fuzzes: handing a small mesh to another takes longer than reading it.
pub fn alone() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("rayon starts");
}
