//! The equations of points tied to the pose of a body.
//!
//! With the home positions `r_k` of the body's targets, common to all groups, and a free pose in each,
//!
//! ```text
//! p_k = R r_k + t       dp_k = dt + dω × (p_k - c) + R N_k ds
//! ```
//!
//! where `c` is the centroid of the group's points and `s` are the deformations of the body that no motion
//! makes (three for a triangle). Against free points this ties nine coordinates of a triangle to six
//! unknowns.

use nalgebra::DVector;
use trueaxis_leastsquares::{BlockBatch, LANES, Lanes, Shape};

use crate::batches::Batch;
use crate::bodies::Bodies;
use crate::linearise::Beams;
use crate::state::{POSE, State};

/// Ties the equations of the points of a batch to poses: `A_pose = A T`, `B_deformation = A D`,
/// `H_pose = Tᵀ H`. The datum takes shapes as they are. The deformations come with the column of the first.
#[inline(always)]
pub(crate) fn tie(
    (batch, bodies): (&Batch, &Bodies),
    (state, beams): (&State, &Beams),
    (first, deformations): (usize, &[DVector<f64>]),
    of_points: &BlockBatch,
    equations: &mut BlockBatch,
) {
    equations.reset(Shape {
        unknowns: POSE,
        ..of_points.shape()
    });
    equations.take_shared(of_points);
    let constraints = of_points.shape().datum;
    let centre = beams.centroid();
    for coordinate in 0..beams.points.len() {
        let axis = coordinate % 3;
        let column = of_points.own(coordinate);
        add(equations.own_mut(axis), column, Lanes::splat(1.0));
        for k in 0..constraints {
            equations.datum_mut(k)[axis] += of_points.datum(k)[coordinate];
        }
        // Row `axis` of -[arm]×: the rotations about the other two axes move this coordinate.
        let arm = |axis: usize| beams.points[coordinate - coordinate % 3 + axis] - centre[axis];
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        for (about, lever) in [(next, arm(last)), (last, -arm(next))] {
            add(equations.own_mut(3 + about), column, lever);
            for k in 0..constraints {
                equations.datum_mut(k)[3 + about] += of_points.datum(k)[coordinate] * lever;
            }
        }
    }
    for (k, deformation) in deformations.iter().enumerate() {
        let moved = moved_by(deformation, batch, bodies, state);
        let column = equations.other_mut(first + k);
        for (coordinate, factor) in moved.into_iter().enumerate() {
            add(column, of_points.own(coordinate), factor);
        }
    }
    equations.use_only(batch.groups.len());
}

/// What a unit of a deformation does to the coordinates of the points of a batch.
pub(crate) fn moved_by(
    deformation: &DVector<f64>,
    batch: &Batch,
    bodies: &Bodies,
    state: &State,
) -> Vec<Lanes> {
    let mut moved = vec![Lanes::ZERO; 3 * batch.points];
    for lane in 0..LANES {
        let group = batch.groups.start + lane.min(batch.groups.len() - 1);
        let rotation = &state.poses[group].rotation;
        for (point, &place) in bodies.of_groups[group].places.iter().enumerate() {
            let displaced = rotation * deformation.fixed_rows::<3>(3 * place).into_owned();
            for (axis, x) in displaced.iter().enumerate() {
                moved[3 * point + axis].0[lane] = *x;
            }
        }
    }
    moved
}

/// `sum += factor · column`.
#[inline(always)]
fn add(sum: &mut [Lanes], column: &[Lanes], factor: Lanes) {
    for (s, x) in sum.iter_mut().zip(column) {
        *s = factor.mul_add(*x, *s);
    }
}
