//! Work on all threads with results in order: the same bits on any number of them.

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// Items that one thread takes at a time, and that one partial sum is made of: some ten
/// microseconds of work, beside which the hand-over is nothing.
const PIECE: usize = 32;

/// `f` of each of `count` items.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    let items = (0..count).into_par_iter().with_min_len(PIECE);
    items.map(f).collect()
}

/// The same with memory to work in.
pub(crate) fn map_with<M: Default, T: Send>(
    count: usize,
    f: impl Fn(&mut M, usize) -> T + Sync + Send,
) -> Vec<T> {
    let items = (0..count).into_par_iter().with_min_len(PIECE);
    items.map_init(M::default, f).collect()
}

/// The same for pieces that are work enough for a thread each.
pub(crate) fn map_pieces<M: Default, T: Send>(
    count: usize,
    f: impl Fn(&mut M, usize) -> T + Sync + Send,
) -> Vec<T> {
    (0..count).into_par_iter().map_init(M::default, f).collect()
}

/// `f` of each of `count` items, or the error of the first that fails.
pub(crate) fn try_map<T: Send, E: Send>(
    count: usize,
    f: impl Fn(usize) -> Result<T, E> + Sync + Send,
) -> Result<Vec<T>, E> {
    map(count, f).into_iter().collect()
}

/// Sum over `count` items: `add` adds an item to a partial sum that started at `zero`, with memory
/// to work in; `join` adds partial sums, in order.
pub(crate) fn sum<M: Default, T: Send>(
    count: usize,
    zero: impl Fn() -> T + Sync,
    add: impl Fn(&mut T, &mut M, usize) + Sync,
    join: impl Fn(&mut T, T),
) -> T {
    let of_piece = |memory: &mut M, piece: usize| {
        let mut part = zero();
        let first = piece * PIECE;
        for item in first..count.min(first + PIECE) {
            add(&mut part, memory, item);
        }
        part
    };
    let pieces = (0..count.div_ceil(PIECE)).into_par_iter();
    let parts: Vec<T> = pieces.map_init(M::default, of_piece).collect();
    let mut whole = zero();
    for part in parts {
        join(&mut whole, part);
    }
    whole
}
