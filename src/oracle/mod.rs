//! CPU twins of the kernels, and references that they answer to. Order of trust: brute > reference > device.

pub mod brute;
pub mod compare;
pub mod exact;
pub mod rays;
pub mod reference;
pub mod validate;
