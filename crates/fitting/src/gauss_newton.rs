//! Gauss–Newton with step control on the true cost, run down to the rounding of f64.

use faer::Mat;
use trueaxis_leastsquares::dense;

use crate::Error;

/// A geometric fit that linearises itself. Its unknowns are scaled: a change of one is large.
pub(crate) trait Model: Sized {
    /// Residuals and their derivatives by the unknowns, here.
    fn linearise(&self) -> (Vec<f64>, Mat<f64>);

    /// The model with its unknowns changed by `step`.
    fn moved(&self, step: &[f64]) -> Self;

    /// How far rounding alone can change the norm of the residuals.
    fn rounding(&self) -> f64;
}

/// How an iterated fit came to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Steps taken.
    pub iterations: usize,
    /// Length of the last step: lengths relative to the spread of the points, angles in rad.
    pub last_step: f64,
    /// Why it stopped.
    pub termination: Termination,
}

/// Why an iterated fit stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Termination {
    /// The steps have come down to the rounding of f64: this is the minimum.
    Converged,
    /// No shorter step lowers the cost, and the step is longer than rounding explains.
    NoDecrease,
    /// The iterations were used up.
    MaxIterations,
}

/// A model at its minimum, with the evidence.
#[derive(Debug, Clone)]
pub(crate) struct Minimum<M> {
    pub(crate) model: M,
    /// Sum of squares of the residuals.
    pub(crate) squares: f64,
    /// Covariance of the unknowns for residuals of unit variance.
    pub(crate) cofactor: Mat<f64>,
    pub(crate) convergence: Convergence,
}

/// A step below this is lost in the rounding of the unknowns.
const STEP_TOL: f64 = f64::EPSILON;

/// Steps that shrink by less than this from one to the next, and change the residuals by no more
/// than their rounding, will not come to more.
const SLOW: f64 = 0.5;

/// Steps shrink by the ratio of residual to bend of the arc (on a full turn: to radius) or better:
/// four is usual, a target within its own noise of the axis needs fifty to a hundred.
const MAX_ITERATIONS: usize = 200;

/// Halvings of a step before giving up: 2⁻²⁰ of a step is no progress.
const MAX_HALVINGS: usize = 20;

/// Least singular value, relative to the largest, of a design with unit columns. Beyond the
/// square root of the rounding, the error of the linearisation is as large as the effect.
const MIN_SINGULAR_VALUE: f64 = 1.5e-8;

/// Minimises the sum of squares of the residuals of a model from a start near the minimum.
///
/// # Errors
/// [`Error::Undetermined`] if the points leave a combination of the unknowns free.
pub(crate) fn minimise<M: Model>(mut model: M) -> Result<Minimum<M>, Error> {
    let (mut residuals, mut jacobian) = model.linearise();
    let mut previous = f64::INFINITY;
    let mut iterations = 0;
    loop {
        let Step {
            unknowns,
            change,
            cofactor,
        } = newton_step(&residuals, &jacobian)?;
        let length = norm(&unknowns);
        iterations += 1;

        let next = descend(&model, &unknowns, norm(&residuals));
        let settled = change <= model.rounding() && length > SLOW * previous;
        let termination = match &next {
            _ if length <= STEP_TOL || settled => Some(Termination::Converged),
            None => Some(Termination::NoDecrease),
            Some(_) if iterations == MAX_ITERATIONS => Some(Termination::MaxIterations),
            Some(_) => None,
        };
        if let Some(next) = next {
            (model, residuals, jacobian) = next;
        }
        if let Some(termination) = termination {
            return Ok(Minimum {
                model,
                squares: norm(&residuals).powi(2),
                cofactor,
                convergence: Convergence {
                    iterations,
                    last_step: length,
                    termination,
                },
            });
        }
        previous = length;
    }
}

/// Sum of squared residuals and covariance of the unknowns of a model that is at its minimum.
///
/// # Errors
/// As [`minimise`].
pub(crate) fn cofactor(model: &impl Model) -> Result<(f64, Mat<f64>), Error> {
    let (residuals, jacobian) = model.linearise();
    let step = newton_step(&residuals, &jacobian)?;
    Ok((norm(&residuals).powi(2), step.cofactor))
}

/// What the linear model asks for.
struct Step {
    /// Change of the unknowns, `-J⁺ r`.
    unknowns: Vec<f64>,
    /// Length of the change of the residuals that goes with it.
    change: f64,
    /// `(JᵀJ)⁻¹`.
    cofactor: Mat<f64>,
}

