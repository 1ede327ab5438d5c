//! Report of the disturbances while readings are taken, with units.

use trueaxis_effects::Level;
use trueaxis_selection::{Projection, combined};

use crate::engine::Posterior;
use crate::verification::form::Form;
use crate::verification::problem::Problem;
use crate::verification::report::rms_of_readings_um;
use crate::verification::wandering::FittedProcess;
use crate::{CorrelationLength, CurvePoint, Disturbance, Gain};

/// The disturbances of a problem that has them in its covariance; `after` has the causes in the model, too. `gain` if
/// nothing else gains.
pub(crate) fn wandered(
    problem: &Problem<'_>,
    courses: &[(&FittedProcess, Course)],
    after: &Projection,
    gain: Option<Gain>,
) -> Vec<Disturbance> {
    let noise_um = problem.noise_um(after);
    let report = |(own, course): &(&FittedProcess, Course)| {
        let comparison = problem.comparison;
        let (range, unit) = own.wanderer.range(comparison);
        let period = match own.form {
            Form::Smooth { .. } => None,
            Form::Swing(period) => Some(period),
        };
        Disturbance {
            level: Level::Verification,
            data: String::new(),
            whose: own.wanderer.whose(comparison),
            p_value: own.p_value,
            rms_um: rms_of_readings_um(problem, &course.whitened),
            share: 0.0,
            correlation_length: CorrelationLength {
                value: own.form.length() * (range[1] - range[0]),
                unit,
            },
            period: period.map(|period| period * (range[1] - range[0])),
            heldout_gain: gain.map(|gain| 1.0 - gain.heldout_rms_ratio),
            curve: curve(problem, own, &course.posterior, noise_um),
            rivals: own.rivals.iter().map(|w| w.whose(comparison)).collect(),
        }
    };
    courses.iter().map(report).collect()
}

/// A disturbance as the readings show it.
pub(crate) struct Course {
    posterior: Posterior,
    /// Its effect on the whitened readings.
    pub(crate) whitened: Vec<f64>,
}

impl Course {
    /// Of a disturbance in the covariance of a problem; `after` has the causes in the model, too.
    pub(crate) fn new(problem: &Problem<'_>, own: &FittedProcess, after: &Projection) -> Self {
        let columns = own.columns(problem);
        let posterior = Posterior::new(after, &columns);
        Self {
            whitened: combined(after.rows(), &columns, &posterior.mean),
            posterior,
        }
    }
}

/// Each coordinate over the range of the argument with its standard uncertainty, less its mean. `noise_um` is the
/// standard deviation of the noise that is left.
pub(crate) fn curve(
    problem: &Problem<'_>,
    own: &FittedProcess,
    posterior: &Posterior,
    noise_um: f64,
) -> Vec<CurvePoint> {
    let roots = own.wanderer.roots(problem.comparison, own.form);
    let shown = own.wanderer.shown(problem.comparison, own.form).into_iter();
    let point = |(at, basis): (f64, Vec<f64>)| {
        let scaled = basis.iter().zip(&roots).map(|(b, r)| b * r * own.width);
        let row: Vec<f64> = scaled.collect();
        let of_coordinate = |first: usize| {
            let (value, variance) = posterior.of(first, &row);
            (
                value,
                noise_um / problem.whitening.sigma_um * variance.sqrt(),
            )
        };
        let coordinates = (0..posterior.mean.len()).step_by(row.len());
        let (value_um, u_um) = coordinates.map(of_coordinate).unzip();
        CurvePoint {
            at,
            position: None,
            value_um,
            u_um,
        }
    };
    shown.map(point).collect()
}
