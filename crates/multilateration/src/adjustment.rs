//! The adjustment of a network: the linearised lengths, group by group.
//!
//! Block unknowns are those of the groups: the coordinates of free points, or the six of the pose of a
//! body ([`crate::linearise`]). Shared unknowns are the stations and dead paths, four each: `x y z L`, behind
//! them the dead paths after interruptions, behind these the deformations of all bodies, the mean constant of the
//! reflectors where dead paths are known, and last the contrasts of these constants.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use trueaxis_leastsquares::{BlockBatch, Lanes, Reduced, zeros};

use crate::batches::Batch;
use crate::beams::take_points;
use crate::bodies::Deformations;
use crate::datum::Datum;
use crate::known::{Columns, KnownRow};
use crate::lane_vectors::{add, at, times};
use crate::linearise::fill;
use crate::memory::{Gauge, Memories, Memory};
use crate::state::{PER_STATION, State, zero_column};
use crate::visit_weights::{by_visit, fill_weights};
use crate::{Bodies, Network};

/// A network as an adjustment model.
pub(crate) struct GroupAdjustment<'a> {
    pub(crate) network: &'a Network,
    pub(crate) datum: Datum,
    deformations: Deformations,
    columns: Columns,
    pub(crate) batches: Arc<Vec<Batch>>,
    pub(crate) memories: Memories,
}

/// What the linearisation of a piece leaves to the step that follows, batch after batch.
#[derive(Debug, Default)]
pub(crate) struct Linearised {
    /// As [`fill_weights`] makes them.
    pub(crate) weights: Vec<Lanes>,
    /// As [`BlockBatch::keep`](trueaxis_leastsquares::BlockBatch::keep) appends it.
    pub(crate) eliminated: Vec<Lanes>,
}

impl Linearised {
    /// The same memory with nothing in it, but room for what some batches leave.
    pub(crate) fn cleared(&mut self, batches: &[Batch]) -> &mut Self {
        self.weights.clear();
        self.weights
            .reserve(batches.iter().map(Batch::weights).sum());
        let kept = batches.iter().map(|b| BlockBatch::kept_len(b.unknowns()));
        self.eliminated.clear();
        self.eliminated.reserve(kept.sum());
        self
    }
}

/// The points and poses of the groups of some batches, to be moved.
pub(crate) struct Moved<'a> {
    pub(crate) points: &'a mut [Point3<f64>],
    /// Empty in a network without bodies.
    pub(crate) poses: &'a mut [Isometry3<f64>],
}

impl<'a> GroupAdjustment<'a> {
    /// The model of a network with these groups.
    pub(crate) fn new(network: &'a Network, batches: &Arc<Vec<Batch>>) -> Self {
        let deformations = deformations(network);
        Self {
            network,
            datum: Datum::new(network),
            columns: Columns::new(network, deformations.shared),
            deformations,
            batches: Arc::clone(batches),
            memories: Memories::default(),
        }
    }

    /// Number of shared unknowns.
    pub(crate) fn shared(&self) -> usize {
        self.columns.count
    }

    /// What is known of them, at a state.
    pub(crate) fn known_rows(&self, state: &State) -> Vec<KnownRow> {
        self.network.known_rows(self.columns, state)
    }

    /// Makes the whitened equations of batch `b`, with the weights that belong to the state.
    #[inline(always)]
    pub(crate) fn fill(&self, state: &State, b: usize, gauge: Gauge, memory: &mut Memory) {
        let batch = &self.batches[b];
        self.fill_rows(state, b, gauge, memory);
        let Memory {
            beams,
            weights,
            factor,
            equations,
            ..
        } = memory;
        zeros(weights, batch.weights());
        fill_weights(batch, &self.network.noise, beams, factor, weights);
        for (first, count, weights) in by_visit(batch, weights) {
            equations.whiten(first, count, weights);
        }
    }

    /// Makes the equations of batch `b` without weights.
    #[inline(always)]
    fn fill_rows(&self, state: &State, b: usize, gauge: Gauge, memory: &mut Memory) {
        let batch = &self.batches[b];
        let Memory {
            beams,
            equations,
            tie,
            ..
        } = memory;
        take_points(batch, batch.own(&state.points), &mut beams.points);
        beams.fill(batch, state.common());
        let tie = match self.body_of(batch) {
            Some((bodies, body)) => {
                let Deformations {
                    of_bodies, first, ..
                } = &self.deformations;
                tie.take(&state.poses[batch.groups.clone()]);
                let deformations = (first[body], &of_bodies[body][..]);
                tie.fill((batch, bodies), &beams.points, deformations);
                Some(&*tie)
            }
            None => None,
        };
        let datum = (gauge == Gauge::Datum).then_some((&self.datum, &self.network.nominal_mm[..]));
        let sizes = (self.network.stations.len(), self.shared());
        fill(batch, tie, datum, beams, sizes, equations);
    }

