//! What tests cost on the device: measured, kept, and good enough to rank trees by.

#![allow(clippy::unwrap_used)]

use crate::gpu::{quiet, quiet_on};
use crate::matrix::each_width;
use boxwood::bench::Costs;
use std::fs;

#[test]
fn every_test_costs_something() {
    for device in each_width() {
        let device = quiet_on(device);
        let costs = Costs::measured(&device, None).unwrap();
        assert!(costs.to_array().iter().all(|c| c.is_finite() && *c > 0.0), "{costs:?}");
    }
}

#[test]
fn what_was_measured_is_kept() {
    let device = quiet();
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let costs = Costs::measured(&device, Some(&cache)).unwrap();
    let files: Vec<_> = fs::read_dir(&cache).unwrap().map(|f| f.unwrap().path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    assert_eq!(Costs::measured(&device, Some(&cache)).unwrap(), costs, "measured anew");
    // What can't be read is measured again, and kept in its place.
    fs::write(&files[0], "{").unwrap();
    let again = Costs::measured(&device, Some(&cache)).unwrap();
    assert_eq!(Costs::measured(&device, Some(&cache)).unwrap(), again);
    assert_eq!(fs::read_dir(&cache).unwrap().count(), 1);
    // No folder can be made within a file.
    let nowhere = files[0].join("cache");
    assert!(Costs::measured(&device, Some(&nowhere)).is_ok());
}
