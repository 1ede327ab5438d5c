//! The check of a first-order result against the Monte Carlo (JCGM 101, clause 8).

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

use crate::coverage::Interval;
use crate::error::Error;
use crate::summary::Summary;
use crate::tolerance::{check_digits, numerical_tolerance};

/// A difference of up to this many of its standard deviations is attributed to the Monte Carlo. Over both
/// ends of a thousand outputs, the chance that scatter alone gives any of them a wrong outcome is
/// 6 %; with two standard deviations it would be a certainty.
const SCATTER_FACTOR: f64 = 4.0;

/// A result of the law of propagation of uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstOrder {
    /// The estimate `y`.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
    /// The coverage factor `k`: the interval is `y ± k u`.
    pub coverage_factor: f64,
}

impl FirstOrder {
    /// A result that is taken to be normal, so that `k` is 1.96 for a coverage of 0.95. `k` is NaN
    /// when the coverage is not between 0 and 1.
    pub fn normal(value: f64, u: f64, coverage: f64) -> Self {
        let inside = coverage > 0.0 && coverage < 1.0;
        let coverage_factor = if inside {
            Normal::standard().inverse_cdf(0.5 + 0.5 * coverage)
        } else {
            f64::NAN
        };
        Self {
            value,
            u,
            coverage_factor,
        }
    }

    /// The coverage interval `y ± k u`.
    pub fn interval(&self) -> Interval {
        let expanded = self.coverage_factor * self.u;
        Interval {
            low: self.value - expanded,
            high: self.value + expanded,
        }
    }
}

/// Probability, at most, that among `results` normal ones the standard deviation of `trials` values that is
/// farthest from a right u is as far from it as `ratio` (standard deviation over u): `(n - 1) ratio²` follows
/// chi-squared with `n - 1` degrees of freedom. Exact for one result; for many they may depend on each other in any way
/// (Bonferroni). 1 where the question has no meaning.
///
/// The largest difference of many is no surprise by itself: of 400 results by 200 trials it is some 16 %.
pub fn chance_of_ratio(ratio: f64, trials: usize, results: usize) -> f64 {
    let degrees = trials.saturating_sub(1) as f64;
    let Ok(chi_squared) = ChiSquared::new(degrees) else {
        return 1.0;
    };
    if !ratio.is_finite() {
        return 1.0;
    }
    let value = degrees * ratio * ratio;
    let tail = chi_squared.cdf(value).min(chi_squared.sf(value));
    (2.0 * tail * results as f64).min(1.0)
}

/// What the Monte Carlo says about a first-order result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Both ends of the interval agree within the tolerance, whatever the Monte Carlo scatter.
    Validated,
    /// One end differs by more than the tolerance, and Monte Carlo scatter does not explain it.
    NotValidated,
    /// The difference is too close to the tolerance for so few trials.
    Undecided,
}

/// The comparison of a first-order result with a Monte Carlo, in the unit of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Validation {
    /// Numerical tolerance δ of the Monte Carlo's standard uncertainty.
    pub tolerance: f64,
    /// `d_low`, distance of the lower ends of the intervals.
    pub d_low: f64,
    /// `d_high`, distance of the upper ends.
    pub d_high: f64,
    /// What follows.
    pub outcome: Outcome,
}

