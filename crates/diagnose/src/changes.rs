//! Changes of a calibration when the causes join the model.

use trueaxis_calibrate::Calibration;
use trueaxis_kinematics::Component;
use trueaxis_predict::Unit;

use crate::Change;

/// Largest changes of component and location errors, in the order of the machine; both calibrations must be of the
/// same campaign.
pub(crate) fn changes(before: &Calibration, after: &Calibration) -> Vec<Change> {
    let mut changes = Vec::new();
    for axis in &before.axes {
        let Some(other) = after.axis(&axis.name) else {
            continue;
        };
        for component in Component::ALL {
            let k = component.index();
            let value = |node: &trueaxis_calibrate::NodeResult| node.error.to_vector()[k];
            let nodes = axis.nodes.iter().zip(&other.nodes);
            let changed = nodes.map(|(a, b)| (value(b) - value(a)).abs());
            let largest = changed.fold(0.0, f64::max);
            let unit = Unit::of_component(component);
            changes.push(Change {
                name: component.name(&axis.name),
                largest: largest / unit.size(),
                unit: unit.suffix(),
            });
        }
        for location in &axis.location_errors {
            let name = location.component.name(&axis.name);
            let Some(changed) = other.location_error(&name) else {
                continue;
            };
            let unit = Unit::of_location(location.component);
            changes.push(Change {
                name,
                largest: (changed.value - location.value).abs() / unit.size(),
                unit: unit.suffix(),
            });
        }
    }
    changes
}
