//! The arguments of each kernel, by what the kernels are for.

mod binary;
mod boxes;
mod order;
mod packed;
mod ray_query;
mod rays;
mod trace;

pub use binary::*;
pub use boxes::*;
pub use order::*;
pub use packed::*;
pub use ray_query::*;
pub use rays::*;
pub use trace::*;
