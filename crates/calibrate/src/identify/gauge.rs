//! The least-squares gauge (paper 4.2.2 and 4.2.3): which part of the measured motion is location error, position of
//! the targets, and component error.
//!
//! The pose errors `e_i = (δ, ε)` of an axis determine its component errors `E`
//! only up to the motions
//!
//! ```text
//! linear   δ += (t × d) q + g_δ            ε += g_ε
//! rotary   δ += a - R a + R g_δ            ε += α - R α + R g_ε        R = R(d, θ)
//! ```
//!
//! of the axis (tilt `t`; shift `a`, tilt `α` across the axis) and of the targets (`g`, six for
//! each run). The gauge fixes them:
//!
//! ```text
//! linear   Σ δ⊥ = 0,  Σ q δ⊥ = 0;                          δ∥ = 0, ε = 0 at home
//! rotary   Σ δ⊥ = 0,  Σ Rᵀδ⊥ = 0,  Σ ε⊥ = 0,  Σ Rᵀε⊥ = 0;  δ∥ = 0, ε∥ = 0 at home
//! ```
//!
//! with sums over the different positions (nodes). Runs that share positions are joined by least squares: `E` at a
//! node is the mean over the runs there, each with its own `g`. All this is linear, `x = Σ Γ_i e_i`, `E_k = mean e -
//! Λ x`; the uncertainties use `Γ`, too.

use nalgebra::{
    DMatrix, DVector, Matrix3, Matrix6, Matrix6xX, MatrixXx6, RowVector6, UnitQuaternion, Vector3,
    Vector6,
};
use trueaxis_kinematics::{Axis, AxisKind};
use trueaxis_leastsquares::dense::relative_singular_value;
use trueaxis_poses::twist_map;

use crate::identify::axis_data::AxisData;
use crate::identify::basis::Basis;
use crate::in_order;

/// The gauge of one axis.
pub(crate) struct LeastSquaresGauge {
    /// Number of parameters of the axis itself: tilts of a linear, shifts and tilts of a rotary axis, along the two
    /// directions of its [`Basis`].
    pub(crate) location_parameters: usize,
    /// `Λ` of each pose: the effect of the parameters on its pose error.
    pub(crate) effects: Vec<Matrix6xX<f64>>,
    /// Weighted mean `Λ` of each node's poses.
    pub(crate) node_effects: Vec<Matrix6xX<f64>>,
    /// `Γ` of each pose: the effect of its pose error on the parameters.
    pub(crate) shares: Vec<MatrixXx6<f64>>,
}

/// A gauge that the measured positions do not determine.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum GaugeDefect {
    /// Too few different positions, or all too close together.
    Positions {
        /// Smallest singular value relative to the largest.
        singular_value: f64,
    },
    /// Runs without common positions.
    Disjoint,
}

/// Relative singular value below which positions do not determine the gauge: a rotary axis turned
/// by less than half a degree has 1e-5.
const RANK_TOL: f64 = 1e-6;

/// Parameters of the targets of one run.
pub(crate) const PER_RUN: usize = 6;

impl LeastSquaresGauge {
    pub(crate) fn new(axis: &Axis, data: &AxisData) -> Result<Self, GaugeDefect> {
        let location_parameters = match axis.kind() {
            AxisKind::Linear => 2,
            AxisKind::Rotary => 4,
        };
        let width = location_parameters + PER_RUN * data.runs.len();
        let effects = in_order::map(data.poses.len(), |i| {
            let pose = &data.poses[i];
            let position = data.nodes[pose.node].position;
            let mut effect = Matrix6xX::zeros(width);
            effect
                .columns_mut(0, location_parameters)
                .copy_from(&location_effect(axis, position));
            effect
                .columns_mut(location_parameters + PER_RUN * pose.run, PER_RUN)
                .copy_from(&target_effect(axis, position));
            effect
        });
        let conditions = conditions(axis, data);

        // Weighted means over the poses of each node.
        let mut node_effects = vec![Matrix6xX::zeros(width); data.nodes.len()];
        for (pose, effect) in data.poses.iter().zip(&effects) {
            node_effects[pose.node] += effect * pose.weight;
        }
        let count = conditions.first().map_or(0, MatrixXx6::nrows);
        let mut constraint = DMatrix::zeros(count, width);
        for (condition, effect) in conditions.iter().zip(&node_effects) {
            constraint += condition * effect;
        }
        let deviation = |i: usize| &effects[i] - &node_effects[data.poses[i].node];
        let zero = || DMatrix::zeros(width, width);
        let add = |sum: &mut DMatrix<f64>, i: usize| {
            let deviation = deviation(i);
            sum.gemm_tr(data.poses[i].weight, &deviation, &deviation, 1.0);
        };
        let poses = data.poses.len();
        let agreement = in_order::sum(poses, zero, add);
        let solver = bordered_inverse(&agreement, &constraint)?;
        let (of_agreement, of_constraint) =
            (solver.columns(0, width), solver.columns(width, count));
        let shares = in_order::map(poses, |i| {
            let pose = &data.poses[i];
            let share = of_agreement * deviation(i).transpose();
            (share + of_constraint * &conditions[pose.node]) * pose.weight
        });
        Ok(Self {
            location_parameters,
            effects,
            node_effects,
            shares,
        })
    }

    /// Number of parameters.
    pub(crate) fn parameters(&self) -> usize {
        self.shares.first().map_or(0, MatrixXx6::nrows)
    }

    /// The parameters of given pose errors.
    pub(crate) fn apply(&self, pose_errors: &[Vector6<f64>]) -> DVector<f64> {
        let mut x = DVector::zeros(self.parameters());
        for (share, error) in self.shares.iter().zip(pose_errors) {
            x += share * error;
        }
        x
    }
}

