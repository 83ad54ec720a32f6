//! `--explain`: what was done and what was skipped, a sentence a line on stderr.

use super::choices::SortName;
use crate::bench::{Choice, Counting, Traced, Trial, Tried};
use crate::trace::{Boxes, Precision, Query, RayOrder, Walk};

/// What a build did.
pub(super) fn build(sentences: &[String]) {
    for sentence in sentences {
        eprintln!("explain: {sentence}");
    }
}

/// What a sample of rays said of the trees that were tried.
pub(super) fn sample(tried: &[Tried], rays: usize) {
    let cost = |t: &Tried| {
        let (builder, fit) = (t.recipe.builder.name(), t.recipe.fit.name());
        format!("{builder} with boxes {fit}, {}: {:.1} ns", t.boxes.name(), t.cost_per_ray)
    };
    let costs: Vec<String> = tried.iter().map(cost).collect();
    eprintln!(
        "explain: sample: what {rays} rays cost each by their tests, the first tree kept: {}",
        costs.join("; ")
    );
}

/// What tracing did.
pub(super) fn trace(sort: SortName, choice: &Choice, counting: Counting, traced: &Traced) {
    let options = choice.options;
    let say = |sentence: String| eprintln!("explain: {sentence}");
    let kernel = options.walk.kernel_name();
    let why = match options.walk {
        Walk::Single => "an invocation a ray",
        Walk::Refill => "an invocation takes its next ray as soon as it is done with one",
        Walk::Persistent => "invocations take rays until there are none",
        Walk::Packet => "a subgroup walks the tree together",
    };
    say(format!("trace: {kernel}, {why}: {}", tried(choice)));
    say(format!("trace: {}", order(sort, choice)));
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

/// What a choice rests on.
fn tried(choice: &Choice) -> String {
    if choice.trials.is_empty() {
        return "too few rays to tell what is fastest".into();
    }
    let time = |t: &Trial| {
        let sorted = if t.order == RayOrder::Sorted { " sorted" } else { "" };
        let boxes = if t.boxes == Boxes::AxisAligned { " in axis-aligned boxes" } else { "" };
        format!("{}{sorted}{boxes} {:.2} ms", t.walk.kernel_name(), t.ms)
    };
    let times: Vec<String> = choice.trials.iter().map(time).collect();
    format!("{} rays took {}", choice.rays, times.join(", "))
}

/// Why rays were sorted, or weren't.
fn order(sort: SortName, choice: &Choice) -> String {
    let sorted = choice.options.order == RayOrder::Sorted;
    let pair = (choice.fastest(RayOrder::Sorted), choice.fastest(RayOrder::AsGiven));
    match (sort, pair) {
        (SortName::On, _) => "rays sorted by origin and direction, as asked".into(),
        (SortName::Off, _) => "rays not sorted, as asked".into(),
        (SortName::Auto, (Some(s), Some(g))) => format!(
            "rays {}sorted by origin and direction: {:.2} ms with the sort, {:.2} ms without",
            if sorted { "" } else { "not " },
            s.ms,
            g.ms
        ),
        (SortName::Auto, (_, None)) => "rays not sorted: too few to tell whether that pays".into(),
        (SortName::Auto, (None, _)) => "rays not sorted: neighbours go much the same way as they come".into(),
    }
}
