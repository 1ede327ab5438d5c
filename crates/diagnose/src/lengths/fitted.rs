//! The misfit of the lengths without a cause, and what the cause explains of it.

use trueaxis_leastsquares::dot;
use trueaxis_multilateration::Whitened;
use trueaxis_poses::LengthCircumstances;

use crate::engine::Suspect;
use crate::fitted::{Fitted, Row, most_shown};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::noise_floor::mean_noise_um;

/// The figure for one station and target: `rest` is what all causes and disturbances leave, `current` the model with
/// all causes. The other causes keep the values fitted together with this one. Repeatability moves all targets of a
/// visit together; an effect that does not shows in a length less what the others predict of it.
pub(crate) fn fitted(
    base: &Base<'_>,
    rest: &Adjusted,
    current: &Adjusted,
    suspect: &Suspect,
) -> Option<Fitted> {
    let suspects = current.suspects.iter();
    let others = suspects.filter(|s| !s.is(suspect));
    let others: Vec<Suspect> = others.cloned().collect();
    let without = base.adjust_given(others, current.network.noise).ok()?;
    let targets = base.scene.targets.len();
    let [without, with] = [&without, current].map(|model| model.solution.residuals_mm.iter());
    let fitted_mm: Vec<f64> = without.zip(with).map(|(a, b)| a - b).collect();
    let rest_mm = &rest.solution.residuals_mm;
    let rows = |of_reading: &dyn Fn(usize) -> [f64; 3]| -> Vec<Row> {
        let row = |(i, reading): (usize, &LengthCircumstances)| {
            let [rest, fitted, u] = of_reading(i).map(|mm| 1e3 * mm);
            let (axis, step) = (reading.axis, &base.campaign.steps[reading.step]);
            Row {
                group: reading.station * targets + reading.target,
                time_s: reading.time_s,
                moving: vec![(axis, step.positions[axis])],
                direction: reading.sign(),
                misfit: rest + fitted,
                fitted,
                u,
            }
        };
        base.readings.iter().enumerate().map(row).collect()
    };
    let noise_mm = 1e-3 * mean_noise_um(base, current);
    let alone = rows(&|i| [rest_mm[i], fitted_mm[i], noise_mm]);
    let whitened = &current.whitened;
    let [rest_mm, fitted_mm] = [rest_mm, &fitted_mm].map(|all| given_others(whitened, all));
    let given = rows(&|i| [rest_mm[i].0, fitted_mm[i].0, rest_mm[i].1]);
    let is_given = most_shown(&given) > most_shown(&alone);
    let name = |group: usize| {
        let [station, target] = [group / targets, group % targets];
        let target = &base.scene.targets[target].name;
        let given = if is_given { " given the others" } else { "" };
        format!(
            "lengths from {} to {target}{given}",
            base.scene.stations[station]
        )
    };
    let rows = if is_given { &given } else { &alone };
    Fitted::new(rows, 1, name, &base.scene)
}

/// Each value less what the others of its visit predict of it, and the standard deviation of the difference by noise,
/// `(Σ⁻¹e)ᵢ / (Σ⁻¹)ᵢᵢ` and `(Σ⁻¹)ᵢᵢ^-½`.
fn given_others(whitened: &Whitened, values: &[f64]) -> Vec<(f64, f64)> {
    let mut rows = values.to_vec();
    whitened.whiten(&mut rows);
    let (mut given, mut unit) = (Vec::with_capacity(values.len()), Vec::new());
    for (visit, readings) in whitened.visits.iter().enumerate() {
        for reading in readings.clone() {
            whitened.unit_error(visit, reading, &mut unit);
            let weight = dot(&unit, &unit);
            given.push((
                dot(&unit, &rows[readings.clone()]) / weight,
                weight.sqrt().recip(),
            ));
        }
    }
    given
}