/// The first rows of the inverse of `[N Aᵀ; A 0]`: they map `(Σ Λᵀe, c)` to the parameters that minimise the
/// disagreement `xᵀN x / 2 - …` subject to `A x = c`.
fn bordered_inverse(
    agreement: &DMatrix<f64>,
    constraint: &DMatrix<f64>,
) -> Result<DMatrix<f64>, GaugeDefect> {
    let (width, count) = (agreement.nrows(), constraint.nrows());
    // Columns and rows of unit size, for rotations and translations, large and small travels alike.
    let unit = |size: f64| if size > 0.0 { size } else { 1.0 };
    let columns: Vec<f64> = (0..width)
        .map(|j| unit(constraint.column(j).norm()))
        .collect();
    let rows: Vec<f64> = (0..count).map(|i| unit(constraint.row(i).norm())).collect();
    let scaled_agreement = DMatrix::from_fn(width, width, |i, j| {
        agreement[(i, j)] / (columns[i] * columns[j])
    });
    let weight = 1.0 / unit(scaled_agreement.amax());
    let scaled_constraint = DMatrix::from_fn(count, width, |i, j| {
        constraint[(i, j)] / (rows[i] * columns[j])
    });
    let bordered = DMatrix::from_fn(width + count, width + count, |i, j| {
        match (i < width, j < width) {
            (true, true) => weight * scaled_agreement[(i, j)],
            (true, false) => scaled_constraint[(j - width, i)],
            (false, true) => scaled_constraint[(i - width, j)],
            (false, false) => 0.0,
        }
    });
    let singular_value = relative_singular_value(&bordered);
    if singular_value < RANK_TOL {
        // The constraints alone must be independent: if they are not, the positions are at fault.
        let of_positions = relative_singular_value(&scaled_constraint);
        return Err(if of_positions < RANK_TOL {
            GaugeDefect::Positions {
                singular_value: of_positions,
            }
        } else {
            GaugeDefect::Disjoint
        });
    }
    let inverse = bordered.lu().try_inverse();
    let inverse = inverse.ok_or(GaugeDefect::Disjoint)?;
    Ok(DMatrix::from_fn(width, width + count, |i, j| {
        let right = if j < width {
            weight / columns[j]
        } else {
            1.0 / rows[j - width]
        };
        inverse[(i, j)] / columns[i] * right
    }))
}

/// The effect of the axis' own parameters on a pose error.
fn location_effect(axis: &Axis, position: f64) -> Matrix6xX<f64> {
    let Basis { across, along } = Basis::of(axis);
    let column = |translation: Vector3<f64>, rotation: Vector3<f64>| {
        Vector6::from_iterator(translation.iter().chain(rotation.iter()).copied())
    };
    let zero = Vector3::zeros();
    match axis.kind() {
        AxisKind::Linear => {
            Matrix6xX::from_columns(&across.map(|t| column(t.cross(&along) * position, zero)))
        }
        AxisKind::Rotary => {
            let turn = UnitQuaternion::from_axis_angle(&axis.direction(), position);
            let [a, b] = across.map(|v| v - turn * v);
            Matrix6xX::from_columns(&[
                column(a, zero),
                column(b, zero),
                column(zero, a),
                column(zero, b),
            ])
        }
    }
}

/// The effect of a twist of the targets on the stage on a pose error.
fn target_effect(axis: &Axis, position: f64) -> Matrix6<f64> {
    let turn = match axis.kind() {
        AxisKind::Linear => UnitQuaternion::identity(),
        AxisKind::Rotary => UnitQuaternion::from_axis_angle(&axis.direction(), position),
    };
    twist_map(turn.to_rotation_matrix().matrix(), &Matrix3::zeros())
}

/// The gauge conditions: for each node the matrix by which its component errors enter them.
fn conditions(axis: &Axis, data: &AxisData) -> Vec<MatrixXx6<f64>> {
    let Basis { across, along } = Basis::of(axis);
    let nodes = data.nodes.len() as f64;
    let positions = data.nodes.iter().map(|node| node.position);
    let mean = positions.clone().sum::<f64>() / nodes;
    let spread = positions.map(|q| (q - mean).powi(2)).sum::<f64>().sqrt();
    let at_home = data.weights_at(0.0);
    let translation = |d: Vector3<f64>| RowVector6::new(d.x, d.y, d.z, 0.0, 0.0, 0.0);
    let rotation = |d: Vector3<f64>| RowVector6::new(0.0, 0.0, 0.0, d.x, d.y, d.z);
    in_order::map(data.nodes.len(), |number| {
        let node = &data.nodes[number];
        let home = at_home.iter().find(|(n, _)| *n == number);
        let home = home.map_or(0.0, |&(_, weight)| weight);
        let mut rows = Vec::new();
        match axis.kind() {
            AxisKind::Linear => {
                let lever = (node.position - mean) / spread.max(f64::MIN_POSITIVE);
                for direction in across {
                    rows.push(translation(direction / nodes));
                    rows.push(translation(direction * (lever / nodes.sqrt())));
                }
                rows.push(translation(along * home));
                rows.extend((0..3).map(|i| rotation(Vector3::ith(i, home))));
            }
            AxisKind::Rotary => {
                let turn = UnitQuaternion::from_axis_angle(&axis.direction(), node.position);
                for direction in across {
                    rows.push(translation(direction / nodes));
                    rows.push(translation(turn * direction / nodes));
                    rows.push(rotation(direction / nodes));
                    rows.push(rotation(turn * direction / nodes));
                }
                rows.extend([translation(along * home), rotation(along * home)]);
            }
        }
        MatrixXx6::from_rows(&rows)
    })
}
