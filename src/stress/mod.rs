//! Tests that try to break trees and rays, long ones as well.

pub mod closed;
