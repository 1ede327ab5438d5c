//! Passes over the batches of a network: the equations are made, used and forgotten.
//!
//! Threads take pieces that depend on the number of batches alone, and sums are added up in their order:
//! the same bits on any number of threads. Each takes the widest registers that the processor has
//! ([`in_widest_registers`](trueaxis_leastsquares::in_widest_registers)).

use std::ops::Range;

use trueaxis_leastsquares::{
    Adjustment, BlockBatch, Error as LeastSquaresError, Factors, Lanes, Reduced,
};

use crate::adjustment::{GroupAdjustment, Linearised, Moved};
use crate::batches::{Batch, groups_of};
use crate::memory::{Gauge, Memory};
use crate::pieces::{in_parallel, pieces, split_mut};
use crate::state::{Common, DATUM, State};

impl Adjustment for GroupAdjustment<'_> {
    type State = State;
    type Linearised = Vec<Linearised>;

    fn reduce(
        &self,
        state: &State,
        linearised: &mut Vec<Linearised>,
    ) -> Result<Reduced, LeastSquaresError> {
        let pieces = pieces(self.batches.len());
        linearised.resize_with(pieces.len(), Linearised::default);
        let parts = linearised.iter_mut().zip(pieces);
        let mut reduced = reduced(
            self,
            state,
            Gauge::Free,
            parts
                .map(|(left, piece)| left.cleared(&self.batches[piece]))
                .collect(),
            #[inline(always)]
            |_, memory, piece: &mut &mut Linearised| {
                piece.weights.extend_from_slice(&memory.weights);
                memory.equations.keep(&mut piece.eliminated);
            },
        )?;
        self.observe_known(state, &mut reduced);
        Ok(reduced)
    }

    fn reduce_with_datum(&self, state: &State) -> Result<(Reduced, Factors), LeastSquaresError> {
        let batches = &self.batches;
        let of_piece = |piece: Range<usize>| {
            let unknowns = batches[piece].iter().map(Batch::unknowns);
            Factors::with_room(self.shared() + DATUM, unknowns)
        };
        let of_pieces = pieces(batches.len()).into_iter().map(of_piece);
        let mut parts: Vec<Factors> = of_pieces.collect();
        let mut reduced = reduced(
            self,
            state,
            Gauge::Datum,
            parts.iter_mut().collect(),
            #[inline(always)]
            |b, memory, part: &mut &mut Factors| {
                let groups = batches[b].groups.clone();
                memory.equations.add_factors(groups, part);
            },
        )?;
        self.observe_known(state, &mut reduced);
        let mut factors = Factors::default();
        parts.into_iter().for_each(|part| factors.append(part));
        Ok((reduced, factors))
    }

    fn step(
        &self,
        (state, linearised): (&State, &Vec<Linearised>),
        s: &[f64],
        factor: f64,
        next: &mut State,
    ) -> f64 {
        self.step_shared(state, s, factor, next);
        let State {
            stations,
            dead_paths_mm,
            points,
            poses,
            shapes_mm,
            contrasts_mm,
            ..
        } = next;
        let common = Common {
            stations,
            dead_paths_mm,
            contrasts_mm,
        };
        let batches = &self.batches;
        let pieces = pieces(batches.len());
        let groups = groups_of(batches, &pieces);
        let ends = &self.network.groups;
        let of_points = groups
            .iter()
            .map(|g| ends[g.end - 1].end - ends[g.start].start);
        let points = split_mut(points, of_points);
        let has_poses = !poses.is_empty();
        let of_poses = groups.iter().map(|g| if has_poses { g.len() } else { 0 });
        let poses = split_mut(poses, of_poses);
        let parts = points.into_iter().zip(poses).zip(linearised);
        let of_pieces = in_parallel(
            pieces.into_iter().zip(parts).collect(),
            #[inline(always)]
            |(piece, ((mut points, mut poses), left)): (
                Range<usize>,
                ((&mut [_], &mut [_]), _),
            )| {
                let Linearised {
                    weights,
                    eliminated,
                } = left;
                let (mut weights, mut eliminated) = (&weights[..], &eliminated[..]);
                self.memories.lend(
                    #[inline(always)]
                    |memory| {
                        let mut squares = Lanes::ZERO;
                        for b in piece {
                            let batch = &batches[b];
                            let groups = batch.groups.len();
                            let own;
                            (own, points) = points.split_at_mut(groups * batch.points);
                            let own_poses;
                            (own_poses, poses) =
                                poses.split_at_mut(if has_poses { groups } else { 0 });
                            let of_batch;
                            (of_batch, weights) = weights.split_at(batch.weights());
                            let kept;
                            (kept, eliminated) =
                                eliminated.split_at(BlockBatch::kept_len(batch.unknowns()));
                            let mut moved = Moved {
                                points: own,
                                poses: own_poses,
                            };
                            self.move_groups(
                                (state, b),
                                (of_batch, kept),
                                (s, factor),
                                shapes_mm,
                                (memory, &mut moved),
                            );
                            memory.beams.fill(batch, common);
                            squares += memory.beams.squares(batch, of_batch);
                        }
                        squares.sum()
                    },
                )
            },
        );
        let known = self.known_rows(next);
        let of_known: f64 = known.iter().map(|row| row.residual.powi(2)).sum();
        of_pieces.into_iter().sum::<f64>() + of_known
    }

    fn free_motions(&self, state: &State) -> Vec<Vec<f64>> {
        self.datum.free_motions(state, self.shared())
    }

    fn settle(&self, state: &mut State) {
        let motion = self.datum.motion(self.network, &state.points);
        state.move_by(&motion);
    }
}

/// The reduced system of all batches at a state; `take` gets the eliminated equations of each batch, by its
/// number, with what its piece is given of `parts`.
fn reduced<P: Send>(
    model: &GroupAdjustment<'_>,
    state: &State,
    gauge: Gauge,
    parts: Vec<P>,
    take: impl Fn(usize, &mut Memory, &mut P) + Sync + Send,
) -> Result<Reduced, LeastSquaresError> {
    let pieces = pieces(model.batches.len()).into_iter();
    let sums = in_parallel(
        pieces.zip(parts).collect(),
        #[inline(always)]
        |(piece, mut part): (Range<usize>, P)| {
            model.memories.lend(
                #[inline(always)]
                |memory| {
                    memory.sums.reset(model.shared(), gauge.constraints());
                    for b in piece {
                        let batch = &model.batches[b];
                        model.fill(state, b, gauge, memory);
                        memory.equations.eliminate(|lane| batch.number(lane))?;
                        memory.equations.add_to(&mut memory.sums);
                        let unknowns = batch.unknowns() * batch.groups.len();
                        memory.sums.count(batch.readings, unknowns);
                        take(b, memory, &mut part);
                    }
                    Ok(memory.sums.reduced())
                },
            )
        },
    );
    // Of several errors the first.
    let none = Reduced::new(model.shared(), gauge.constraints());
    sums.into_iter().try_fold(none, |mut whole, sum| {
        whole.merge(&sum?);
        Ok(whole)
    })
}
