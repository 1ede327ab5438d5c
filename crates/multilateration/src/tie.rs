//! What ties the points of eight groups to the poses of their body ([`crate::linearise`]).

use nalgebra::{DVector, UnitQuaternion};
use trueaxis_leastsquares::Lanes;

use crate::batches::Batch;
use crate::bodies::Bodies;
use crate::lane_vectors::{LaneVector, at, minus, plus, splat, times};
use crate::state::State;

/// What ties the points of a batch to poses.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tie {
    /// From the centroid of each group's points to these, mm, x y z of each.
    pub(crate) arms_mm: Vec<Lanes>,
    /// What a unit of each deformation does to the points, one deformation after the other, and the column of
    /// the first among the shared unknowns.
    pub(crate) deformations: Vec<Lanes>,
    pub(crate) first: usize,
}

impl Tie {
    /// Takes the points of a batch of a body with these deformations, the first of which has the column
    /// `first`.
    #[inline(always)]
    pub(crate) fn fill(
        &mut self,
        batch: &Batch,
        (state, points): (&State, &[Lanes]),
        bodies: &Bodies,
        (first, deformations): (usize, &[DVector<f64>]),
    ) {
        let count = batch.points;
        let mut sum = [Lanes::ZERO; 3];
        for point in 0..count {
            sum = plus(sum, at(points, point));
        }
        let centre = times(sum, Lanes::splat(1.0 / count as f64));
        self.arms_mm.clear();
        for point in 0..count {
            self.arms_mm.extend(minus(at(points, point), centre));
        }
        self.first = first;
        let group = |lane: usize| batch.groups.start + lane.min(batch.groups.len() - 1);
        let [x, y, z] = columns_of_rotations(|lane| &state.poses[group(lane)].rotation);
        let places = |lane: usize| &bodies.of_groups[group(lane)].places[..];
        // Most groups see the targets of their body in one order.
        let are_alike = (1..batch.groups.len()).all(|lane| places(lane) == places(0));
        self.deformations.clear();
        for deformation in deformations {
            let deformation = deformation.as_slice();
            for point in 0..count {
                let moved = |lane: usize| &deformation[3 * places(lane)[point]..][..3];
                let [a, b, c] = match are_alike {
                    true => splat(moved(0)[0], moved(0)[1], moved(0)[2]),
                    false => [
                        Lanes::from_fn(|lane| moved(lane)[0]),
                        Lanes::from_fn(|lane| moved(lane)[1]),
                        Lanes::from_fn(|lane| moved(lane)[2]),
                    ],
                };
                let turned = plus(plus(times(x, a), times(y, b)), times(z, c));
                self.deformations.extend(turned);
            }
        }
    }
}

/// The columns of the matrices of eight rotations.
#[inline(always)]
fn columns_of_rotations<'q>(
    rotation: impl Fn(usize) -> &'q UnitQuaternion<f64>,
) -> [LaneVector; 3] {
    let part = |k: usize| Lanes::from_fn(|lane| rotation(lane).coords[k]);
    let (i, j, k, w) = (part(0), part(1), part(2), part(3));
    let two = Lanes::splat(2.0);
    let (ii, jj, kk, ww) = (i * i, j * j, k * k, w * w);
    let (ij, ik, jk) = (i * j * two, i * k * two, j * k * two);
    let (wi, wj, wk) = (w * i * two, w * j * two, w * k * two);
    [
        [ww + ii - jj - kk, wk + ij, ik - wj],
        [ij - wk, ww - ii + jj - kk, wi + jk],
        [wj + ik, jk - wi, ww - ii - jj + kk],
    ]
}
