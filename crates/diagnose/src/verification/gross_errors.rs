//! Readings that contradict all others, as a slip of the pen does.
//!
//! Against the model that leaves nothing but scatter (each position and side has a mean, each pass an offset,
//! [`scatter`]) every arrival is tested with the residual of the others,
//!
//! ```text
//! t = e/(s √r)      s² = (S - e²/r)/(ν - 1)      r = diagonal of M
//! ```
//!
//! one at a time, the largest first (externally studentised residual; Cook and Weisberg 1982). What stands beside
//! another one in time, or is more than a few, is no slip but structure, and stays.

use trueaxis_campaign::Verification;
use trueaxis_leastsquares::student_two_sided;

use crate::Rejected;
use crate::selection::Projection;
use crate::verification::comparison::Comparison;
use crate::verification::noise_floor::scatter;
use crate::verification::resolution::resolution_um;

/// Probability of leaving out anything of readings that are in order, for each file.
const LEVEL: f64 = 1e-4;

/// Part of the arrivals that may be slips, and at least one.
const MOST: f64 = 0.03;

/// The readings of a table that are gross errors: their indices, and what is said of them.
pub(crate) fn gross_errors(
    verification: &Verification,
    comparison: &Comparison<'_>,
) -> Vec<(usize, Rejected)> {
    let Some(mut left) = scatter(comparison) else {
        return Vec::new();
    };
    let count = comparison.arrivals.len();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count"
    )]
    let most = ((MOST * count as f64) as usize).max(1);
    let mut found: Vec<(usize, f64, f64)> = Vec::new();
    let resolution_um = resolution_um(comparison).unwrap_or_default();
    while let Some((arrival, error, u)) = largest(&left, count, resolution_um) {
        found.push((arrival, error, u));
        if found.len() > most {
            return Vec::new();
        }
        let mut own = vec![0.0; left.rows()];
        own[arrival] = 1.0;
        left = left.extended(&[own]);
    }
    let stands_alone = |arrival: usize| {
        let beside = |other: usize| other.abs_diff(arrival) == 1;
        comparison.arrivals[arrival].readings == 1 && !found.iter().any(|f| beside(f.0))
    };
    let mut first = 0;
    let rows: Vec<usize> = comparison
        .arrivals
        .iter()
        .map(|arrival| {
            let row = first;
            first += arrival.readings;
            row
        })
        .collect();
    let alone = found.iter().filter(|f| stands_alone(f.0));
    let said = alone.map(|&(arrival, error_um, u_um)| {
        let row = rows[arrival];
        let rejected = Rejected {
            file: verification.name.clone(),
            row: verification.readings[row].line,
            error_um,
            u_um,
            reason: "contradicts all other readings: a slip of the pen, or read too early"
                .to_owned(),
        };
        (row, rejected)
    });
    let mut all: Vec<(usize, Rejected)> = said.collect();
    all.sort_by_key(|(row, _)| *row);
    all
}

/// The arrival that stands out most, if noise has none like it: error and its standard uncertainty, µm.
fn largest(left: &Projection, count: usize, resolution_um: f64) -> Option<(usize, f64, f64)> {
    let (squares, freedom) = (left.squares(), left.degrees_of_freedom - 1.0);
    if freedom < LEAST_DEGREES_OF_FREEDOM {
        return None;
    }
    let tested = (0..count).filter_map(|row| {
        let taken: f64 = left.shared_row(row).iter().map(|x| x * x).sum();
        let redundancy = 1.0 - taken;
        // What the model takes as it is cannot be tested.
        if redundancy < LEAST_REDUNDANCY {
            return None;
        }
        let e = left.residuals[row];
        let rest = (squares - e * e / redundancy).max(0.0);
        let u = ((rest / freedom).sqrt().max(resolution_um)) / redundancy.sqrt();
        Some((row, e / redundancy, u))
    });
    let mut tested: Vec<(usize, f64, f64)> = tested.collect();
    let t = |row: &(usize, f64, f64)| (row.1 / row.2).abs();
    tested.sort_by(|a, b| t(b).total_cmp(&t(a)));
    let first = tested.first()?;
    // Two that explain it alike: which of them is wrong cannot be told.
    let is_alone = tested
        .get(1)
        .is_none_or(|second| t(second) < ALIKE * t(first));
    let limit = student_two_sided(LEVEL / count as f64, freedom);
    (is_alone && t(first) > limit).then_some(*first)
}

/// With fewer, Student's limit is beyond anything.
const LEAST_DEGREES_OF_FREEDOM: f64 = 5.0;

const ALIKE: f64 = 0.9;

const LEAST_REDUNDANCY: f64 = 1e-6;
