//! All numbers of a calibration in one list.

use trueaxis_kinematics::Component;

use crate::result::calibration::{AxisResult, Calibration, StationResult};
use crate::result::output::Output;

/// One number of a calibration with its uncertainty, in mm and rad.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberedResult {
    /// Which number.
    pub output: Output,
    /// Its value, mm or rad.
    pub value: f64,
    /// Its standard uncertainty, mm or rad; zero where gauge or frame define it.
    pub u: f64,
    /// Degrees of freedom of that.
    pub dof: f64,
}

impl Calibration {
    /// All results in a fixed order: the component errors of all axes (for each position all six), the
    /// location errors, the stations (x y z and dead path of each).
    pub fn results(&self) -> Vec<NumberedResult> {
        results(&self.axes, &self.stations)
    }
}

pub(crate) fn results(axes: &[AxisResult], stations: &[StationResult]) -> Vec<NumberedResult> {
    let mut all = Vec::new();
    for axis in axes {
        for node in &axis.nodes {
            let values = node.error.to_vector();
            all.extend(Component::ALL.map(|component| {
                let c = component.index();
                NumberedResult {
                    output: Output::ComponentError {
                        axis: axis.name.clone(),
                        kind: axis.kind,
                        component,
                        position: node.position,
                        direction: node.direction,
                    },
                    value: values[c],
                    u: node.u[c],
                    dof: node.dof[c],
                }
            }));
        }
    }
    for axis in axes {
        all.extend(axis.location_errors.iter().map(|location| NumberedResult {
            output: Output::LocationError {
                axis: axis.name.clone(),
                component: location.component,
            },
            value: location.value,
            u: location.u,
            dof: location.dof,
        }));
    }
    for station in stations {
        all.extend((0..3).map(|coordinate| NumberedResult {
            output: Output::StationPosition {
                station: station.name.clone(),
                coordinate,
            },
            value: station.position_mm[coordinate],
            u: station.u_mm[coordinate],
            dof: station.dof[coordinate],
        }));
        all.push(NumberedResult {
            output: Output::DeadPath {
                station: station.name.clone(),
            },
            value: station.dead_path_mm,
            u: station.u_dead_path_mm,
            dof: station.dof_dead_path,
        });
    }
    all
}
