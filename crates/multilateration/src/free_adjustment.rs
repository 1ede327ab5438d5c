//! The adjustment with free points: every point has three unknowns of its own.
//!
//! Block unknowns are the coordinates of a group's points, shared ones the stations and dead paths, four
//! each: `x y z L`, and behind them the dead paths after interruptions.

use nalgebra::Vector3;
use trueaxis_leastsquares::{
    Adjustment, BlockBatch, Error as LeastSquaresError, Factors, Lanes, Reduced,
};

use crate::Network;
use crate::batches::{Batch, batches};
use crate::datum::Datum;
use crate::free_points::{PER_STATION, State, zero_column};
use crate::linearise::{Beams, append_weights, fill};
use crate::passes::{
    self, GroupModel, Memories, Memory, in_parallel, pieces, split_mut, try_in_parallel,
};

/// The model with its weights, which stay as they are while it is adjusted.
pub(crate) struct FreeAdjustment<'a> {
    network: &'a Network,
    datum: Datum,
    batches: Vec<Batch>,
    /// Weights of each batch as [`append_weights`] makes them.
    weights: Vec<Vec<Lanes>>,
    memories: Memories,
}

impl<'a> FreeAdjustment<'a> {
    /// The model with the weights that belong to the beams at `state`.
    pub(crate) fn new(network: &'a Network, state: &State) -> Self {
        let mut model = Self {
            network,
            datum: Datum::new(network),
            batches: batches(network),
            weights: Vec::new(),
            memories: Memories::default(),
        };
        model.update_weights(state);
        model
    }

    pub(crate) fn datum(&self) -> &Datum {
        &self.datum
    }

    /// Whether weights depend on the beams.
    pub(crate) fn weights_follow_beams(&self) -> bool {
        let noise = &self.network.noise;
        let correlated = || self.network.visits.iter().any(|v| v.readings.len() > 1);
        noise.length_sigma_relative > 0.0 || noise.return_sigma_mm > 0.0 && correlated()
    }

    /// Takes the weights from the beams at `state`.
    pub(crate) fn update_weights(&mut self, state: &State) {
        let of_piece = in_parallel(
            pieces(self.batches.len()),
            #[inline(always)]
            |piece| {
                let (mut beams, mut memory) = (Beams::default(), Vec::new());
                let of_batch = |batch: &Batch| {
                    let mut weights = Vec::new();
                    beams.fill(batch, state);
                    append_weights(
                        batch,
                        &self.network.noise,
                        &beams,
                        &mut memory,
                        &mut weights,
                    );
                    weights
                };
                self.batches[piece].iter().map(of_batch).collect::<Vec<_>>()
            },
        );
        self.weights = of_piece.into_iter().flatten().collect();
    }

    /// Makes the equations of batch `b` for a model with `shared` shared unknowns.
    #[inline(always)]
    pub(crate) fn fill_for(
        &self,
        (state, b): (&State, usize),
        shared: usize,
        beams: &mut Beams,
        equations: &mut BlockBatch,
    ) {
        let (batch, stations) = (&self.batches[b], self.network.stations.len());
        beams.fill(batch, state);
        let content = (batch, &self.weights[b][..]);
        fill(content, &self.datum, beams, (stations, shared), equations);
    }

    /// Writes to `next` the stations and dead paths moved by `factor` times the correction.
    pub(crate) fn step_stations(&self, state: &State, s: &[f64], factor: f64, next: &mut State) {
        let stations = state.stations.len();
        next.stations.clone_from(&state.stations);
        for (position, x) in next.stations.iter_mut().zip(s.chunks_exact(PER_STATION)) {
            *position += Vector3::new(x[0], x[1], x[2]) * factor;
        }
        next.dead_paths_mm.clone_from(&state.dead_paths_mm);
        for (zero, dead_path) in next.dead_paths_mm.iter_mut().enumerate() {
            *dead_path += s[zero_column(zero, stations)] * factor;
        }
    }
}

impl GroupModel for FreeAdjustment<'_> {
    type State = State;

    fn batches(&self) -> &[Batch] {
        &self.batches
    }

    fn memories(&self) -> &Memories {
        &self.memories
    }

    fn unknowns(&self, batch: &Batch) -> usize {
        3 * batch.points
    }

    fn shared(&self) -> usize {
        PER_STATION * self.network.stations.len() + self.network.interruptions.len()
    }

    #[inline(always)]
    fn fill(&self, state: &State, b: usize, memory: &mut Memory) {
        let shared = self.shared();
        self.fill_for((state, b), shared, &mut memory.beams, &mut memory.equations);
    }
}

impl Adjustment for FreeAdjustment<'_> {
    type State = State;

    fn reduce(&self, state: &State) -> Result<Reduced, LeastSquaresError> {
        passes::reduce(self, state)
    }

    fn squares(&self, state: &State) -> f64 {
        let mut memory = Memory::default();
        let of_batch = |b| {
            self.fill(state, b, &mut memory);
            let residuals = memory.equations.residual_mut().iter();
            residuals.map(|r| (*r * *r).sum()).sum::<f64>()
        };
        (0..self.batches.len()).map(of_batch).sum()
    }

    fn step(
        &self,
        state: &State,
        t: &[f64],
        factor: f64,
        next: &mut State,
    ) -> Result<(), LeastSquaresError> {
        self.step_stations(state, t, factor, next);
        let pieces = pieces(self.batches.len());
        let points = |batch: &Batch| batch.points * batch.groups.len();
        let lengths = pieces
            .iter()
            .map(|piece| self.batches[piece.clone()].iter().map(points).sum());
        let moved = split_mut(&mut next.points, lengths);
        try_in_parallel(
            pieces.into_iter().zip(moved).collect(),
            #[inline(always)]
            |(piece, moved)| {
                self.memories.lend(
                    #[inline(always)]
                    |memory| {
                        let mut moved = moved.iter_mut();
                        for b in piece {
                            passes::eliminate(self, state, b, memory)?;
                            let x = memory.equations.correction(t);
                            let batch = &self.batches[b];
                            for lane in 0..batch.groups.len() {
                                let points =
                                    &state.points[batch.first_points[lane]..][..batch.points];
                                let x = x.as_chunks::<3>().0;
                                for ((point, x), moved) in points.iter().zip(x).zip(&mut moved) {
                                    let x = x.map(|x| x.0[lane]);
                                    *moved = point + Vector3::from(x) * factor;
                                }
                            }
                        }
                        Ok(())
                    },
                )
            },
        )?;
        Ok(())
    }

    fn factors(&self, state: &State) -> Result<Factors, LeastSquaresError> {
        passes::factors(self, state)
    }

    fn free_motions(&self, state: &State) -> Vec<Vec<f64>> {
        self.datum.free_motions(state, self.shared())
    }
}
