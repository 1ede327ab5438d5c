//! What ties the points of eight groups to the poses of their body ([`crate::linearise`]).

use nalgebra::{DVector, Matrix3};
use trueaxis_leastsquares::{LANES, Lanes};

use crate::batches::Batch;
use crate::bodies::Bodies;
use crate::lane_vectors::{LaneVector, at, minus, plus, times};
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
        let groups: [usize; LANES] = std::array::from_fn(group);
        let mut rotations = [Matrix3::zeros(); LANES];
        let mut places: [&[usize]; LANES] = [&[]; LANES];
        for (lane, &g) in groups.iter().enumerate() {
            rotations[lane] = state.poses[g].rotation.to_rotation_matrix().into_inner();
            places[lane] = &bodies.of_groups[g].places;
        }
        let column = |j: usize| -> LaneVector {
            [
                Lanes::from_fn(|lane| rotations[lane][(0, j)]),
                Lanes::from_fn(|lane| rotations[lane][(1, j)]),
                Lanes::from_fn(|lane| rotations[lane][(2, j)]),
            ]
        };
        let (x, y, z) = (column(0), column(1), column(2));
        self.deformations.clear();
        for deformation in deformations {
            let deformation = deformation.as_slice();
            for point in 0..count {
                let home = |axis: usize| {
                    Lanes::from_fn(|lane| deformation[3 * places[lane][point] + axis])
                };
                let turned = plus(
                    plus(times(x, home(0)), times(y, home(1))),
                    times(z, home(2)),
                );
                self.deformations.extend(turned);
            }
        }
    }
}
