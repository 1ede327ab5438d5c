//! The noise that points show, where none is declared or where they reject it.
//!
//! The rigid triangle shows the variance of unit weight, without what all targets of a visit share; the repeats show
//! the rest ([`crate::points::repeats`]). Each declared part holds until the points reject it, and is then replaced
//! alone: a wrong one says nothing about the other. Where each visit sees one target, the points show only the sum of
//! both parts, which get a common factor.

use nalgebra::Matrix2;
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_screening::{LEAST_DEGREES_OF_FREEDOM, LEAST_SEPARATION, TOO_GOOD};

use crate::points::MeasuredPoints;
use crate::report::GLOBAL_TEST_LEVEL;

/// Largest repeatability of a machine, mm, also relative to a micrometre of noise, beside which nothing else would
/// count: repeats that differ by more are mistakes, and multiply all uncertainties.
const MOST_REPEATABILITY_MM: f64 = 1.0;

/// What points show of their noise.
pub(crate) struct NoiseShown {
    /// Whether all variances, including that of the repeatability at its new weight, get a factor from the residuals.
    pub(crate) by_residuals: bool,
    /// Whether the points separate the instrument's noise from the repeatability.
    pub(crate) told_apart: bool,
    /// Variance of a coordinate by the repeatability in units of the variance of unit weight, mm², where it differs
    /// from that of the weights, and how well both variances are known ([`crate::Poses::relative_covariance`]).
    pub(crate) repeatability: Option<(f64, Matrix2<f64>)>,
    /// The p-value of the declared repeatability, where the repeats reject it.
    pub(crate) p_value: Option<f64>,
}

/// The noise of points whose rigid triangle leaves these squares with their degrees of freedom. The last argument
/// says whether the instrument's noise is declared, and the declared repeatability, mm.
pub(crate) fn noise_shown(
    points: &MeasuredPoints,
    (squares, degrees): (f64, usize),
    (sigma_declared, repeatability_mm): (bool, Option<f64>),
) -> NoiseShown {
    let told_apart = points.separation() >= LEAST_SEPARATION;
    let by_residuals = degrees > 0 && (!sigma_declared || is_rejected(squares, degrees));
    let degrees = degrees as f64;
    // The factor on all variances, at least of a nanometre.
    let unit = match by_residuals {
        true => (squares / degrees).max(1e-6),
        false => 1.0,
    };
    let relative_variance = if by_residuals { 2.0 / degrees } else { 0.0 };
    let by_repeats = || points.repeatability_by_repeats(unit, relative_variance);
    let is_one = |mm2: f64| mm2.max(mm2 / unit) < MOST_REPEATABILITY_MM.powi(2);
    let mut p_value = None;
    let variance = match repeatability_mm.map(|mm| mm * mm) {
        // Nothing separates the repeatability from the noise of the instrument.
        None if !sigma_declared && !by_residuals => None,
        None => by_repeats().filter(|(mm2, _)| is_one(*mm2)),
        Some(known_mm2) => {
            let rejected = || points.rejected_repeatability(known_mm2, unit, relative_variance);
            p_value = told_apart.then(rejected).flatten();
            let found = p_value.map(|_| by_repeats().unwrap_or((0.0, Matrix2::zeros())));
            let found = found.filter(|(mm2, _)| is_one(*mm2));
            if found.is_none() {
                p_value = None;
            }
            // A declared repeatability that holds is known; where repeats scatter by more, it grows with the rest.
            let is_kept = by_residuals && known_mm2 > 0.0 && (told_apart || !sigma_declared);
            found.or_else(|| is_kept.then(|| (known_mm2, Matrix2::zeros())))
        }
    };
    NoiseShown {
        by_residuals,
        told_apart,
        repeatability: variance.map(|(mm2, relative)| (mm2 / unit, relative)),
        p_value,
    }
}

/// Whether residuals reject the declared noise of the instrument: they are larger than it explains, or smaller, if
/// there are many and they are not those of a calculation.
fn is_rejected(squares: f64, degrees: usize) -> bool {
    let degrees = degrees as f64;
    let above = chi_squared_upper_tail(squares, degrees);
    let is_credible =
        degrees >= LEAST_DEGREES_OF_FREEDOM && squares > TOO_GOOD * TOO_GOOD * degrees;
    above < GLOBAL_TEST_LEVEL || (is_credible && above > 1.0 - GLOBAL_TEST_LEVEL)
}
