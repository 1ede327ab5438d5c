//! What each result of the calibration contributes to the errors, to first order: for draws of the covariance and for
//! shares.

use nalgebra::{Point3, Vector6};

use crate::calibrated_machine::CalibratedMachine;
use crate::predict::influences;

/// Coefficients of the results in displacement and rotation at a place (mm, rad for mm, rad).
pub(crate) type Coefficients = Vec<(usize, Vector6<f64>)>;

/// A component or location error of one axis, with the values of all its results.
pub(crate) struct Part {
    /// ISO 230-1 name.
    pub(crate) name: String,
    /// Places of its results among all.
    pub(crate) places: Vec<usize>,
}

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

    /// The component errors of all axes, then the location errors.
    pub(crate) fn parts(&self) -> Vec<Part> {
        let mut parts = Vec::new();
        for axis in &self.axes {
            let name = self.machine.axes()[axis.axis].name();
            for component in trueaxis_kinematics::Component::ALL {
                let nodes = 0..axis.errors.len();
                parts.push(Part {
                    name: component.name(name),
                    places: nodes
                        .map(|node| axis.first + 6 * node + component.index())
                        .collect(),
                });
            }
        }
        for axis in &self.axes {
            let name = self.machine.axes()[axis.axis].name();
            let reported = axis.reported.iter().enumerate();
            parts.extend(reported.map(|(i, component)| Part {
                name: component.name(name),
                places: vec![axis.first_location + i],
            }));
        }
        parts
    }
}

/// The value of functions with these coefficients.
pub(crate) fn applied(coefficients: &Coefficients, values: &[f64]) -> Vector6<f64> {
    let terms = coefficients.iter().map(|(place, c)| c * values[*place]);
    terms.sum()
}
