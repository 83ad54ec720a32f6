//! Integration tests: one binary, so that one device serves all.

mod oracle;
mod scene;
