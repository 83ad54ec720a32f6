//! The Trace Event format's object form, as far as profiles use it: what each event must have, and that the spans of a line
//! lie within each other or apart.

use serde_json::Value;
use std::collections::HashMap;

/// What is wrong with a file that should be in the Trace Event format's object form.
pub fn fault(file: &Value) -> Option<String> {
    let unit = &file["displayTimeUnit"];
    if unit != "ms" && unit != "ns" {
        return Some(format!("displayTimeUnit: {unit}"));
    }
    let Some(events) = file["traceEvents"].as_array() else { return Some("no traceEvents".into()) };
    let mut named = vec![];
    let mut lines: HashMap<(u64, u64), Vec<[f64; 2]>> = HashMap::new();
    for e in events {
        let number = |key: &str| e[key].as_f64().filter(|x| x.is_finite() && *x >= 0.0);
        let (Some(pid), Some(tid), Some(ts)) = (e["pid"].as_u64(), e["tid"].as_u64(), number("ts")) else {
            return Some(format!("pid, tid or ts of {e}"));
        };
        if !e["name"].is_string() || !e["args"].is_object() {
            return Some(format!("name or args of {e}"));
        }
        match (e["ph"].as_str(), e["name"].as_str()) {
            (Some("X"), _) => match number("dur") {
                Some(dur) if e["cat"].is_string() => {
                    lines.entry((pid, tid)).or_default().push([ts, ts + dur]);
                }
                _ => return Some(format!("dur or cat of {e}")),
            },
            (Some("M"), Some("thread_name")) if e["args"]["name"].is_string() => named.push((pid, tid)),
            (Some("M"), Some("process_name")) if e["args"]["name"].is_string() => {}
            (Some("M"), Some("thread_sort_index")) if e["args"]["sort_index"].is_u64() => {}
            _ => return Some(format!("ph of {e}")),
        }
    }
    lines.into_iter().find_map(|(line, spans)| {
        let unnamed = (!named.contains(&line)).then(|| format!("{line:?} has no name"));
        unnamed.or_else(|| badly_nested(spans).map(|spans| format!("{line:?}: {spans:?} overlap")))
    })
}

/// Two spans of one line, neither of which holds the other or ends before it, µs.
fn badly_nested(mut spans: Vec<[f64; 2]>) -> Option<[[f64; 2]; 2]> {
    // A part of a ns: what is left of whole ns written as µs.
    const NONE: f64 = 1e-4;
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]).then(b[1].total_cmp(&a[1])));
    let mut open: Vec<[f64; 2]> = vec![];
    for span in spans {
        open.retain(|o| o[1] > span[0] + NONE);
        if let Some(o) = open.last().filter(|o| span[1] > o[1] + NONE) {
            return Some([*o, span]);
        }
        open.push(span);
    }
    None
}

#[test]
fn faults_of_a_timeline_are_found() {
    assert_eq!(badly_nested(vec![[0.0, 5.0], [1.0, 2.0], [2.0, 5.0], [5.0, 6.0], [3.0, 4.0]]), None);
    assert!(badly_nested(vec![[0.0, 5.0], [3.0, 6.0]]).is_some());
    assert!(badly_nested(vec![[0.0, 9.0], [1.0, 4.0], [3.0, 6.0]]).is_some());
    for bad in [
        r#"{"displayTimeUnit": "s", "traceEvents": []}"#,
        r#"{"displayTimeUnit": "ms"}"#,
        r#"{"displayTimeUnit": "ms", "traceEvents": [{"name": "a", "ph": "X", "ts": 0, "pid": 1, "tid": 1, "cat": "c", "args": {}}]}"#,
        r#"{"displayTimeUnit": "ms", "traceEvents": [{"name": "a", "ph": "X", "ts": 0, "dur": -1, "pid": 1, "tid": 1, "cat": "c", "args": {}}]}"#,
        r#"{"displayTimeUnit": "ms", "traceEvents": [{"name": "a", "ph": "X", "ts": 0, "dur": 1, "pid": 1, "tid": 1, "cat": "c", "args": {}}]}"#,
    ] {
        assert!(fault(&serde_json::from_str(bad).unwrap()).is_some(), "{bad}");
    }
}
