#![allow(clippy::unwrap_used)]

use super::*;
use crate::bench::{Check, Header, KernelTime, Order, RayRow, Spread, Survey};
use crate::oracle::validate::Stats;

/// Names as files may have them.
const HOSTILE: &str = "<script>alert('a')</script>\"&amp;.obj";

fn results(scene: &str) -> Results {
    let spread = Spread::of(&[1.0, 2.0, 3.0]);
    let kernels = vec![KernelTime { name: "ploc/search".into(), count: 2, ms: 0.5 }];
    let tree = Stats { area_by_level: vec![1.0, 0.5], ..Stats::default() };
    let survey = Some(Survey { tree, ..Survey::default() });
    let build = BuildRow {
        scene: scene.into(),
        builder: "ploc".into(),
        build_ms: spread,
        kernels,
        survey,
        explain: vec![format!("skipped {scene}")],
        ..BuildRow::default()
    };
    let rays = RayRow {
        scene: scene.into(),
        builder: "ploc".into(),
        view: 1,
        set: format!("file:{scene}"),
        rays: 1000,
        trace_ms: spread,
        ..RayRow::default()
    };
    let order = Order { scenes: vec![scene.into()], ..Order::default() };
    let header =
        Header { device: "a device".into(), order, command: vec![scene.into()], ..Header::default() };
    Results { header, builds: vec![build], rays: vec![rays], images: vec![], pictures: vec![] }
}

#[test]
fn names_are_text() {
    let page = html(&[results(HOSTILE)]).unwrap();
    assert!(page.contains("&lt;script&gt;alert"), "it is named");
    for markup in ["<script", "alert('a')</", "\"&amp;.obj", "onerror="] {
        assert!(!page.contains(markup), "{markup}");
    }
}

#[test]
fn pictures_are_in_the_page() {
    let mut run = results(HOSTILE);
    let of = |builder: &str, png: &[u8]| PictureRow {
        scene: HOSTILE.into(),
        builder: builder.into(),
        png: png.to_vec(),
        ..PictureRow::default()
    };
    run.pictures = vec![of("gone", &[]), of("ploc", b"Man"), of("", b"sun")];
    run.header.order.builders = vec!["ploc".into()];
    let page = html(&[run]).unwrap();
    let at = |text: &str| page.find(text);
    let (scene, map) = (at("base64,c3Vu").unwrap(), at("base64,TWFu").unwrap());
    assert!(scene < map && at("gone:").is_none(), "the scene first, none without a file");
}

#[test]
fn nothing_is_asked_of_a_network() {
    let page = html(&[results("dragon")]).unwrap();
    // Names of namespaces are no addresses.
    let page = page.replace("http://www.w3.org/2000/svg", "");
    for asking in ["http:", "https:", "src=", "@import", "url(", "<link", "<script", "<iframe"] {
        assert!(!page.contains(asking), "{asking}");
    }
}

#[test]
fn what_was_measured_is_there() {
    let page = html(&[results("dragon"), results("sponza")]).unwrap();
    for text in ["dragon", "sponza", "skipped dragon", "a device", "Mrays/s", "<svg", "ploc"] {
        assert!(page.contains(text), "{text}");
    }
    assert_eq!(page.matches("<h2>").count(), 2, "a run a section");
}

#[test]
fn what_is_missing_is_there() {
    let mut results = results("dragon");
    assert!(!html(&[results.clone()]).unwrap().contains("missing"));
    results.header.order = Order {
        scenes: vec!["dragon".into(), HOSTILE.into()],
        builders: vec!["ploc".into()],
        ..results.header.order
    };
    let page = html(&[results]).unwrap();
    assert!(page.contains("1 of 3 rows are missing") && page.contains("&lt;script&gt;"), "{page}");
}

#[test]
fn no_rows_make_a_page_too() {
    let nothing = Results { builds: vec![], rays: vec![], ..results("dragon") };
    assert!(html(&[nothing]).unwrap().contains("a device"));
}

#[test]
fn counts_are_short() {
    let shown = [0.0, 870.0, 3_140.0, 99_900.0, 1_000_000.0, 12_345_678.0, 4e9].map(count);
    assert_eq!(shown, ["0", "870", "3.1k", "100k", "1.0M", "12M", "4.0G"]);
}

#[test]
fn a_drivers_faults_are_not_boxwoods() {
    let mut run = results("dragon");
    let check =
        |rays, verdict: Option<&str>| Check { rays, verdict: verdict.map(Into::into), ..Check::default() };
    run.rays[0].check = Some(check(1000, None));
    let mut theirs = run.rays[0].clone();
    (theirs.builder, theirs.kernel) = ("ray-query".into(), "ray_query/trace".into());
    theirs.check = Some(check(1000, Some("seven missed")));
    run.rays.push(theirs);
    let report = Report::new(&run);
    assert_eq!((report.faults().len(), report.drivers_faults().len(), report.checked()), (0, 1, 1000));
    let page = html(&[run]).unwrap();
    for text in ["none is wrong", "wrong about some hits", "ray-query, view 1", "seven missed"] {
        assert!(page.contains(text), "{text}");
    }
}
