//! Integration tests.

mod scene;
