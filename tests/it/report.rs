//! Reports, shards and comparisons of runs, as programs.

#![allow(clippy::unwrap_used)]

use crate::bench::{args, folder, rows};
use crate::cli::Folder;
use std::fs;
use std::process::Output;

fn text(out: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr))
}

/// A run of the benchmark into `out`.
fn measured(folder: &Folder, more: &[&str]) -> String {
    let out = folder.run(&args(more));
    assert!(out.status.success(), "{}", text(&out));
    text(&out)
}

fn page(folder: &Folder, path: &str) -> String {
    fs::read_to_string(folder.path(path)).unwrap()
}

#[test]
fn bench_ends_with_the_path_of_a_report() {
    let folder = folder();
    let said = measured(&folder, &["--out", "r"]);
    let path = said.lines().find_map(|line| line.strip_prefix("Report: ")).unwrap();
    let page = fs::read_to_string(path).unwrap();
    for word in ["sphere:2k", "hairball:2k", "wide-leaves", "file:b.rays", "The answer", "none is wrong"] {
        assert!(page.contains(word), "{word}");
    }
    // From its rows alone it is the same.
    assert!(folder.run(&["report", "r", "--out", "again.html"]).status.success());
    assert_eq!(self::page(&folder, "again.html"), page);
}

#[test]
fn shards_make_the_whole() {
    let folder = folder();
    measured(&folder, &["--out", "whole"]);
    let mut shared = 0;
    for shard in ["1/3", "2/3", "3/3"] {
        let out = format!("s{}", &shard[..1]);
        measured(&folder, &["--out", &out, "--shard", shard]);
        let whole = rows(&folder, "whole/rows.jsonl");
        let part = rows(&folder, &format!("{out}/rows.jsonl"));
        assert!(part.iter().all(|(key, row)| whole[key] == *row), "{shard}");
        shared += part.len();
    }
    assert_eq!(shared, rows(&folder, "whole/rows.jsonl").len());
    let out = folder.run(&["report", "s2", "s1", "s3", "whole", "--out", "all.html"]);
    assert!(out.status.success(), "{}", text(&out));
    let page = page(&folder, "all.html");
    assert_eq!(page.matches("<h2>").count(), 1, "shards of one run are one run");
    assert_eq!(page.matches("triangles</h3>").count(), 2, "two scenes");
    folder.fails(&["bench", "sphere:9", "--shard", "4/3"], 2, "no shard");
}

