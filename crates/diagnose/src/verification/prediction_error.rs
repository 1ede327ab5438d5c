//! The errors that a prediction has itself: directions `P` with `cov(prediction) = P Pᵀ`.
//!
//! A calibration is uncertain, and its errors are correlated from one position to the next: in a
//! comparison they look like structure. To first order the prediction follows the errors of the machine,
//! these the results of the calibration, with the weights of its interpolation:
//!
//! ```text
//! K = J Σ Jᵀ        J = ∂(reading)/∂(errors at the position) · weights of the nodes
//! ```
//!
//! `Σ` is the covariance of the results ([`Calibration::covariance`]). Where the calibration was made
//! without it, it is built from the standard uncertainties, with `1 + exp(-|Δq|/range)` in place of the
//! correlation between nodes of one curve: whether their errors are local or slow is not known then, so
//! both are allowed in full.
//!
//! `K` has few directions that matter; they come from a pivoted Cholesky factorisation, which stops when
//! what is left is far below the noise. As unknowns with the pseudo-observations `0 = x ± 1` they join
//! the base model, which is the same as adding `K` to the covariance of the readings.

use nalgebra::{DMatrix, DVector, Vector3, Vector6};
use trueaxis_calibrate::{AxisResult, Calibration, predicted_reading_um};
use trueaxis_kinematics::{
    Axis, GeometricErrors, LocationComponent, LocationError, Machine, MotionError,
};

use crate::verification::base::stands;
use crate::verification::comparison::Comparison;

/// Steps of the differences: errors of a poor machine; the prediction is linear in them to 1e-6.
const STEP_MM: f64 = 1e-3;
const STEP_RAD: f64 = 1e-6;

/// Variance of a prediction, in variances of an arrival, that may be left out.
const NEGLIGIBLE: f64 = 1e-3;

/// The columns of `P` over the readings, µm.
pub(crate) fn prediction_directions(
    comparison: &Comparison<'_>,
    calibration: &Calibration,
    noise_um: f64,
) -> Vec<Vec<f64>> {
    let stands = stands(comparison);
    let count = stands.iter().max().map_or(0, |max| max + 1);
    let mut positions: Vec<&[f64]> = vec![&[]; count];
    for (arrival, &stand) in comparison.arrivals.iter().zip(&stands) {
        positions[stand] = &arrival.positions;
    }
    let jacobian = jacobian(comparison, calibration, &positions);
    let results = covariance(calibration);
    let prediction = &jacobian * results * jacobian.transpose();
    let of_stands = pivoted_cholesky(prediction, NEGLIGIBLE * noise_um * noise_um);
    let spread = |column: &DVector<f64>| stands.iter().map(|&stand| column[stand]).collect();
    of_stands.iter().map(spread).collect()
}

/// `J`: µm per mm or rad of each component error of each node and of each location error, in the order
/// of [`trueaxis_calibrate::OutputCovariance::outputs`].
fn jacobian(
    comparison: &Comparison<'_>,
    calibration: &Calibration,
    positions: &[&[f64]],
) -> DMatrix<f64> {
    let axes = &calibration.axes;
    let mut jacobian = DMatrix::zeros(positions.len(), results(axes));
    let mut first = 0;
    let mut first_location: usize = axes.iter().map(|axis| 6 * axis.nodes.len()).sum();
    for result in axes {
        let content = &comparison.machine.axes()[result.axis];
        let probes = Probes::new(result);
        for (row, at) in positions.iter().enumerate() {
            let slope = |location: LocationError, motion: MotionError, step: f64| {
                let (axis, base) = (result.axis, calibration);
                let change = |sign: f64| {
                    let errors = Changed {
                        base,
                        axis,
                        location,
                        motion,
                        sign,
                    };
                    predicted_reading_um(comparison.machine, comparison.kind, &errors, at, at)
                };
                (change(1.0) - change(-1.0)) / (2.0 * step)
            };
            let weights = probes.weights_at(at[result.axis]);
            for c in 0..6 {
                let step = if c < 3 { STEP_MM } else { STEP_RAD };
                let unit = MotionError::from_vector(&Vector6::ith(c, step));
                let slope = slope(LocationError::default(), unit, step);
                for (node, weight) in weights.iter().enumerate() {
                    jacobian[(row, first + 6 * node + c)] = slope * weight;
                }
            }
            for (i, location) in result.location_errors.iter().enumerate() {
                let (unit, step) = unit_location(location.component, content);
                jacobian[(row, first_location + i)] = slope(unit, MotionError::default(), step);
            }
        }
        first += 6 * result.nodes.len();
        first_location += result.location_errors.len();
    }
    jacobian
}

/// Number of component and location errors.
fn results(axes: &[AxisResult]) -> usize {
    let of_axis = |axis: &AxisResult| 6 * axis.nodes.len() + axis.location_errors.len();
    axes.iter().map(of_axis).sum()
}

