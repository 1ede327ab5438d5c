//! What small displacements of the axes do to the tool, and which of them undo an error of the tool.
//!
//! Linear axes answer for the position of the tool point, rotary axes (if they take part) for its rotation, in the
//! sense of least squares where they cannot make every rotation:
//!
//! ```text
//! Δrot = -R⁺ ε      Δlin = -L⁺ (δ + D Δrot)
//! ```
//!
//! with `L` and `D` the displacement of the tool point by the linear and the rotary axes and `R` the rotation by the
//! rotary ones, along the reference axes of the workpiece. What a `⁺` (Moore and Penrose) cannot reach stays.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};
use trueaxis_kinematics::{AxisKind, Branch, Ideal, Machine, MotionError};
use trueaxis_leastsquares::dense::Svd;

/// Which axes are moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moved {
    /// Linear axes alone: the position of the tool point.
    Linear,
    /// All axes: its position, and as much of its rotation as the rotary axes can make.
    All,
}

/// Directions of axes that are closer together than this (sine) are taken for one: half a degree would turn an error
/// of a micrometre into a motion of a hundred.
const INDEPENDENT: f64 = 0.01;

/// What small displacements of the axes do.
#[derive(Debug, Clone)]
pub(crate) struct Freedom {
    axes: usize,
    linear: Vec<usize>,
    rotary: Vec<usize>,
    inverse_of_linear: DMatrix<f64>,
    inverse_of_rotary: DMatrix<f64>,
    displaced_by_rotary: DMatrix<f64>,
}

impl Freedom {
    /// Of a machine at commanded positions of all axes (mm or rad), for the tool point that is at `tool_home_mm` at
    /// home.
    pub(crate) fn new(
        machine: &Machine,
        commanded: &[f64],
        tool_home_mm: Point3<f64>,
        moved: Moved,
    ) -> Self {
        let [tool, workpiece] =
            [Branch::Tool, Branch::Workpiece].map(|branch| machine.branch(branch));
        let tool_point = machine.chain_motion(&Ideal, tool, commanded) * tool_home_mm;
        let from_bed = machine.chain_motion(&Ideal, workpiece, commanded).rotation;
        let from_bed = from_bed.inverse();
        let mut linear = (Vec::new(), Vec::new());
        let mut rotary = (Vec::new(), Vec::new(), Vec::new());
        for (chain, sign) in [(tool, 1.0), (workpiece, -1.0)] {
            let mut base = Isometry3::identity();
            for &index in chain {
                let axis = &machine.axes()[index];
                let direction = base.rotation * axis.direction().into_inner();
                let lever = tool_point - base * axis.reference_mm();
                match axis.kind() {
                    AxisKind::Linear => {
                        linear.0.push(index);
                        linear.1.push(from_bed * direction * sign);
                    }
                    AxisKind::Rotary if moved == Moved::All => {
                        rotary.0.push(index);
                        rotary.1.push(from_bed * direction * sign);
                        rotary.2.push(from_bed * direction.cross(&lever) * sign);
                    }
                    AxisKind::Rotary => {}
                }
                base *= machine.chain_motion(&Ideal, &[index], commanded);
            }
        }
        Self {
            axes: machine.axes().len(),
            linear: linear.0,
            rotary: rotary.0,
            inverse_of_linear: pseudo_inverse(&columns(&linear.1), INDEPENDENT),
            inverse_of_rotary: pseudo_inverse(&columns(&rotary.1), INDEPENDENT),
            displaced_by_rotary: columns(&rotary.2),
        }
    }

    /// The displacements of all axes (mm or rad) that take away an error of the tool against the workpiece, to first
    /// order.
    pub(crate) fn undoing(&self, error: &MotionError) -> Vec<f64> {
        let mut displacements = vec![0.0; self.axes];
        let mut displaced = DVector::from_column_slice(error.translation_mm.as_slice());
        let rotation = DVector::from_column_slice(error.rotation_rad.as_slice());
        let turned = -(&self.inverse_of_rotary * rotation);
        displaced += &self.displaced_by_rotary * &turned;
        let shifted = -(&self.inverse_of_linear * displaced);
        let of_linear = self.linear.iter().zip(shifted.iter());
        let of_rotary = self.rotary.iter().zip(turned.iter());
        for (&axis, &displacement) in of_linear.chain(of_rotary) {
            displacements[axis] = displacement;
        }
        displacements
    }
}

fn columns(vectors: &[Vector3<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(3, vectors.len(), |row, column| vectors[column][row])
}

/// Moore and Penrose's inverse; singular values that are not above `least` are zero.
pub(crate) fn pseudo_inverse(matrix: &DMatrix<f64>, least: f64) -> DMatrix<f64> {
    let none = || DMatrix::zeros(matrix.ncols(), matrix.nrows());
    // Nothing undoes what is not a number.
    Svd::new(matrix).map_or_else(|_| none(), |svd| svd.pseudo_inverse(least))
}
