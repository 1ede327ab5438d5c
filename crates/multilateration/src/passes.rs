//! Passes over the batches of a network: the equations are made, used and forgotten.
//!
//! Threads take chunks that depend only on the number of batches, and sums are added in the order of the chunks: the
//! bits do not depend on the number of threads. All work uses the widest registers of the processor
//! ([`in_widest_registers`](trueaxis_leastsquares::in_widest_registers)).

use std::ops::Range;

use nalgebra::{Isometry3, Point3};
use trueaxis_kinematics::best_fit;
use trueaxis_leastsquares::{
    Adjustment, BlockBatch, Error as LeastSquaresError, Factors, Lanes, Reduced,
};

use crate::adjustment::GroupAdjustment;
use crate::batches::{Batch, groups_of};
use crate::chunks::{chunks, in_parallel, split_mut};
use crate::known::KnownRow;
use crate::lane_vectors::{add, at, times};
use crate::memory::{Constraints, Memory};
use crate::state::{Common, DATUM, State};
use crate::visit_weights::by_visit;

/// What the linearisation of a chunk leaves for the next step, batch after batch.
#[derive(Debug, Default)]
pub(crate) struct Linearised {
    /// As [`fill_weights`](crate::visit_weights::fill_weights) makes them.
    weights: Vec<Lanes>,
    /// As [`BlockBatch::keep`] writes it.
    eliminated: Vec<Lanes>,
}

/// A pass: with a step the batches move, with `constraints` they are linearised afterwards.
#[derive(Clone, Copy)]
struct Pass<'a> {
    /// The state before the step.
    state: &'a State,
    /// The correction of the shared unknowns, and the factor on it.
    step: Option<(&'a [f64], f64)>,
    /// The state after the step.
    common: Common<'a>,
    shapes_mm: &'a [Vec<Point3<f64>>],
    constraints: Option<Constraints>,
}

/// What a pass reads and writes of some batches; empty where it is not needed.
#[derive(Default)]
struct Part<'a> {
    /// The groups after the step.
    points: &'a mut [Point3<f64>],
    poses: &'a mut [Isometry3<f64>],
    weights: &'a mut [Lanes],
    eliminated: &'a mut [Lanes],
    factors: Option<&'a mut Factors>,
}

impl Adjustment for GroupAdjustment<'_> {
    type State = State;
    type Linearised = Vec<Linearised>;

    fn reduce(
        &self,
        state: &State,
        linearised: &mut Vec<Linearised>,
    ) -> Result<Reduced, LeastSquaresError> {
        let chunks = chunks(self.batches.len());
        linearised.resize_with(chunks.len(), Linearised::default);
        for (left, chunk) in linearised.iter_mut().zip(chunks) {
            left.fit(&self.batches[chunk]);
        }
        let parts = linearised.iter_mut().map(Linearised::part);
        self.reduced_at(state, Constraints::None, parts.collect())
    }

    fn reduce_with_datum(&self, state: &State) -> Result<(Reduced, Factors), LeastSquaresError> {
        let batches = &self.batches;
        let of_chunk = |chunk: Range<usize>| {
            let unknowns = batches[chunk].iter().map(Batch::unknowns);
            Factors::with_room(self.shared() + DATUM, unknowns)
        };
        let of_chunks = chunks(batches.len()).into_iter().map(of_chunk);
        let mut left: Vec<Factors> = of_chunks.collect();
        let parts = left.iter_mut().map(|factors| Part {
            factors: Some(factors),
            ..Part::default()
        });
        let reduced = self.reduced_at(state, Constraints::Datum, parts.collect())?;
        let mut factors = Factors::default();
        left.into_iter().for_each(|part| factors.append(part));
        Ok((reduced, factors))
    }

    fn step(
        &self,
        from: (&State, &mut Vec<Linearised>),
        s: &[f64],
        factor: f64,
        next: &mut State,
    ) -> f64 {
        self.step_and(None, from, (s, factor), next).0
    }

    fn step_and_reduce(
        &self,
        from: (&State, &mut Vec<Linearised>),
        s: &[f64],
        next: &mut State,
    ) -> (f64, Result<Reduced, LeastSquaresError>) {
        self.step_and(Some(Constraints::None), from, (s, 1.0), next)
    }

    fn free_motions(&self, state: &State) -> Vec<Vec<f64>> {
        self.datum.free_motions(state, self.shared())
    }

    fn apply_datum(&self, state: &mut State) {
        state.move_by(&best_fit(&state.points, &self.network.nominal_mm));
    }
}

