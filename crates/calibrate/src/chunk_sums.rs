//! Sums over the records of an axis, of matrices that are made eight side by side.

use nalgebra::DMatrix;
use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSlice;
use trueaxis_leastsquares::Lanes;

use crate::in_order::CHUNKS;
use crate::record_chunks::Chunk;

/// Sums of matrices of these sizes: `add` adds those of a chunk to rows that follow each other, in each
/// lane, with memory to work in. The same bits on any number of threads.
pub(crate) fn chunk_sums<M: Default, const N: usize>(
    chunks: &[Chunk],
    sizes: [[usize; 2]; N],
    add: impl Fn(&mut M, &Chunk, &mut [Vec<Lanes>; N]) + Sync,
) -> [DMatrix<f64>; N] {
    let of_piece = |memory: &mut M, piece: &[Chunk]| {
        let mut sums = sizes.map(|[rows, columns]| vec![Lanes::ZERO; rows * columns]);
        for chunk in piece {
            add(memory, chunk, &mut sums);
        }
        sums.map(|sum| sum.into_iter().map(Lanes::sum).collect::<Vec<f64>>())
    };
    let pieces = chunks.par_chunks(CHUNKS);
    let parts: Vec<_> = pieces.map_init(M::default, of_piece).collect();
    let mut whole = sizes.map(|[rows, columns]| DMatrix::zeros(rows, columns));
    for part in parts {
        for (sum, part) in whole.iter_mut().zip(part) {
            let (rows, columns) = sum.shape();
            *sum += DMatrix::from_row_slice(rows, columns, &part);
        }
    }
    whole
}
