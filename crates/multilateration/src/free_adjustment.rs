//! The adjustment with free points: every point has three unknowns of its own.
//!
//! Block unknowns are the coordinates of a group's points, shared ones the stations and dead paths, four
//! each: `x y z L`, and behind them the dead paths after interruptions.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use trueaxis_leastsquares::{
    Adjustment, BlockBatch, Error as LeastSquaresError, Factors, LaneSums, Lanes, Reduced,
};

use crate::Network;
use crate::batches::Batch;
use crate::datum::Datum;
use crate::free_points::{PER_STATION, State, zero_column};
use crate::linearise::{Beams, fill, fill_weights};
use crate::passes::{
    self, Gauge, GroupModel, Memories, Memory, in_parallel, pieces, split_mut, try_in_parallel,
};
use crate::plain_batches;
use crate::reweighting::Reweighted;

/// The model with its weights, which stay as they are while it is adjusted.
pub(crate) struct FreeAdjustment<'a> {
    network: &'a Network,
    datum: Datum,
    batches: Arc<Vec<Batch>>,
    /// Weights of the batches as [`fill_weights`] makes them.
    weights: Vec<Lanes>,
    /// Those of each batch: within a piece, the same ones as of the batch before if they are equal.
    weight_ranges: Vec<Range<usize>>,
    memories: Memories,
}

impl<'a> FreeAdjustment<'a> {
    /// The model with the weights that belong to the beams at `state`.
    pub(crate) fn new(network: &'a Network, batches: &Arc<Vec<Batch>>, state: &State) -> Self {
        let mut model = Self {
            network,
            datum: Datum::new(network),
            batches: Arc::clone(batches),
            weights: Vec::new(),
            weight_ranges: Vec::with_capacity(batches.len()),
            memories: Memories::default(),
        };
        let by_beams = model.weights_follow_beams();
        let mut end = 0;
        for piece in pieces(batches.len()) {
            for b in piece.clone() {
                let batch = &batches[b];
                let is_new = by_beams || b == piece.start || !batch.is_weighted_as(&batches[b - 1]);
                if is_new {
                    end += batch.weights();
                }
                model.weight_ranges.push(end - batch.weights()..end);
            }
        }
        model.weights = vec![Lanes::ZERO; end];
        model.update_weights(state);
        model
    }

    pub(crate) fn datum(&self) -> &Datum {
        &self.datum
    }

    /// Makes the equations of batch `b` for a model with `shared` shared unknowns.
    #[inline(always)]
    pub(crate) fn fill_for(
        &self,
        (state, b): (&State, usize),
        (shared, gauge): (usize, Gauge),
        beams: &mut Beams,
        equations: &mut BlockBatch,
    ) {
        let (batch, stations) = (&self.batches[b], self.network.stations.len());
        beams.fill(batch, state);
        let content = (batch, self.weights_of(b));
        let datum = (gauge == Gauge::Datum).then_some((&self.datum, &self.network.nominal_mm[..]));
        fill(content, datum, beams, (stations, shared), equations);
    }

    /// Moves the points of batch `b` by `factor` times what follows from the correction `s`.
    #[inline(always)]
    fn move_points(
        &self,
        (state, b): (&State, usize),
        (s, factor): (&[f64], f64),
        memory: &mut Memory,
        moved: &mut [Point3<f64>],
    ) -> Result<(), LeastSquaresError> {
        let batch = &self.batches[b];
        let step = (s, factor);
        if plain_batches::is_plain(batch)
            && plain_batches::move_points(batch, self.weights_of(b), state, step, moved)
        {
            return Ok(());
        }
        passes::eliminate(self, state, b, Gauge::Free, memory)?;
        let x = memory.equations.correction(s).as_chunks::<3>().0;
        for (lane, moved) in moved.chunks_exact_mut(batch.points).enumerate() {
            let points = &state.points[batch.first_points[lane]..];
            for ((point, x), moved) in points.iter().zip(x).zip(moved) {
                *moved = point + Vector3::from(x.map(|x| x.0[lane])) * factor;
            }
        }
        Ok(())
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

    #[inline(always)]
    fn weights_of(&self, b: usize) -> &[Lanes] {
        &self.weights[self.weight_ranges[b].clone()]
    }

    fn unknowns(&self, batch: &Batch) -> usize {
        3 * batch.points
    }

    fn shared(&self) -> usize {
        PER_STATION * self.network.stations.len() + self.network.interruptions.len()
    }

    #[inline(always)]
    fn fill(&self, state: &State, b: usize, gauge: Gauge, memory: &mut Memory) {
        let content = (self.shared(), gauge);
        self.fill_for(
            (state, b),
            content,
            &mut memory.beams,
            &mut memory.equations,
        );
    }

    #[inline(always)]
    fn add_shortly(&self, state: &State, b: usize, gauge: Gauge, sums: &mut LaneSums) -> bool {
        let batch = &self.batches[b];
        gauge == Gauge::Free
            && plain_batches::is_plain(batch)
            && plain_batches::add_to(batch, self.weights_of(b), state, sums)
    }
}

impl Reweighted for FreeAdjustment<'_> {
    fn weights_follow_beams(&self) -> bool {
        let noise = &self.network.noise;
        let correlated = || self.network.visits.iter().any(|v| v.readings.len() > 1);
        noise.length_sigma_relative > 0.0 || noise.return_sigma_mm > 0.0 && correlated()
    }

