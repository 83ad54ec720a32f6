//! What orients the nodes of a scene's tree: what a fit says, or, left to the scene, no more than its triangles need.

use super::orientation::{Corners, MOST};
use super::{Fit, Orientations};
use crate::abi::Pair;

/// Share of the triangles beyond which the others don't count.
const ENOUGH: f64 = 63.0 / 64.0;
/// Bases whose boxes cost less to find than those of DiTO.
const FEW: usize = 4;
/// Extremal points of DiTO where no number is given.
pub(super) const POINTS: u32 = 14;

/// What is tried on every node, in this order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trials {
    /// Words of the frames of bases.
    pub bases: Vec<Pair>,
    /// Extremal points of DiTO.
    pub points: Option<u32>,
    /// Why, where the scene decided.
    pub why: Option<String>,
}

/// What `fit` tries on a scene with triangles like those of `sample`.
pub fn trials(fit: Fit, sample: &[Corners]) -> Trials {
    let own = |most: u32| {
        let found = Orientations::of(sample);
        let why = format!("orientation: {found}");
        (found.frames(most), Some(why))
    };
    match fit {
        Fit::Aabb => Trials::default(),
        Fit::Dito(points) => Trials { points: Some(points), ..Trials::default() },
        Fit::Odop(bases) => Trials { bases: bases.frames(), ..Trials::default() },
        Fit::Own(most) => {
            let (bases, why) = own(most);
            Trials { bases, points: None, why }
        }
        Fit::Hybrid => {
            let (bases, why) = own(MOST);
            Trials { bases, points: Some(POINTS), why }
        }
        Fit::Auto => as_needed(&Orientations::of(sample)),
    }
}

/// None where the scene's axes serve; its own bases where few of them do; else DiTO, which no number of bases comes near
/// where triangles lie all ways.
fn as_needed(found: &Orientations) -> Trials {
    let shares = |count: usize| found.bases.iter().take(count).map(|b| b.share).sum::<f64>();
    let because = |what: &str| Some(format!("auto: {what}: {found}"));
    if found.aligned >= ENOUGH {
        return Trials { why: because("oriented boxes skipped"), ..Trials::default() };
    }
    match (1..=FEW).find(|count| shares(*count) >= ENOUGH) {
        Some(count) => Trials {
            bases: found.frames(count as u32),
            points: None,
            why: because("boxes in the bases of the scene, DiTO skipped"),
        },
        None => Trials { bases: vec![], points: Some(POINTS), why: because("boxes by DiTO, bases skipped") },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::orientation::Basis;

    fn found(aligned: f64, shares: &[f64]) -> Trials {
        let basis = |(i, share): (u32, &f64)| Basis { frame: [i, 0], share: *share };
        as_needed(&Orientations { triangles: 9, aligned, bases: (0..).zip(shares).map(basis).collect() })
    }

    #[test]
    fn no_more_than_is_needed() {
        let aligned = found(0.99, &[0.99, 0.01]);
        assert_eq!((aligned.bases.len(), aligned.points), (0, None));
        let turned = found(0.0, &[0.6, 0.39]);
        assert_eq!((turned.bases.len(), turned.points), (2, None));
        let scattered = found(0.5, &[0.5, 0.1, 0.1, 0.1, 0.1, 0.1]);
        assert_eq!((scattered.bases.len(), scattered.points), (0, Some(14)));
        assert!([aligned, turned, scattered].iter().all(|t| t.why.is_some()));
    }

    #[test]
    fn a_scene_of_nothing_needs_nothing() {
        assert_eq!(trials(Fit::Auto, &[]).points, None);
        assert_eq!(trials(Fit::Dito(20), &[]), Trials { points: Some(20), ..Trials::default() });
    }
}
