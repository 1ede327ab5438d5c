//! Report of the disturbances while readings are taken, with units.

use trueaxis_effects::Level;
use trueaxis_selection::Projection;

use crate::engine::{Coefficients, JudgedDisturbance};
use crate::numbers::squares;
use crate::verification::problem::Problem;
use crate::{CurvePoint, Disturbance, Gain};

/// A disturbance in the covariance of a problem; `after` has the causes in the model, too.
pub(crate) fn coefficients(
    problem: &Problem<'_>,
    own: &JudgedDisturbance,
    after: &Projection,
) -> Coefficients {
    Coefficients::new(after, &own.columns(problem), own.roots(problem), 1)
}

/// The disturbances of a problem that has them in its covariance: of each what it takes out of the misfit, without what
/// the base model, `before`, absorbs. `gain` if nothing else gains.
pub(crate) fn wandered(
    problem: &Problem<'_>,
    before: &Projection,
    all: &[(&JudgedDisturbance, Coefficients)],
    after: &Projection,
    gain: Option<Gain>,
) -> Vec<Disturbance> {
    let noise_um = problem.noise_um(after);
    let report = |(own, coefficients): &(&JudgedDisturbance, Coefficients)| {
        let seen = before.left_of(&coefficients.effect);
        // Weighted as the misfit is.
        let rms = (squares(&seen) / problem.readings() as f64).sqrt();
        let shown = (
            problem.whitening.sigma_um * rms,
            curve(problem, own, coefficients, noise_um),
        );
        let range = problem.course(own).range();
        own.reported((Level::Verification, None), range, shown, gain)
    };
    all.iter().map(report).collect()
}

/// Each coordinate over the range of the argument with its standard uncertainty, less its mean. `noise_um` is the
/// standard deviation of the noise that is left.
pub(crate) fn curve(
    problem: &Problem<'_>,
    own: &JudgedDisturbance,
    coefficients: &Coefficients,
    noise_um: f64,
) -> Vec<CurvePoint> {
    let noise = noise_um / problem.whitening.sigma_um;
    let shown = problem.course(own).shown(own.disturbance.form).into_iter();
    let point = |(at, functions): (f64, Vec<f64>)| {
        let coordinates = coefficients.coordinates(&functions);
        let (value_um, u) = coefficients.at(0, &functions, &coordinates);
        CurvePoint {
            at,
            position: None,
            value_um,
            u_um: u.iter().map(|u| noise * u).collect(),
        }
    };
    shown.map(point).collect()
}