impl GroupAdjustment<'_> {
    /// The reduced system at a state.
    fn reduced_at(
        &self,
        state: &State,
        constraints: Constraints,
        parts: Vec<Part<'_>>,
    ) -> Result<Reduced, LeastSquaresError> {
        let pass = Pass {
            state,
            step: None,
            common: state.common(),
            shapes_mm: &state.shapes_mm,
            constraints: Some(constraints),
        };
        Ok(observed(self.pass(pass, parts).1?, &self.known_rows(state)))
    }

    /// Makes a step and, with `constraints`, linearises all lengths at its end.
    fn step_and(
        &self,
        constraints: Option<Constraints>,
        (state, linearised): (&State, &mut Vec<Linearised>),
        (s, factor): (&[f64], f64),
        next: &mut State,
    ) -> (f64, Result<Reduced, LeastSquaresError>) {
        self.step_shared(state, s, factor, next);
        let known = self.known_rows(next);
        let of_known: f64 = known.iter().map(|row| row.residual.powi(2)).sum();
        let groups = groups_of(&self.batches, &chunks(self.batches.len()));
        let ends = &self.network.groups;
        let of_points = groups
            .iter()
            .map(|g| ends[g.end - 1].end - ends[g.start].start);
        let points = split_mut(&mut next.points, of_points);
        let has_poses = !next.poses.is_empty();
        let of_poses = groups.iter().map(|g| if has_poses { g.len() } else { 0 });
        let poses = split_mut(&mut next.poses, of_poses);
        let moved = points.into_iter().zip(poses).zip(linearised);
        let parts = moved.map(|((points, poses), left)| Part {
            points,
            poses,
            ..left.part()
        });
        let pass = Pass {
            state,
            step: Some((s, factor)),
            common: Common {
                stations: &next.stations,
                dead_paths_mm: &next.dead_paths_mm,
                contrasts_mm: &next.contrasts_mm,
            },
            shapes_mm: &next.shapes_mm,
            constraints,
        };
        let (squares, reduced) = self.pass(pass, parts.collect());
        let reduced = match constraints {
            Some(_) => reduced.map(|reduced| observed(reduced, &known)),
            None => reduced,
        };
        (squares + of_known, reduced)
    }

    /// The sum of squares after the step, with the weights from before it, and the reduced system.
    fn pass(
        &self,
        pass: Pass<'_>,
        parts: Vec<Part<'_>>,
    ) -> (f64, Result<Reduced, LeastSquaresError>) {
        let chunks = chunks(self.batches.len()).into_iter();
        let of_constraints = |constraints: Constraints| (self.shared(), constraints.count());
        let (shared, constraints) = pass.constraints.map_or((0, 0), of_constraints);
        let sums = in_parallel(
            chunks.zip(parts).collect(),
            #[inline(always)]
            |(chunk, mut part): (Range<usize>, Part<'_>)| {
                self.memories.lend(
                    #[inline(always)]
                    |memory| {
                        memory.sums.reset(shared, constraints);
                        let (mut squares, mut outcome) = (Lanes::ZERO, Ok(()));
                        for batch in &self.batches[chunk] {
                            let mut own = part.next(batch);
                            self.take(pass.state, batch, memory);
                            if let Some(step) = pass.step {
                                self.move_groups((batch, memory), (&pass, step), &mut own);
                            }
                            memory.beams.fill(batch, pass.common);
                            if pass.step.is_some() {
                                squares += memory.beams.squares(batch, own.weights);
                            }
                            // The squares are needed even where the system cannot be reduced.
                            if let (Some(constraints), Ok(())) = (pass.constraints, &outcome) {
                                outcome = self.eliminate((batch, memory), constraints, &mut own);
                            }
                        }
                        // A closure would not use the registers that were chosen.
                        let reduced = match outcome {
                            Ok(()) => Ok(memory.sums.reduced()),
                            Err(error) => Err(error),
                        };
                        (squares.sum(), reduced)
                    },
                )
            },
        );
        // The first of several errors counts.
        let none = (0.0, Ok(Reduced::new(shared, constraints)));
        sums.into_iter()
            .fold(none, |(squares, whole), (more, sum)| {
                let whole = whole.and_then(|mut whole| {
                    whole.merge(&sum?);
                    Ok(whole)
                });
                (squares + more, whole)
            })
    }

    /// Moves the groups of a batch that was taken, and writes their new points and poses.
    #[inline(always)]
    fn move_groups(
        &self,
        (batch, memory): (&Batch, &mut Memory),
        (pass, (s, factor)): (&Pass<'_>, (&[f64], f64)),
        own: &mut Part<'_>,
    ) {
        memory.beams.fill(batch, pass.state.common());
        self.fill_rows(batch, Constraints::None, memory);
        let equations = &mut memory.equations;
        equations.take_off(s);
        for (first, count, weights) in by_visit(batch, own.weights) {
            equations.weigh(first, count, weights);
        }
        let x = equations.correction(own.eliminated);
        let by = |k: usize| times(at(x, k), Lanes::splat(factor));
        let (tie, points) = (&mut memory.tie, &mut memory.beams.points);
        match self.body_of(batch) {
            Some((bodies, body)) => {
                tie.move_by([by(0), by(1)]);
                tie.put((batch, bodies), &pass.shapes_mm[body], points);
                for (lane, pose) in own.poses.iter_mut().enumerate() {
                    *pose = tie.pose(lane);
                }
            }
            None => (0..batch.points).for_each(|k| add(&mut points[3 * k..], by(k))),
        }
        for (lane, group) in own.points.chunks_exact_mut(batch.points).enumerate() {
            for (point, place) in group.iter_mut().zip(points.chunks_exact(3)) {
                *point = Point3::new(place[0].0[lane], place[1].0[lane], place[2].0[lane]);
            }
        }
    }

    /// Eliminates the groups of a batch whose beams are filled.
    #[inline(always)]
    fn eliminate(
        &self,
        (batch, memory): (&Batch, &mut Memory),
        constraints: Constraints,
        own: &mut Part<'_>,
    ) -> Result<(), LeastSquaresError> {
        self.fill_rows(batch, constraints, memory);
        self.weigh(batch, memory);
        let Memory {
            equations, sums, ..
        } = memory;
        equations.eliminate(|lane| batch.number(lane))?;
        equations.add_to(sums);
        sums.count(batch.readings, batch.unknowns() * batch.groups.len());
        match &mut own.factors {
            Some(factors) => equations.add_factors(batch.groups.clone(), factors),
            None => {
                own.weights.copy_from_slice(&memory.weights);
                equations.keep(own.eliminated);
            }
        }
        Ok(())
    }
}

