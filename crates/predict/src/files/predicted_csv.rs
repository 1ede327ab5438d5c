//! `predicted.csv`: a row for each place, with its positions and what is predicted there.

use std::fmt::Write;

use nalgebra::Point3;
use trueaxis_files::round;
use trueaxis_kinematics::{ARCSEC, MICROMETRE, Machine};

use crate::output::position_in_file;
use crate::predict::Prediction;

/// Columns of the tool point.
const POINT: [&str; 3] = ["x_mm", "y_mm", "z_mm"];

/// Columns of the error of the tool against the workpiece, µm and ″.
pub const ERROR_COLUMNS: [&str; 6] = [
    "ex_um",
    "ey_um",
    "ez_um",
    "ea_arcsec",
    "eb_arcsec",
    "ec_arcsec",
];

/// Columns behind those of the error.
const BEHIND: [&str; 7] = [
    "u_ex_um",
    "u_ey_um",
    "u_ez_um",
    "u_ea_arcsec",
    "u_eb_arcsec",
    "u_ec_arcsec",
    "extrapolated",
];

/// Decimals of µm and ″, far below anything measurable.
const DECIMALS: i32 = 6;

impl Prediction {
    /// Names of the columns of `predicted.csv`: the axes (mm, degrees), the tool point at home, error and standard
    /// uncertainty (actual minus nominal), and whether an axis stands outside its steps.
    pub fn columns(machine: &Machine) -> Vec<&str> {
        let axes = machine.axes().iter().map(|axis| axis.name());
        axes.chain(POINT)
            .chain(ERROR_COLUMNS)
            .chain(BEHIND)
            .collect()
    }

    /// The row of this prediction.
    pub fn row(&self, machine: &Machine, positions: &[f64], tool_home_mm: Point3<f64>) -> Vec<f64> {
        let axes = machine.axes().iter().zip(positions);
        let axes = axes.map(|(axis, &position)| position_in_file(axis.kind(), position));
        let in_units = |v: nalgebra::Vector6<f64>| {
            let unit = |c: usize| if c < 3 { MICROMETRE } else { ARCSEC };
            (0..6).map(move |c| round(v[c] / unit(c), DECIMALS))
        };
        let point: [f64; 3] = tool_home_mm.coords.into();
        axes.chain(point)
            .chain(in_units(self.error.to_vector()))
            .chain(in_units(self.u()))
            .chain([if self.extrapolated { 1.0 } else { 0.0 }])
            .collect()
    }
}

/// A table as CSV; what is not known (NaN) is an empty cell.
pub fn to_csv(columns: &[&str], rows: impl Iterator<Item = Vec<f64>>) -> String {
    let mut text = columns.join(",");
    for row in rows {
        let mut separator = '\n';
        for number in row {
            // Writing to a String cannot fail.
            let _ = match number.is_nan() {
                true => write!(text, "{separator}"),
                false => write!(text, "{separator}{number}"),
            };
            separator = ',';
        }
    }
    text.push('\n');
    text
}
