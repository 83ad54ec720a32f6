//! Times of things of several kinds, taken apart: non-negative least squares by coordinate descent.

/// A time, and how many things of each kind it took.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample<const N: usize> {
    pub counts: [f64; N],
    /// Above 0.
    pub time: f64,
}

/// Rounds at most, and the largest step, of a sample's time, after which no more is done.
const ROUNDS: usize = 1 << 17;
const ENOUGH: f64 = 1e-9;

/// The time of a thing of each kind, never negative, for which Σ (Σ_k count_k x_k / time − 1)² is least: all samples
/// weigh the same, however long they took. A kind that no sample has takes 0.
pub(super) fn taken_apart<const N: usize>(samples: &[Sample<N>]) -> [f64; N] {
    let rows: Vec<[f64; N]> = samples.iter().map(|s| s.counts.map(|c| c / s.time)).collect();
    let mut x = [0.0; N];
    for _ in 0..ROUNDS {
        let mut step = 0f64;
        for k in 0..N {
            // What the other kinds leave to explain, along this one.
            let (mut along, mut square) = (0.0, 0.0);
            for row in &rows {
                let others: f64 = (0..N).filter(|j| *j != k).map(|j| row[j] * x[j]).sum();
                along += row[k] * (1.0 - others);
                square += row[k] * row[k];
            }
            let next = if square > 0.0 { (along / square).max(0.0) } else { 0.0 };
            step = step.max((next - x[k]).abs() * square.sqrt());
            x[k] = next;
        }
        if step < ENOUGH {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(counts: [f64; 3], costs: [f64; 3]) -> Sample<3> {
        Sample { counts, time: (0..3).map(|k| counts[k] * costs[k]).sum() }
    }

    #[test]
    fn exact_times_give_exact_costs() {
        let costs = [12.0, 15.0, 40.0];
        let counts =
            [[90.0, 0.0, 3.0], [30.0, 60.0, 2.0], [10.0, 0.0, 30.0], [4.0, 0.0, 0.0], [1.0, 20.0, 1.0]];
        let found = taken_apart(&counts.map(|c| sample(c, costs)));
        for (found, cost) in found.iter().zip(costs) {
            assert!((found / cost - 1.0).abs() < 1e-5, "{found}, not {cost}");
        }
    }

    #[test]
    fn noise_moves_little_and_nothing_below_0() {
        let costs = [12.0, 15.0, 40.0];
        let counts =
            [[90.0, 0.0, 3.0], [30.0, 60.0, 2.0], [10.0, 0.0, 30.0], [40.0, 0.0, 8.0], [1.0, 20.0, 1.0]];
        let noisy = counts.map(|c| sample(c, costs)).into_iter().zip([1.1, 0.9, 1.05, 1.0, 0.95]);
        let noisy: Vec<_> = noisy.map(|(s, noise)| Sample { time: s.time * noise, ..s }).collect();
        for (found, cost) in taken_apart(&noisy).iter().zip(costs) {
            assert!((found / cost - 1.0).abs() < 0.2, "{found}, not {cost}");
        }
        // A kind that seems to save time takes none.
        let odd = [Sample { counts: [1.0, 0.0], time: 2.0 }, Sample { counts: [1.0, 1.0], time: 1.0 }];
        let [first, second] = taken_apart(&odd);
        assert!((first - 1.2).abs() < 1e-6 && second == 0.0, "{first}, {second}");
        assert_eq!(taken_apart::<2>(&[]), [0.0; 2]);
    }
}
