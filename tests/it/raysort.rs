//! The order of rays against its twin, and hits that don't depend on it.

#![allow(clippy::unwrap_used)]

use crate::gpu::{gpu, quiet, quiet_on};
use crate::matrix::{each_shape, gpu_shaped};
use crate::soup::{random, random_rays, scene};
use boxwood::abi::{Hit, Ray, UNORDERED_KEY};
use boxwood::bvh::{Bvh, Recipe, SceneBuffers, build};
use boxwood::device::{Buffer, Device, Recorder, Timing};
use boxwood::oracle::raysort as twin;
use boxwood::trace::raysort::Raysort;
use boxwood::trace::{Batch, Options, Query, RayOrder, Walk, trace};
use std::sync::Arc;

/// Keys in order and the order, of the device, which must be the twin's.
fn assert_twin(what: &str, device: &Arc<Device>, rays: &[Ray]) -> (Vec<u32>, Vec<u32>) {
    let buffer = Buffer::from_slice(device, "rays", rays).unwrap();
    // Room for more than there are.
    let mut raysort = Raysort::new(device, rays.len() + 3).unwrap();
    let mut rec = Recorder::new(device, Timing::Off).unwrap();
    raysort.record(&mut rec, buffer.ptr(), rays.len() as u32).unwrap();
    rec.submit().unwrap();
    let (keys, order) = raysort.read(rays.len()).unwrap();
    let expected = twin::keys(rays);
    for (place, &i) in order.iter().enumerate() {
        let (i, key) = (i as usize, keys[place]);
        assert_eq!(key, expected[i], "{what}: key {key:08x}, not {:08x}, of {:?}", expected[i], rays[i]);
    }
    assert_eq!(order, twin::order(rays), "{what}");
    (keys, order)
}

/// Rays that have no key, and rays at the ends of what has one.
fn odd_rays() -> Vec<Ray> {
    let plain = random_rays(60, 3);
    let mut rays = plain.clone();
    for (i, r) in plain.iter().enumerate().take(24) {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut words: [f32; 8] = bytemuck::cast(*r);
            words[i % 8] = bad;
            rays.push(bytemuck::cast(words));
        }
    }
    let scaled = |r: &Ray, s: f32| Ray { direction: r.direction.map(|x| x * s), ..*r };
    for s in [0.0, -0.0, 1e-41, 1.2e-38, 3e-38, 1e-30, 1e30, 2e38, 3.4e38] {
        rays.extend(plain.iter().map(|r| scaled(r, s)));
    }
    for axis in 0..3 {
        for sign in [1.0f32, -1.0] {
            let mut direction = [0.0 * sign; 3];
            direction[axis] = sign;
            rays.push(Ray { direction, ..plain[axis] });
        }
    }
    rays
}

#[test]
fn the_order_is_the_twins_at_every_size() {
    for device in each_shape() {
        let device = quiet_on(device);
        let shape = device.shape().clone();
        let (wg, tile) = (shape.workgroup as usize, (shape.workgroup * shape.items) as usize);
        let sort_tile = (shape.sort_workgroup * shape.sort_items) as usize;
        let subgroup = device.info().subgroup_size as usize;
        let around = [subgroup, wg, tile, sort_tile].into_iter().flat_map(|n| [n - 1, n, n + 1]);
        for n in [0, 1, 2, 20_000].into_iter().chain(around) {
            let (keys, _) = assert_twin(&format!("{n} rays"), &device, &random_rays(n, n as u64));
            assert!(keys.windows(2).all(|k| k[0] <= k[1]), "{n}");
        }
    }
}

#[test]
fn odd_rays_come_last_and_spoil_no_box() {
    let device = quiet();
    let rays = odd_rays();
    let (keys, order) = assert_twin("odd rays", &device, &rays);
    let last = keys.iter().position(|k| *k == UNORDERED_KEY).unwrap();
    assert!(order[..last].iter().all(|&i| twin::orderable(&rays[i as usize])));
    let without = rays.iter().filter(|r| !twin::orderable(r)).count();
    assert!(without > 100 && keys.len() - last >= without, "{without} of {}", rays.len());
    let none: Vec<Ray> = rays.into_iter().filter(|r| !twin::orderable(r)).collect();
    let (keys, order) = assert_twin("no ray with a key", &device, &none);
    assert!(keys.iter().all(|k| *k == UNORDERED_KEY));
    assert!(order.into_iter().eq(0..none.len() as u32));
}

