//! No ray gets out of a closed mesh, and what would let one out is found out.

#![allow(clippy::unwrap_used)]

use crate::cli::Folder;
use crate::gpu::{quiet, quiet_on};
use crate::matrix::each_width;
use boxwood::bvh::Method;
use boxwood::stress::closed::{Fault, Plan, Row, Solid, Step, run};
use boxwood::trace::Precision;
use serde_json::Value;
use std::cell::Cell;

fn plan(rays: u64, builders: &[&str]) -> Plan {
    let builders = builders.iter().map(|name| Method::named(name).unwrap()).collect();
    Plan { rays, builders, seed: 0, solids: Solid::all(), precision: Precision::Robust }
}

fn assert_tight(rows: &[Row], rays: u64) {
    for row in rows {
        assert_eq!(row.faults(), 0, "{row:?}");
    }
    assert_eq!(rows.iter().map(|r| r.rays).sum::<u64>(), rays);
    assert!(rows.iter().map(|r| r.judged).sum::<u64>() >= rays / 16);
}

#[test]
fn no_ray_of_a_million_gets_out() {
    let device = quiet();
    let builders = ["ploc", "lbvh", "sah", "dito14", "odop2", "hybrid", "auto"];
    let plan = plan(1_000_000, &builders);
    let (traced, done) = (Cell::new(0), Cell::new(0));
    let told = |step: Step| match step {
        Step::Traced(rays) => traced.set(traced.get() + rays),
        Step::Done(rows) => {
            done.set(done.get() + 1);
            assert_eq!(rows.len(), done.get());
        }
    };
    let rows = run(&device, &plan, &told).unwrap();
    assert_eq!((rows.len(), traced.get(), done.get()), (plan.solids.len() * 7 * 3, 1_000_000, rows.len()));
    assert_tight(&rows, 1_000_000);
    let oriented = rows.iter().filter(|r| r.oriented > 0).count();
    assert!(oriented > rows.len() / 3, "{oriented} of {} rows go through oriented boxes", rows.len());
}

#[test]
fn nor_without_doubles() {
    // The first is the device of the test above.
    for device in each_width().into_iter().skip(1) {
        let device = quiet_on(device);
        assert_tight(&run(&device, &plan(200_000, &["ploc", "dito14"]), &|_| ()).unwrap(), 200_000);
    }
}

#[test]
fn what_lets_rays_out_is_found_out() {
    let device = quiet();
    let sum = |rows: &[Row]| {
        rows.iter()
            .fold([0; 4], |s, r| [s[0] + r.misses, s[1] + r.leaks, s[2] + r.others, s[3] + r.contradicted])
    };
    // A test that rounds misses edges.
    let fast = Plan { precision: Precision::Fast, ..plan(60_000, &["ploc"]) };
    let rows = run(&device, &fast, &|_| ()).unwrap();
    let [misses, leaks, ..] = sum(&rows);
    assert!(misses > 100 && leaks > 0, "{misses} misses, {leaks} leaks");
    let example = rows.iter().flat_map(|r| &r.examples).find(|e| e.fault == Fault::Miss).unwrap();
    assert!(example.t.is_infinite() && example.way.contains("trace/"), "{example:?}");
    // A hole of a triangle in a thousand; in a tube, other walls are behind.
    for name in ["sphere", "cube", "needles", "torus"] {
        let mut holed = plan(60_000, &["ploc", "dito14"]);
        holed.solids.retain(|s| s.name == name);
        // In its place, so that the others keep their numbers, one that can't be hit.
        let first = holed.solids[0].scene.triangles[17][0];
        holed.solids[0].scene.triangles[17] = [first; 3];
        let [misses, leaks, others, contradicted] = sum(&run(&device, &holed, &|_| ()).unwrap());
        assert!(misses + leaks > 0, "{name}: {misses} misses, {leaks} leaks");
        assert_eq!((others, contradicted), (0, 0), "{name}: the reference knows the hole");
    }
    // A wall behind which the surface should be.
    let mut walled = plan(20_000, &["ploc"]);
    walled.solids.retain(|s| s.name == "sphere");
    let scene = &mut walled.solids[0].scene;
    let first = scene.positions.len() as u32;
    scene.positions.extend([[-2.0, -2.0, 0.99], [2.0, -2.0, 0.99], [0.0, 3.0, 0.99]]);
    scene.triangles.push([first, first + 1, first + 2]);
    let [misses, leaks, others, contradicted] = sum(&run(&device, &walled, &|_| ()).unwrap());
    assert!(others > 100 && misses + leaks + contradicted == 0, "{misses} {leaks} {others} {contradicted}");
}

#[test]
fn the_command_tells_counts() {
    let folder = Folder::new();
    let args =
        ["stress", "--closed", "20000", "--builders", "ploc,auto", "--json", "closed.json", "--seed", "3"];
    let out = folder.run(&args);
    let (stdout, stderr) = (String::from_utf8(out.stdout).unwrap(), String::from_utf8(out.stderr).unwrap());
    assert_eq!(out.status.code(), Some(0), "{stderr}");
    assert!(stdout.contains("| needles") && stdout.contains("| all"), "{stdout}");
    let report: Value = serde_json::from_slice(&std::fs::read(folder.path("closed.json")).unwrap()).unwrap();
    for (key, value) in [("rays", 20_000), ("misses", 0), ("leaks", 0), ("others", 0), ("seed", 3)] {
        assert_eq!(report[key], value, "{key}");
    }
    assert_eq!(report["rows"].as_array().unwrap().len(), Solid::all().len() * 2 * 3);
    assert!(report["commit"].is_string() && report["device"].is_string() && report["driver"].is_string());
    folder.fails(&["stress", "--closed", "0"], 2, "--closed");
    folder.fails(&["stress", "--closed", "9", "--json", "none/a.json"], 1, "none/a.json");
}
