//! The misfit of the points without a cause, and what the cause explains of it.

use crate::Error;
use crate::engine::{Measured, Suspect};
use crate::fitted::{Fitted, Row};
use crate::points::base::Base;
use crate::points::model::Model;

/// Of one coordinate of one target, weighted with the noise.
pub(crate) fn fitted(
    base: &Base<'_>,
    model: &Model,
    suspect: &Suspect,
) -> Result<Option<Fitted>, Error> {
    let others = model.suspects.iter();
    let others = others.filter(|s| !s.hypothesis.is(&suspect.hypothesis));
    let without = base.refit_near(model, others.cloned().collect())?;
    let noise_um = model.noise.mean_um(&base.readings);
    let residuals = without.projection.residuals.iter();
    let residuals = residuals.zip(&model.projection.residuals).enumerate();
    let row = |(i, (misfit, left)): (usize, (&f64, &f64))| {
        let reading = &base.readings.all[i / 3];
        let positions = &base.campaign.steps[reading.step].positions;
        let moving = reading.axis.map(|axis| (axis, positions[axis]));
        Row {
            group: 3 * reading.target + i % 3,
            time_s: reading.time_s,
            moving: moving.into_iter().collect(),
            direction: reading.side,
            misfit: noise_um * misfit,
            fitted: noise_um * (misfit - left),
        }
    };
    let rows: Vec<Row> = residuals.map(row).collect();
    let target = |group: usize| &base.scene.targets[group / 3].name;
    let name = |group: usize| format!("a coordinate of target {}", target(group));
    Ok(Fitted::new(&rows, name, base.scene))
}
