//! What each result of the calibration contributes to the errors, to first order: for draws of the covariance and for
//! shares.

use nalgebra::{Point3, Vector6};
use trueaxis_kinematics::Component;

use crate::calibrated_machine::CalibratedMachine;
use crate::predict::influences;

/// Coefficients of the results in displacement and rotation at a place (mm, rad for mm, rad).
pub(crate) type Coefficients = Vec<(usize, Vector6<f64>)>;

impl CalibratedMachine {
    /// The coefficients at a place.
    pub(crate) fn coefficients(
        &self,
        positions: &[f64],
        tool_home_mm: Point3<f64>,
    ) -> Coefficients {
        let effects = self.effects(positions, tool_home_mm).into_iter();
        let of_axis = effects.flat_map(|(axis, effect)| {
            let sample = axis.curve.at(positions[axis.axis]);
            influences(&self.machine, axis, &sample, &effect)
        });
        of_axis.collect()
    }

    /// The values of all component and location errors, mm and rad, in the order of the results.
    pub(crate) fn values(&self) -> Vec<f64> {
        let errors = self.axes.iter().flat_map(|axis| &axis.errors);
        let mut values: Vec<f64> = Vec::new();
        for error in errors {
            values.extend(error.to_vector().iter());
        }
        for axis in &self.axes {
            values.extend(axis.reported.iter().map(|c| c.of(&axis.location)));
        }
        values
    }

    /// ISO 230-1 names of the component errors of all axes, then of the location errors; and for each result the place of
    /// its name among them.
    pub(crate) fn parts(&self) -> (Vec<String>, Vec<usize>) {
        let (mut names, mut part_of) = (Vec::new(), Vec::new());
        for axis in &self.axes {
            let name = self.machine.axes()[axis.axis].name();
            for _ in &axis.errors {
                part_of.extend(names.len()..names.len() + Component::ALL.len());
            }
            names.extend(Component::ALL.map(|component| component.name(name)));
        }
        for axis in &self.axes {
            let name = self.machine.axes()[axis.axis].name();
            for component in &axis.reported {
                part_of.push(names.len());
                names.push(component.name(name));
            }
        }
        (names, part_of)
    }
}

/// The value of functions with these coefficients.
pub(crate) fn applied(coefficients: &Coefficients, values: &[f64]) -> Vector6<f64> {
    let terms = coefficients.iter().map(|(place, c)| c * values[*place]);
    terms.sum()
}
