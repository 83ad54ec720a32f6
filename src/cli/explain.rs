//! `--explain`: what was done and what was skipped, a sentence a line on stderr.

use crate::bench::{Counting, Traced};
use crate::bvh::Built;
use crate::device::Device;
use crate::trace::{Options, Precision, Query, kernel_name};

/// What a build did.
pub(super) fn build(built: &Built) {
    for sentence in &built.explain {
        eprintln!("explain: {sentence}");
    }
}

/// What tracing did.
pub(super) fn trace(device: &Device, options: Options, counting: Counting, traced: &Traced) {
    let say = |sentence: String| eprintln!("explain: {sentence}");
    let kernel = kernel_name(device, options);
    say(match (options.coherent, device.shape().packets) {
        (true, true) => {
            format!("trace: {kernel}, which a sample of the rays ran faster in, or which suits rays so alike")
        }
        (true, false) => {
            format!("trace: {kernel}, for this device gains nothing by packets, though the rays are alike")
        }
        (false, _) => format!(
            "trace: {kernel}, for neighbouring rays go different ways, or a sample ran slower in packets"
        ),
    });
    say(match options.query {
        Query::Closest => "trace: nearest hit, with t, u and v".into(),
        Query::Any => {
            "trace: any hit: ended at the first, and t, u, v and the triangle never computed".into()
        }
    });
    say(match options.precision {
        Precision::Robust => {
            "trace: watertight triangle test; higher precision only where a sign is in doubt".into()
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
