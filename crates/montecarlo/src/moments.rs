//! Mean and standard deviation of an output with their standard errors (JCGM 101, 7.6).

/// Moments of a sample, in two passes about its first value: what is common to all values, such as
/// the nominal length of a gauge block, cancels before anything is squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moments {
    count: usize,
    pub(crate) mean: f64,
    /// Sum of squares about the mean, not negative; not finite where the squares overflow.
    squares: f64,
}

impl Moments {
    /// Of no values.
    pub(crate) const NONE: Self = Self {
        count: 0,
        mean: 0.0,
        squares: 0.0,
    };

    /// Of values in their order, so that the bits do not depend on how they were made.
    pub(crate) fn of(values: &[f64]) -> Self {
        let Some(first) = values.first() else {
            return Self::NONE;
        };
        let n = values.len() as f64;
        let shift = values.iter().map(|value| value - first).sum::<f64>() / n;
        let mean = first + shift;
        let (sum, squares) = values.iter().fold((0.0, 0.0), |(sum, squares), value| {
            let deviation = (value - first) - shift;
            (sum + deviation, squares + deviation * deviation)
        });
        // What rounding left in the mean, taken out again.
        let squares = squares - sum * sum / n;
        Self {
            count: values.len(),
            mean,
            squares: if squares < 0.0 { 0.0 } else { squares },
        }
    }

    /// The moments of both samples together (pairwise updating of Chan et al.).
    pub(crate) fn merged(&self, other: &Self) -> Self {
        let (n, m) = (self.count as f64, other.count as f64);
        let total = (n + m).max(1.0);
        let step = other.mean - self.mean;
        Self {
            count: self.count + other.count,
            mean: self.mean + step * m / total,
            squares: self.squares + other.squares + step * step * n * m / total,
        }
    }

    /// Standard deviation with n - 1: the standard uncertainty of the output.
    pub(crate) fn standard_deviation(&self) -> f64 {
        let degrees = self.count.saturating_sub(1).max(1);
        (self.squares / degrees as f64).sqrt()
    }

    /// Standard error of the mean, s/√n.
    pub(crate) fn mean_scatter(&self) -> f64 {
        self.standard_deviation() / (self.count.max(1) as f64).sqrt()
    }

    /// Standard error of the standard deviation, from the kurtosis κ of the same `values`:
    /// var(s²) = s⁴ (κ - (n - 3)/(n - 1)) / n, and s = √s² scatters by √var(s²) / (2 s).
    ///
    /// It has no meaning where the distribution has no fourth moment (Student's t with four degrees
    /// of freedom or less).
    pub(crate) fn standard_deviation_scatter(&self, values: &[f64]) -> f64 {
        let s = self.standard_deviation();
        if self.count < 2 || s < f64::MIN_POSITIVE {
            return 0.0;
        }
        let n = self.count as f64;
        let fourth_powers = values.iter().map(|value| ((value - self.mean) / s).powi(4));
        let kurtosis = fourth_powers.sum::<f64>() / n;
        let relative_variance = (kurtosis - (n - 3.0) / (n - 1.0)).max(0.0) / n;
        0.5 * s * relative_variance.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_sample_by_hand() {
        // Deviations -1, 0, 1, 4, -4 about 1e9 + 3: squares 34, fourth powers 514.
        let values = [2.0, 3.0, 4.0, 7.0, -1.0].map(|v| 1e9 + v);
        let moments = Moments::of(&values);
        assert!((moments.mean - 1e9 - 3.0).abs() < 1e-6);
        assert!((moments.standard_deviation() - 8.5_f64.sqrt()).abs() < 1e-12);
        assert!((moments.mean_scatter() - 1.7_f64.sqrt()).abs() < 1e-12);
        let kurtosis = 514.0 / 5.0 / 8.5_f64.powi(2);
        let theory = 0.5 * (8.5 * (kurtosis - 0.5) / 5.0).sqrt();
        assert!((moments.standard_deviation_scatter(&values) - theory).abs() < 1e-12);
    }

    #[test]
    fn merging_gives_the_moments_of_all() {
        let values: Vec<f64> = (0..100).map(|i| f64::from(i * i % 37)).collect();
        let (left, right) = values.split_at(31);
        let merged = Moments::of(left).merged(&Moments::of(right));
        let all = Moments::of(&values);
        assert_eq!(merged.count, 100);
        assert!((merged.mean - all.mean).abs() < 1e-12);
        assert!((merged.squares / all.squares - 1.0).abs() < 1e-12);
    }

    #[test]
    fn values_that_do_not_vary_have_no_scatter() {
        let values = [0.1; 7];
        let moments = Moments::of(&values);
        assert!(moments.standard_deviation() < f64::MIN_POSITIVE);
        assert!(moments.standard_deviation_scatter(&values) < f64::MIN_POSITIVE);
    }
}
