//! Products of small matrices with contiguous rows, as sums over a group are made of.
//!
//! ```text
//! S += Aᵀ B     S += the upper part of Aᵀ B     C = A B
//! ```
//!
//! A tile of a few elements of the result stays in registers while the sum runs over the rows: a
//! sum in memory would be loaded and stored for every product. [`pulp`] chooses the widest registers
//! that the processor has; products are not fused with sums, so the bits are the same on all.

use pulp::Arch;

/// Rows of a tile, and the most columns: sixteen registers of four numbers hold it with its factors.
const ROWS: usize = 4;
const COLUMNS: usize = 8;

/// `sum += Aᵀ B`, `columns` of them in `a` and `b`.
pub(crate) fn add_transposed_product(sum: &mut [f64], a: &[f64], b: &[f64], columns: [usize; 2]) {
    let [n, m] = columns;
    Arch::new().dispatch(|| {
        for i in (0..n).step_by(ROWS) {
            add_band(sum, Rows::transposed(a, n, i), b, m, 0);
        }
    });
}

/// The upper triangle (and some of the lower) of `sum += Aᵀ B`, for a product that is symmetric;
/// both have `columns` columns.
pub(crate) fn add_symmetric_product(sum: &mut [f64], a: &[f64], b: &[f64], columns: usize) {
    Arch::new().dispatch(|| {
        for i in (0..columns).step_by(ROWS) {
            add_band(sum, Rows::transposed(a, columns, i), b, columns, i);
        }
    });
}

/// `aᵀ b`, in four sums that do not wait for each other.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a_fours, a_rest) = a.as_chunks::<4>();
    let (b_fours, b_rest) = b.as_chunks::<4>();
    for (a, b) in a_fours.iter().zip(b_fours) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Copies the upper triangle to the lower.
pub(crate) fn mirror(sum: &mut [f64], columns: usize) {
    for i in 0..columns {
        for j in 0..i {
            sum[i * columns + j] = sum[j * columns + i];
        }
    }
}

/// Appends `A B` to `out`; `a` has `inner` columns and `b` has `columns`.
pub(crate) fn append_product(
    out: &mut Vec<f64>,
    a: &[f64],
    b: &[f64],
    [inner, columns]: [usize; 2],
) {
    let first = out.len();
    let rows = a.len() / inner.max(1);
    out.resize(first + rows * columns, 0.0);
    let out = &mut out[first..];
    Arch::new().dispatch(|| {
        for i in (0..rows).step_by(ROWS) {
            add_band(out, Rows::plain(a, inner, i), b, columns, 0);
        }
    });
}

/// Up to [`ROWS`] rows of the left factor, as the product needs them.
#[derive(Clone, Copy)]
struct Rows<'a> {
    elements: &'a [f64],
    /// First of the rows, their number, and how far the elements of a row and of a column are apart.
    first: usize,
    count: usize,
    along: usize,
    down: usize,
}

impl<'a> Rows<'a> {
    /// Rows of `A` with `columns` columns.
    fn plain(a: &'a [f64], columns: usize, first: usize) -> Self {
        Self {
            elements: &a[first * columns..],
            first,
            count: (a.len() / columns - first).min(ROWS),
            along: 1,
            down: columns,
        }
    }

    /// Rows of `Aᵀ`, columns of `A`.
    fn transposed(a: &'a [f64], columns: usize, first: usize) -> Self {
        Self {
            elements: &a[first.min(a.len())..],
            first,
            count: (columns - first).min(ROWS),
            along: columns,
            down: 1,
        }
    }
}

/// Adds the product of `rows` with the columns from `j` on of `b`, which has `m` columns.
#[inline(always)]
fn add_band(sum: &mut [f64], rows: Rows<'_>, b: &[f64], m: usize, mut j: usize) {
    while j < m {
        let columns = match m - j {
            COLUMNS.. => add_columns::<COLUMNS>(sum, rows, b, [m, j]),
            4.. => add_columns::<4>(sum, rows, b, [m, j]),
            2.. => add_columns::<2>(sum, rows, b, [m, j]),
            _ => add_columns::<1>(sum, rows, b, [m, j]),
        };
        j += columns;
    }
}

/// Returns the number of columns.
#[inline(always)]
fn add_columns<const C: usize>(
    sum: &mut [f64],
    rows: Rows<'_>,
    b: &[f64],
    place: [usize; 2],
) -> usize {
    match rows.count {
        1 => add_tile::<1, C>(sum, rows, b, place),
        2 => add_tile::<2, C>(sum, rows, b, place),
        3 => add_tile::<3, C>(sum, rows, b, place),
        _ => add_tile::<ROWS, C>(sum, rows, b, place),
    }
    C
}

/// One tile: `R` rows and `C` columns from `j` on.
#[inline(always)]
fn add_tile<const R: usize, const C: usize>(
    sum: &mut [f64],
    rows: Rows<'_>,
    b: &[f64],
    [m, j]: [usize; 2],
) {
    let mut tile = [[0.0; C]; R];
    let mut place = 0;
    for b in b.chunks_exact(m) {
        let Some(b) = b[j..].first_chunk::<C>() else {
            break;
        };
        for (i, tile) in tile.iter_mut().enumerate() {
            let a = rows.elements[place + i * rows.down];
            for (t, b) in tile.iter_mut().zip(b) {
                *t += a * b;
            }
        }
        place += rows.along;
    }
    for (i, tile) in tile.iter().enumerate() {
        let start = (rows.first + i) * m + j;
        for (sum, t) in sum[start..start + C].iter_mut().zip(tile) {
            *sum += t;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    fn matrix(rows: usize, columns: usize, seed: f64) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |i, j| {
            (seed + 1.7 * i as f64 - 0.9 * j as f64).sin()
        })
    }

    fn rows_of(matrix: &DMatrix<f64>) -> Vec<f64> {
        matrix.transpose().as_slice().to_vec()
    }

    fn close(found: &[f64], expected: &DMatrix<f64>) {
        let expected = rows_of(expected);
        assert_eq!(found.len(), expected.len());
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() < 1e-13, "{f} {e}");
        }
    }

    #[test]
    fn products_are_those_of_matrices() {
        for (k, n, m) in [
            (12, 9, 22),
            (3, 3, 22),
            (3, 9, 9),
            (5, 1, 2),
            (1, 7, 6),
            (4, 4, 4),
        ] {
            let (a, b) = (matrix(k, n, 0.3), matrix(k, m, 1.1));
            let mut sum = vec![1.0; n * m];
            add_transposed_product(&mut sum, &rows_of(&a), &rows_of(&b), [n, m]);
            close(&sum, &(a.tr_mul(&b).add_scalar(1.0)));
            let right = matrix(n, m, 2.0);
            let mut out = Vec::new();
            append_product(&mut out, &rows_of(&a), &rows_of(&right), [n, m]);
            close(&out, &(&a * right));
            let mut sum = vec![0.0; n * n];
            add_symmetric_product(&mut sum, &rows_of(&a), &rows_of(&a), n);
            mirror(&mut sum, n);
            close(&sum, &a.tr_mul(&a));
        }
    }

    #[test]
    fn nothing_times_nothing_is_nothing() {
        let mut out = Vec::new();
        append_product(&mut out, &[], &[], [0, 0]);
        append_product(&mut out, &[], &[1.0, 2.0], [1, 2]);
        add_transposed_product(&mut [], &[], &[], [0, 0]);
        assert!(out.is_empty());
    }
}
