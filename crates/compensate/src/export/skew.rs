//! Mean slopes of the lines of X, Y and Z through a point: what a matrix can hold.

use nalgebra::Vector3;
use trueaxis_files::round;
use trueaxis_kinematics::AxisKind;

use crate::Error;
use crate::export::Request;
use crate::export::line::{Line, direction};

/// A direction this close to a reference direction is that one.
const ALONG: f64 = 1e-6;

/// How the axes deviate when another one moves.
pub(crate) struct Skew {
    /// Indices of X, Y, Z.
    pub(crate) axes: [usize; 3],
    /// `slopes[i][k]`: deviation of axis i per mm of axis k.
    pub(crate) slopes: [[f64; 3]; 3],
}

impl Skew {
    /// For machines with linear axes X, Y, Z along the reference directions, if none is asked for alone.
    pub(crate) fn new(request: &Request<'_>) -> Result<Self, Error> {
        if let Some(axis) = request.axis {
            let takes = "the squareness of X, Y and Z together";
            let lacks = format!("{} alone is asked for", request.name(axis));
            return Err(request.unsuitable(takes, lacks));
        }
        let machine = request.machine.machine();
        let index = |i: usize| {
            let name = ["X", "Y", "Z"][i];
            let found = machine.axis_index(name).filter(|&axis| {
                let is_linear = machine.axes()[axis].kind() == AxisKind::Linear;
                is_linear && !request.machine.steps(axis).is_empty()
            });
            let takes = "the squareness of linear axes X, Y, Z along x, y, z";
            let refused = |lacks| request.unsuitable(takes, lacks);
            let axis =
                found.ok_or_else(|| refused(format!("no linear axis {name} was measured")))?;
            let moved = direction(machine, axis);
            match (moved - Vector3::ith(i, 1.0)).norm() < ALONG {
                true => Ok(axis),
                false => {
                    let [x, y, z] = moved.data.0[0].map(|x| round(x, 3));
                    let along = format!(
                        "{name} moves the tool against the workpiece along [{x}, {y}, {z}]"
                    );
                    Err(refused(along))
                }
            }
        };
        let axes = [index(0)?, index(1)?, index(2)?];
        let mut slopes = [[0.0; 3]; 3];
        for (k, &axis) in axes.iter().enumerate() {
            let line = Line::new(request, axis)?;
            for (i, &of) in axes.iter().enumerate() {
                slopes[i][k] = line.slope(of);
            }
        }
        Ok(Self { axes, slopes })
    }

    /// Tangents of the angles by which the lines of X and Y, X and Z, Y and Z are short of 90°: Y leans towards +X.
    pub(crate) fn factors(&self) -> [f64; 3] {
        let s = &self.slopes;
        [s[0][1] + s[1][0], s[0][2] + s[2][0], s[1][2] + s[2][1]]
    }

    /// What a printer's firmware adds for these factors: X stays, Y and Z are set upright.
    pub(crate) fn added(&self, [xy, xz, yz]: [f64; 3], commanded: &[f64]) -> Vec<f64> {
        let [x, y, z] = self.axes;
        let mut added = vec![0.0; commanded.len()];
        added[x] = -commanded[y] * xy - commanded[z] * (xz - xy * yz);
        added[y] = -commanded[z] * yz;
        added
    }
}
