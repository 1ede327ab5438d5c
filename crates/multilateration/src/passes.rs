//! Passes over the batches of a network: the equations are made, used and forgotten.
//!
//! Threads take pieces that depend on the number of batches alone, and sums are added up in their order:
//! the same bits on any number of threads. Each takes the widest registers that the processor has
//! ([`in_widest_registers`]).

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use trueaxis_leastsquares::{
    BlockBatch, Error as LeastSquaresError, LaneSums, Lanes, Reduced, in_widest_registers,
};

use crate::adjustment::{GroupAdjustment, unknowns};
use crate::batches::Batch;
use crate::linearise::{Beams, Tie};
use crate::state::{DATUM, State};

/// Batches of a piece: enough work, some 50 µs, to be worth handing out.
const LEAST_BATCHES: usize = 16;

/// Most pieces: more would not spread the work better and each has a reduced system of its own.
const MOST_PIECES: usize = 64;

/// What decides among results that differ by a motion of the whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Gauge {
    /// Nothing: the equations of the lengths alone.
    Free,
    /// The constraints of the datum.
    Datum,
}

impl Gauge {
    /// Number of constraints.
    pub(crate) fn constraints(self) -> usize {
        match self {
            Self::Free => 0,
            Self::Datum => DATUM,
        }
    }
}

/// Memory for one batch after the other.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    pub(crate) beams: Beams,
    /// `L⁻¹` of each visit, the rows of its triangle one after the other; and `L` of one.
    pub(crate) weights: Vec<Lanes>,
    pub(crate) factor: Vec<Lanes>,
    pub(crate) equations: BlockBatch,
    pub(crate) tie: Tie,
}

/// Memory that one pass leaves to the next.
#[derive(Debug, Default)]
pub(crate) struct Memories(Mutex<Vec<Memory>>);

impl Memories {
    /// Work with some memory; what is in it means nothing.
    #[inline(always)]
    pub(crate) fn lend<T>(&self, work: impl FnOnce(&mut Memory) -> T) -> T {
        let pool = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut memory = pool().pop().unwrap_or_default();
        let result = work(&mut memory);
        pool().push(memory);
        result
    }
}

/// The pieces of so many batches, in order.
pub(crate) fn pieces(batches: usize) -> Vec<Range<usize>> {
    let size = batches.div_ceil(MOST_PIECES).max(LEAST_BATCHES);
    let starts = (0..batches).step_by(size);
    starts
        .map(|start| start..batches.min(start + size))
        .collect()
}

/// Does what has many passes over so many batches in a thread of the pool, if they are worth several:
/// handing out pieces from outside costs more, each time.
pub(crate) fn within_pool<T: Send>(batches: usize, work: impl FnOnce() -> T + Send) -> T {
    match batches > LEAST_BATCHES {
        true => rayon::scope(|_| work()),
        false => work(),
    }
}

/// What `work` makes of each item with the widest registers, in order.
pub(crate) fn in_parallel<I: Send, T: Send>(
    items: Vec<I>,
    work: impl Fn(I) -> T + Sync + Send,
) -> Vec<T> {
    let work = |item| {
        in_widest_registers(
            #[inline(always)]
            || work(item),
        )
    };
    if items.len() <= 1 {
        return items.into_iter().map(work).collect();
    }
    items.into_par_iter().map(work).collect()
}

/// The same for work that may fail; of several errors the first.
pub(crate) fn try_in_parallel<I: Send, T: Send>(
    items: Vec<I>,
    work: impl Fn(I) -> Result<T, LeastSquaresError> + Sync + Send,
) -> Result<Vec<T>, LeastSquaresError> {
    in_parallel(items, work).into_iter().collect()
}

/// The reduced system of all batches at a state; `take` gets the eliminated equations of each batch, by its
/// number, with what its piece is given of `parts`.
pub(crate) fn reduce<P: Send>(
    model: &GroupAdjustment<'_>,
    state: &State,
    gauge: Gauge,
    parts: Vec<P>,
    take: impl Fn(usize, &mut Memory, &mut P) + Sync + Send,
) -> Result<Reduced, LeastSquaresError> {
    let pieces = pieces(model.batches().len()).into_iter();
    let sums = try_in_parallel(
        pieces.zip(parts).collect(),
        #[inline(always)]
        |(piece, mut part): (Range<usize>, P)| {
            let mut sums = LaneSums::new(model.shared(), gauge.constraints());
            model.memories().lend(
                #[inline(always)]
                |memory| {
                    for b in piece {
                        let batch = &model.batches()[b];
                        model.fill(state, b, gauge, memory);
                        memory.equations.eliminate(|lane| batch.number(lane))?;
                        memory.equations.add_to(&mut sums);
                        sums.count(batch.readings, unknowns(batch) * batch.groups.len());
                        take(b, memory, &mut part);
                    }
                    Ok(())
                },
            )?;
            Ok(sums.into_reduced())
        },
    )?;
    let sum = sums.into_iter().reduce(|mut sum, piece| {
        sum.merge(&piece);
        sum
    });
    Ok(sum.unwrap_or_else(|| Reduced::new(model.shared(), gauge.constraints())))
}

/// The groups of the batches of some pieces.
pub(crate) fn groups_of(batches: &[Batch], pieces: &[Range<usize>]) -> Vec<Range<usize>> {
    let of_piece =
        |piece: &Range<usize>| batches[piece.start].groups.start..batches[piece.end - 1].groups.end;
    pieces.iter().map(of_piece).collect()
}

/// Splits a slice into parts of these lengths.
pub(crate) fn split_mut<T>(
    mut all: &mut [T],
    lengths: impl IntoIterator<Item = usize>,
) -> Vec<&mut [T]> {
    let mut parts = Vec::new();
    for length in lengths {
        let (part, rest) = all.split_at_mut(length);
        all = rest;
        parts.push(part);
    }
    parts
}
