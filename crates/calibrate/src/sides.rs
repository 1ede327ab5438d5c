//! Whether the two sides of approach differ, where they share a curve.
//!
//! The joint adjustment has one pose for both sides. A difference between them, of the reference point (δ) and
//! in angle (ε), moves the targets of an axis by ± half of it; with the whitened columns `X` of its six
//! components and what the adjustment leaves of them, `M X`,
//!
//! ```text
//! G = Xᵀ M X     d = G⁻¹ Xᵀ v     cov(d) = G⁻¹     dᵀ G d ~ χ²(6) if there is no difference
//! ```

use nalgebra::{Matrix6, Point3, Vector3, Vector6};
use trueaxis_campaign::{Campaign, Direction, Lengths};
use trueaxis_kinematics::{GeometricErrors, Machine};
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_multilateration::{Screened, Whitened};

use crate::axis_data::AxisData;
use crate::calibration::SideDifference;
use crate::from_lengths::AdjustedLengths;

/// Significance of all axes together: one clean campaign in a thousand.
const LEVEL: f64 = 1e-3;

/// What is left of a column, relative to its squares, below which the lengths do not show its component.
const VISIBLE: f64 = 1e-8;

/// For each axis the difference forward minus backward, where both sides were measured and it is significant;
/// `errors` are those of the calibrated machine.
pub(crate) fn side_differences(
    campaign: &Campaign,
    machine: &Machine,
    (data, errors): (&[AxisData], &impl GeometricErrors),
    adjusted: &AdjustedLengths<'_>,
) -> Vec<Option<SideDifference>> {
    let screened = &*adjusted.screened;
    let Some(lengths) = &campaign.lengths else {
        return vec![None; data.len()];
    };
    let sides: Vec<Side> = sides(lengths, screened);
    let both = |axis: usize| {
        let of_axis = |side: &&Side| campaign.runs[campaign.steps[side.step].run].axis == axis;
        let mut signs = sides.iter().filter(of_axis).map(|side| side.sign > 0.0);
        let first = signs.next();
        signs.any(|sign| Some(sign) != first)
    };
    let axes: Vec<usize> = (0..data.len()).filter(|&k| both(data[k].axis)).collect();
    let mut found = vec![None; data.len()];
    if axes.is_empty() || screened.solution.degrees_of_freedom() == 0 {
        return found;
    }
    let whitened = Whitened::new(&screened.network, &screened.solution);
    for &k in &axes {
        let of_axis = |side: &Side| {
            let step = &campaign.steps[side.step];
            if campaign.runs[step.run].axis != data[k].axis || !adjusted.groups[side.group].moved {
                return Vector6::zeros();
            }
            let axis = &machine.axes()[data[k].axis];
            let motion = machine.motion(errors, data[k].axis, &step.positions);
            let reference = motion * axis.reference_at_home_mm(&errors.location(data[k].axis));
            let arm_mm = side.point_mm - reference;
            let by_rotation = arm_mm.cross(&side.beam);
            let half = 0.5 * side.sign;
            Vector6::from_iterator(side.beam.iter().chain(&by_rotation).map(|x| half * x))
        };
        let rows: Vec<Vector6<f64>> = sides.iter().map(of_axis).collect();
        let difference = difference(&whitened, &rows);
        found[k] = difference.filter(|d| d.p_value < LEVEL / axes.len() as f64);
    }
    found
}

/// A used length: where it was read, on which side of approach.
struct Side {
    step: usize,
    group: usize,
    sign: f64,
    /// Unit vector from the station to the target, and the target, mm.
    beam: Vector3<f64>,
    point_mm: Point3<f64>,
}

fn sides(lengths: &Lengths, screened: &Screened) -> Vec<Side> {
    let Screened {
        network, solution, ..
    } = screened;
    let mut stops = lengths.stops.iter().peekable();
    let mut sides = Vec::with_capacity(network.readings.len());
    for visit in &network.visits {
        for reading in visit.readings.clone() {
            let original = screened.kept[reading];
            while stops
                .peek()
                .is_some_and(|stop| stop.readings.end <= original)
            {
                stops.next();
            }
            let Some(stop) = stops.peek() else { continue };
            let point = network.groups[visit.group].start + network.readings[reading].point;
            let point_mm = solution.points_mm[point];
            let beam = point_mm - solution.stations[visit.station].position_mm;
            sides.push(Side {
                step: stop.step,
                group: visit.group,
                sign: match stop.direction {
                    Direction::Forward => 1.0,
                    Direction::Backward => -1.0,
                },
                beam: beam.normalize(),
                point_mm,
            });
        }
    }
    sides
}

/// The difference whose unit components change the lengths by `rows`; `None` if the lengths do not show all
/// of them.
fn difference(whitened: &Whitened, rows: &[Vector6<f64>]) -> Option<SideDifference> {
    let column = |c: usize| {
        let mut column: Vec<f64> = rows.iter().map(|row| row[c]).collect();
        whitened.whiten(&mut column);
        column
    };
    let columns: [Vec<f64>; 6] = std::array::from_fn(column);
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut gram = Matrix6::zeros();
    for (k, own) in columns.iter().enumerate() {
        let mut left = own.clone();
        whitened.project(&mut left);
        if dot(&left, &left) < VISIBLE * dot(own, own) {
            return None;
        }
        for (i, other) in columns.iter().enumerate() {
            gram[(i, k)] = dot(other, &left);
        }
    }
    // Micrometres and seconds of arc: columns of unit size.
    let size = gram.diagonal().map(f64::sqrt);
    let scaled = Matrix6::from_fn(|i, k| gram[(i, k)] / (size[i] * size[k]));
    let inverse = scaled.try_inverse()?;
    let covariance = Matrix6::from_fn(|i, k| inverse[(i, k)] / (size[i] * size[k]));
    let seen = Vector6::from_fn(|c, _| dot(&columns[c], &whitened.residuals));
    let value = covariance * seen;
    Some(SideDifference {
        p_value: chi_squared_upper_tail(value.dot(&seen), 6.0),
        value: value.into(),
        u: covariance.diagonal().map(f64::sqrt).into(),
    })
}
