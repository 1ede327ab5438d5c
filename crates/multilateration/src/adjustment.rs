//! The adjustment of a network: the linearised lengths, group by group; [`crate::passes`] goes through all of them.
//!
//! Block unknowns belong to one group: the coordinates of its free points, or the six of the pose of its body
//! ([`crate::linearise`]). Shared unknowns are, in this order, `x y z L` of each station (position and dead path),
//! the dead paths after interruptions, the deformations of all bodies, the mean constant of the reflectors where dead
//! paths are known, and the contrasts of the reflectors' constants.

use std::sync::Arc;

use nalgebra::Vector3;
use trueaxis_leastsquares::Lanes;

use crate::batches::Batch;
use crate::beams::take_points;
use crate::bodies::Deformations;
use crate::datum::Datum;
use crate::known::{Columns, KnownRow};
use crate::linearise::fill;
use crate::memory::{Constraints, Memories, Memory};
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

impl<'a> GroupAdjustment<'a> {
    /// The model of a network with these groups.
    pub(crate) fn new(network: &'a Network, batches: &Arc<Vec<Batch>>) -> Self {
        let deformations = Deformations::new(network);
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

    /// What is known of the shared unknowns, at a state.
    pub(crate) fn known_rows(&self, state: &State) -> Vec<KnownRow> {
        self.network.known_rows(self.columns, state)
    }

    /// Makes the whitened equations of batch `b`, with the weights that belong to the state.
    #[inline(always)]
    pub(crate) fn fill(
        &self,
        state: &State,
        b: usize,
        constraints: Constraints,
        memory: &mut Memory,
    ) {
        let batch = &self.batches[b];
        self.take(state, batch, memory);
        memory.beams.fill(batch, state.common());
        self.fill_rows(batch, constraints, memory);
        self.weigh(batch, memory);
    }

    /// Takes the points of a batch and, if it has a body, the poses that tie them.
    #[inline(always)]
    pub(crate) fn take(&self, state: &State, batch: &Batch, memory: &mut Memory) {
        take_points(batch, batch.own(&state.points), &mut memory.beams.points);
        if batch.body.is_some() {
            memory.tie.take(&state.poses[batch.groups.clone()]);
        }
    }

    /// Makes the equations of a batch whose beams are filled, without weights.
    #[inline(always)]
    pub(crate) fn fill_rows(&self, batch: &Batch, constraints: Constraints, memory: &mut Memory) {
        let Memory {
            beams,
            equations,
            tie,
            ..
        } = memory;
        let tie = match self.body_of(batch) {
            Some((bodies, body)) => {
                let Deformations {
                    of_bodies, first, ..
                } = &self.deformations;
                let deformations = (first[body], &of_bodies[body][..]);
                tie.fill((batch, bodies), &beams.points, deformations);
                Some(&*tie)
            }
            None => None,
        };
        let datum = (constraints == Constraints::Datum)
            .then_some((&self.datum, &self.network.nominal_mm[..]));
        let sizes = (self.network.stations.len(), self.shared());
        fill(batch, tie, datum, beams, sizes, equations);
    }

    /// Makes the weights of a batch, and multiplies its equations by them.
    #[inline(always)]
    pub(crate) fn weigh(&self, batch: &Batch, memory: &mut Memory) {
        let Memory {
            beams,
            weights,
            factor,
            equations,
            ..
        } = memory;
        weights.resize(batch.layout.weights, Lanes::ZERO);
        fill_weights(batch, &self.network.noise, beams, factor, weights);
        for (first, count, weights) in by_visit(batch, weights) {
            equations.whiten(first, count, weights);
        }
    }

    /// The body that the points of a batch are tied to.
    #[inline(always)]
    pub(crate) fn body_of(&self, batch: &Batch) -> Option<(&Bodies, usize)> {
        self.network.bodies.as_deref().zip(batch.body)
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
}
