//! The misfit of the lengths without a cause, and what the cause explains of it.

use trueaxis_poses::LengthCircumstances;

use crate::engine::Suspect;
use crate::fitted::{Fitted, Row};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::noise_floor::mean_noise_um;

/// The figure for one station and target: `rest` is what all causes and disturbances leave, `current` the model with
/// all causes. The other causes keep the values fitted together with this one.
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
    let noise_um = mean_noise_um(base, current);
    let row = |(i, reading): (usize, &LengthCircumstances)| {
        let LengthCircumstances {
            time_s,
            station,
            target,
            axis,
            direction,
            step,
            ..
        } = reading;
        let explained_mm = without.solution.residuals_mm[i] - current.solution.residuals_mm[i];
        let fitted = 1e3 * explained_mm;
        Row {
            group: station * targets + target,
            time_s: *time_s,
            moving: vec![(*axis, base.campaign.steps[*step].positions[*axis])],
            direction: f64::from(direction.sign()),
            misfit: 1e3 * rest.solution.residuals_mm[i] + fitted,
            fitted,
            u: noise_um,
        }
    };
    let rows: Vec<Row> = base.readings.iter().enumerate().map(row).collect();
    let name = |group: usize| {
        let [station, target] = [group / targets, group % targets];
        let target = &base.scene.targets[target].name;
        format!("lengths from {} to {target}", base.scene.stations[station])
    };
    Fitted::new(&rows, name, &base.scene)
}
