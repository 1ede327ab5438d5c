//! The adjustment with rigid stages: every group of points has the six unknowns of its pose.
//!
//! The equations are those of free points ([`crate::linearise`]), tied to poses and shapes
//! ([`crate::rigid_stages`]).

use std::sync::Arc;

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use trueaxis_leastsquares::{
    Adjustment, BlockBatch, Error as LeastSquaresError, Factors, LANES, Lanes, Reduced, Shape,
};

use crate::Network;
use crate::batches::{Batch, batches};
use crate::bodies::Bodies;
use crate::free_adjustment::FreeAdjustment;
use crate::free_points::State;
use crate::passes::{self, Gauge, GroupModel, Memories, Memory, pieces, try_in_parallel};
use crate::reweighting::Reweighted;
use crate::rigid_stages::{Deformations, POSE, RigidState};

/// The model with its weights, which stay as they are while it is adjusted.
pub(crate) struct RigidAdjustment<'a> {
    free: FreeAdjustment<'a>,
    network: &'a Network,
    bodies: &'a Bodies,
    deformations: Deformations,
}

impl<'a> RigidAdjustment<'a> {
    /// The model with the weights that belong to the beams at `state`.
    pub(crate) fn new(network: &'a Network, bodies: &'a Bodies, state: &State) -> Self {
        // Points that few stations see are tied to others.
        let batches = Arc::new(batches(network));
        let free = FreeAdjustment::new(network, &batches, state);
        Self {
            deformations: Deformations::new(bodies, GroupModel::shared(&free)),
            free,
            network,
            bodies,
        }
    }
}

impl RigidAdjustment<'_> {
    /// Ties the points of a batch to their poses: `A_pose = A T`, `B_deformation = A D`,
    /// `H_pose = Tᵀ H`. The datum of the covariance takes shapes as they are.
    #[inline(always)]
    fn tie(&self, state: &RigidState, batch: &Batch, memory: &mut Memory) {
        let Memory {
            beams,
            of_points,
            equations,
        } = memory;
        equations.reset(Shape {
            unknowns: POSE,
            shared: self.deformations.shared,
            ..of_points.shape()
        });
        equations.take_shared(of_points);
        let constraints = of_points.shape().datum;
        let centre = centroid(&beams.points);
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
        self.add_deformations(state, batch, of_points, equations);
        equations.use_only(batch.groups.len());
    }

    #[inline(always)]
    fn add_deformations(
        &self,
        state: &RigidState,
        batch: &Batch,
        of_points: &BlockBatch,
        equations: &mut BlockBatch,
    ) {
        let group = |lane: usize| batch.groups.start + lane.min(batch.groups.len() - 1);
        for (body, deformations) in self.deformations.of_bodies.iter().enumerate() {
            for (k, deformation) in deformations.iter().enumerate() {
                let moved: [Vec<Vector3<f64>>; LANES] = std::array::from_fn(|lane| {
                    let group = group(lane);
                    let places = &self.bodies.places[group];
                    let own = self.bodies.body_of_group[group] == body;
                    let rotation = &state.poses[group].rotation;
                    let at_home = |&place: &usize| {
                        rotation * deformation.fixed_rows::<3>(3 * place).into_owned()
                    };
                    match own {
                        true => places.iter().map(at_home).collect(),
                        false => vec![Vector3::zeros(); batch.points],
                    }
                });
                let column = equations.other_mut(self.deformations.first[body] + k);
                for coordinate in 0..3 * batch.points {
                    let factor = Lanes::from_fn(|lane| moved[lane][coordinate / 3][coordinate % 3]);
                    add(column, of_points.own(coordinate), factor);
                }
            }
        }
    }
}

/// Mean of some points, x y z of each.
#[inline(always)]
fn centroid(points: &[Lanes]) -> [Lanes; 3] {
    let mut sum = [Lanes::ZERO; 3];
    for (coordinate, x) in points.iter().enumerate() {
        sum[coordinate % 3] += *x;
    }
    let share = Lanes::splat(3.0 / points.len() as f64);
    sum.map(|x| x * share)
}

/// `sum += factor · column`.
#[inline(always)]
fn add(sum: &mut [Lanes], column: &[Lanes], factor: Lanes) {
    for (s, x) in sum.iter_mut().zip(column) {
        *s = factor.mul_add(*x, *s);
    }
}

