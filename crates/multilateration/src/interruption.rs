//! Whether a station's zero jumped, and nothing else.
//!
//! A beam interruption changes all later lengths of a station's turn by one constant. Other things
//! raise the test of such a step, too: a drift (the zero or the tripod creeps), or a displacement of
//! the station or the machine (the change depends on the direction of the beam). The turn is split
//! only if the step explains the lengths better than these do.

use faer::Mat;
use trueaxis_leastsquares::BlockRows;

use crate::influence::Influence;
use crate::noise::whiten;
use crate::step_tests::StepTest;

/// What a step must be ahead of other explanations, as a difference of squares of standardised
/// sizes: a likelihood ratio of e⁵.
const AHEAD: f64 = 10.0;

/// A displacement has three parameters for the step's one; by chance alone its square is larger by
/// this at most (chi-squared with two degrees of freedom, one in e⁵).
const DISPLACEMENT_CHANCE: f64 = 10.0;

/// Whether the step is that of an interrupted beam; `scale` is the standard deviation of w.
pub(crate) fn is_interruption(influence: &Influence<'_>, step: &StepTest, scale: f64) -> bool {
    let network = influence.network();
    let zero = influence.model().zero_of(step.first_reading);
    let turn: Vec<usize> = (0..network.readings.len())
        .filter(|&i| influence.model().zero_of(i) == zero)
        .collect();
    let length = turn.len().max(2) as f64 - 1.0;
    let mut progress = vec![0.0; network.readings.len()];
    for (k, &i) in turn.iter().enumerate() {
        progress[i] = k as f64 / length;
    }
    let in_step = |i: usize| i >= step.first_reading && influence.model().zero_of(i) == zero;

    let drift = explained(influence, step.station, 1, |i, _, column| {
        column[0] = progress[i];
    });
    let displacement = explained(influence, step.station, 3, |i, beam, column| {
        if in_step(i) {
            column.copy_from_slice(beam);
        }
    });
    let own = (step.w / scale).powi(2);
    let other = |squares: f64| squares / (scale * scale);
    own > other(drift) + AHEAD && own > other(displacement) - DISPLACEMENT_CHANCE
}

/// By how much the sum of squares falls if errors of the form of `columns` columns in the lengths of
/// a station are allowed for. `fill` gives a reading's part of them from its number and its beam.
fn explained(
    influence: &Influence<'_>,
    station: usize,
    columns: usize,
    fill: impl Fn(usize, &[f64; 3], &mut [f64]),
) -> f64 {
    let network = influence.network();
    let mut right = Mat::<f64>::zeros(columns, 1);
    let mut left = Mat::<f64>::zeros(columns, columns);
    let mut through_shared = Mat::<f64>::zeros(influence.width(), columns);
    let mut memory = BlockRows::default();
    for g in 0..influence.groups() {
        let group = influence.group(g, &mut memory);
        let mut x = Mat::<f64>::zeros(group.own.nrows(), columns);
        for visit in &group.visits {
            let content = &network.visits[visit.visit];
            if content.station != station {
                continue;
            }
            let mut rows = vec![vec![0.0; visit.count]; columns];
            let mut column = vec![0.0; columns];
            for (i, reading) in content.readings.clone().enumerate() {
                column.fill(0.0);
                fill(reading, &influence.beam(reading, visit.visit), &mut column);
                for (row, value) in rows.iter_mut().zip(&column) {
                    row[i] = *value;
                }
            }
            for (k, row) in rows.iter_mut().enumerate() {
                whiten(influence.model().factor(visit.visit), row);
                for (i, value) in row.iter().enumerate() {
                    x[(visit.first + i, k)] = *value;
                }
            }
        }
        let own = group.own.transpose() * &x;
        left += x.transpose() * &x - own.transpose() * &own;
        through_shared += group.shared.transpose() * &x;
        for k in 0..columns {
            right[(k, 0)] += (0..x.nrows())
                .map(|i| x[(i, k)] * group.residuals[i])
                .sum::<f64>();
        }
    }
    left -= through_shared.transpose() * influence.reduced_inverse() * &through_shared;
    projected_squares(&left, &right)
}

/// A direction that the adjustment absorbs explains nothing, below this part of the largest one.
const ABSORBED: f64 = 1e-9;

/// `bᵀ A⁻¹ b` by elimination with diagonal pivots; directions without a pivot count for nothing.
fn projected_squares(left: &Mat<f64>, right: &Mat<f64>) -> f64 {
    let (mut a, mut b) = (left.clone(), right.clone());
    let n = a.nrows();
    let largest = (0..n).map(|k| a[(k, k)]).fold(0.0, f64::max);
    let mut open: Vec<usize> = (0..n).collect();
    let mut squares = 0.0;
    while let Some(place) =
        (0..open.len()).max_by(|&i, &j| a[(open[i], open[i])].total_cmp(&a[(open[j], open[j])]))
    {
        let pivot = open.swap_remove(place);
        let value = a[(pivot, pivot)];
        if value <= ABSORBED * largest {
            break;
        }
        squares += b[(pivot, 0)].powi(2) / value;
        for &i in &open {
            let factor = a[(i, pivot)] / value;
            b[(i, 0)] -= factor * b[(pivot, 0)];
            for &j in &open {
                let change = factor * a[(pivot, j)];
                a[(i, j)] -= change;
            }
        }
    }
    squares
}
