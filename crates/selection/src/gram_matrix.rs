//! `G = Xᵀ M X` of whitened columns, row after row.
//!
//! Few columns are multiplied one by one. The many columns of wandering courses are multiplied as matrices, block by
//! block, which reads each element from memory once for all columns of a block.

use std::ops::Range;

use nalgebra::{DMatrixView, DMatrixViewMut};
use rayon::prelude::*;
use trueaxis_leastsquares::dot;

use crate::projection::Taken;
use crate::{Gram, Projection};

/// Number of columns from which products of matrices are faster; they are made in blocks of eight by eight.
pub(crate) const SEVERAL: usize = 8;

/// Rows of `G` that are computed together.
const BLOCK: usize = 32;

/// Rows of `X` that are read together.
const ROWS: usize = 512;

/// `Xᵀ M X` of whitened columns in its eigenvectors.
pub fn gram(projection: &Projection, columns: &[Vec<f64>]) -> Gram {
    let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
    Gram::new(&gram_matrix(projection, columns), &before)
}

/// `Xᵀ M X` of whitened columns, row after row.
pub fn gram_matrix(projection: &Projection, columns: &[Vec<f64>]) -> Vec<f64> {
    let taken = projection.taken_of_all(columns.iter().map(Vec::as_slice));
    gram_matrix_of(columns, (&taken, 0))
}

/// The same, given what the base model takes of columns, and the index of the first of these among them.
pub(crate) fn gram_matrix_of(columns: &[Vec<f64>], taken: (&Taken, usize)) -> Vec<f64> {
    let n = columns.len();
    let mut matrix = vec![0.0; n * n];
    let rows: Vec<Range<usize>> = columns.iter().map(|c| concerned(&[c])).collect();
    if n < SEVERAL {
        for (i, row) in matrix.chunks_exact_mut(n.max(1)).enumerate() {
            one_by_one(row, i, (columns, &rows), taken);
        }
    } else {
        let blocks = matrix.par_chunks_mut(n * BLOCK).enumerate();
        blocks.for_each(|(block, of_block)| {
            let own = block * BLOCK..n.min((block + 1) * BLOCK);
            together(of_block, own, (columns, &rows), taken);
        });
    }
    for i in 0..n {
        for j in 0..i {
            matrix[j * n + i] = matrix[i * n + j];
        }
    }
    matrix
}

/// From the first to the last row with anything but zeros.
pub(crate) fn concerned(columns: &[impl AsRef<[f64]>]) -> Range<usize> {
    let columns = columns.iter().map(AsRef::as_ref);
    let first = |column: &[f64]| column.iter().position(|&x| x != 0.0);
    let last = |column: &[f64]| column.iter().rposition(|&x| x != 0.0);
    let start = columns.clone().filter_map(first).min().unwrap_or(0);
    start
        ..columns
            .filter_map(last)
            .max()
            .map_or(start, |last| last + 1)
}

/// Columns, and the rows that each concerns.
type Concerned<'a> = (&'a [Vec<f64>], &'a [Range<usize>]);

/// A row of `G` up to the diagonal.
fn one_by_one(
    row: &mut [f64],
    i: usize,
    (columns, rows): Concerned<'_>,
    (taken, first): (&Taken, usize),
) {
    for (j, x) in row[..=i].iter_mut().enumerate() {
        let start = rows[i].start.max(rows[j].start);
        let both = start..rows[i].end.min(rows[j].end).max(start);
        let all = dot(&columns[i][both.clone()], &columns[j][both]);
        *x = all - taken.product(first + i, first + j);
    }
}

