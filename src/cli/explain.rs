//! `--explain`: what was done and what was skipped, a sentence a line on stderr.

use crate::bench::{Counting, Traced};
use crate::bvh::Built;
use crate::device::Device;
use crate::trace::{Options, Precision, Query, Walk};

/// What a build did.
pub(super) fn build(built: &Built) {
    for sentence in &built.explain {
        eprintln!("explain: {sentence}");
    }
}

/// What tracing did.
pub(super) fn trace(device: &Device, options: Options, counting: Counting, traced: &Traced) {
    let say = |sentence: String| eprintln!("explain: {sentence}");
    let kernel = options.walk.kernel_name();
    let why = match options.walk {
        Walk::Single => "an invocation a ray",
        Walk::Refill => "an invocation takes its next ray as soon as it is done with one",
        Walk::Persistent => "invocations take rays until there are none",
        Walk::Packet => "a subgroup walks the tree together",
    };
    let others: Vec<&str> =
        Walk::all(device).iter().filter(|w| **w != options.walk).map(|w| w.kernel_name()).collect();
    say(format!(
        "trace: {kernel}, {why}: a sample of the rays was slower with {}, or there are too few to tell",
        others.join(" and ")
    ));
    say(match options.query {
        Query::Closest => "trace: nearest hit, with t, u and v".into(),
        Query::Any => {
            "trace: any hit: ended at the first, and t, u, v and the triangle never computed".into()
        }
    });
    say(match options.precision {
        Precision::Robust => {
            "trace: watertight triangle test; higher precision only where a triangle is not surely missed"
                .into()
        }
        Precision::Fast => {
            "trace: Möller–Trumbore; exact signs skipped, so rays may slip through edges".into()
        }
    });
    say(match counting {
        Counting::Off => "trace: tests not counted: the kernel has no code for it, nor memory".into(),
        Counting::On => "trace: tests counted in a run of its own; the timed runs have no code for it".into(),
    });
    let (rays, submits) = (traced.chunk.min(traced.hits.len()), traced.submits);
    say(format!("trace: {submits} submit{} of up to {rays} rays", if submits == 1 { "" } else { "s" }));
    say("trace: read back once, after the last run: the hits; the tree only for its hash and for --check"
        .into());
}
