//! The device layer: buffers, passes, times, errors.

#![allow(clippy::unwrap_used)]

use crate::gpu::{gpu, quiet};
use crate::soup::{random, scene};
use boxwood::abi::{SPEC_WG, SortGatherArgs};
use boxwood::bvh::{self, Recipe, SceneBuffers};
use boxwood::device::{Buffer, Device, DeviceError, Options, Recorder, Timing, list};
use boxwood::kernels;

fn gather(
    rec: &mut Recorder,
    source: &Buffer<u32>,
    order: &Buffer<u32>,
    gathered: &Buffer<u32>,
    workgroup: u32,
) -> Result<(), DeviceError> {
    let count = order.len() as u32;
    let args =
        SortGatherArgs { source: source.ptr(), order: order.ptr(), gathered: gathered.ptr_mut(), count };
    rec.dispatch(&kernels::SORT_GATHER, &[(SPEC_WG, workgroup)], count.div_ceil(workgroup), args)
}

#[test]
fn bytes_survive_the_way_there_and_back() {
    let device = quiet();
    // Staging goes 32 MiB at a time: one word less, as much, one more, and more than two.
    let chunk = 8 << 20;
    for n in [0, 1, 3, chunk - 1, chunk, chunk + 1, 2 * chunk + 3] {
        let words: Vec<u32> = (0..n as u32).map(|i| i.wrapping_mul(0x9e37_79b9)).collect();
        let buffer = Buffer::from_slice(&device, "round trip", &words).unwrap();
        assert!(buffer.read().unwrap() == words, "{n} words");
        if n > 0 {
            assert_eq!(buffer.read_at(n - 1).unwrap(), words[n - 1]);
            assert_eq!(buffer.read_first(n / 2).unwrap(), words[..n / 2]);
        }
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let device = quiet();
    let buffer = Buffer::<u32>::new(&device, "small", 4).unwrap();
    for error in [
        buffer.write(&[0; 5]).unwrap_err(),
        buffer.read_first(5).unwrap_err(),
        buffer.read_at(4).unwrap_err(),
    ] {
        assert!(matches!(error, DeviceError::Limit { limit: 4, .. }), "{error}");
    }
    let error = device.require_memory("a test", u64::MAX).unwrap_err();
    assert!(matches!(error, DeviceError::Memory { needed, .. } if needed == u64::MAX >> 20), "{error}");
    let message = error.to_string();
    assert!(message.starts_with("a test needs ") && message.contains(&device.info().name), "{message}");
    device.require_memory("a test", 1 << 20).unwrap();
}

#[test]
fn unknown_devices_are_named_with_those_there_are() {
    for wanted in ["no such device", "4096"] {
        let options = Options { device: Some(wanted.into()), ..Options::default() };
        let message = Device::open(&options).unwrap_err().to_string();
        assert!(message.contains(wanted) && message.contains(&gpu().info().name), "{message}");
    }
    let all = list().unwrap();
    assert!(all.iter().any(|d| d.usable() && d.features.iter().all(|f| f.present || !f.required)));
}

#[test]
fn grids_of_more_groups_than_a_row_holds() {
    let device = quiet();
    for n in [65_535u32, 65_536, 65_537, 100_001] {
        let source: Vec<u32> = (0..n).map(|i| i * 3).collect();
        let order: Vec<u32> = (0..n).rev().collect();
        let [source, order] = [source, order].map(|x| Buffer::from_slice(&device, "numbers", &x).unwrap());
        let gathered = Buffer::<u32>::new(&device, "gathered", n as usize).unwrap();
        let mut rec = Recorder::new(&device, Timing::Off).unwrap();
        gather(&mut rec, &source, &order, &gathered, 1).unwrap();
        rec.submit().unwrap();
        assert!(gathered.read().unwrap().iter().rev().enumerate().all(|(i, x)| *x == 3 * i as u32), "{n}");
    }
}

#[test]
fn passes_follow_each_other_or_overlap() {
    let device = quiet();
    let n = 5000u32;
    let order: Vec<u32> = (0..n).map(|i| (i + 1) % n).collect();
    let order = Buffer::from_slice(&device, "order", &order).unwrap();
    let first = Buffer::from_slice(&device, "numbers", &(0..n).collect::<Vec<_>>()).unwrap();
    let (a, b) = (
        Buffer::<u32>::new(&device, "a", n as usize).unwrap(),
        Buffer::<u32>::new(&device, "b", n as usize).unwrap(),
    );
    let mut rec = Recorder::new(&device, Timing::Off).unwrap();
    gather(&mut rec, &first, &order, &a, 64).unwrap();
    gather(&mut rec, &a, &order, &b, 64).unwrap();
    gather(&mut rec, &b, &order, &a, 64).unwrap();
    rec.submit().unwrap();
    assert!(a.read().unwrap().iter().enumerate().all(|(i, x)| *x == (i as u32 + 3) % n));
    let mut rec = Recorder::new(&device, Timing::Off).unwrap();
    // Both only read what was there before.
    rec.overlap(|rec| {
        gather(rec, &first, &order, &a, 64)?;
        gather(rec, &first, &order, &b, 64)
    })
    .unwrap();
    rec.submit().unwrap();
    assert_eq!(a.read().unwrap(), b.read().unwrap());
}

#[test]
fn times_add_up_and_bear_the_kernels_names() {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &scene(&random(20_000, 0.05, 1))).unwrap();
    let build = |timing| bvh::build(&device, &buffers, &Recipe::default(), timing).unwrap();
    build(Timing::Off);
    let built = build(Timing::Kernels);
    let times = &built.times;
    let sum: f64 = times.passes.iter().map(|p| p.ms).sum();
    assert!(sum > 0.0 && times.passes.iter().all(|p| p.ms >= 0.0), "{times:?}");
    assert!((sum / times.device_ms - 1.0).abs() < 0.01, "passes {sum} ms, all {} ms", times.device_ms);
    assert!(times.device_ms <= times.wall_ms, "{} ms of {} ms", times.device_ms, times.wall_ms);
    for pass in &times.passes {
        assert!(kernels::ALL.iter().any(|k| k.0 == pass.name), "{}", pass.name);
    }
    for name in [
        "morton/bounds",
        "morton/encode",
        "sort/count",
        "sort/scatter",
        "ploc/search",
        "ploc/merge",
        "layout/nodes",
        "layout/triangles",
    ] {
        assert!(times.passes.iter().any(|p| p.name == name), "no {name}");
    }
    let outer = build(Timing::Outer).times;
    assert!(outer.passes.is_empty() && outer.device_ms > 0.0);
    assert!(
        built.scratch_bytes > 0 && built.scratch_bytes < 200 * 20_000 + (1 << 20),
        "{}",
        built.scratch_bytes
    );
    assert!(built.explain.iter().any(|s| s.starts_with("ploc:")), "{:?}", built.explain);
}
