//! spirv-val on every module.

#![allow(clippy::unwrap_used)]

use boxwood::kernels;
use std::process::Command;

#[test]
fn every_module_is_valid() {
    let dir = tempfile::tempdir().unwrap();
    assert!(kernels::ALL.len() > 10);
    for (name, [words, pairs]) in kernels::ALL {
        for (kind, bytes) in [("words", words), ("pairs", pairs)] {
            let path = dir.path().join(format!("{}.{kind}.spv", name.replace('/', "_")));
            std::fs::write(&path, bytes).unwrap();
            let out = Command::new("spirv-val")
                .args(["--target-env", "vulkan1.2", "--scalar-block-layout"])
                .arg(&path)
                .output()
                .unwrap_or_else(|e| panic!("spirv-val did not start ({e}); run `make setup`"));
            let said =
                String::from_utf8_lossy(&out.stderr).into_owned() + &String::from_utf8_lossy(&out.stdout);
            assert!(out.status.success() && said.trim().is_empty(), "{name} ({kind}): {said}");
        }
    }
}
