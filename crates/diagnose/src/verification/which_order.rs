//! Which of two orders the readings were taken in, by the readings themselves.
//!
//! A report sorts cycles by position and side; a test of repeatability reads all its cycles at one position from one
//! side before the next. Both tables look alike. What wanders is smooth in the order of measuring alone, so each order
//! has a likelihood: a random walk beside white noise, in this order, with a free value for each position and side,
//! and a slope over the cycle numbers. These take what the two orders have in common: to either, a drift at one rate
//! is the same slope, and the lost motion is another. Restricted maximum likelihood over the variance of a step:
//!
//! ```text
//! -2 ln L = (n - p) ln(rᵀV⁻¹r) + ln det V + ln det XᵀV⁻¹X        V_ij = δ_ij + step · min(i, j)
//! ```

use trueaxis_leastsquares::median;
use trueaxis_selection::lengths_beside_earlier;

use crate::verification::base::{count, indicators, less_location};

/// Odds of 20 to 1, as 2 ln B.
const CLEAR: f64 = 6.0;

/// Variances of a step in units of the noise; at the largest the noise is nothing.
const STEPS: [f64; 12] = [
    0.0, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 10.0, 100.0,
];

/// Larger deviations, in standard deviations, count as this: a wrong reading tells nothing about the order.
const MOST_DEVIATIONS: f64 = 4.0;

/// Standard deviation of normal deviations in units of their median amount.
const OF_MEDIAN: f64 = 1.4826;

/// Positions and sides considered; more tell nothing else.
const MOST_CELLS: usize = 100;

/// Degrees of freedom below which nothing is told.
const LEAST_DEGREES_OF_FREEDOM: usize = 8;

/// What the readings say about two orders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tells {
    /// They are measured as they are listed.
    Listed,
    /// They are measured in the other order.
    Other,
    /// Neither is clearly more likely.
    Neither,
}

/// Judges the order in which `values` are listed against another one, given by their places. `cells` numbers positions
/// and sides.
pub(crate) fn tells(values: &[f64], cells: &[usize], cycles: &[u32], other: &[usize]) -> Tells {
    let deviations = deviations(values, cells);
    let listed: Vec<usize> = (0..values.len()).collect();
    let deviance = |order: &[usize]| {
        let order = order.iter().copied();
        let rows: Vec<usize> = order.filter(|&row| cells[row] < MOST_CELLS).collect();
        let of_cells: Vec<usize> = rows.iter().map(|&row| cells[row]).collect();
        let p = count(&of_cells) + 1;
        let freedom = rows.len().checked_sub(p + LEAST_DEGREES_OF_FREEDOM)?;
        let mut columns = indicators(&of_cells);
        columns.push(rows.iter().map(|&row| f64::from(cycles[row])).collect());
        columns.push(rows.iter().map(|&row| deviations[row]).collect());
        let freedom = (freedom + LEAST_DEGREES_OF_FREEDOM) as f64;
        let deviances = STEPS.iter().map(|&step| of_step(&columns, step, freedom));
        deviances.reduce(f64::min)
    };
    let Some((as_listed, as_other)) = deviance(&listed).zip(deviance(other)) else {
        return Tells::Neither;
    };
    match as_other - as_listed {
        two_ln_b if two_ln_b > CLEAR => Tells::Listed,
        two_ln_b if two_ln_b < -CLEAR => Tells::Other,
        _ => Tells::Neither,
    }
}

/// Values less the median of their cell, the largest cut.
fn deviations(values: &[f64], cells: &[usize]) -> Vec<f64> {
    let mut deviations = values.to_vec();
    less_location(&mut deviations, cells, |own| median(own).unwrap_or(0.0));
    let mut amounts: Vec<f64> = deviations.iter().map(|x| x.abs()).collect();
    let most = MOST_DEVIATIONS * OF_MEDIAN * median(&mut amounts).unwrap_or(0.0);
    if most > 0.0 {
        for x in &mut deviations {
            *x = x.clamp(-most, most);
        }
    }
    deviations
}

/// `-2 ln L` of the last column beside the others, in their order, for this variance of a step.
fn of_step(columns: &[Vec<f64>], step: f64, freedom: f64) -> f64 {
    let rows = columns[0].len();
    // Share of an innovation that the walk keeps, and its standard deviation (Kalman's filter); it begins at the mean.
    let mut variance = 0.0;
    let filter: Vec<[f64; 2]> = (0..rows)
        .map(|_| {
            let of_innovation: f64 = variance + 1.0;
            let kept = variance / of_innovation;
            variance = variance * (1.0 - kept) + step;
            [kept, of_innovation.sqrt()]
        })
        .collect();
    let whiten = |column: &Vec<f64>| -> Vec<f64> {
        let mut expected = 0.0;
        let rows = column.iter().zip(&filter);
        rows.map(|(x, [kept, sigma])| {
            let innovation = x - expected;
            expected += kept * innovation;
            innovation / sigma
        })
        .collect()
    };
    let columns: Vec<Vec<f64>> = columns.iter().map(whiten).collect();
    let lengths = lengths_beside_earlier(&columns);
    let ln = |length: &f64| 2.0 * length.max(f64::MIN_POSITIVE).ln();
    let (left, of_model) = lengths.split_last().unwrap_or((&0.0, &[]));
    let ln_determinant: f64 = filter.iter().map(|[_, sigma]| ln(sigma)).sum();
    freedom * ln(left) + ln_determinant + of_model.iter().map(ln).sum::<f64>()
}
