//! Reports as a browser shows them: headless Chromium, spoken to over its DevTools protocol, which runs scripts from
//! outside even where the page's policy forbids any.
//!
//! Which browser: `BOXWOOD_CHROMIUM`, else the first of [`BROWSERS`] there is. `.ci/setup test` installs one on Debian;
//! without any the tests fail.

#![allow(clippy::unwrap_used)]

mod devtools;

use crate::bench::{args, folder};
use crate::cli::Folder;
use devtools::Browser;
use serde_json::{Value, json};
use std::fs;

/// Widths that a page is looked at, pixels: a screen's, a telephone's.
const WIDTHS: [u32; 2] = [1280, 400];
/// Least size of text anywhere, pixels.
const LEAST_TEXT: f64 = 11.0;

/// What a page says of itself. `wide`: elements that stick out of the page, or in a box that scrolls out of its content;
/// `smallest`: the size of its smallest text as it is seen, and that text.
const SURVEY: &str = r"(() => {
  const width = document.documentElement.clientWidth, wide = [], tags = {}, handlers = [];
  const name = e => `${e.tagName} ${(e.textContent || '').trim().slice(0, 40)}`;
  for (const e of document.body.querySelectorAll('*')) {
    const box = e.getBoundingClientRect(), scroll = e.parentElement.closest('.scroll'), svg = e.ownerSVGElement;
    if (box.width > 0 && !scroll && (box.right > width + 1 || box.left < -1)) wide.push(name(e));
    if (box.width > 0 && scroll && box.left < scroll.getBoundingClientRect().left - scroll.scrollLeft - 1) wide.push(name(e));
    if (e.tagName === 'text') {
      const plot = svg.getBoundingClientRect();
      if (box.left < plot.left - 1 || box.right > plot.right + 1) wide.push(name(e));
    }
    if (!svg) tags[e.tagName] = (tags[e.tagName] || 0) + 1;
    for (const a of e.attributes) if (/^on|^(href|src|srcdoc|action|formaction|data)$/i.test(a.name) && !a.value.startsWith('data:image/png;base64,')) handlers.push(a.name);
  }
  let smallest = [Infinity, ''];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let t = walk.nextNode(); t; t = walk.nextNode()) {
    const e = t.parentElement;
    if (!t.data.trim() || !e.checkVisibility()) continue;
    const scale = e.ownerSVGElement ? Math.hypot(e.getScreenCTM().a, e.getScreenCTM().b) : 1;
    const size = parseFloat(getComputedStyle(e).fontSize) * scale;
    if (size < smallest[0]) smallest = [size, t.data.trim().slice(0, 40)];
  }
  return { width, scrolled: document.documentElement.scrollWidth, wide, tags, handlers, smallest, text: document.body.textContent };
})()";

/// A page at a width.
struct Seen {
    survey: Value,
    /// Addresses asked for, the page's own first; without pictures that it holds itself.
    requests: Vec<String>,
    /// What the browser complains of.
    complaints: Vec<Value>,
}

/// Opens `path` in a window of `width` pixels.
fn look(browser: &mut Browser, folder: &Folder, path: &str, width: u32) -> Seen {
    let mut tab = browser.tab();
    for domain in ["Page", "Runtime", "Log", "Network"] {
        tab.call(&format!("{domain}.enable"), json!({}));
    }
    let mobile = width < 800;
    let metrics = json!({ "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": mobile });
    tab.call("Emulation.setDeviceMetricsOverride", metrics);
    let path = folder.path(path).canonicalize().unwrap();
    tab.call("Page.navigate", json!({ "url": format!("file://{}", path.display()) }));
    tab.wait("Page.loadEventFired");
    // What is folded is read as well.
    tab.evaluate("document.querySelectorAll('details').forEach(e => e.open = true)");
    let survey = tab.evaluate(SURVEY);
    let of =
        |name: &'static str| tab.events.iter().filter(move |e| e["method"] == name).map(|e| &e["params"]);
    let requests = of("Network.requestWillBeSent")
        .map(|params| params["request"]["url"].as_str().unwrap().to_owned())
        .filter(|url| !url.starts_with("data:image/png;base64,"))
        .collect();
    let complaints = ["Log.entryAdded", "Runtime.consoleAPICalled", "Runtime.exceptionThrown"];
    let complaints = complaints.into_iter().flat_map(of).cloned().collect();
    Seen { survey, requests, complaints }
}

/// Asserts that the report at `path` is readable at `width`, asks for nothing and makes the browser complain of nothing.
fn assert_fine(browser: &mut Browser, folder: &Folder, path: &str, width: u32) -> Value {
    let Seen { survey, requests, complaints } = look(browser, folder, path, width);
    let what = format!("{path} at {width} px");
    assert!(requests.len() == 1 && requests[0].starts_with("file://"), "{what} asks for {requests:?}");
    assert!(complaints.is_empty(), "{what}: {complaints:?}");
    assert!(survey["scrolled"].as_u64() <= survey["width"].as_u64(), "{what} is {} wide", survey["scrolled"]);
    assert_eq!(survey["wide"], json!([]), "{what}: elements stick out");
    assert_eq!(survey["handlers"], json!([]), "{what}: attributes that act or fetch");
    let smallest = &survey["smallest"];
    assert!(smallest[0].as_f64().unwrap() >= LEAST_TEXT, "{what}: text is as small as {smallest}");
    survey
}

