//! Least squares where the rows are not linear in the unknowns.
//!
//! Levenberg–Marquardt steps on the true sum of squares ([`super::trust_region`]) lead to the
//! neighbourhood of a stationary point. There the decrease of the sum of squares drowns in
//! rounding long before the unknowns are exact, so the measure is the *offset*: the length of that
//! part of the residuals which a change of the unknowns could still remove. It is zero at a
//! stationary point and does not depend on the scale of the unknowns; nor does it shrink only
//! because unknowns run away to infinity and the sum of squares becomes flat, as its decrease and
//! its gradient do. (D. M. Bates, D. G. Watts, A relative offset orthogonality convergence
//! criterion for nonlinear least squares, Technometrics 23, 1981.) The last steps are Newton's
//! ([`super::curvature`]), whose second derivatives tell a minimum from a saddle.

use nalgebra::DMatrix;

use super::curvature::Newton;
use super::linearised::{Linearised, RANK_TOL, norm, squares};
use super::model::Model;
use super::termination::Termination;
use super::trust_region::TrustRegion;
use crate::Error;

/// Converged when Newton's step changes the residuals by less than this fraction of their norm (or by less than their
/// rounding); it is taken still. No unknown then moves by more than this fraction, times the root of the degrees of
/// freedom, of its standard deviation.
const OFFSET_TOL: f64 = 1e-8;

/// Adjusted unknowns with the evidence.
#[derive(Debug, Clone)]
pub struct Adjusted {
    /// The unknowns.
    pub unknowns: Vec<f64>,
    /// The residuals there.
    pub residuals: Vec<f64>,
    /// Their sum of squares.
    pub squares: f64,
    /// Covariance of the unknowns for unit variance of the residuals, `(JᵀJ)⁻¹`; none if the
    /// Jacobian leaves a combination of the unknowns free.
    pub covariance: Option<DMatrix<f64>>,
    /// Singular values of the Jacobian with unit columns, largest first.
    pub singular_values: Vec<f64>,
    /// Steps taken before the last.
    pub iterations: usize,
    /// Why it stopped. A result that is not converged is returned, not hidden.
    pub termination: Termination,
}

/// Newton's steps start at an offset below this fraction of the residuals: near enough for their
/// quadratic convergence, and the sum of squares can still guide until there.
const NEAR: f64 = 1e-3;

/// Newton's steps that do not shrink to this fraction from one to the next do not converge, or
/// have come down to rounding.
const SLOW: f64 = 0.5;

