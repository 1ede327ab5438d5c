//! The misfit of the points without a cause, and what the cause explains of it.

use nalgebra::Vector3;
use trueaxis_kinematics::MICROMETRE;

use crate::Error;
use crate::engine::{Measured, Suspect};
use crate::fitted::{Fitted, Row};
use crate::points::base::Base;
use crate::points::model::Model;

/// The figure for the coordinates of one target in the reference frame.
pub(crate) fn fitted(
    base: &Base<'_>,
    model: &Model,
    suspect: &Suspect,
) -> Result<Option<Fitted>, Error> {
    let others = model.suspects.iter();
    let others = others.filter(|s| !s.hypothesis.is(&suspect.hypothesis));
    let without = base.adjust_near(model, others.cloned().collect())?;
    let in_mm = |model: &Model| {
        let mut residuals = model.projection.residuals.clone();
        model.colour(base, &mut residuals);
        residuals
    };
    let (misfits_mm, left_mm) = (in_mm(&without), in_mm(model));
    let rows = base
        .readings
        .all
        .iter()
        .enumerate()
        .flat_map(|(i, reading)| {
            let reference_from_rows = base.reference_from_rows(i);
            let in_um = |all_mm: &[f64]| {
                let of_point = Vector3::from_column_slice(&all_mm[3 * i..3 * i + 3]);
                reference_from_rows * of_point / MICROMETRE
            };
            let (misfit, left) = (in_um(&misfits_mm), in_um(&left_mm));
            let own = Vector3::from(model.noise.own_variances_mm2(reading));
            let own = reference_from_rows.component_mul(&reference_from_rows) * own;
            let squares = own + Vector3::from(model.noise.return_variances_mm2(reading));
            let positions = &base.campaign.steps[reading.step].positions;
            let moving = reading.axis.map(|axis| (axis, positions[axis]));
            (0..3).map(move |k| Row {
                group: 3 * reading.target + k,
                time_s: reading.time_s,
                moving: moving.into_iter().collect(),
                direction: reading.side,
                misfit: misfit[k],
                fitted: misfit[k] - left[k],
                u: squares[k].sqrt() / MICROMETRE,
            })
        });
    let rows: Vec<Row> = rows.collect();
    let name = |group: usize| {
        let target = &base.scene.targets[group / 3].name;
        format!("{} of target {target}", ["x", "y", "z"][group % 3])
    };
    Ok(Fitted::new(&rows, 3, name, base.scene))
}