/// Names of elements outside plots.
fn tags(survey: &Value) -> Vec<&String> {
    survey["tags"].as_object().unwrap().keys().collect()
}

/// A folder with presets and rays whose reports have pictures.
fn pictured() -> Folder {
    let folder = folder();
    let presets = fs::read_to_string(folder.path("presets.toml")).unwrap();
    let presets = presets.replace("check = 500\n", "check = 500\npicture-width = 48\npicture-height = 36\n");
    fs::write(folder.path("presets.toml"), presets).unwrap();
    folder
}

#[test]
fn reports_are_readable() {
    let folder = pictured();
    let out = folder.run(&args(&["--out", "r"]));
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let mut browser = Browser::open();
    for width in WIDTHS {
        let survey = assert_fine(&mut browser, &folder, "r/report.html", width);
        assert!(survey["text"].as_str().unwrap().contains("hairball:2k"));
        assert_eq!(survey["tags"]["IMG"], 2 * (1 + 2), "a picture a scene, and one a builder");
    }
}

/// Names as files, folders and builders may have them; a slash makes a folder of what is before it.
const HOSTILE: [&str; 4] = [
    "<script>alert(1)</script>.tri",
    "\"><img src=x onerror=alert(1)>.tri",
    "'--><svg onload=alert(1)>{{ 7 * 191 }}{% raw %}.tri",
    "a-name-without-a-gap-",
];

/// A folder of scenes with hostile names, and a file of presets with such a builder; the scenes.
fn hostile() -> (Folder, Vec<String>) {
    let folder = pictured();
    let [script, image, template, long] = HOSTILE;
    let names = vec![script.into(), image.into(), template.into(), long.repeat(9) + ".tri"];
    for name in &names {
        let path = folder.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::copy(folder.path("two.tri"), path).unwrap();
    }
    fs::copy(folder.path("b.rays"), folder.path("<b onclick=alert(1)>.rays")).unwrap();
    let mut presets = fs::read_to_string(folder.path("presets.toml")).unwrap();
    presets.push_str("[recipes.'<i onmouseover=alert(1)>&amp;']\nparent = 'default'\n");
    fs::write(folder.path("presets.toml"), presets).unwrap();
    (folder, names)
}

#[test]
fn hostile_names_are_text() {
    let (folder, names) = hostile();
    let more = ["--preset", "quick", "--presets", "presets.toml", "--rays"];
    let rays = "primary,file:<b onclick=alert(1)>.rays";
    let hostile: Vec<&str> = ["bench"].into_iter().chain(names.iter().map(String::as_str)).collect();
    let builders = ["--builders", "ploc,<i onmouseover=alert(1)>&amp;", "--out", "hostile"];
    let out = folder.run(&[&hostile[..], &more, &[rays], &builders].concat());
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let out = folder.run(&args(&["--out", "plain"]));
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let mut browser = Browser::open();
    for width in WIDTHS {
        let plain = assert_fine(&mut browser, &folder, "plain/report.html", width);
        let survey = assert_fine(&mut browser, &folder, "hostile/report.html", width);
        assert_eq!(tags(&survey), tags(&plain), "elements that no plain report has");
        let text = survey["text"].as_str().unwrap();
        for name in names.iter().map(String::as_str).chain(["<i onmouseover=alert(1)>&amp;", rays]) {
            assert!(text.contains(name.trim_start_matches("primary,")), "{name} is not there as it is");
        }
    }
}

/// That the tests above would see what they look for.
#[test]
fn faults_of_a_page_are_seen() {
    let folder = Folder::new();
    let page = "<!DOCTYPE html><body><script>console.error('said')</script><img src='http://boxwood.invalid/a.png'>\
        <p onclick='0' style='width: 5000px'>wide</p><svg width='99' viewBox='0 0 990 99'><text y='50' font-size='20'>small</text></svg>";
    fs::write(folder.path("bad.html"), page).unwrap();
    let Seen { survey, requests, complaints } = look(&mut Browser::open(), &folder, "bad.html", 400);
    assert!(requests.iter().any(|r| r == "http://boxwood.invalid/a.png"), "{requests:?}");
    assert!(complaints.iter().any(|c| c["type"] == "error"), "{complaints:?}");
    assert!(complaints.iter().any(|c| c["entry"]["level"] == "error"), "a failed request: {complaints:?}");
    assert!(survey["scrolled"].as_u64() > Some(4000), "{survey}");
    assert!(survey["wide"].to_string().contains("P wide"), "{survey}");
    assert_eq!(survey["handlers"], json!(["src", "onclick"]));
    assert!(tags(&survey).contains(&&"SCRIPT".to_owned()), "{survey}");
    assert_eq!(survey["smallest"][1], "small");
    assert!((survey["smallest"][0].as_f64().unwrap() - 2.0).abs() < 0.1, "{survey}");
}
