//! What a device's faults come to: memory that runs out at any call, a device that is lost at any submit, a budget that
//! does not suffice. An error that says what to do; nothing leaked; the next build right to the bit.

#![allow(clippy::unwrap_used)]

mod caches;
mod disk;
#[cfg(target_os = "linux")]
mod full;
#[cfg(unix)]
mod kills;
mod program;

use crate::gpu::{options, quiet};
use crate::soup::{random, random_rays, scene};
use boxwood::bench::Presets;
use boxwood::bvh::{BuildError, Recipe, SceneBuffers, build};
use boxwood::device::{Buffer, Device, DeviceError, Faults, Options, Timing};
use boxwood::ray_query::{self, TriangleOrder};
use boxwood::scene::Scene;
use boxwood::trace::{Batch, Options as Tracing, RayOrder, Walk, trace};
use std::sync::Arc;

/// A kind of builder by its name in scenes/bench.toml.
fn recipe(name: &str) -> Recipe {
    Presets::own().unwrap().recipe(name).unwrap()
}

fn small() -> Scene {
    scene(&random(300, 0.3, 8))
}

/// The tree's hash, and the words of the hits of each walk and order.
type Found = (String, Vec<Vec<u32>>);

/// Uploads a scene, builds its tree, traces rays by all walks, as given and sorted.
fn work(device: &Arc<Device>, scene: &Scene, recipe: &Recipe) -> Result<Found, BuildError> {
    let buffers = SceneBuffers::upload(device, scene)?;
    let bvh = build(device, &buffers, recipe, Timing::Kernels)?.bvh;
    let hash = bvh.read()?.hash();
    let mut hits = vec![];
    for &walk in Walk::all(device) {
        for order in RayOrder::ALL {
            let mut batch = Batch::new(device, 200, true)?;
            batch.set(&random_rays(200, 3))?;
            let timing = if order == RayOrder::Sorted { Timing::Statistics } else { Timing::Outer };
            trace(device, &bvh, &batch, Tracing { walk, order, ..Tracing::default() }, timing)?;
            hits.push(bytemuck::cast_slice(&batch.hits.read()?).to_vec());
        }
    }
    Ok((hash, hits))
}

/// Builds the driver's own structure, where there is one.
fn drivers_work(device: &Arc<Device>, scene: &Scene) -> Result<Found, BuildError> {
    let buffers = SceneBuffers::upload(device, scene)?;
    ray_query::build(device, &buffers, TriangleOrder::ALL[0], Timing::Kernels)?;
    Ok(Found::default())
}

/// Fails unless the error says that memory ran out, for what, on which device, and what to do.
fn assert_out_of_memory(error: &BuildError, device: &Device, at: &str) {
    let said = error.to_string();
    let what = match error {
        BuildError::Device(DeviceError::Memory { what, needed, .. }) => {
            assert!(*needed > 0 && said.contains(&format!("needs {needed} MiB")), "{at}: {said}");
            what
        }
        BuildError::Device(DeviceError::Full { what, .. }) => what,
        _ => panic!("{at}: another error: {said}"),
    };
    assert!(!what.is_empty() && said.starts_with(what.as_str()), "{at}: {said}");
    let helps = said.contains("MiB") && said.contains("use a smaller scene or another --device");
    assert!(helps && said.contains(&device.info().name) && !said.contains('\n'), "{at}: {said}");
}

/// Runs `work` with memory out from call `first` on, then from `step` further on, until it is there for all of it. In
/// between the device must work as if nothing had been. How many calls failed.
fn run_out_of_memory(
    device: &Arc<Device>,
    name: &str,
    [first, step]: [u64; 2],
    work: &dyn Fn() -> Result<Found, BuildError>,
) -> u64 {
    let right = work().unwrap();
    let before = device.memory_in_use();
    for (tries, call) in (first..).step_by(step as usize).enumerate() {
        device.inject(Faults { allocation: Some(call), ..Faults::default() });
        let done = work();
        device.inject(Faults::default());
        assert_eq!(device.memory_in_use(), before, "{name}, call {call}: memory is still held");
        let at = format!("{name}, call {call}");
        match done {
            Err(error) => assert_out_of_memory(&error, device, &at),
            Ok(found) => {
                assert_eq!(found, right, "{at}");
                return tries as u64;
            }
        }
        if tries % 16 == 0 {
            assert_eq!(work().unwrap(), right, "after {at}");
        }
    }
    unreachable!("call numbers have no end")
}

#[test]
fn memory_that_runs_out_at_any_call_is_an_error_and_no_more() {
    let device = quiet();
    let scene = small();
    // All calls of one builder; of the others a few, at other distances so that they fall on other ones.
    let steps = [("ploc", 1), ("lbvh", 23), ("sah", 29), ("dito", 31), ("odop2", 37), ("auto", 41)];
    for (i, (name, step)) in steps.into_iter().enumerate() {
        let recipe = recipe(name);
        let failed =
            run_out_of_memory(&device, name, [1 + i as u64, step], &|| work(&device, &scene, &recipe));
        assert!(failed > 3 && (step > 1 || failed > 100), "{name}: only {failed} calls failed");
    }
    if device.info().features.iter().any(|f| f.name == "VK_KHR_ray_query" && f.present) {
        let failed = run_out_of_memory(&device, "ray-query", [1, 3], &|| drivers_work(&device, &scene));
        assert!(failed > 5, "only {failed} calls failed");
    }
}

