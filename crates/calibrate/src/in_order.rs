//! Work on all threads with results in order: the bits do not depend on the number of threads.

use std::ops::AddAssign;

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// Records that one thread takes at a time, each time for one partial sum: some ten microseconds of work, which make
/// the hand-over negligible.
const RECORDS: usize = 32;

/// The results of `f` for each of `count` items.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    let items = (0..count).into_par_iter().with_min_len(RECORDS);
    items.map(f).collect()
}

/// Sum over `count` items: `add` adds an item to a partial sum that starts at `zero`; partial sums are added in
/// order.
pub(crate) fn sum<T: Send + AddAssign>(
    count: usize,
    zero: impl Fn() -> T + Sync,
    add: impl Fn(&mut T, usize) + Sync,
) -> T {
    let of_piece = |number: usize| {
        let mut part = zero();
        let first = number * RECORDS;
        for item in first..count.min(first + RECORDS) {
            add(&mut part, item);
        }
        part
    };
    let pieces = (0..count.div_ceil(RECORDS)).into_par_iter();
    let parts: Vec<T> = pieces.map(of_piece).collect();
    let mut whole = zero();
    for part in parts {
        whole += part;
    }
    whole
}
