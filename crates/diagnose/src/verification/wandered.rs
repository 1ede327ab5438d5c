//! What wanders while readings are taken, in words and units.

use trueaxis_effects::Level;

use crate::engine::Posterior;
use crate::selection::Projection;
use crate::verification::problem::Problem;
use crate::verification::wanderer::Wanderer;
use crate::verification::wandering::Wandering;
use crate::{CorrelationLength, CurvePoint, Disturbance, Gain};

/// Points of a curve.
const POINTS: usize = 33;

/// The disturbances of a problem that has them in its covariance; `after` has the causes in the model, too. `gain` if
/// there is nothing else that gains.
pub(crate) fn wandered(
    problem: &Problem<'_>,
    wandering: &[Wandering],
    after: &Projection,
    gain: Option<Gain>,
) -> Vec<Disturbance> {
    let report = |own: &Wandering| {
        let comparison = problem.comparison;
        let columns = own.columns(problem);
        let posterior = Posterior::new(after, &columns);
        let mut sum = vec![0.0; problem.readings()];
        for (column, mean) in columns.iter().zip(&posterior.mean) {
            for (sum, x) in sum.iter_mut().zip(column) {
                *sum += mean * x;
            }
        }
        let squares: f64 = sum.iter().map(|x| x * x).sum();
        let (range, unit) = own.wanderer.range(comparison);
        Disturbance {
            level: Level::Verification,
            data: String::new(),
            whose: own.wanderer.whose(comparison),
            p_value: own.p_value,
            rms_um: problem.sigma_um * (squares / sum.len() as f64).sqrt(),
            share: 0.0,
            correlation_length: CorrelationLength {
                value: own.length * (range[1] - range[0]),
                unit,
            },
            heldout_gain: gain.map(|gain| 1.0 - gain.heldout_rms_ratio),
            curve: curve(problem, own, &posterior, problem.rms_um(after)),
            rivals: own.rivals.iter().map(|w| w.whose(comparison)).collect(),
        }
    };
    wandering.iter().map(report).collect()
}

/// Each coordinate over the range of the argument with its standard uncertainty, from its mean. `noise_um` is the standard deviation of the noise that is left.
fn curve(
    problem: &Problem<'_>,
    own: &Wandering,
    posterior: &Posterior,
    noise_um: f64,
) -> Vec<CurvePoint> {
    let roots = own.wanderer.roots(problem.comparison, own.length);
    let (range, _) = own.wanderer.range(problem.comparison);
    let point = |k: usize| {
        let x = k as f64 / (POINTS - 1) as f64;
        let basis = Wanderer::basis(x);
        let of_coordinate = |first: usize| {
            let scaled = basis.iter().zip(&roots).map(|(b, r)| b * r * own.width);
            let row: Vec<f64> = scaled.collect();
            let (value, variance) = posterior.of(first, &row);
            (value, noise_um / problem.sigma_um * variance.sqrt())
        };
        let (value_um, u_um) = (0..roots.len())
            .step_by(basis.len())
            .map(of_coordinate)
            .unzip();
        CurvePoint {
            at: range[0] + x * (range[1] - range[0]),
            value_um,
            u_um,
        }
    };
    (0..POINTS).map(point).collect()
}
