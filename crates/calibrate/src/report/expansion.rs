//! Linear axes at 20 °C (ISO 1): their thermal expansion is taken out of the positioning errors.
//!
//! At the temperature T an axis with the expansion coefficient α travels longer by `α (T - 20 °C) q`. With the
//! temperature T at which all lengths hold ([`trueaxis_poses::at_one_temperature`]),
//!
//! ```text
//! E(20 °C) = E - α (T - 20 °C) q d     u² grows by (α q u(T) d)²     d: direction of the axis
//! ```
//!
//! u(T) is one error of the thermometer, common to the axis. The declared α counts as exact.

use nalgebra::Vector3;
use trueaxis_campaign::{AxisExpansion, Campaign, Lengths, LoggedQuantity};
use trueaxis_kinematics::{AxisKind, Machine};

use crate::result::calibration::{AxisResult, Calibration};
use trueaxis_predict::Output;

/// The reference temperature of ISO 1, °C.
const REFERENCE_C: f64 = 20.0;

/// Distance from the reference temperature that few workshops exceed, K.
const FAR_K: f64 = 15.0;

/// µm per m.
const PPM: f64 = 1e-6;

/// Refers the axes that declare their expansion to 20 °C, and gives a notice of the temperature of the others.
pub(crate) fn refer_to_20_degrees(campaign: &Campaign, calibration: &mut Calibration) {
    let Some(lengths) = &campaign.lengths else {
        return;
    };
    let mut notices = Vec::new();
    for k in 0..calibration.axes.len() {
        let axis = calibration.axes[k].axis;
        let expansion = campaign.expansions.iter().find(|e| e.axis == axis);
        let Some(expansion) = expansion else { continue };
        let name = &calibration.axes[k].name;
        match (expansion.lengths_hold_at_c, is_logged(lengths, expansion)) {
            (Some(at_c), _) => {
                let since_k = at_c - REFERENCE_C;
                notices.extend((since_k.abs() > FAR_K).then(|| {
                    format!(
                        "axis {name}: at {at_c:.1} °C by `{}`, and {:+.0} ppm were taken out for that: see whether the column is in °C, \
                         and filled",
                        expansion.temperature_column,
                        expansion.ppm_per_k * since_k
                    )
                }));
                refer(campaign, calibration, k, expansion);
            }
            (None, true) => notices.push(format!(
                "axis {name}: its lengths could not be corrected for their temperatures, so its errors are not referred to 20 °C"
            )),
            (None, false) => notices.push(format!(
                "axis {name}: `{}` has no value in its rows, so its errors are not referred to 20 °C",
                expansion.temperature_column
            )),
        }
    }
    notices.extend(scale_holds_at(campaign, lengths, &calibration.axes));
    calibration.notices.extend(notices);
}

fn is_logged(lengths: &Lengths, expansion: &AxisExpansion) -> bool {
    let column = lengths.logged_column(&expansion.temperature_column);
    column.is_some_and(|column| column.values.iter().any(Option::is_some))
}

/// Expansion of an axis from 20 °C to the temperature at which its lengths hold, for each mm of its position; zero
/// where the axis is not referred to 20 °C.
pub(crate) fn since_20_degrees(campaign: &Campaign, axis: usize) -> Vector3<f64> {
    let own = campaign.expansions.iter().find(|e| e.axis == axis);
    let since = own.and_then(|own| {
        let since_k = own.lengths_hold_at_c? - REFERENCE_C;
        Some(per_k(&campaign.machine, own) * since_k)
    });
    since.unwrap_or_else(Vector3::zeros)
}

fn per_k(machine: &Machine, expansion: &AxisExpansion) -> Vector3<f64> {
    let direction = machine.axes()[expansion.axis].direction().into_inner();
    direction * (expansion.ppm_per_k * PPM)
}

fn refer(campaign: &Campaign, calibration: &mut Calibration, k: usize, expansion: &AxisExpansion) {
    let machine = &campaign.machine;
    let longer = since_20_degrees(campaign, expansion.axis);
    let axis = &mut calibration.axes[k];
    for node in &mut axis.nodes {
        node.error.translation_mm -= longer * node.position;
    }
    let Some(sigma_k) = expansion.temperature_sigma_k else {
        return;
    };
    let name = axis.name.clone();
    let per_k = per_k(machine, expansion);
    let change = |output: &Output| match output {
        Output::ComponentError {
            axis,
            component,
            position,
            ..
        } if *axis == name && !component.is_angular() => {
            per_k[component.index()] * position * sigma_k
        }
        _ => 0.0,
    };
    let results = calibration.results();
    let defined = results.iter().filter(|result| result.u > 0.0);
    let changes: Vec<f64> = defined.map(|result| change(&result.output)).collect();
    calibration.add_uncertainty(machine, &changes, |budget| &mut budget.systematic);
}

/// The temperature at which the scale of linear axes without a declared expansion holds, if one was logged.
fn scale_holds_at(campaign: &Campaign, lengths: &Lengths, axes: &[AxisResult]) -> Option<String> {
    let declared = |axis: &AxisResult| campaign.expansions.iter().any(|e| e.axis == axis.axis);
    let open = axes
        .iter()
        .filter(|axis| axis.kind == AxisKind::Linear && !declared(axis));
    let open: Vec<&str> = open.map(|axis| axis.name.as_str()).collect();
    let machine = |quantity| {
        lengths
            .logged
            .iter()
            .find(|c| c.quantity() == Some(quantity))
    };
    let column = machine(LoggedQuantity::MachineTemperature)
        .or_else(|| machine(LoggedQuantity::AirTemperature))?;
    let values: Vec<f64> = column.values.iter().flatten().copied().collect();
    if open.is_empty() || values.is_empty() {
        return None;
    }
    let mean_c = values.iter().sum::<f64>() / values.len() as f64;
    Some(format!(
        "the scale of {} holds at {mean_c:.1} °C (mean of {}), not at 20 °C: declare `expansion_ppm_per_k` of the \
         axis to refer it",
        open.join(", "),
        column.name
    ))
}
