//! Integration tests: one binary, so that one device serves all.

mod gpu;
mod oracle;
mod rays;
mod scene;
