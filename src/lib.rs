//! boxwood: bounding volume hierarchies built and traced by Vulkan compute shaders, and measured honestly.
//!
//! Flow: `scene → bvh::{morton → sort → ploc → collapse → layout} → trace → bench::report`.

pub mod abi;
pub mod bench;
pub mod bvh;
pub mod cli;
pub mod device;
pub mod kernels;
pub mod oracle;
pub mod scene;
pub mod trace;
