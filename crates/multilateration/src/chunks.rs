//! Work on batches, handed out to threads.

use std::ops::Range;

use rayon::prelude::*;
use trueaxis_leastsquares::in_widest_registers;

/// Batches of a chunk: enough work, some 50 µs, to pay for handing it to a thread.
const LEAST_BATCHES: usize = 16;

/// Largest number of chunks: more would not spread the work better, and each has a reduced system of its own.
const MOST_CHUNKS: usize = 64;

/// The consecutive chunks of all batches, nearly equal and even in number, so that two threads share them equally.
pub(crate) fn chunks(batches: usize) -> Vec<Range<usize>> {
    let count = match batches.div_ceil(LEAST_BATCHES) {
        0 | 1 => 1,
        several => several.next_multiple_of(2).min(MOST_CHUNKS),
    };
    let size = batches.div_ceil(count).max(1);
    let starts = (0..batches).step_by(size);
    starts
        .map(|start| start..batches.min(start + size))
        .collect()
}

/// Runs work that passes over the batches many times in a thread of the pool, if there is more than one chunk:
/// handing out chunks from outside the pool costs more, each time.
pub(crate) fn within_pool<T: Send>(batches: usize, work: impl FnOnce() -> T + Send) -> T {
    match batches > LEAST_BATCHES {
        true => rayon::scope(|_| work()),
        false => work(),
    }
}

/// The results of `work` on each item, in order; `work` uses the widest registers.
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
