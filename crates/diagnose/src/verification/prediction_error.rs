//! The errors of the prediction itself: directions `P` with `cov(prediction) = P Pᵀ`.
//!
//! A calibration is uncertain, and its errors are correlated from one position to the next: in a comparison they look
//! like structure. Their covariance `K` is that of the calibrated machine
//! ([`CalibratedMachine::covariance_of_readings`]), for the side of each reading where it has both sides.
//!
//! `K` has few directions that matter; they come from a pivoted Cholesky factorisation, which stops when what is left
//! is far below the noise. As unknowns with the pseudo-observations `0 = x ± 1` they join the base model, which is
//! the same as adding `K` to the covariance of the readings.

use nalgebra::DVector;
use trueaxis_campaign::Direction;
use trueaxis_predict::{CalibratedMachine, pivoted_cholesky};

use crate::verification::base::{cells, count, stands};
use crate::verification::comparison::{Comparison, came_from};

/// Negligible variance of a prediction, in variances of an arrival.
const NEGLIGIBLE: f64 = 1e-3;

/// The columns of `P` over the readings of the comparisons in turn, µm; none if the calibration has no uncertainties.
pub(crate) fn prediction_directions(
    comparisons: &[&Comparison<'_>],
    machine: &CalibratedMachine,
    noise_um: f64,
) -> Vec<Vec<f64>> {
    if !machine.has_uncertainties {
        return Vec::new();
    }
    let (mut readings, mut of_arrivals) = (Vec::<(_, &[f64], _)>::new(), Vec::new());
    for comparison in comparisons {
        let axis = comparison.line();
        let stands = match axis.is_some_and(|axis| machine.keeps_sides_apart(axis)) {
            true => cells(comparison),
            false => stands(comparison),
        };
        let first = readings.len();
        readings.resize(
            first + count(&stands),
            (comparison.kind, &[], Direction::Forward),
        );
        for (arrival, stand) in comparison.arrivals.iter().zip(stands) {
            readings[first + stand] = (comparison.kind, &arrival.positions, came_from(arrival));
            of_arrivals.push(first + stand);
        }
    }
    let prediction = machine.covariance_of_readings(&readings);
    let of_stands = pivoted_cholesky(&prediction, NEGLIGIBLE * noise_um * noise_um);
    let spread = |column: &DVector<f64>| of_arrivals.iter().map(|&stand| column[stand]).collect();
    of_stands.iter().map(spread).collect()
}
