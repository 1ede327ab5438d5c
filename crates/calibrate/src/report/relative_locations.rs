//! Locations of rotary axes relative to each other.
//!
//! Two axes with the directions `a` and `c` have, across both (`n = a × c / |a × c|`), a nominal location at the feet
//! of their common perpendicular. With shifts `o` and tilts `t` of both,
//!
//! ```text
//! offset = n·(o_c + t_c × s_c - o_a - t_a × s_a)     angle = n·(t_c - t_a)
//! ```
//!
//! alike, so neither number depends on the nests of the targets. Parallel axes have two directions across them; their
//! feet are at the reference point of `a`.

use nalgebra::{DMatrix, Point3, RowDVector, Vector3};
use trueaxis_kinematics::AxisKind;

use crate::identify::basis::Basis;
use crate::propagate::propagation::{Propagation, Uncertainty};
use crate::result::calibration::{RelativeLocation, RelativeQuantity};

/// Sine of the angle below which two axes count as parallel.
const PARALLEL_TOL: f64 = 1e-3;

/// For each pair of rotary axes, the later one in the order of the machine relative to the earlier one.
pub(crate) fn relative_locations(propagation: &Propagation<'_, '_>) -> Vec<RelativeLocation> {
    let context = propagation.dependence.context;
    let axes = 0..context.data.len();
    let rotary: Vec<usize> = axes
        .filter(|&k| context.axis(k).kind() == AxisKind::Rotary)
        .collect();
    let mut found = Vec::new();
    for (i, &a) in rotary.iter().enumerate() {
        for &c in &rotary[i + 1..] {
            found.extend(pair(propagation, c, a));
        }
    }
    found
}

/// Axis `k` of the data relative to axis `to`.
fn pair(propagation: &Propagation<'_, '_>, k: usize, to: usize) -> Vec<RelativeLocation> {
    let context = propagation.dependence.context;
    let [own, other] = [k, to].map(|k| context.axis(k));
    let [c, a] = [own, other].map(|axis| axis.direction().into_inner());
    let [of_own, of_other] = [own, other].map(|axis| axis.reference_mm());
    let normal = a.cross(&c);
    let (across, levers_mm) = if normal.norm() < PARALLEL_TOL {
        let along = c * c.dot(&(of_other - of_own));
        (Basis::of(other).across.to_vec(), [along, Vector3::zeros()])
    } else {
        (
            vec![normal.normalize()],
            to_feet([of_own, of_other], [c, a]),
        )
    };
    let locations = [k, to].map(|k| propagation.dependence.identified.state.axes[k].location);
    let relative = |n: Vector3<f64>| {
        // Offsets are stated along +y, not along -y, and so for x and z.
        let direction = n * n[n.iamax()].signum();
        let rows = rows(propagation, [k, to], direction, levers_mm);
        let unknown = |Uncertainty { u, dof, budget }| RelativeQuantity {
            value: 0.0,
            u,
            dof,
            budget,
        };
        let [offset, angle] = propagation.of_sources::<2>(&rows).map(unknown);
        let mut relative = RelativeLocation {
            axis: own.name().to_owned(),
            to: other.name().to_owned(),
            direction,
            levers_mm,
            offset,
            angle,
        };
        [relative.offset.value, relative.angle.value] = relative.of(&locations[0], &locations[1]);
        relative
    };
    across.into_iter().map(relative).collect()
}

/// The offset along `n` and the angle about it as functions of the sources.
fn rows(
    propagation: &Propagation<'_, '_>,
    [k, to]: [usize; 2],
    n: Vector3<f64>,
    levers_mm: [Vector3<f64>; 2],
) -> DMatrix<f64> {
    let dependence = propagation.dependence;
    let mut rows = DMatrix::zeros(2, dependence.sources.count);
    for (k, sign, lever_mm) in [(k, 1.0, levers_mm[0]), (to, -1.0, levers_mm[1])] {
        let of_axis = &dependence.locations[k];
        let along = |shift: Vector3<f64>, tilt: Vector3<f64>| -> RowDVector<f64> {
            let parts = [(shift, 0), (tilt, 3)];
            let [a, b] = parts.map(|(v, first)| v.transpose() * of_axis.fixed_rows::<3>(first));
            (a + b) * sign
        };
        // n·(t × s) = t·(s × n)
        let parts = [along(n, lever_mm.cross(&n)), along(Vector3::zeros(), n)];
        for (mut row, part) in rows.row_iter_mut().zip(parts) {
            row += part;
        }
    }
    rows
}

/// From points on two lines that are not parallel to the feet of their common perpendicular.
fn to_feet([p, q]: [Point3<f64>; 2], [c, a]: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    let between = q - p;
    let (cosine, of_c, of_a) = (c.dot(&a), c.dot(&between), a.dot(&between));
    let sine_squared = 1.0 - cosine * cosine;
    [
        c * ((of_c - cosine * of_a) / sine_squared),
        a * ((cosine * of_c - of_a) / sine_squared),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_feet_are_nearest_to_each_other() {
        let lines = [Point3::new(1.0, 2.0, 3.0), Point3::new(-4.0, 7.0, 0.5)];
        let directions = [
            Vector3::new(0.1, 0.2, 1.0).normalize(),
            Vector3::new(1.0, -0.3, 0.2).normalize(),
        ];
        let [s, t] = to_feet(lines, directions);
        let between = (lines[1] + t) - (lines[0] + s);
        for direction in directions {
            assert!(between.dot(&direction).abs() < 1e-12, "{between}");
        }
    }
}
