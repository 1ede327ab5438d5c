//! By how much a calibration changes when the causes join the model.

use trueaxis_calibrate::Calibration;
use trueaxis_kinematics::{ARCSEC, Component, LocationComponent, MICROMETRE};

use crate::Change;

/// Largest amounts by which component and location errors differ, in the order of the machine; the two
/// calibrations must be of the same campaign.
pub(crate) fn changes(before: &Calibration, after: &Calibration) -> Vec<Change> {
    let mut changes = Vec::new();
    for axis in &before.axes {
        let Some(other) = after.axis(&axis.name) else {
            continue;
        };
        for component in Component::ALL {
            let k = component.index();
            let value = |node: &trueaxis_calibrate::NodeResult| node.error.to_vector()[k];
            let largest = axis
                .nodes
                .iter()
                .zip(&other.nodes)
                .map(|(a, b)| (value(b) - value(a)).abs())
                .fold(0.0, f64::max);
            let (scale, unit) = if component.is_angular() {
                (ARCSEC, "arcsec")
            } else {
                (MICROMETRE, "um")
            };
            changes.push(Change {
                name: component.name(&axis.name),
                largest: largest / scale,
                unit,
            });
        }
        for location in &axis.location_errors {
            let name = location.component.name(&axis.name);
            let Some(changed) = other.location_error(&name) else {
                continue;
            };
            let (scale, unit) = match location.component {
                LocationComponent::Tilt(_) => (ARCSEC, "arcsec"),
                LocationComponent::Offset(_) => (1.0, "mm"),
            };
            changes.push(Change {
                name,
                largest: (changed.value - location.value).abs() / scale,
                unit,
            });
        }
    }
    changes
}
