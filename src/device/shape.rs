//! Kernel shapes: how many items an invocation takes, how large a workgroup is. Software drivers are CPUs with wide
//! vectors, where an invocation that streams a long run wins; GPUs want many invocations of little work each.
//! Trees and hits don't depend on any of this.

use super::DeviceInfo;

/// Shapes that suit one device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    /// Workgroup size of the streaming kernels, invocations.
    pub workgroup: u32,
    /// Consecutive clusters, nodes or triangles that one invocation of a streaming kernel takes.
    pub items: u32,
    /// Workgroup size of the sort's kernels.
    pub sort_workgroup: u32,
    /// Keys that one invocation of the sort takes.
    pub sort_items: u32,
    /// Bits of a sort digit: counters take 4 · 2^bits · workgroup bytes of shared memory.
    pub sort_digit_bits: u32,
    /// Workgroup size of kernels that run in one workgroup.
    pub single_workgroup: u32,
    /// Workgroup size of ray kernels.
    pub trace_workgroup: u32,
    /// PLOC's search window in registers, each pair computed once, for radii up to 32; else every neighbour is loaded.
    pub search_in_registers: bool,
    /// Triangles that an invocation of `orient/refit` takes.
    pub refit_items: u32,
    /// Bases whose boxes `odopfit/climb` takes up the tree together: an invocation holds 25 floats of each.
    pub bases: u32,
    /// Rays that an invocation of `trace/refill` takes, one after the other.
    pub refill: u32,
    /// Workgroups of `trace/persistent`: as many as the device runs at once. More do no harm, for they find no ray left.
    pub persistent_groups: u32,
    /// `trace/persistent` takes rays as soon as fewer than this many eighths of a subgroup have one; 0: once none has.
    pub persistent_few: u32,
    /// Whether packets may pay: rays that walk the tree a subgroup at a time.
    pub packets: bool,
    /// Threads that workgroups are dealt to; 1 on a GPU.
    pub threads: u32,
}

impl Shape {
    /// The shape for `device`.
    pub fn of(device: &DeviceInfo) -> Self {
        if device.is_cpu() { Self::software(device.subgroup_size) } else { Self::gpu(device.max_workgroup) }
    }

    /// For software drivers: measured on lavapipe 25.0.7, 2 cores of Zen 5.
    pub fn software(subgroup: u32) -> Self {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
        let threads = std::env::var("LP_NUM_THREADS").ok().and_then(|s| s.parse().ok()).unwrap_or(threads);
        Self {
            // One subgroup: their scans then need no shared memory.
            workgroup: subgroup.max(4),
            items: 124,
            sort_workgroup: subgroup.max(8),
            sort_items: 1000,
            sort_digit_bits: 8,
            single_workgroup: subgroup.max(4),
            trace_workgroup: 64,
            search_in_registers: true,
            refit_items: 8,
            bases: 4,
            refill: 16,
            persistent_groups: threads.max(1),
            // The least process time of 0, 4, 5, 6, 7 and 8 on most sets of rays.
            persistent_few: 0,
            packets: true,
            threads: threads.max(1),
        }
    }

    /// For GPUs: by the books, not measured.
    pub fn gpu(max_workgroup: u32) -> Self {
        Self {
            workgroup: max_workgroup.min(256),
            items: 2,
            sort_workgroup: max_workgroup.min(256),
            sort_items: 16,
            sort_digit_bits: 4,
            single_workgroup: max_workgroup.min(512),
            trace_workgroup: 64,
            search_in_registers: false,
            refit_items: 2,
            bases: 2,
            refill: 4,
            // 2^18 invocations: 128 multiprocessors of 2048.
            persistent_groups: 4096,
            // The authors' 20 of 32.
            persistent_few: 5,
            packets: false,
            threads: 1,
        }
    }
}
