//! The check of a first-order result against the Monte Carlo (JCGM 101, clause 8).

use statrs::distribution::{ContinuousCDF, Normal};

use crate::coverage::Interval;
use crate::error::Error;
use crate::summary::{Scatter, Summary};
use crate::tolerance::{check_digits, numerical_tolerance};

/// A difference is blamed on the Monte Carlo up to so many of its standard deviations. Over both
/// ends of a thousand outputs, the chance that scatter alone gives any of them a wrong outcome is
/// 6 %; with two standard deviations it would be a certainty.
const SCATTER_FACTOR: f64 = 4.0;

/// Clause 8.2: the Monte Carlo should be stable to this part of the tolerance.
const SUFFICIENT_PART: f64 = 0.2;

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
    /// Scatter of the Monte Carlo; `d_low` and `d_high` scatter by its `low` and `high`.
    pub scatter: Scatter,
    /// What follows.
    pub outcome: Outcome,
}

impl Validation {
    /// Whether there were as many trials as clause 8.2 recommends: twice the scatter of mean, u and
    /// both ends within a fifth of the tolerance. More trials may decide an undecided outcome even
    /// then, and fewer may do for a clear one.
    pub fn trials_suffice(&self) -> bool {
        2.0 * self.scatter.largest() <= SUFFICIENT_PART * self.tolerance
    }
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
        scatter,
        outcome,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(found.trials_suffice(), scatter < 0.005);
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
