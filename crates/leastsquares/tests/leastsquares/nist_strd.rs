//! NIST's 27 nonlinear regression sets, each from both starts, with one setting for all.
//!
//! Digits are `-log10(|q - c| / |c|)` of the worst unknown against the certified values, which have
//! eleven, so eleven is the most. (Ceres reports 9.4 in the mean for itself, and 4.4 for MINPACK.)

use nalgebra::DMatrix;
use trueaxis_leastsquares::dense::{Adjusted, Model, adjust};

use crate::strd_file::Set;
use crate::strd_models::{MODELS, Regression};

/// Digits of the certified values.
const CERTIFIED_DIGITS: f64 = 11.0;

/// Half a unit of the eleventh digit, relative to a number that begins with 1.0.
const CERTIFIED_ROUNDING: f64 = 5e-11;

/// Digits that agree with the certified values, of the worst value.
pub(crate) fn digits(values: &[f64], certified: &[f64]) -> f64 {
    assert!(values.iter().all(|q| q.is_finite()), "{values:?}");
    let pairs = values.iter().zip(certified);
    pairs
        .map(|(q, c)| -((q - c).abs() / c.abs()).log10())
        .fold(CERTIFIED_DIGITS, f64::min)
}

pub(crate) fn regressions() -> Vec<Regression> {
    let read = |&(name, function)| Regression {
        set: Set::read(name),
        function,
    };
    MODELS.iter().map(read).collect()
}

#[test]
fn converges_in_52_of_54_runs_and_never_to_a_wrong_answer() {
    let (mut runs, mut good, mut sum) = (0, 0, 0.0);
    println!("set       start  digits  steps  termination");
    for regression in regressions() {
        let certified = &regression.set.certified;
        for (k, start) in regression.set.starts.iter().enumerate() {
            let adjusted = adjust(&regression, start, 2000).unwrap();
            let found = digits(&adjusted.unknowns, &certified.unknowns).max(0.0);
            println!(
                "{:9} {:5}  {found:6.1}  {:5}  {:?}",
                regression.set.name,
                k + 1,
                adjusted.iterations,
                adjusted.termination
            );
            runs += 1;
            sum += found;
            if adjusted.termination.is_converged() {
                // The certified values allow 10.3 and more.
                assert!(found > 10.0, "{}: wrong", regression.set.name);
                check_spread(&regression, &adjusted);
                good += 1;
            }
        }
    }
    let mean = sum / f64::from(runs);
    println!("{good} of {runs} runs converged to ten digits or more, {mean:.2} in the mean");
    assert_eq!(runs, 54);
    assert!(good >= 52 && mean >= 9.4);
}

/// Residual sum of squares and standard deviations to all certified digits, as far as the
/// responses have them: rounded to f64, they change the norm of the residuals by up to
/// `ρ = ε |y|`, the sum of squares by the fraction `2 ρ/|r|`. That is 0.005 for Lanczos1, whose
/// residuals of 1e-13 are the rounding of its responses to 13 digits, 4e-10 for Lanczos2, and
/// below 2e-11 for the others.
fn check_spread(regression: &Regression, adjusted: &Adjusted) {
    let Set {
        name,
        rows,
        certified,
        ..
    } = &regression.set;
    let responses: f64 = rows.iter().map(|row| row.response.powi(2)).sum();
    let rounding = f64::EPSILON * (responses / certified.squares).sqrt();
    let limit = -(CERTIFIED_ROUNDING + 2.0 * rounding).log10();
    let squares = digits(&[adjusted.squares], &[certified.squares]);
    assert!(squares > limit, "{name}: sum of squares, {squares} digits");
    let degrees_of_freedom = adjusted.residuals.len() - adjusted.unknowns.len();
    let variance = adjusted.squares / degrees_of_freedom as f64;
    let variances = adjusted.covariance.as_ref().unwrap().diagonal() * variance;
    let deviations = digits(variances.map(f64::sqrt).as_slice(), &certified.deviations);
    assert!(
        deviations > limit,
        "{name}: deviations, {deviations} digits"
    );
}

/// Central differences over steps of `H` of each unknown: truncation and rounding are 1e-8 of the
/// column at most.
#[test]
fn derivatives_are_those_of_the_models() {
    const H: f64 = 1e-6;
    for regression in regressions() {
        let set = &regression.set;
        for unknowns in [&set.starts[1], &set.certified.unknowns] {
            let jacobian: DMatrix<f64> = regression.jacobian(unknowns);
            for j in 0..unknowns.len() {
                let [ahead, behind] = [H, -H].map(|h| {
                    let mut unknowns = unknowns.clone();
                    unknowns[j] *= 1.0 + h;
                    regression.residuals(&unknowns)
                });
                let step = 2.0 * H * unknowns[j];
                let differences =
                    DMatrix::from_fn(ahead.len(), 1, |i, _| (ahead[i] - behind[i]) / step);
                let column = jacobian.column(j);
                let error = (differences.column(0) - column).norm() / column.norm();
                assert!(error < 1e-7, "{}: b{}, {error:.1e}", set.name, j + 1);
            }
        }
    }
}