#[test]
fn origins_of_any_size_and_place() {
    let device = quiet();
    let plain = random_rays(3000, 5);
    for (scale, shift) in
        [(0.0f32, 0.0f32), (0.0, 7.0), (1e-41, 0.0), (1e-30, 0.0), (1e-6, 1.0), (1e36, 0.0), (1.7e38, 0.0)]
    {
        let place = |p: [f32; 3]| p.map(|x| x * scale + shift);
        let rays: Vec<Ray> = plain.iter().map(|r| Ray { origin: place(r.origin), ..*r }).collect();
        assert_twin(&format!("· {scale:e} + {shift:e}"), &device, &rays);
    }
}

#[test]
fn neighbours_in_order_are_alike() {
    let rays = random_rays(1 << 14, 6);
    let order = twin::order(&rays);
    let place = |i: u32| {
        let d = glam::Vec3::from(rays[i as usize].direction);
        (glam::Vec3::from(rays[i as usize].origin), d / d.abs().max_element())
    };
    let apart = |order: &[u32]| -> f32 {
        let gap = |w: &[u32]| place(w[0]).0.distance(place(w[1]).0) + place(w[0]).1.distance(place(w[1]).1);
        order.windows(2).map(gap).sum::<f32>() / order.len() as f32
    };
    let (sorted, given) = (apart(&order), apart(&(0..rays.len() as u32).collect::<Vec<_>>()));
    assert!(sorted < 0.4 * given, "{sorted} and {given}");
}

/// Words of the hits of a batch, and of its tests where it counts them.
fn found(device: &Arc<Device>, bvh: &Bvh, batch: &Batch, options: Options) -> (Vec<u32>, Vec<u32>) {
    batch.hits.write(&vec![Hit { t: -1.0, triangle: 0, u: 0.0, v: 0.0 }; batch.count]).unwrap();
    trace(device, bvh, batch, options, Timing::Off).unwrap();
    let hits = batch.hits.read_first(batch.count).unwrap();
    let tests = batch.tests.as_ref().map_or(vec![], |t| t.read_first(batch.count).unwrap());
    (bytemuck::cast_slice(&hits).to_vec(), bytemuck::cast_slice(&tests).to_vec())
}

#[test]
fn hits_do_not_depend_on_the_order_of_rays() {
    for device in [gpu, gpu_shaped] {
        let device = quiet_on(device);
        let buffers = SceneBuffers::upload(&device, &scene(&random(1500, 0.3, 8))).unwrap();
        let bvh = build(&device, &buffers, &Recipe::default(), Timing::Off).unwrap().bvh;
        let mut rays = random_rays(4001, 9);
        rays.extend(odd_rays());
        let queries = [Query::Closest, Query::Any];
        for (walk, query) in Walk::all(&device).iter().flat_map(|w| queries.map(|q| (*w, q))) {
            let options = Options { query, walk, ..Options::default() };
            for counting in [false, true] {
                let mut batch = Batch::new(&device, rays.len(), counting).unwrap();
                for count in [rays.len(), 0, 1, 1234] {
                    batch.set(&rays[..count]).unwrap();
                    let [given, sorted] =
                        RayOrder::ALL.map(|order| found(&device, &bvh, &batch, Options { order, ..options }));
                    let what = format!("{count} rays, counted: {counting}, {options:?}");
                    assert_eq!(given.0, sorted.0, "{what}");
                    // A packet's tests are those of its company, and a leaf is put off until the company has one.
                    let alone = !matches!(walk, Walk::Packet | Walk::Persistent);
                    assert!(!alone || given.1 == sorted.1, "tests of {what}");
                }
            }
        }
    }
}

#[test]
fn the_sort_is_on_the_bill() {
    let device = quiet();
    let buffers = SceneBuffers::upload(&device, &scene(&random(100, 0.3, 8))).unwrap();
    let bvh = build(&device, &buffers, &Recipe::default(), Timing::Off).unwrap().bvh;
    let mut batch = Batch::new(&device, 3000, false).unwrap();
    batch.set(&random_rays(3000, 11)).unwrap();
    let options = Options { order: RayOrder::Sorted, ..Options::default() };
    let times = trace(&device, &bvh, &batch, options, Timing::Kernels).unwrap();
    let names: Vec<&str> = times.passes.iter().map(|p| p.name).collect();
    assert_eq!(names[..2], ["raysort/bounds", "raysort/keys"]);
    assert_eq!(names.last(), Some(&"trace/single"));
    let digits = 24u32.div_ceil(device.shape().sort_digit_bits) as usize;
    assert_eq!(names.iter().filter(|n| **n == "sort/scatter").count(), digits, "{names:?}");
    let sum: f64 = times.passes.iter().map(|p| p.ms).sum();
    assert!((sum - times.device_ms).abs() <= 1e-6 * times.device_ms, "{sum} of {}", times.device_ms);
}
