//! All numbers of a calibration in one list.

use std::io::{self, Seek, Write};

use trueaxis_kinematics::Component;

use crate::result::calibration::{AxisResult, Calibration, StationResult};
use trueaxis_predict::Output;

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

    /// Writes `covariance.npz`.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_covariance_npz(&self, out: impl Write + Seek) -> io::Result<()> {
        let results = self.results().into_iter();
        let per_unit = results.map(|result| result.output.unit().size().recip());
        self.factors.write_npz(out, &per_unit.collect::<Vec<_>>())
    }
}

pub(crate) fn results(axes: &[AxisResult], stations: &[StationResult]) -> Vec<NumberedResult> {
    let mut all = Vec::new();
    let mut add = |output: Output, value: f64, u: f64, dof: f64| {
        all.push(NumberedResult {
            output,
            value,
            u,
            dof,
        });
    };
    for axis in axes {
        for node in &axis.nodes {
            let values = node.error.to_vector();
            for component in Component::ALL {
                let c = component.index();
                let output = Output::ComponentError {
                    axis: axis.name.clone(),
                    kind: axis.kind,
                    component,
                    position: node.position,
                    direction: node.direction,
                };
                add(output, values[c], node.u[c], node.dof[c]);
            }
        }
    }
    for axis in axes {
        for location in &axis.location_errors {
            let output = Output::LocationError {
                axis: axis.name.clone(),
                component: location.component,
            };
            add(output, location.value, location.u, location.dof);
        }
    }
    for s in stations {
        for coordinate in 0..3 {
            let station = s.name.clone();
            let output = Output::StationPosition {
                station,
                coordinate,
            };
            let [u, dof] = [s.u_mm, s.dof].map(|of| of[coordinate]);
            add(output, s.position_mm[coordinate], u, dof);
        }
        let station = s.name.clone();
        let output = Output::DeadPath { station };
        add(output, s.dead_path_mm, s.u_dead_path_mm, s.dof_dead_path);
    }
    all
}
