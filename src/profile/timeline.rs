//! A profile as Chrome's Trace Event JSON, for Perfetto (ui.perfetto.dev), chrome://tracing and speedscope: the object
//! form, complete events (`X`) and metadata (`M`), times in µs since the profile began. Of each part the last run with a
//! stamp a pass.

use super::copied::gb_s;
use super::part::bytes;
use super::{BUILD, Part, Profile};
use crate::device::{Event, HostWork, Submit, Work};
use serde_json::{Map, Value, json};
use std::time::{Duration, Instant};

/// The one process.
const PROCESS: u32 = 1;

/// What a line of the timeline is of.
#[derive(Clone, Copy)]
enum Thread {
    Host = 1,
    Build = 2,
    Trace = 3,
}

impl Thread {
    const ALL: [(Self, &'static str); 3] =
        [(Self::Host, "host"), (Self::Build, "device: build"), (Self::Trace, "device: trace")];

    fn of(part: &Part) -> Self {
        if part.name == BUILD { Self::Build } else { Self::Trace }
    }
}

/// The JSON of `profile`.
pub fn timeline(profile: &Profile) -> Value {
    let name = format!("boxwood: {} on {}", profile.scene, profile.device);
    let mut events = vec![metadata("process_name", Thread::Host, json!({ "name": name }))];
    for (thread, name) in Thread::ALL {
        events.push(metadata("thread_name", thread, json!({ "name": name })));
        events.push(metadata("thread_sort_index", thread, json!({ "sort_index": thread as u32 })));
    }
    let line = Line { origin: profile.began, copy_gb_s: profile.copy.gb_s };
    for part in &profile.parts {
        let (times, [began, ended]) = &part.last;
        let whole = line.span(*began, *ended);
        events.push(complete(Thread::Host, part.name, "part", whole, Map::new()));
        events.extend(times.host.iter().map(|work| line.host(work)));
        for submit in &times.submits {
            line.submit(&mut events, Thread::of(part), submit);
        }
    }
    json!({
        "traceEvents": events,
        "displayTimeUnit": "ms",
        "otherData": {
            "device": profile.device,
            "driver": profile.driver,
            "commit": profile.commit,
            "scene": profile.scene,
            "copy_gb_s": profile.copy.gb_s,
        },
    })
}

fn metadata(name: &str, thread: Thread, args: Value) -> Value {
    json!({ "name": name, "ph": "M", "ts": 0, "pid": PROCESS, "tid": thread as u32, "args": args })
}

/// An event that lasts from `from` to `to`, ns.
fn complete(
    thread: Thread,
    name: &str,
    category: &str,
    [from, to]: [u64; 2],
    args: Map<String, Value>,
) -> Value {
    let us = |ns: u64| ns as f64 / 1000.0;
    json!({
        "name": name, "cat": category, "ph": "X", "ts": us(from), "dur": us(to.saturating_sub(from)),
        "pid": PROCESS, "tid": thread as u32, "args": args,
    })
}

/// Where times are placed.
struct Line {
    origin: Instant,
    copy_gb_s: f64,
}

impl Line {
    /// ns since the origin.
    fn at(&self, time: Instant) -> u64 {
        time.saturating_duration_since(self.origin).as_nanos() as u64
    }

    fn span(&self, from: Instant, to: Instant) -> [u64; 2] {
        [self.at(from), self.at(to)]
    }

    fn lasting(&self, from: Instant, ms: f64) -> [u64; 2] {
        let from = self.at(from);
        [from, from + Duration::try_from_secs_f64(ms.max(0.0) * 1e-3).unwrap_or_default().as_nanos() as u64]
    }

    fn host(&self, work: &HostWork) -> Value {
        complete(Thread::Host, work.name, "host", self.lasting(work.at, work.ms), Map::new())
    }

    /// A submit on the host's line, from there to its fence; on the device's, with its passes within.
    fn submit(&self, events: &mut Vec<Value>, thread: Thread, submit: &Submit) {
        let mut args = Map::new();
        args.insert("passes".into(), submit.events.len().into());
        args.insert("device_ms".into(), submit.device_ms.into());
        let waited = self.lasting(submit.at, submit.wall_ms);
        events.push(complete(Thread::Host, "submit and wait", "submit", waited, args.clone()));
        let placed = match submit.unsure_ms {
            Some(ms) => format!("by calibrated timestamps, within {ms:.4} ms"),
            None => "at the submit: the device doesn't tell its clock's time".to_owned(),
        };
        args.insert("placed".into(), placed.into());
        let whole = self.lasting(submit.device_at, submit.device_ms);
        events.push(complete(thread, "submit", "submit", whole, args));
        // Rounding to whole ns must not let a pass reach into the next, or out of its submit.
        let within = |ns: u64| ns.clamp(whole[0], whole[1]);
        let starts: Vec<u64> = submit.events.iter().map(|e| within(self.at(e.at))).collect();
        for (i, event) in submit.events.iter().enumerate() {
            let end = within(self.lasting(event.at, event.ms)[1]);
            let end = starts.get(i + 1).map_or(end, |next| end.min(*next));
            let args = self.args(event);
            events.push(complete(thread, event.name, stage(event.name), [starts[i], end], args));
        }
    }

    fn args(&self, event: &Event) -> Map<String, Value> {
        let mut args = Map::new();
        args.insert("kernel".into(), event.name.into());
        args.insert("stage".into(), stage(event.name).into());
        match event.work {
            Work::Groups { groups, size } => {
                args.insert("workgroups".into(), groups.into());
                args.insert("workgroup_size".into(), size.into());
            }
            Work::Indirect { size } => {
                if let Some(n) = event.invocations {
                    args.insert("workgroups".into(), (n / u64::from(size.max(1))).into());
                }
                args.insert("workgroup_size".into(), size.into());
            }
            Work::Transfer | Work::Driver => {}
        }
        if let Some(n) = event.invocations {
            args.insert("invocations".into(), n.into());
        }
        if let Some(traffic) = bytes(event) {
            args.insert("bytes_read".into(), traffic.read.into());
            args.insert("bytes_written".into(), traffic.written.into());
            if let Some(rate) = gb_s(traffic.bytes(), event.ms) {
                args.insert("gb_s".into(), rate.into());
                if self.copy_gb_s > 0.0 {
                    args.insert("percent_of_copy".into(), (100.0 * rate / self.copy_gb_s).into());
                }
            }
        }
        args
    }
}

/// The stage of a kernel's name; a transfer's is its name.
fn stage(name: &str) -> &str {
    name.split('/').next().unwrap_or(name)
}
