//! Whether a station's zero jumped, and nothing else.
//!
//! A beam interruption changes all later lengths of a station's turn by one constant. Other things
//! raise the test of such a step, too: a drift (the zero or the tripod creeps), or a displacement of
//! the station or the machine (the change depends on the direction of the beam). The turn is split
//! only if the step explains the lengths better than these do.

use nalgebra::{DMatrix, DVector};
use trueaxis_leastsquares::dot;

use crate::step_tests::StepTest;
use crate::whitened::Whitened;
use crate::{Network, Solution};

/// What a step must be ahead of other explanations, as a difference of squares of standardised
/// sizes: a likelihood ratio of e⁵.
const AHEAD: f64 = 10.0;

/// A displacement has three parameters for the step's one; by chance alone its square is larger by
/// this at most (chi-squared with two degrees of freedom, one in e⁵).
const DISPLACEMENT_CHANCE: f64 = 10.0;

/// Whether the step is that of an interrupted beam; `scale` is the standard deviation of w.
pub(crate) fn is_interruption(
    (network, solution): (&Network, &Solution),
    rows: &Whitened,
    step: &StepTest,
    scale: f64,
) -> bool {
    let zeros = network.zero_of_readings();
    let zero = zeros[step.first_reading];
    let turn: Vec<usize> = (0..zeros.len()).filter(|&i| zeros[i] == zero).collect();
    let length = turn.len().max(2) as f64 - 1.0;
    let mut drift = vec![0.0; zeros.len()];
    for (k, &i) in turn.iter().enumerate() {
        drift[i] = k as f64 / length;
    }
    let mut displacement = vec![vec![0.0; zeros.len()]; 3];
    for visit in network.visits.iter().filter(|v| v.station == step.station) {
        let station_mm = solution.stations[visit.station].position_mm;
        for i in visit.readings.clone() {
            if i < step.first_reading || zeros[i] != zero {
                continue;
            }
            let point = network.point(visit.group, network.readings[i].point);
            let beam = (solution.points_mm[point] - station_mm).normalize();
            for (column, u) in displacement.iter_mut().zip(beam.iter()) {
                column[i] = *u;
            }
        }
    }
    let own = (step.w / scale).powi(2);
    let other = |columns| explained(rows, columns) / (scale * scale);
    own > other(vec![drift]) + AHEAD && own > other(displacement) - DISPLACEMENT_CHANCE
}

/// A direction that the adjustment absorbs explains nothing, below this part of the largest one.
const ABSORBED: f64 = 1e-9;

/// By how much the sum of squares falls if errors of the form of these columns, one element for each
/// reading, are allowed for: `bᵀ A⁺ b` with `A = XᵀMX` and `b = Xᵀv` of the whitened columns.
fn explained(rows: &Whitened, mut columns: Vec<Vec<f64>>) -> f64 {
    columns.iter_mut().for_each(|column| rows.whiten(column));
    let mut kept = columns.clone();
    kept.iter_mut().for_each(|column| rows.project(column));
    let n = columns.len();
    let left = DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &kept[j]));
    let right = DVector::from_fn(n, |k, _| dot(&columns[k], &rows.residuals));
    let limit = ABSORBED * left.amax();
    let found = left.svd(true, true).solve(&right, limit);
    found.map_or(0.0, |estimates| right.dot(&estimates))
}
