//! Twin of `glsl/lib/by_integers.glsl`: ray against triangle as if in exact arithmetic.

use super::digits::{Origin, exact_triple};
use super::double_single::Pair;
use super::ray::scaled;
use super::{Meeting, Setup, V3};

/// `corners` in the order of `axes`.
pub(super) fn meet_by_integers(s: &Setup, [a, b, c]: [V3; 3]) -> Option<Meeting> {
    if a == b || b == c || c == a {
        return None;
    }
    let origin = Origin { at: s.origin, scale: s.scale };
    let weights = [[c, b], [a, c], [b, a]].map(|[p, q]| exact_triple(s.line, origin, p, q, false));
    let least = weights.iter().fold(0.0, |x, w| f32::min(x, w.value.hi));
    let most = weights.iter().fold(0.0, |x, w| f32::max(x, w.value.hi));
    if (least < 0.0 && most > 0.0) || least == most {
        return None;
    }
    let depth = exact_triple(a, origin, c, b, true);
    let exponent = weights.iter().map(|w| w.exponent).max()?;
    let mut det = Pair::new(0.0);
    for w in &weights {
        let shift = w.exponent - exponent;
        let sum = Pair::exact_sum(det.hi, scaled(w.value.hi, shift));
        det = Pair { hi: sum.hi, lo: sum.lo + (det.lo + scaled(w.value.lo, shift)) };
    }
    let [t, v, w] = [depth, weights[1], weights[2]].map(|x| (x.value.over(det), x.exponent - exponent));
    let side = t.0;
    let [t, v, w] = [(t.0, t.1 + s.shift), v, w].map(|(x, shift)| scaled(x, shift));
    let beside = t == 0.0 && (side < 0.0 && s.t_min >= 0.0 || side > 0.0 && s.t_max <= 0.0);
    (!beside).then_some(Meeting { t, uv: [v, w] })
}
