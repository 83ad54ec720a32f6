//! Medians, spread, and when a warm-up has done its work.

use std::time::{Duration, Instant};

/// What repeated measurements of one thing gave.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Spread {
    /// Median: of an even number the mean of the middle two.
    pub median: f64,
    /// Least.
    pub min: f64,
    /// Greatest.
    pub max: f64,
    /// Lower quartile.
    pub q1: f64,
    /// Upper quartile.
    pub q3: f64,
    /// How many.
    pub runs: usize,
}

impl Spread {
    /// Of `values`; zeros where there are none.
    pub fn of(values: &[f64]) -> Self {
        let mut v = values.to_vec();
        v.sort_by(f64::total_cmp);
        // Linear between the neighbours, as most statistics programs do it.
        let at = |share: f64| {
            let x = share * v.len().saturating_sub(1) as f64;
            let (below, above) = (v.get(x.floor() as usize), v.get(x.ceil() as usize));
            let (below, above) = (below.copied().unwrap_or(0.0), above.copied().unwrap_or(0.0));
            below + (above - below) * x.fract()
        };
        Self { median: at(0.5), min: at(0.0), max: at(1.0), q1: at(0.25), q3: at(0.75), runs: v.len() }
    }

    /// The same of `count` things a millisecond, as millions a second.
    pub fn rate(&self, count: usize) -> Self {
        let mega = |ms: f64| if ms > 0.0 { count as f64 / ms * 1e-3 } else { 0.0 };
        Self {
            median: mega(self.median),
            min: mega(self.max),
            max: mega(self.min),
            q1: mega(self.q3),
            q3: mega(self.q1),
            runs: self.runs,
        }
    }

    /// Interquartile range over median, per cent.
    pub fn percent(&self) -> f64 {
        if self.median > 0.0 { (self.q3 - self.q1) / self.median * 100.0 } else { 0.0 }
    }
}

/// How far the last three runs of a warm-up may lie apart, over their median.
const SETTLED: f64 = 0.05;

/// Whether a warm-up has done its work: the last three runs agree.
pub fn settled(values: &[f64]) -> bool {
    let Some(start) = values.len().checked_sub(3) else { return false };
    let last = Spread::of(&values[start..]);
    last.max - last.min <= SETTLED * last.median
}

/// Whether `most` runs are done, or fewer that have settled.
pub(super) fn enough(most: usize, values: &[f64]) -> bool {
    values.len() >= most || settled(values)
}

/// Warm-up runs at most, where nobody says otherwise.
pub(super) const WARM_UPS: usize = 8;
/// No further warm-up run is begun after this.
const WARM_UP_TIME: Duration = Duration::from_secs(2);

/// Repeats `run`, which says what it took, until three take the same time; `most` times at most.
///
/// # Errors
/// Those of `run`.
pub(super) fn warm_up<E>(most: usize, mut run: impl FnMut() -> Result<f64, E>) -> Result<(), E> {
    let start = Instant::now();
    let mut times = vec![];
    while !enough(most, &times) && (times.is_empty() || start.elapsed() < WARM_UP_TIME) {
        times.push(run()?);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warm_up_ends_when_times_settle() {
        let mut times = [9.0, 3.0, 2.0, 2.0, 2.0, 1.0].into_iter();
        warm_up(WARM_UPS, || times.next().ok_or(())).unwrap_or_else(|()| panic!("went on"));
        assert_eq!(times.len(), 1);
        let mut runs = 0;
        let wild = || {
            runs += 1;
            Ok::<f64, ()>(f64::from(runs))
        };
        assert!(warm_up(WARM_UPS, wild).is_ok() && runs == WARM_UPS as u32);
    }

    #[test]
    fn spread_of_few() {
        assert_eq!(Spread::of(&[]), Spread::default());
        let s = Spread::of(&[4.0, 1.0, 3.0, 2.0]);
        assert_eq!((s.median, s.min, s.max, s.q1, s.q3, s.runs), (2.5, 1.0, 4.0, 1.75, 3.25, 4));
        assert_eq!(s.rate(8_000).max, 8.0, "the shortest time is the highest rate");
    }

    #[test]
    fn three_alike_are_settled() {
        assert!(!settled(&[1.0, 1.0]));
        assert!(!settled(&[1.0, 1.1, 1.0]));
        assert!(settled(&[9.0, 1.0, 1.02, 1.01]));
    }
}