fn newton_step(residuals: &[f64], jacobian: &Mat<f64>) -> Result<Step, Error> {
    let undetermined = |singular_value| Error::Undetermined {
        singular_value,
        limit: MIN_SINGULAR_VALUE,
    };
    let downhill: Vec<f64> = residuals.iter().map(|r| -r).collect();
    let fit = dense::solve(jacobian.as_ref(), &downhill).map_err(|error| match error {
        trueaxis_leastsquares::Error::DenseRank { singular_value, .. } => {
            undetermined(singular_value)
        }
        _ => undetermined(f64::NAN),
    })?;
    let ends = (fit.singular_values.first(), fit.singular_values.last());
    if let (Some(largest), Some(least)) = ends
        && *least < MIN_SINGULAR_VALUE * largest
    {
        return Err(undetermined(least / largest));
    }
    let change: Vec<f64> = downhill
        .iter()
        .zip(&fit.residuals)
        .map(|(y, r)| y - r)
        .collect();
    Ok(Step {
        unknowns: fit.unknowns,
        change: norm(&change),
        cofactor: fit.covariance,
    })
}

/// The longest of the steps 1, 1/2, 1/4, … that does not raise the norm of the residuals, rounding
/// apart, with its linearisation.
fn descend<M: Model>(model: &M, step: &[f64], current: f64) -> Option<(M, Vec<f64>, Mat<f64>)> {
    let limit = current + model.rounding();
    let mut factor = 1.0;
    for _ in 0..=MAX_HALVINGS {
        let part: Vec<f64> = step.iter().map(|x| x * factor).collect();
        let candidate = model.moved(&part);
        let (residuals, jacobian) = candidate.linearise();
        // Residuals that are not finite fail this, too.
        if norm(&residuals) <= limit {
            return Some((candidate, residuals, jacobian));
        }
        factor *= 0.5;
    }
    None
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Largest difference between the Jacobian of a model and central differences of its residuals.
#[cfg(test)]
pub(crate) fn jacobian_error(model: &impl Model) -> f64 {
    /// Third derivatives are about one: truncation 1e-10 and rounding 1e-11 are balanced.
    const H: f64 = 1e-5;
    let (_, jacobian) = model.linearise();
    let mut worst = 0.0_f64;
    for k in 0..jacobian.ncols() {
        let [ahead, behind] = [H, -H].map(|h| {
            let mut step = vec![0.0; jacobian.ncols()];
            step[k] = h;
            model.moved(&step).linearise().0
        });
        for i in 0..jacobian.nrows() {
            let difference = (ahead[i] - behind[i]) / (2.0 * H);
            worst = worst.max((difference - jacobian[(i, k)]).abs());
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley, for which a full Gauss–Newton step from (-1.2, 1) raises the cost.
    struct Valley(f64, f64);

    impl Model for Valley {
        fn linearise(&self) -> (Vec<f64>, Mat<f64>) {
            let Self(x, y) = *self;
            let rows = [[-20.0 * x, 10.0], [-1.0, 0.0]];
            let jacobian = Mat::from_fn(2, 2, |i, k| rows[i][k]);
            (vec![10.0 * (y - x * x), 1.0 - x], jacobian)
        }

        fn moved(&self, step: &[f64]) -> Self {
            Self(self.0 + step[0], self.1 + step[1])
        }

        fn rounding(&self) -> f64 {
            10.0 * f64::EPSILON
        }
    }

    #[test]
    fn shortens_a_step_that_raises_the_cost() {
        let start = Valley(-1.2, 1.0);
        assert!(jacobian_error(&start) < 1e-8);
        let (residuals, jacobian) = start.linearise();
        let full = newton_step(&residuals, &jacobian).unwrap();
        let after = norm(&start.moved(&full.unknowns).linearise().0);
        assert!(after > norm(&residuals), "the test needs a bad step");

        let minimum = minimise(start).unwrap();
        assert_eq!(minimum.convergence.termination, Termination::Converged);
        assert!((minimum.model.0 - 1.0).abs() < 1e-15 && (minimum.model.1 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn refuses_a_direction_that_changes_nothing() {
        struct Flat;
        impl Model for Flat {
            fn linearise(&self) -> (Vec<f64>, Mat<f64>) {
                (vec![1.0; 3], Mat::from_fn(3, 2, |i, _| i as f64))
            }
            fn moved(&self, _: &[f64]) -> Self {
                Self
            }
            fn rounding(&self) -> f64 {
                0.0
            }
        }
        assert!(matches!(minimise(Flat), Err(Error::Undetermined { .. })));
    }
}
