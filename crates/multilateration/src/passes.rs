//! Passes over the groups of a network, in pieces that threads take.
//!
//! Pieces depend on the number of groups alone and their sums are added up in order: the same bits on
//! any number of threads.

use std::ops::Range;

use rayon::prelude::*;
use trueaxis_leastsquares::{Error as LeastSquaresError, Reduced};

/// Groups of a piece: enough work, some 50 µs, to be worth handing out.
const LEAST_GROUPS: usize = 512;

/// Most pieces: more would not spread the work better and each has a reduced system of its own.
const MOST_PIECES: usize = 64;

/// Groups come in multiples of the widest registers.
const LANES: usize = 8;

/// The pieces of so many groups, in order.
pub(crate) fn pieces(groups: usize) -> Vec<Range<usize>> {
    let size = groups.div_ceil(MOST_PIECES).max(LEAST_GROUPS);
    let size = size.next_multiple_of(LANES);
    let starts = (0..groups).step_by(size);
    starts
        .map(|start| start..groups.min(start + size))
        .collect()
}

/// What `work` makes of each item, in order; of several errors the first.
pub(crate) fn in_parallel<I: Send, T: Send>(
    items: Vec<I>,
    work: impl Fn(I) -> Result<T, LeastSquaresError> + Sync + Send,
) -> Result<Vec<T>, LeastSquaresError> {
    if items.len() <= 1 {
        return items.into_iter().map(work).collect();
    }
    let results: Vec<Result<T, LeastSquaresError>> = items.into_par_iter().map(work).collect();
    results.into_iter().collect()
}

/// Sums of all pieces of so many groups.
pub(crate) fn sum_pieces(
    groups: usize,
    of_piece: impl Fn(Range<usize>) -> Result<Reduced, LeastSquaresError> + Sync + Send,
) -> Result<Option<Reduced>, LeastSquaresError> {
    let sums = in_parallel(pieces(groups), of_piece)?;
    Ok(sums.into_iter().reduce(|mut sum, piece| {
        sum.merge(&piece);
        sum
    }))
}

/// The points of each piece, of all `groups`, out of all `points`.
pub(crate) fn split_points<'a, T>(
    pieces: &[Range<usize>],
    groups: &[Range<usize>],
    mut points: &'a mut [T],
) -> Vec<&'a mut [T]> {
    let mut parts = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let count = groups[piece.end - 1].end - groups[piece.start].start;
        let (part, rest) = points.split_at_mut(count);
        points = rest;
        parts.push(part);
    }
    parts
}