/// A step of a location error, and its size. A tilt is across the axis: the part that has no name
/// follows from the others.
fn unit_location(component: LocationComponent, axis: &Axis) -> (LocationError, f64) {
    let mut unit = LocationError::default();
    match component {
        LocationComponent::Offset(c) => {
            unit.offset_mm[c] = STEP_MM;
            (unit, STEP_MM)
        }
        LocationComponent::Tilt(c) => {
            let (direction, principal) = (axis.direction(), axis.principal());
            unit.tilt_rad = Vector3::ith(c, STEP_RAD);
            unit.tilt_rad[principal] -= STEP_RAD * direction[c] / direction[principal];
            (unit, STEP_RAD)
        }
    }
}

/// `Σ` in mm and rad.
fn covariance(calibration: &Calibration) -> DMatrix<f64> {
    let count = results(&calibration.axes);
    if let Some(covariance) = &calibration.covariance {
        let size = |i: usize| covariance.outputs[i].unit().size();
        return DMatrix::from_fn(count, count, |i, j| {
            covariance.matrix[(i, j)] * size(i) * size(j)
        });
    }
    let mut matrix = DMatrix::zeros(count, count);
    let mut first = 0;
    for axis in &calibration.axes {
        let range = match (axis.nodes.first(), axis.nodes.last()) {
            (Some(a), Some(b)) if b.position > a.position => b.position - a.position,
            _ => 1.0,
        };
        for (i, a) in axis.nodes.iter().enumerate() {
            for (j, b) in axis.nodes.iter().enumerate() {
                let own = if i == j { 1.0 } else { 0.0 };
                let correlation = own + (-(a.position - b.position).abs() / range).exp();
                for c in 0..6 {
                    matrix[(first + 6 * i + c, first + 6 * j + c)] = a.u[c] * b.u[c] * correlation;
                }
            }
        }
        first += 6 * axis.nodes.len();
    }
    let locations = calibration
        .axes
        .iter()
        .flat_map(|axis| &axis.location_errors);
    for (i, location) in locations.enumerate() {
        matrix[(first + i, first + i)] = location.u * location.u;
    }
    matrix
}

/// Columns `L` with `K ≈ L Lᵀ`; no diagonal element of the rest exceeds `limit`.
fn pivoted_cholesky(mut rest: DMatrix<f64>, limit: f64) -> Vec<DVector<f64>> {
    let mut columns = Vec::new();
    for _ in 0..rest.nrows() {
        let (pivot, largest) = rest.diagonal().argmax();
        if largest <= limit || largest.is_nan() {
            break;
        }
        let column = rest.column(pivot) / largest.sqrt();
        rest -= &column * column.transpose();
        columns.push(column);
    }
    columns
}

/// A calibration with one axis changed.
struct Changed<'a> {
    base: &'a Calibration,
    axis: usize,
    location: LocationError,
    motion: MotionError,
    sign: f64,
}

impl GeometricErrors for Changed<'_> {
    fn location(&self, axis: usize) -> LocationError {
        let mut location = self.base.location(axis);
        if axis == self.axis {
            location.offset_mm += self.location.offset_mm * self.sign;
            location.tilt_rad += self.location.tilt_rad * self.sign;
        }
        location
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        let motion = self.base.motion(axis, position);
        if axis != self.axis {
            return motion;
        }
        let sum = motion.to_vector() + self.motion.to_vector() * self.sign;
        MotionError::from_vector(&sum)
    }
}

/// The weights of an axis' nodes at a position, read off its own interpolation: curves that are one at
/// one node and zero at the others, six at a time in the six components.
struct Probes {
    curves: Vec<AxisResult>,
    nodes: usize,
}

impl Probes {
    fn new(result: &AxisResult) -> Self {
        let nodes = result.nodes.len();
        let curve = |first: usize| {
            let mut curve = result.clone();
            for (i, node) in curve.nodes.iter_mut().enumerate() {
                let own = i.checked_sub(first).filter(|c| *c < 6);
                let unit = own.map_or_else(Vector6::zeros, |c| Vector6::ith(c, 1.0));
                node.error = MotionError::from_vector(&unit);
            }
            curve
        };
        Self {
            curves: (0..nodes).step_by(6).map(curve).collect(),
            nodes,
        }
    }

    fn weights_at(&self, position: f64) -> Vec<f64> {
        let parts = self
            .curves
            .iter()
            .map(|curve| curve.error_at(position).to_vector());
        let mut weights: Vec<f64> = parts
            .flat_map(|p| p.iter().copied().collect::<Vec<_>>())
            .collect();
        weights.truncate(self.nodes);
        weights
    }
}

/// The machine with the reference points that the component errors of a calibration are given for.
pub(crate) fn with_reference_points(machine: &Machine, calibration: &Calibration) -> Machine {
    machine.with_axes(|index, axis| {
        let result = calibration.axes.iter().find(|result| result.axis == index);
        match result {
            Some(result) => axis.with_reference(result.reference_point_mm),
            None => axis,
        }
    })
}
