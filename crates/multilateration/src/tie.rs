//! What ties the points of eight groups to the poses of their body ([`crate::linearise`]).

use nalgebra::{DVector, Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use trueaxis_leastsquares::Lanes;

use crate::batches::Batch;
use crate::bodies::Bodies;
use crate::lane_vectors::{LaneVector, at, cross, dot, minus, plus, plus_times, times};

/// What ties the points of a batch to poses.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tie {
    /// Of the poses: the vector parts of their quaternions, the real parts, the columns of their rotation matrices,
    /// and the images of the origin, mm.
    turn: LaneVector,
    real: Lanes,
    columns: [LaneVector; 3],
    shift_mm: LaneVector,
    /// Centroids of the points, mm.
    centre_mm: LaneVector,
    /// From the centroid of each group's points to the points, mm, x y z of each.
    pub(crate) arms_mm: Vec<Lanes>,
    /// Displacements of the points by a unit of each deformation, one deformation after the other, and the column of
    /// the first among the shared unknowns.
    pub(crate) deformations: Vec<Lanes>,
    pub(crate) first: usize,
}

impl Tie {
    /// Takes the poses of the groups of a batch.
    #[inline(always)]
    pub(crate) fn take(&mut self, poses: &[Isometry3<f64>]) {
        let pose = |lane: usize| &poses[lane.min(poses.len() - 1)];
        let part = |k: usize| Lanes::from_fn(|lane| pose(lane).rotation.coords[k]);
        (self.turn, self.real) = ([part(0), part(1), part(2)], part(3));
        let along = |axis: usize| Lanes::from_fn(|lane| pose(lane).translation.vector[axis]);
        self.shift_mm = [along(0), along(1), along(2)];
    }

    /// Takes the points of a batch of a body with these deformations, the first of which has the column `first`.
    #[inline(always)]
    pub(crate) fn fill(
        &mut self,
        (batch, bodies): (&Batch, &Bodies),
        points: &[Lanes],
        (first, deformations): (usize, &[DVector<f64>]),
    ) {
        let count = batch.points;
        let mut sum = [Lanes::ZERO; 3];
        for point in 0..count {
            sum = plus(sum, at(points, point));
        }
        self.centre_mm = times(sum, Lanes::splat(1.0 / count as f64));
        self.arms_mm.clear();
        for point in 0..count {
            self.arms_mm
                .extend(minus(at(points, point), self.centre_mm));
        }
        self.first = first;
        self.columns = columns(self.turn, self.real);
        self.deformations.clear();
        for deformation in deformations {
            for point in 0..count {
                let moved = |place: usize| &deformation.as_slice()[3 * place..][..3];
                let moved = batch.of_places(bodies, point, moved);
                self.deformations.extend(turned(self.columns, moved));
            }
        }
    }

    /// Moves the poses by a shift and a turn about the centroid of the points. The turn is the quaternion `1 + ½ω`,
    /// of the angle `2 atan ½|ω|`: this needs no sine, and the angle is short by a twelfth of its third power.
    #[inline(always)]
    pub(crate) fn move_by(&mut self, [shift, turn]: [LaneVector; 2]) {
        let (one, half) = (Lanes::splat(1.0), times(turn, Lanes::splat(0.5)));
        let per_square = one / (one + dot(half, half));
        let norm = per_square.sqrt();
        let across = plus(times(half, self.real), cross(half, self.turn));
        let real = self.real - dot(half, self.turn);
        (self.turn, self.real) = (times(plus(self.turn, across), norm), real * norm);
        self.columns = columns(self.turn, self.real);
        let across = cross(half, minus(self.shift_mm, self.centre_mm));
        let twice = plus(across, cross(half, across));
        let by = times(twice, per_square + per_square);
        self.shift_mm = plus(plus(self.shift_mm, by), shift);
    }

    /// Writes the positions of the points of a body with this shape in the poses.
    #[inline(always)]
    pub(crate) fn put(
        &self,
        (batch, bodies): (&Batch, &Bodies),
        shape_mm: &[Point3<f64>],
        points: &mut [Lanes],
    ) {
        for (point, place_mm) in points.chunks_exact_mut(3).enumerate() {
            let home_mm = |place: usize| shape_mm[place].coords.as_slice();
            let home_mm = batch.of_places(bodies, point, home_mm);
            place_mm.copy_from_slice(&plus(turned(self.columns, home_mm), self.shift_mm));
        }
    }

    /// The pose in a lane.
    #[inline(always)]
    pub(crate) fn pose(&self, lane: usize) -> Isometry3<f64> {
        let ([x, y, z], [i, j, k]) = (&self.shift_mm, &self.turn);
        let [x, y, z] = [x.0[lane], y.0[lane], z.0[lane]];
        let turn = Quaternion::new(self.real.0[lane], i.0[lane], j.0[lane], k.0[lane]);
        Isometry3::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::new_unchecked(turn),
        )
    }
}

/// The columns of the matrices of rotations, from their quaternions.
#[inline(always)]
fn columns([i, j, k]: LaneVector, w: Lanes) -> [LaneVector; 3] {
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

/// The product of matrices with these columns and vectors.
#[inline(always)]
fn turned([x, y, z]: [LaneVector; 3], [a, b, c]: LaneVector) -> LaneVector {
    plus_times(plus_times(times(x, a), b, y), c, z)
}
