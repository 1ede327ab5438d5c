//! Work on all threads with results in order: the bits do not depend on the number of threads.

use std::ops::AddAssign;

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// Items that one thread takes at a time, each time for one partial sum: some ten microseconds of work, which make
/// the hand-over negligible.
const CHUNK: usize = 32;

/// The results of `f` for each of `count` items.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    let items = (0..count).into_par_iter().with_min_len(CHUNK);
    items.map(f).collect()
}

/// Sum over `count` items: `add` adds an item to a partial sum that starts at `zero`; partial sums are added in
/// order.
pub(crate) fn sum<T: Send + AddAssign>(
    count: usize,
    zero: impl Fn() -> T + Sync,
    add: impl Fn(&mut T, usize) + Sync,
) -> T {
    let of_chunk = |number: usize| {
        let mut part = zero();
        let first = number * CHUNK;
        for item in first..count.min(first + CHUNK) {
            add(&mut part, item);
        }
        part
    };
    let chunks = (0..count.div_ceil(CHUNK)).into_par_iter();
    let parts: Vec<T> = chunks.map(of_chunk).collect();
    let mut whole = zero();
    for part in parts {
        whole += part;
    }
    whole
}
