//! Integration tests: one binary, so that one device serves all.

mod cli;
mod gpu;
mod oracle;
mod rays;
mod scene;