impl Linearised {
    /// Makes room for the results of some batches.
    fn fit(&mut self, batches: &[Batch]) {
        let weights = batches.iter().map(|b| b.layout.weights).sum();
        self.weights.resize(weights, Lanes::ZERO);
        let kept = batches.iter().map(|b| BlockBatch::kept_len(b.unknowns()));
        self.eliminated.resize(kept.sum(), Lanes::ZERO);
    }

    fn part(&mut self) -> Part<'_> {
        Part {
            weights: &mut self.weights,
            eliminated: &mut self.eliminated,
            ..Part::default()
        }
    }
}

impl Part<'_> {
    /// The part of the next batch.
    #[inline(always)]
    fn next(&mut self, batch: &Batch) -> Part<'_> {
        let groups = batch.groups.len();
        Part {
            points: next(&mut self.points, groups * batch.points),
            poses: next(&mut self.poses, groups),
            weights: next(&mut self.weights, batch.layout.weights),
            eliminated: next(&mut self.eliminated, BlockBatch::kept_len(batch.unknowns())),
            factors: self.factors.as_deref_mut(),
        }
    }
}

/// Splits off the next elements, as far as there are any.
#[inline(always)]
fn next<'a, T>(all: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let count = count.min(all.len());
    all.split_off_mut(..count).unwrap_or_default()
}

/// A reduced system with what is known beside the lengths.
fn observed(mut reduced: Reduced, known: &[KnownRow]) -> Reduced {
    for row in known {
        reduced.observe(&row.columns, row.residual);
    }
    reduced
}
