//! Integration tests: one binary, so that one device serves all.

mod gpu;
mod matrix;
mod oracle;
mod scene;
mod soup;
mod trace;