#[test]
fn folders_are_merged() {
    let folder = folder();
    measured(&folder, &["--out", "s1", "--shard", "1/2"]);
    measured(&folder, &["--out", "s2", "--shard", "2/2"]);
    let merge = |parts: &[&str], out: &str| {
        let out = folder.run(&[&["report", "merge"], parts, &["--out", out]].concat());
        assert!(out.status.success(), "{}", text(&out));
        text(&out)
    };
    // One run: a folder as if it had been measured in one go, whichever part comes first.
    merge(&["s2", "s1"], "all");
    let all = rows(&folder, "all/rows.jsonl");
    let parts = ["s1", "s2"].map(|part| rows(&folder, &format!("{part}/rows.jsonl")));
    assert_eq!(all, parts.into_iter().flatten().collect());
    for other in ["all/bench.json", "all/bench.csv", "all/report.html"] {
        assert!(folder.path(other).is_file(), "{other}");
    }
    assert!(folder.run(&["compare", "all", "all/bench.json"]).status.success());
    assert!(!page(&folder, "all/report.html").contains("rows are missing"));
    assert!(page(&folder, "s1/report.html").contains("rows are missing"), "a part is not all");
    let resumed = folder.run(&args(&["--out", "all", "--resume"]));
    assert!(text(&resumed).contains("resuming: 40 of 40 rows are there"), "{}", text(&resumed));
    let page_of_all = page(&folder, "all/report.html");
    assert!(!merge(&["all", "s1"], "all").contains("twice"), "the same rows again are no other measurement");
    assert_eq!(page(&folder, "all/report.html"), page_of_all);
    // A part measured anew, and another device.
    fs::create_dir(folder.path("anew")).unwrap();
    let lines = page(&folder, "s1/rows.jsonl");
    fs::write(folder.path("anew/rows.jsonl"), lines.replace("\"scratch_bytes\":", "\"scratch_bytes\":9"))
        .unwrap();
    let said = merge(&["all", "anew"], "again");
    assert!(said.contains("2 rows are measured twice") && said.contains("sphere:2k, ploc"), "{said}");
    fs::create_dir(folder.path("other")).unwrap();
    let device = lines.find("\"device\":\"").unwrap() + "\"device\":\"".len();
    fs::write(folder.path("other/rows.jsonl"), format!("{}A/Card ..{}", &lines[..device], &lines[device..]))
        .unwrap();
    merge(&["all", "other"], "both");
    let mut names: Vec<_> = fs::read_dir(folder.path("both"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert!(names[0].starts_with("1-") && names[1].starts_with("2-a-card-"), "{names:?}");
    assert_eq!(
        (names[2].as_str(), page(&folder, "both/report.html").matches("<h2>").count()),
        ("report.html", 2)
    );
    assert_eq!(rows(&folder, &format!("both/{}/rows.jsonl", names[0])), all);
    // What would lose rows is refused.
    folder.fails(&["report", "merge", "s1", "--out", "all"], 1, "rows that none of the folders has");
    folder.fails(&["report", "merge", "none", "--out", "all"], 1, "none/rows.jsonl");
    folder.fails(&["report", "merge"], 2, "required");
}

#[test]
fn a_picture_whose_file_is_lost_is_left_out_until_it_is_taken_again() {
    let folder = Folder::new();
    let bench = ["bench", "sphere:500", "--preset", "smoke", "--builders", "ploc", "--rays", "primary"];
    let resumed = || {
        let out = folder.run(&[&bench[..], &["--out", "r", "--resume"]].concat());
        assert!(out.status.success(), "{}", text(&out));
    };
    resumed();
    let (whole, picture) = (page(&folder, "r/report.html"), folder.path("r/pictures/1.png"));
    let shown = |page: &str| page.matches("<img").count();
    let bytes = fs::read(&picture).unwrap();
    fs::remove_file(&picture).unwrap();
    let out = folder.run(&["report", "r", "--out", "lost.html"]);
    assert!(out.status.success() && text(&out).contains("can't read r/pictures/1.png"), "{}", text(&out));
    assert_eq!(shown(&page(&folder, "lost.html")) + 1, shown(&whole));
    resumed();
    assert_eq!(fs::read(&picture).unwrap(), bytes);
    assert_eq!(shown(&page(&folder, "r/report.html")), shown(&whole));
    // The row of before and that of now are one picture.
    assert!(folder.run(&["report", "r", "--out", "again.html"]).status.success());
    assert_eq!(shown(&page(&folder, "again.html")), shown(&whole));
}

#[test]
fn comparisons_are_gates() {
    let folder = folder();
    measured(&folder, &["--out", "a"]);
    let same = folder.run(&["compare", "a", "a/bench.json"]);
    assert!(same.status.success(), "{}", text(&same));
    // A tree of twice the bytes, and no rays of a file.
    fs::create_dir(folder.path("b")).unwrap();
    let lines = page(&folder, "a/rows.jsonl");
    let changed: Vec<String> = lines
        .lines()
        .filter(|line| !line.contains("\"file:b.rays\",\"kernel\""))
        .map(|line| line.replace("\"bvh_bytes\":", "\"bvh_bytes\":9"))
        .collect();
    fs::write(folder.path("b/rows.jsonl"), changed.join("\n") + "\n").unwrap();
    let worse = folder.run(&["compare", "a", "b", "--of", "counts"]);
    assert!(!worse.status.success() && text(&worse).contains("worse by more than 5 %"), "{}", text(&worse));
    assert!(text(&worse).contains("only the first has"), "{}", text(&worse));
    let times = folder.run(&["compare", "a", "b", "--of", "times", "--json"]);
    assert!(!times.status.success() && text(&times).contains("lacks 4 rows"), "{}", text(&times));
    assert!(folder.run(&["compare", "b", "a", "--of", "times"]).status.success(), "more rows are no fault");
    folder.fails(&["compare", "a", "none"], 1, "none");
    folder.fails(&["compare", "a", "a", "--threshold=-1"], 2, "number from 0");
}

#[test]
fn reports_of_nothing_are_refused() {
    let folder = folder();
    folder.fails(&["report", "none"], 1, "none/rows.jsonl");
    fs::write(folder.path("rows.jsonl"), "{}\n").unwrap();
    folder.fails(&["report", "."], 1, "line 1");
}
