//! Coverage intervals of sorted values (JCGM 101, 7.7).

/// An interval of an output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Distance of the ends.
    pub fn width(&self) -> f64 {
        self.high - self.low
    }
}

/// Where the coverage intervals `[y_(r), y_(r + q)]` of M sorted values `y_(1) … y_(M)` lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Ranks {
    /// Steps from the lower to the upper end: pM, rounded.
    pub(crate) q: usize,
    /// Lower end of the probabilistically symmetric interval, from 1: half of M - q, or where that
    /// is not an integer, the integer above.
    pub(crate) r: usize,
}

/// The ranks for a number of trials (7.7.2); none when no value would lie outside.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the integer part is meant, of a positive number not above the number of trials"
)]
pub(crate) fn ranks(trials: usize, coverage: f64) -> Option<Ranks> {
    // Where pM is an integer, this is that integer in spite of rounding.
    let q = (coverage * trials as f64 + 0.5).floor() as usize;
    let outside = trials.checked_sub(q).filter(|outside| *outside > 0)?;
    let r = outside.div_ceil(2);
    Some(Ranks { q, r })
}

pub(crate) fn symmetric(sorted: &[f64], ranks: Ranks) -> Interval {
    Interval {
        low: sorted[ranks.r - 1],
        high: sorted[ranks.r - 1 + ranks.q],
    }
}

/// The shortest interval; of equally short ones the lowest.
pub(crate) fn shortest(sorted: &[f64], ranks: Ranks) -> Interval {
    let ends = sorted.iter().zip(&sorted[ranks.q..]);
    ends.map(|(&low, &high)| Interval { low, high })
        .min_by(|a, b| a.width().total_cmp(&b.width()))
        .unwrap_or_else(|| symmetric(sorted, ranks))
}

/// Standard error of the order statistic `y_(rank)`.
///
/// The number of values below the quantile α is binomial with variance M α (1 - α), so the quantile
/// has a rank that is uncertain by its square root: half of the way between the values that far
/// below and above is the standard error, without asking for the density there. Close to the ends
/// of the sample the way is cut off, and the figure is too small.
pub(crate) fn order_statistic_scatter(sorted: &[f64], rank: usize) -> f64 {
    let trials = sorted.len() as f64;
    let alpha = rank as f64 / (trials + 1.0);
    let rank_scatter = (trials * alpha * (1.0 - alpha)).sqrt();
    let below = at_rank(sorted, rank as f64 - rank_scatter);
    let above = at_rank(sorted, rank as f64 + rank_scatter);
    0.5 * (above - below)
}

/// The sorted values at a rank (from 1) between two of them.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the integer part is meant, of a position inside the slice"
)]
fn at_rank(sorted: &[f64], rank: f64) -> f64 {
    let last = sorted.len() - 1;
    let position = (rank - 1.0).clamp(0.0, last as f64);
    let index = position as usize;
    let share = position - index as f64;
    let next = sorted[(index + 1).min(last)];
    sorted[index] + share * (next - sorted[index])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand from 7.7.2: pM integer, pM not integer, M - q odd and even.
    #[test]
    fn ranks_are_those_of_the_supplement() {
        for (trials, coverage, q, r) in [
            (1_000_000, 0.95, 950_000, 25_000),
            (100, 0.95, 95, 3), // (M - q)/2 = 2.5, integer part of (M - q + 1)/2
            (50, 0.95, 48, 1),  // pM = 47.5
            (30, 0.95, 29, 1),  // pM = 28.5
            (11, 0.95, 10, 1),  // pM = 10.45
            (100, 0.99, 99, 1),
            (10, 0.7, 7, 2),
        ] {
            assert_eq!(ranks(trials, coverage), Some(Ranks { q, r }), "{trials}");
        }
        assert_eq!(ranks(10, 0.95), None);
        assert_eq!(ranks(49, 0.99), None);
    }

    #[test]
    fn intervals_of_ten_values() {
        let sorted = [0.0, 4.0, 5.0, 5.5, 6.0, 6.5, 7.0, 8.0, 9.0, 20.0];
        let ranks = ranks(10, 0.7).unwrap();
        let (low, high) = (4.0, 9.0);
        assert_eq!(symmetric(&sorted, ranks), Interval { low, high });
        assert_eq!(shortest(&sorted, ranks), Interval { low, high });
        let even = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        let (low, high) = (0.0, 7.0);
        assert_eq!(shortest(&even, ranks), Interval { low, high });
    }

    /// Values spread evenly over 0 to 1: the quantile α scatters by √(α (1 - α) / M).
    #[test]
    fn scatter_of_a_quantile_of_the_rectangular_distribution() {
        let even: Vec<f64> = (1..10_000).map(|i| f64::from(i) / 10_000.0).collect();
        for rank in [250, 5000, 9750] {
            let alpha = rank as f64 / 10_000.0;
            let theory = (alpha * (1.0 - alpha) / 9999.0).sqrt();
            let found = order_statistic_scatter(&even, rank);
            assert!((found / theory - 1.0).abs() < 1e-3, "{found} {theory}");
        }
    }
}
