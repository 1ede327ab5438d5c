//! The linear map from volumetric errors to component errors.

use nalgebra::{Dyn, OMatrix, U6, Vector3, Vector6};
use trueaxis_kinematics::MotionError;

use crate::design::CentredTargets;

/// The six component errors as a linear function of the volumetric errors of the targets:
/// `E = P Δ` with `P A = I`, where `A` is the matrix of [`crate::equations`].
///
/// Made by [`crate::nine()`], [`crate::nine_weighted`] or [`crate::SixRows::operator`]. It belongs to one geometry: a
/// linear axis needs one for all steps, a rotary axis one for each angle.
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    targets: Vec<Vector3<f64>>,
    matrix: OMatrix<f64, U6, Dyn>,
}

impl Operator {
    /// `scaled` solves the centred and scaled equations of the targets `r`.
    pub(crate) fn from_scaled(
        r: &[Vector3<f64>],
        centred: &CentredTargets,
        scaled: OMatrix<f64, U6, Dyn>,
    ) -> Self {
        Self {
            targets: r.to_vec(),
            matrix: centred.unscale(scaled),
        }
    }

    /// The component errors of a step from the volumetric errors of its targets, mm.
    ///
    /// `delta` holds measured minus ideal position of each target in the order of the targets.
    /// Numbers that are not finite give results that are not finite. Nothing is allocated.
    ///
    /// # Panics
    /// If `delta` does not have one vector for each target.
    pub fn apply(&self, delta: &[Vector3<f64>]) -> MotionError {
        assert_eq!(
            delta.len(),
            self.targets.len(),
            "one volumetric error for each target"
        );
        let add = |sum, (j, delta): (usize, &Vector3<f64>)| {
            sum + self.matrix.fixed_columns::<3>(3 * j) * delta
        };
        let sum = delta.iter().enumerate().fold(Vector6::zeros(), add);
        MotionError::from_vector(&sum)
    }

    /// What the rigid motion of [`Operator::apply`] leaves of the volumetric errors:
    /// `v_j = Δ_j - δ - ε × r_j`, mm.
    ///
    /// # Panics
    /// If `delta` does not have one vector for each target.
    pub fn residual_mm(&self, delta: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let error = self.apply(delta);
        let left = |(delta, r): (&Vector3<f64>, &Vector3<f64>)| delta - error.displacement_mm(*r);
        delta.iter().zip(&self.targets).map(left).collect()
    }

    /// Standard deviations of δx δy δz (mm) and εx εy εz (rad) for independent noise of standard
    /// deviation 1 mm on every coordinate of every target: `sqrt(diag(P Pᵀ))`.
    ///
    /// The same numbers are µm per µm, and rad per mm.
    pub fn noise_gain(&self) -> Vector6<f64> {
        let squares = self.matrix.component_mul(&self.matrix);
        squares.column_sum().map(f64::sqrt)
    }

    /// The matrix P: 6 rows δx δy δz (mm per mm) εx εy εz (rad per mm), three columns per target.
    pub fn matrix(&self) -> OMatrix<f64, U6, Dyn> {
        self.matrix.clone()
    }

    /// The generalised coordinates of the targets it was made for, mm.
    pub fn targets_mm(&self) -> &[Vector3<f64>] {
        &self.targets
    }
}