    /// The body that the points of a batch are tied to.
    #[inline(always)]
    fn body_of(&self, batch: &Batch) -> Option<(&Bodies, usize)> {
        self.network.bodies.as_deref().zip(batch.body)
    }

    /// Adds what is known of shared unknowns.
    pub(crate) fn observe_known(&self, state: &State, reduced: &mut Reduced) {
        for row in self.known_rows(state) {
            reduced.observe(&row.columns, row.residual);
        }
    }

    /// Moves stations, dead paths and shapes by `factor` times the correction `s`.
    pub(crate) fn step_shared(&self, state: &State, s: &[f64], factor: f64, next: &mut State) {
        let stations = state.stations.len();
        next.stations.clone_from(&state.stations);
        for (position, x) in next.stations.iter_mut().zip(s.chunks_exact(PER_STATION)) {
            *position += Vector3::new(x[0], x[1], x[2]) * factor;
        }
        next.dead_paths_mm.clone_from(&state.dead_paths_mm);
        for (zero, dead_path) in next.dead_paths_mm.iter_mut().enumerate() {
            *dead_path += s[zero_column(zero, stations)] * factor;
        }
        next.mean_constant_mm = state.mean_constant_mm;
        if self.network.has_mean_constant() {
            next.mean_constant_mm += s[self.columns.mean_constant] * factor;
        }
        next.contrasts_mm.clone_from(&state.contrasts_mm);
        let contrasts = next.contrasts_mm.iter_mut();
        for (contrast, x) in contrasts.zip(&s[self.columns.contrasts..]) {
            *contrast += x * factor;
        }
        next.shapes_mm.clone_from(&state.shapes_mm);
        let deformations = &self.deformations;
        for (b, shape_mm) in next.shapes_mm.iter_mut().enumerate() {
            let amounts = s[deformations.first[b]..].iter().map(|x| x * factor);
            for (deformation, amount) in deformations.of_bodies[b].iter().zip(amounts) {
                for (place, point) in shape_mm.iter_mut().enumerate() {
                    *point += deformation.fixed_rows::<3>(3 * place) * amount;
                }
            }
        }
    }

    /// Moves the points of batch `b` by `factor` times what follows from the correction `s`, with the weights and
    /// the eliminated equations of its linearisation; the bodies have the new shapes.
    #[inline(always)]
    pub(crate) fn move_groups(
        &self,
        (state, b): (&State, usize),
        (weights, eliminated): (&[Lanes], &[Lanes]),
        (s, factor): (&[f64], f64),
        shapes_mm: &[Vec<Point3<f64>>],
        (memory, moved): (&mut Memory, &mut Moved<'_>),
    ) {
        let batch = &self.batches[b];
        self.fill_rows(state, b, Gauge::Free, memory);
        let equations = &mut memory.equations;
        equations.take_off(s);
        for (first, count, weights) in by_visit(batch, weights) {
            equations.weigh(first, count, weights);
        }
        let x = equations.correction(eliminated);
        let by = |k: usize| times(at(x, k), Lanes::splat(factor));
        let (tie, points) = (&mut memory.tie, &mut memory.beams.points);
        match self.body_of(batch) {
            Some((bodies, body)) => {
                tie.move_by([by(0), by(1)]);
                tie.put((batch, bodies), &shapes_mm[body], points);
                for (lane, pose) in moved.poses.iter_mut().enumerate() {
                    *pose = tie.pose(lane);
                }
            }
            None => (0..batch.points).for_each(|k| add(&mut points[3 * k..], by(k))),
        }
        for (lane, group) in moved.points.chunks_exact_mut(batch.points).enumerate() {
            for (point, place) in group.iter_mut().zip(points.chunks_exact(3)) {
                *point = Point3::new(place[0].0[lane], place[1].0[lane], place[2].0[lane]);
            }
        }
    }
}

/// The deformations of the bodies of a network: behind stations and dead paths.
pub(crate) fn deformations(network: &Network) -> Deformations {
    let behind = PER_STATION * network.stations.len() + network.interruptions.len();
    Deformations::new(network.bodies.as_deref(), behind)
}