/// A device of a test's own.
fn fresh(faults: Faults) -> Result<Arc<Device>, DeviceError> {
    Device::open(&Options { faults, ..options() })
}

#[test]
fn a_fresh_device_that_runs_out_frees_all_that_it_made() {
    let _turn = quiet();
    let (scene, recipe) = (small(), recipe("dito"));
    let mut failed = 0;
    // Pipelines are made at first use, so each try has a device of its own.
    for call in (1..).step_by(47) {
        let faults = Faults { allocation: Some(call), ..Faults::default() };
        let device = match fresh(faults) {
            Ok(device) => device,
            Err(error) => {
                assert!(call == 1 && matches!(error, DeviceError::Full { .. }), "call {call}: {error}");
                continue;
            }
        };
        let messages = device.all_messages();
        let done = work(&device, &scene, &recipe);
        if let Err(error) = &done {
            assert_out_of_memory(error, &device, &format!("call {call}"));
        }
        drop(device);
        assert!(messages.all().is_empty(), "call {call}: {}", messages.all().join("\n"));
        if done.is_ok() {
            assert!(failed > 10, "only {failed} calls failed");
            return;
        }
        failed += 1;
    }
}

#[test]
fn a_lost_device_says_where_and_stays_lost() {
    let shared = quiet();
    let (scene, recipe) = (small(), recipe("auto"));
    let right = work(&shared, &scene, &recipe).unwrap();
    let (mut lost, mut named) = (0, 0);
    for submit in (1..).step_by(5) {
        for after in [false, true] {
            let number = Some(submit);
            let faults = match after {
                false => Faults { submit: number, ..Faults::default() },
                true => Faults { fence: number, ..Faults::default() },
            };
            let device = fresh(faults).unwrap();
            let messages = device.all_messages();
            let at = format!("submit {submit}, {faults:?}");
            match work(&device, &scene, &recipe) {
                Ok(found) => {
                    assert_eq!(found, right, "{at}");
                    assert!(lost > 8 && named > 1, "only {lost} submits were lost, {named} named");
                    return;
                }
                Err(BuildError::Device(DeviceError::Lost { pass, finished })) => {
                    assert!(!pass.is_empty(), "{at}");
                    // What ran is told by its last pass, where it had one that tells.
                    if after && finished != "none of this submit" {
                        let (name, rest) = finished.split_once(", pass ").unwrap();
                        assert!(!name.is_empty() && rest.contains(" of "), "{at}: {finished}");
                        named += 1;
                    }
                    assert!(after || finished == "none of this submit", "{at}: {finished}");
                }
                Err(other) => panic!("{at}: {other}"),
            }
            lost += 1;
            // Whatever comes next fails, and says why.
            for error in [
                work(&device, &scene, &recipe).unwrap_err().to_string(),
                Buffer::from_slice(&device, "words", &[1u32, 2]).unwrap_err().to_string(),
            ] {
                let whole = error.contains("device lost") && error.contains("it was lost before");
                assert!(whole && error.contains("another --device"), "{at}: {error}");
            }
            drop(device);
            assert!(messages.all().is_empty(), "{at}: {}", messages.all().join("\n"));
        }
    }
}

#[test]
fn a_budget_is_kept_and_what_lies_spare_is_given_back_for_it() {
    let device = quiet();
    let mib = 1 << 20;
    let held = |budget| Faults { budget: Some(device.memory_in_use() + budget), ..Faults::default() };
    device.inject(held(8 * mib));
    let words = |mib: usize| Buffer::<u32>::new(&device, "words", mib << 18);
    let five = words(5).unwrap();
    let error = words(4).unwrap_err().to_string();
    assert!(error.starts_with("words needs 4 MiB of device memory, 3 MiB are free on "), "{error}");
    assert_eq!(device.memory_free() >> 20, 3);
    drop(five);
    // Five spare and four new are more than eight; the spare ones make room.
    assert_eq!(device.memory_free() >> 20, 8);
    drop(words(4).unwrap());
    // What can't be is refused before anything is done.
    let error = SceneBuffers::upload(&device, &scene(&random(300_000, 0.1, 1))).unwrap_err().to_string();
    assert!(error.starts_with("a scene of 300000 triangles needs 10 MiB"), "{error}");
    let buffers = SceneBuffers::upload(&device, &scene(&random(100_000, 0.1, 1))).unwrap();
    let error = build(&device, &buffers, &Recipe::default(), Timing::Off).unwrap_err().to_string();
    assert!(error.starts_with("building over 100000 triangles with ploc needs 29 MiB"), "{error}");
    drop(buffers);
    device.inject(Faults::default());
    let right = work(&device, &small(), &Recipe::default()).unwrap();
    // Enough for all of it, and for less than all: the result is the same, or the error says what is missing.
    let mut refused = 0;
    for budget in 3..9 {
        device.inject(held(budget * mib));
        match work(&device, &small(), &Recipe::default()) {
            Ok(found) => assert_eq!(found, right, "{budget} MiB"),
            Err(error) => {
                assert_out_of_memory(&error, &device, &format!("{budget} MiB"));
                refused += 1;
            }
        }
    }
    device.inject(Faults::default());
    assert!((1..6).contains(&refused), "{refused} of 6");
}
