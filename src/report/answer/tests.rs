#![allow(clippy::unwrap_used)]

use super::*;
use crate::bench::{BuildRow, Costs, Header, Order, RayRow, Results, Spread, TestTotals};

/// Builders by name, build time in ms, and quartiles and median of the time of a million rays.
fn results(racers: &[(&str, f64, [f64; 3])]) -> Results {
    let order = Order { aligned: Some("plain".into()), ..Order::default() };
    let costs = Costs { boxes: 10.0, oriented: 14.0, triangles: 17.0 };
    let spread = |[q1, median, q3]: [f64; 3]| Spread { median, q1, q3, min: q1, max: q3, runs: 5 };
    let build = |(name, ms, _): &(&str, f64, [f64; 3])| BuildRow {
        scene: "s".into(),
        builder: (*name).into(),
        build_ms: spread([*ms; 3]),
        ..BuildRow::default()
    };
    let rays = |(name, _, ms): &(&str, f64, [f64; 3])| RayRow {
        scene: "s".into(),
        builder: (*name).into(),
        view: 1,
        set: "diffuse".into(),
        rays: 1_000_000,
        trace_ms: spread(*ms),
        tests: Some(TestTotals { boxes: 1_000_000 * name.len() as u64, ..TestTotals::default() }),
        ..RayRow::default()
    };
    Results {
        header: Header { order, costs, ..Header::default() },
        builds: racers.iter().map(build).collect(),
        rays: racers.iter().map(rays).collect(),
        ..Results::default()
    }
}

fn only(results: &Results) -> Answer {
    let [answer] = answers(&Report::new(results)).try_into().unwrap();
    answer
}

#[test]
fn few_rays_take_the_cheap_build_and_many_the_fast_rays() {
    let answer = only(&results(&[
        ("slow", 300.0, [240.0, 250.0, 260.0]),
        ("plain", 100.0, [290.0, 300.0, 310.0]),
        ("dear", 900.0, [90.0, 100.0, 110.0]),
        ("never", 950.0, [245.0, 255.0, 265.0]),
    ]));
    // 100 + 300 x = 300 + 250 x at 4 million, but 100 + 300 x = 900 + 100 x at 4 as well: the flattest.
    let steps: Vec<_> = answer.steps.iter().map(|s| (s.builder.as_str(), s.from)).collect();
    assert_eq!(steps, [("plain", 0.0), ("dear", 4e6)]);
    assert_eq!((answer.fastest.as_str(), answer.mrays_s), ("dear", 10.0));
    assert!(answer.alike.is_empty());
    let against = answer.against.unwrap();
    assert_eq!((against.builder.as_str(), against.build), ("plain", 9.0));
    let near = |got: f64, wanted: f64| (got / wanted - 1.0).abs() < 1e-12;
    assert!(
        near(against.rate, 3.0) && near(against.tests.unwrap(), 0.8),
        "four letters to five: {against:?}"
    );
}

#[test]
fn overlapping_quartiles_are_no_victory() {
    let answer =
        only(&results(&[("plain", 100.0, [100.0, 104.0, 110.0]), ("other", 100.0, [98.0, 103.0, 105.0])]));
    assert_eq!((answer.fastest.as_str(), answer.alike.as_slice()), ("other", &["plain".to_owned()][..]));
    assert_eq!(answer.steps.len(), 1, "of builds alike the one with the faster rays: {:?}", answer.steps);
}

#[test]
fn three_in_turn() {
    let steps = only(&results(&[
        ("plain", 100.0, [300.0; 3]),
        ("middle", 200.0, [200.0; 3]),
        ("dear", 500.0, [100.0; 3]),
    ]))
    .steps;
    let steps: Vec<_> = steps.iter().map(|s| (s.builder.as_str(), s.from)).collect();
    assert_eq!(steps, [("plain", 0.0), ("middle", 1e6), ("dear", 3e6)]);
}

#[test]
fn without_rays_there_is_nothing_to_say() {
    let mut results = results(&[("plain", 100.0, [300.0; 3])]);
    results.rays.clear();
    assert!(answers(&Report::new(&results)).is_empty());
}