impl GroupModel for RigidAdjustment<'_> {
    type State = RigidState;

    fn batches(&self) -> &[Batch] {
        self.free.batches()
    }

    fn memories(&self) -> &Memories {
        self.free.memories()
    }

    #[inline(always)]
    fn weights_of(&self, b: usize) -> &[Lanes] {
        self.free.weights_of(b)
    }

    fn unknowns(&self, _: &Batch) -> usize {
        POSE
    }

    fn shared(&self) -> usize {
        self.deformations.shared
    }

    #[inline(always)]
    fn fill(&self, state: &RigidState, b: usize, gauge: Gauge, memory: &mut Memory) {
        let shared = GroupModel::shared(&self.free);
        self.free.fill_for(
            (&state.free, b),
            (shared, gauge),
            &mut memory.beams,
            &mut memory.of_points,
        );
        self.tie(state, &self.free.batches()[b], memory);
    }
}

impl Reweighted for RigidAdjustment<'_> {
    fn weights_follow_beams(&self) -> bool {
        self.free.weights_follow_beams()
    }

    fn update_weights(&mut self, state: &RigidState) {
        self.free.update_weights(&state.free);
    }

    fn moved(&self, from: &RigidState, to: &RigidState) -> f64 {
        self.free.moved(&from.free, &to.free)
    }
}

impl Adjustment for RigidAdjustment<'_> {
    type State = RigidState;

    fn reduce(&self, state: &RigidState) -> Result<Reduced, LeastSquaresError> {
        passes::reduce(self, state, Gauge::Free)
    }

    fn reduce_with_datum(&self, state: &RigidState) -> Result<Reduced, LeastSquaresError> {
        passes::reduce(self, state, Gauge::Datum)
    }

    fn squares(&self, state: &RigidState) -> f64 {
        self.free.squares(&state.free)
    }

    fn step(
        &self,
        state: &RigidState,
        s: &[f64],
        factor: f64,
        next: &mut RigidState,
    ) -> Result<(), LeastSquaresError> {
        self.free
            .step_stations(&state.free, s, factor, &mut next.free);
        let batches = self.free.batches();
        let poses = try_in_parallel(
            pieces(batches.len()),
            #[inline(always)]
            |piece| {
                let mut poses = Vec::new();
                self.memories().lend(
                    #[inline(always)]
                    |memory| {
                        for b in piece {
                            passes::eliminate(self, state, b, Gauge::Free, memory)?;
                            let x = memory.equations.correction(s);
                            for (lane, group) in batches[b].groups.clone().enumerate() {
                                let x = |k: usize| x[k].0[lane] * factor;
                                let centre = state.centroid(self.network, group).coords;
                                let turn = UnitQuaternion::from_scaled_axis(Vector3::new(
                                    x(3),
                                    x(4),
                                    x(5),
                                ));
                                let shift =
                                    Translation3::from(Vector3::new(x(0), x(1), x(2)) + centre);
                                let pose = shift * turn * Translation3::from(-centre);
                                poses.push(pose * state.poses[group]);
                            }
                        }
                        Ok(())
                    },
                )?;
                Ok(poses)
            },
        )?;
        next.poses.clear();
        next.poses.extend(poses.into_iter().flatten());
        next.shapes_mm.clone_from(&state.shapes_mm);
        for (b, shape_mm) in next.shapes_mm.iter_mut().enumerate() {
            for (k, deformation) in self.deformations.of_bodies[b].iter().enumerate() {
                let amount = s[self.deformations.first[b] + k] * factor;
                for (place, point) in shape_mm.iter_mut().enumerate() {
                    *point += deformation.fixed_rows::<3>(3 * place) * amount;
                }
            }
        }
        next.place_points(self.network, self.bodies);
        Ok(())
    }

    fn factors(&self, state: &RigidState) -> Result<Factors, LeastSquaresError> {
        passes::factors(self, state)
    }

    fn free_motions(&self, state: &RigidState) -> Vec<Vec<f64>> {
        self.free
            .datum()
            .free_motions(&state.free, self.deformations.shared)
    }

    fn settle(&self, state: &mut RigidState) {
        let motion = self.free.datum().motion(self.network, &state.free.points);
        state.free.move_by(&motion);
        for pose in &mut state.poses {
            *pose = motion * *pose;
        }
    }
}