/// Rows `own` of `G`, up to their last diagonal element.
fn together(
    matrix: &mut [f64],
    own: Range<usize>,
    (columns, rows): Concerned<'_>,
    (taken, first): (&Taken, usize),
) {
    let n = columns.len();
    let start = rows[own.clone()].iter().map(|r| r.start).min().unwrap_or(0);
    let end = rows[own.clone()].iter().map(|r| r.end).max().unwrap_or(0);
    let meets = |k: &usize| rows[*k].start < end && start < rows[*k].end;
    let others: Vec<usize> = (0..own.start).filter(meets).chain(own.clone()).collect();
    let of = |k: usize| &columns[k][start..end];
    let own_columns: Vec<&[f64]> = own.clone().map(of).collect();
    let all: Vec<&[f64]> = others.iter().map(|&k| of(k)).collect();
    let mut products = vec![0.0; own.len() * all.len()];
    add_products(&mut products, (&own_columns, &all));
    let mut less = vec![0.0; own.len() * own.end];
    taken.add_products(&mut less, own.clone(), first);
    for (i, row) in matrix.chunks_exact_mut(n).enumerate() {
        for (&k, products) in others.iter().zip(products.chunks(own.len())) {
            row[k] = products[i];
        }
        for (x, less) in row.iter_mut().zip(less.chunks(own.len())) {
            *x -= less[i];
        }
    }
}

/// Adds `AᵀB`, column after column, for columns of equal length. `A` is transposed by hand: small products of
/// `nalgebra` (0.35) read beyond rows that are not adjacent.
pub(crate) fn add_products(sum: &mut [f64], (a, b): (&[&[f64]], &[&[f64]])) {
    let length = b.first().map_or(0, |column| column.len());
    let (mut rows_of_a, mut columns_of_b) = (vec![0.0; ROWS * a.len()], Vec::new());
    let mut sum = DMatrixViewMut::from_slice(sum, a.len(), b.len());
    for first in (0..length).step_by(ROWS) {
        let rows = first..length.min(first + ROWS);
        for (k, column) in a.iter().enumerate() {
            let places = rows_of_a[k..].iter_mut().step_by(a.len());
            places
                .zip(&column[rows.clone()])
                .for_each(|(place, x)| *place = *x);
        }
        columns_of_b.clear();
        b.iter()
            .for_each(|column| columns_of_b.extend_from_slice(&column[rows.clone()]));
        let at = DMatrixView::from_slice(&rows_of_a, a.len(), rows.len());
        let b = DMatrixView::from_slice(&columns_of_b, rows.len(), b.len());
        sum.gemm(1.0, &at, &b, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Few columns and many, of all rows and of some, beside a base model: the same as by dense matrices.
    #[test]
    fn products_are_those_of_matrices() {
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        let rows = 1300;
        let mut column = |concerned: Range<usize>| -> Vec<f64> {
            let drawn = |i: usize| -> f64 {
                let drawn: f64 = StandardNormal.sample(&mut generator);
                drawn * f64::from(u8::from(concerned.contains(&i)))
            };
            (0..rows).map(drawn).collect()
        };
        let base: Vec<Vec<f64>> = (0..5).map(|_| column(0..rows)).collect();
        let projection = Projection::dense(column(0..rows), &base);
        for n in [1, 3, SEVERAL - 1, SEVERAL, 40, 77] {
            let ranges = [0..rows, 0..400, 300..900, 900..rows];
            let of_column = |k: usize| ranges[k * ranges.len() / n].clone();
            let columns: Vec<Vec<f64>> = (0..n).map(|k| column(of_column(k))).collect();
            let dense =
                |columns: &[Vec<f64>]| DMatrix::from_fn(rows, columns.len(), |i, k| columns[k][i]);
            let (a, x) = (dense(&base), dense(&columns));
            let normal = (a.transpose() * &a).try_inverse().expect("full rank");
            let absorbed = &a.transpose() * &x;
            let expected = x.transpose() * &x - absorbed.transpose() * normal * absorbed;
            let found = DMatrix::from_vec(n, n, gram_matrix(&projection, &columns));
            assert!((found - &expected).amax() < 1e-11 * expected.amax(), "{n}");
        }
    }
}
