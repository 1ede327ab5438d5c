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
use trueaxis_campaign::Direction;
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_multilateration::{Visit, Whitened};

use crate::lengths::LengthsAdjustment;
use crate::settings::Method;
use crate::words::stop_of;

/// Forward minus backward approach, the mean over the positions of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideDifference {
    /// δ of the reference point (mm) and ε (rad).
    pub value: [f64; 6],
    /// Standard uncertainties, mm and rad.
    pub u: [f64; 6],
    /// Probability of a difference as significant if the sides are the same.
    pub p_value: f64,
}

/// Significance of all axes together: one clean campaign in a thousand.
const LEVEL: f64 = 1e-3;

/// What is left of a column, relative to its squares, below which the lengths do not show its component.
const VISIBLE: f64 = 1e-8;

impl LengthsAdjustment<'_> {
    /// For each of some axes of the machine the difference forward minus backward, where both sides were
    /// measured, share their poses in the joint adjustment and differ significantly; `reference_mm` is
    /// where the reference point of the axis under test is at a step of the campaign.
    pub fn side_differences(
        &self,
        axes: &[usize],
        reference_mm: impl Fn(usize) -> Point3<f64>,
    ) -> Vec<Option<SideDifference>> {
        let mut found = vec![None; axes.len()];
        let (campaign, screened) = (self.campaign, &self.screened);
        if self.settings.method != Method::Joint || self.settings.by_direction {
            return found;
        }
        // Whether an axis was measured backward and forward.
        let mut measured = vec![[false; 2]; campaign.machine.axes().len()];
        for visit in &screened.network.visits {
            // All its lengths may have been removed.
            let Some(first) = visit.readings.clone().next() else {
                continue;
            };
            let stop = stop_of(self.lengths, screened.kept[first]);
            if let Some(axis) = campaign.axis_under_test(stop.step) {
                measured[axis][usize::from(stop.direction == Direction::Forward)] = true;
            }
        }
        let both = |axis: &usize| measured[*axis] == [true; 2];
        let two_sided = axes.iter().filter(|axis| both(axis)).count();
        if two_sided == 0 || screened.solution.degrees_of_freedom() == 0 {
            return found;
        }
        let sides = self.sides();
        let whitened = Whitened::new(&screened.network, &screened.solution);
        for (found, axis) in found.iter_mut().zip(axes).filter(|(_, axis)| both(axis)) {
            let row = |side: &Side| {
                if campaign.axis_under_test(side.step) != Some(*axis)
                    || !self.groups[side.group].moved
                {
                    return Vector6::zeros();
                }
                let arm_mm = side.point_mm - reference_mm(side.step);
                let by_rotation = arm_mm.cross(&side.beam);
                let half = 0.5 * side.sign;
                Vector6::from_iterator(side.beam.iter().chain(&by_rotation).map(|x| half * x))
            };
            let rows: Vec<Vector6<f64>> = sides.iter().map(row).collect();
            let difference = difference(&whitened, &rows);
            *found = difference.filter(|d| d.p_value < LEVEL / two_sided as f64);
        }
        found
    }

    /// The used lengths in measuring order.
    fn sides(&self) -> Vec<Side> {
        let (network, solution) = (&self.screened.network, &self.screened.solution);
        let side = |visit: &Visit, reading: usize| {
            let stop = stop_of(self.lengths, self.screened.kept[reading]);
            let point = network.groups[visit.group].start + network.readings[reading].point;
            let point_mm = solution.points_mm[point];
            let beam = point_mm - solution.stations[visit.station].position_mm;
            Side {
                step: stop.step,
                group: visit.group,
                sign: f64::from(stop.direction.sign()),
                beam: beam.normalize(),
                point_mm,
            }
        };
        let mut sides = Vec::with_capacity(network.readings.len());
        for visit in &network.visits {
            sides.extend(visit.readings.clone().map(|reading| side(visit, reading)));
        }
        sides
    }
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