/// Minimises the sum of squares of the residuals of `model` from `start`.
///
/// Finds a local minimum in `max_iterations` steps at most (narrow curved valleys take hundreds); which one depends on
/// the start. Where a model is not finite, or the sum of its squares is not, steps turn back. A step needs the residuals
/// and the Jacobian once; the last few, which are Newton's, need one more Jacobian for each unknown.
///
/// ```
/// use nalgebra::DMatrix;
/// use trueaxis_leastsquares::dense::{Model, adjust};
///
/// /// Warm-up `a (1 - exp(-t/T))` of a spindle, measured in µm after some minutes.
/// struct WarmUp(Vec<(f64, f64)>);
///
/// impl Model for WarmUp {
///     fn residuals(&self, x: &[f64]) -> Vec<f64> {
///         let residual = |&(t, y): &(f64, f64)| x[0] * (1.0 - (-t / x[1]).exp()) - y;
///         self.0.iter().map(residual).collect()
///     }
///
///     fn jacobian(&self, x: &[f64]) -> DMatrix<f64> {
///         DMatrix::from_fn(self.0.len(), 2, |i, j| {
///             let t = self.0[i].0;
///             let rest = (-t / x[1]).exp();
///             [1.0 - rest, -x[0] * rest * t / (x[1] * x[1])][j]
///         })
///     }
/// }
///
/// let readings = vec![(10.0, 8.1), (20.0, 13.0), (40.0, 17.2), (80.0, 19.8)];
/// let adjusted = adjust(&WarmUp(readings), &[10.0, 10.0], 100)?;
/// assert!(adjusted.termination.is_converged(), "{:?}", adjusted.termination);
/// assert!((adjusted.unknowns[1] - 19.4).abs() < 0.1, "{:?}", adjusted.unknowns);
/// # Ok::<(), trueaxis_leastsquares::Error>(())
/// ```
///
/// # Errors
/// [`Error::NotFinite`] at the start, [`Error::Decomposition`]. Not converging is no error; see
/// [`Adjusted::termination`].
///
/// # Panics
/// If there is no unknown, or the Jacobian does not have a row for each residual and a column for
/// each unknown.
pub fn adjust(model: &dyn Model, start: &[f64], max_iterations: usize) -> Result<Adjusted, Error> {
    assert!(!start.is_empty(), "at least one unknown");
    let residuals = model.residuals(start);
    let mut here = Linearised::at(model, start.to_vec(), residuals)?.ok_or(Error::NotFinite {
        what: "the model at the start",
    })?;
    let mut region = TrustRegion::around(&here);
    let mut last_offset = f64::INFINITY;
    let mut iterations = 0;
    let termination = loop {
        let size = norm(&here.residuals);
        let tolerance = (OFFSET_TOL * size).max(here.rounding);
        let stationary = here.offset() <= tolerance;
        let near = stationary || here.offset() <= NEAR * size;
        let newton = if near && here.has_full_rank() {
            Some(Newton::at(model, &here)?)
        } else {
            None
        };
        if stationary && let Some(reason) = no_minimum(&here, newton.as_ref()) {
            break reason;
        }

        // Newton's step, as long as these steps lead to a minimum and shrink; else downhill.
        let newton = newton.filter(Newton::leads_to_a_minimum);
        let offset = newton.as_ref().map_or(here.offset(), |step| step.offset);
        let mut next = None;
        if let Some(newton) = newton {
            let shrinking = offset <= SLOW * last_offset;
            last_offset = offset;
            if shrinking || offset <= tolerance {
                next = newton_step(model, &here, &newton)?;
            } else if offset * offset <= here.decrease_rounding() {
                break Termination::Stalled { offset, tolerance };
            }
            if offset <= tolerance {
                here = next.unwrap_or(here);
                break Termination::Converged { offset, tolerance };
            }
        }
        if iterations == max_iterations {
            break Termination::MaxIterations { offset, tolerance };
        }
        iterations += 1;
        if next.is_none() {
            next = region.descend(model, &here)?;
        }
        let Some(next) = next else {
            break Termination::Stalled { offset, tolerance };
        };
        here = next;
    };
    Ok(Adjusted {
        squares: squares(&here.residuals),
        covariance: here.has_full_rank().then(|| here.svd.covariance()),
        singular_values: here.svd.singular_values().to_vec(),
        unknowns: here.unknowns,
        residuals: here.residuals,
        iterations,
        termination,
    })
}

/// Why a stationary point is no minimum, if so.
fn no_minimum(here: &Linearised, newton: Option<&Newton>) -> Option<Termination> {
    match newton {
        None => Some(Termination::RankDefect {
            rank: here.rank,
            unknowns: here.unknowns.len(),
            singular_value: here.svd.least_singular_value(),
            limit: RANK_TOL,
            free: here.svd.free_shares(here.rank),
        }),
        Some(newton) if !newton.leads_to_a_minimum() => Some(Termination::NoMinimum {
            curvature: newton.curvature,
        }),
        Some(_) => None,
    }
}

/// The point after Newton's step unless it raises the sum of squares by more than rounding.
fn newton_step(
    model: &dyn Model,
    here: &Linearised,
    newton: &Newton,
) -> Result<Option<Linearised>, Error> {
    let unknowns = here.moved(&newton.step);
    let residuals = model.residuals(&unknowns);
    if here.decrease(&residuals) >= -here.decrease_rounding() {
        Linearised::at(model, unknowns, residuals)
    } else {
        Ok(None)
    }
}