    fn update_weights(&mut self, state: &State) {
        let with_beams = self.weights_follow_beams();
        let pieces = pieces(self.batches.len());
        let ranges = &self.weight_ranges;
        let lengths = pieces
            .iter()
            .map(|p| ranges[p.end - 1].end - ranges[p.start].start);
        let parts = split_mut(&mut self.weights, lengths);
        let (batches, noise) = (&self.batches, &self.network.noise);
        in_parallel(
            pieces.into_iter().zip(parts).collect(),
            #[inline(always)]
            |(piece, part): (Range<usize>, &mut [Lanes])| {
                let (mut beams, mut factor) = (Beams::default(), Vec::new());
                let (first, mut filled) = (ranges[piece.start].start, 0);
                for (batch, range) in batches[piece.clone()].iter().zip(&ranges[piece]) {
                    let (start, end) = (range.start - first, range.end - first);
                    if end == filled {
                        continue;
                    }
                    filled = end;
                    if with_beams {
                        beams.fill(batch, state);
                    }
                    let beams = with_beams.then_some(&beams);
                    fill_weights(batch, noise, beams, &mut factor, &mut part[start..end]);
                }
            },
        );
    }

    fn moved(&self, from: &State, to: &State) -> f64 {
        from.farthest_move_mm(to) / self.datum.radius_mm
    }
}

impl Adjustment for FreeAdjustment<'_> {
    type State = State;

    fn reduce(&self, state: &State) -> Result<Reduced, LeastSquaresError> {
        passes::reduce(self, state, Gauge::Free)
    }

    fn reduce_with_datum(&self, state: &State) -> Result<Reduced, LeastSquaresError> {
        passes::reduce(self, state, Gauge::Datum)
    }

    fn squares(&self, state: &State) -> f64 {
        let of_pieces = in_parallel(
            pieces(self.batches.len()),
            #[inline(always)]
            |piece| {
                self.memories.lend(
                    #[inline(always)]
                    |memory| {
                        let mut sum = Lanes::ZERO;
                        for b in piece {
                            self.fill(state, b, Gauge::Free, memory);
                            for r in memory.equations.residual_mut() {
                                sum = r.mul_add(*r, sum);
                            }
                        }
                        sum.sum()
                    },
                )
            },
        );
        of_pieces.into_iter().sum()
    }

    fn step(
        &self,
        state: &State,
        s: &[f64],
        factor: f64,
        next: &mut State,
    ) -> Result<(), LeastSquaresError> {
        self.step_stations(state, s, factor, next);
        let pieces = pieces(self.batches.len());
        let points = |batch: &Batch| batch.points * batch.groups.len();
        let lengths = pieces
            .iter()
            .map(|piece| self.batches[piece.clone()].iter().map(points).sum());
        let moved = split_mut(&mut next.points, lengths);
        try_in_parallel(
            pieces.into_iter().zip(moved).collect(),
            #[inline(always)]
            |(piece, moved): (Range<usize>, &mut [Point3<f64>])| {
                self.memories.lend(
                    #[inline(always)]
                    |memory| {
                        let mut rest = moved;
                        for b in piece {
                            let batch = &self.batches[b];
                            let (moved, others) =
                                rest.split_at_mut(batch.points * batch.groups.len());
                            rest = others;
                            self.move_points((state, b), (s, factor), memory, moved)?;
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

    fn settle(&self, state: &mut State) {
        let motion = self.datum.motion(self.network, &state.points);
        state.move_by(&motion);
    }
}