/// Compares a first-order result with the probabilistically symmetric interval of the Monte Carlo.
///
/// Clause 8.1 validates the first-order result when `d_low` and `d_high` are not above δ, half of
/// the last of `significant_digits` digits of the standard uncertainty. Here this must hold, or
/// fail, by more than four standard deviations of the ends of the Monte Carlo interval; between
/// the two the outcome is [`Outcome::Undecided`]. The coverage factor must belong to the coverage
/// probability of the Monte Carlo.
///
/// # Errors
/// [`Error::SignificantDigits`] and [`Error::FirstOrderNotFinite`].
pub fn validate(
    first_order: &FirstOrder,
    monte_carlo: &Summary,
    significant_digits: u32,
) -> Result<Validation, Error> {
    check_digits(significant_digits)?;
    let interval = first_order.interval();
    if !(interval.low.is_finite() && interval.high.is_finite()) {
        return Err(Error::FirstOrderNotFinite {
            value: first_order.value,
            u: first_order.u,
            coverage_factor: first_order.coverage_factor,
        });
    }
    let tolerance = numerical_tolerance(monte_carlo.u, significant_digits);
    let scatter = monte_carlo.scatter;
    let d_low = (interval.low - monte_carlo.symmetric.low).abs();
    let d_high = (interval.high - monte_carlo.symmetric.high).abs();
    let ends = [(d_low, scatter.low), (d_high, scatter.high)];
    let outcome = if ends
        .iter()
        .all(|(d, s)| d + SCATTER_FACTOR * s <= tolerance)
    {
        Outcome::Validated
    } else if ends.iter().any(|(d, s)| d - SCATTER_FACTOR * s > tolerance) {
        Outcome::NotValidated
    } else {
        Outcome::Undecided
    };
    Ok(Validation {
        tolerance,
        d_low,
        d_high,
        outcome,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scatter;

    /// Abramowitz and Stegun, Table 26.8: chi-squared with 100 degrees of freedom is above 149.449 with 0.001.
    #[test]
    fn the_farthest_of_many_is_judged_as_that() {
        let ratio = (149.449_f64 / 100.0).sqrt();
        assert!((chance_of_ratio(ratio, 101, 1) - 0.002).abs() < 2e-6);
        assert!((chance_of_ratio(ratio, 101, 10) - 0.02).abs() < 2e-5);
        let below = (77.9295_f64 / 100.0).sqrt();
        assert!((chance_of_ratio(below, 101, 1) - 0.1).abs() < 2e-5);
        assert!(chance_of_ratio(0.838, 200, 397) > 0.2);
        assert!(chance_of_ratio(0.838, 2000, 397) < 1e-15);
        let none = [
            chance_of_ratio(f64::NAN, 200, 3),
            chance_of_ratio(1.2, 1, 3),
        ];
        assert!(none.iter().all(|p| *p > 0.999));
    }

    /// A Monte Carlo with the interval -2 to 2, u = 1.02 (δ = 0.05 for two digits) and ends that
    /// scatter by `scatter`.
    fn monte_carlo(scatter: f64) -> Summary {
        let (low, high) = (-2.0, 2.0);
        Summary {
            mean: 0.0,
            u: 1.02,
            symmetric: Interval { low, high },
            shortest: Interval { low, high },
            scatter: Scatter {
                mean: 0.0,
                u: 0.0,
                low: scatter,
                high: scatter,
            },
        }
    }

    fn first_order(low: f64, high: f64) -> FirstOrder {
        FirstOrder {
            value: 0.5 * (low + high),
            u: 0.25 * (high - low),
            coverage_factor: 2.0,
        }
    }

    #[test]
    fn tolerance_and_scatter_decide_together() {
        for (low, high, scatter, outcome) in [
            (-2.03, 2.03, 0.004, Outcome::Validated),
            (-2.03, 2.03, 0.006, Outcome::Undecided),
            (-2.03, 2.07, 0.004, Outcome::NotValidated),
            (-2.03, 2.07, 0.006, Outcome::Undecided),
            (-1.90, 2.03, 0.006, Outcome::NotValidated),
            (-2.00, 2.00, 0.02, Outcome::Undecided),
        ] {
            let found = validate(&first_order(low, high), &monte_carlo(scatter), 2).unwrap();
            assert_eq!(found.outcome, outcome, "{low} {high} {scatter}");
            assert!((found.d_low - (low + 2.0).abs()).abs() < 1e-12);
            assert!((found.d_high - (high - 2.0).abs()).abs() < 1e-12);
            assert!((found.tolerance - 0.05).abs() < 1e-15);
        }
    }

    #[test]
    fn normal_coverage_factors_of_the_gum() {
        for (coverage, k) in [(0.6827, 1.0), (0.95, 1.95996), (0.99, 2.57583)] {
            let found = FirstOrder::normal(0.0, 1.0, coverage).coverage_factor;
            assert!((found - k).abs() < 1e-4, "{found}");
        }
    }

    #[test]
    fn what_cannot_be_compared_is_an_error() {
        let refused = validate(&first_order(-2.0, 2.0), &monte_carlo(0.0), 0);
        assert!(matches!(refused, Err(Error::SignificantDigits { .. })));
        let endless = FirstOrder::normal(f64::NAN, 1.0, 0.95);
        let refused = validate(&endless, &monte_carlo(0.0), 2);
        assert!(matches!(refused, Err(Error::FirstOrderNotFinite { .. })));
        assert!(FirstOrder::normal(0.0, 1.0, 1.0).coverage_factor.is_nan());
    }
}
