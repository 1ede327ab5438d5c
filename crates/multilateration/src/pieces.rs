//! Work on batches, handed out to threads.

use std::ops::Range;

use rayon::prelude::*;
use trueaxis_leastsquares::in_widest_registers;

/// Batches of a piece: enough work, some 50 µs, to be worth handing out.
const LEAST_BATCHES: usize = 16;

/// Most pieces: more would not spread the work better and each has a reduced system of its own.
const MOST_PIECES: usize = 64;

/// The pieces into which batches are divided, in order: an even number of nearly equal ones, so that two threads have as much.
pub(crate) fn pieces(batches: usize) -> Vec<Range<usize>> {
    let count = match batches.div_ceil(LEAST_BATCHES) {
        0 | 1 => 1,
        several => several.next_multiple_of(2).min(MOST_PIECES),
    };
    let size = batches.div_ceil(count).max(1);
    let starts = (0..batches).step_by(size);
    starts
        .map(|start| start..batches.min(start + size))
        .collect()
}

/// Runs work with many passes over batches in a thread of the pool, if there are enough of them for several threads:
/// handing out pieces from outside the pool costs more, each time.
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
