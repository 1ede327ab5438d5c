//! Products of small matrices with contiguous rows, `S += A B`.
//!
//! A tile of a few elements of the result stays in registers while the sum runs over the rows: a
//! sum in memory would be loaded and stored for every product. Products are fused with their sums, so the bits
//! are the same with all registers. A matrix whose columns are contiguous is one whose transpose has contiguous rows.
//!
//! Matrices are slices; sizes that do not fit panic.

use crate::in_widest_registers;

/// Rows of a tile, and the most columns: sixteen registers of four numbers hold it with its factors.
const ROWS: usize = 4;
const COLUMNS: usize = 8;

/// Appends `A B` to `out`; `a` has `inner` columns and `b` has `columns`.
pub fn append_product(out: &mut Vec<f64>, a: &[f64], b: &[f64], [inner, columns]: [usize; 2]) {
    let first = out.len();
    let rows = a.len() / inner.max(1);
    out.resize(first + rows * columns, 0.0);
    add_product(&mut out[first..], a, b, [inner, columns]);
}

/// `sum += A B`; `a` has `inner` columns and `b` has `columns`.
pub fn add_product(sum: &mut [f64], a: &[f64], b: &[f64], [inner, columns]: [usize; 2]) {
    let mut product = Product {
        sum,
        a,
        b,
        rows: a.len() / inner.max(1),
        inner,
        columns,
    };
    in_widest_registers(
        #[inline(always)]
        || product.add_rows(),
    );
}

/// `aᵀ b`, in four sums that do not wait for each other.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
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
pub fn mirror(sum: &mut [f64], columns: usize) {
    for i in 0..columns {
        for j in 0..i {
            sum[i * columns + j] = sum[j * columns + i];
        }
    }
}

/// `sum += A B`.
struct Product<'a> {
    sum: &'a mut [f64],
    a: &'a [f64],
    b: &'a [f64],
    rows: usize,
    inner: usize,
    columns: usize,
}

impl Product<'_> {
    // All of it is inlined here: only then it is compiled for the registers that were chosen.
    #[inline(always)]
    fn add_rows(&mut self) {
        for i in (0..self.rows).step_by(ROWS) {
            let mut j = 0;
            while j < self.columns {
                j += match self.columns - j {
                    COLUMNS.. => self.add_columns::<COLUMNS>(i, j),
                    4.. => self.add_columns::<4>(i, j),
                    2.. => self.add_columns::<2>(i, j),
                    _ => self.add_columns::<1>(i, j),
                };
            }
        }
    }

    /// Returns the number of columns.
    #[inline(always)]
    fn add_columns<const C: usize>(&mut self, i: usize, j: usize) -> usize {
        match self.rows - i {
            ROWS.. => self.add_tile::<ROWS, C>(i, j),
            3 => self.add_tile::<3, C>(i, j),
            2 => self.add_tile::<2, C>(i, j),
            _ => self.add_tile::<1, C>(i, j),
        }
        C
    }

    /// The tile of `R` rows and `C` columns from `i` and `j` on.
    #[inline(always)]
    fn add_tile<const R: usize, const C: usize>(&mut self, i: usize, j: usize) {
        let mut tile = [[0.0; C]; R];
        for (place, b) in (i * self.inner..).zip(self.b.chunks_exact(self.columns)) {
            let Some(b) = b[j..].first_chunk::<C>() else {
                break;
            };
            for (r, tile) in tile.iter_mut().enumerate() {
                let a = self.a[place + r * self.inner];
                for (t, b) in tile.iter_mut().zip(b) {
                    *t = a.mul_add(*b, *t);
                }
            }
        }
        for (r, tile) in tile.iter().enumerate() {
            let start = (i + r) * self.columns + j;
            for (sum, t) in self.sum[start..start + C].iter_mut().zip(tile) {
                *sum += t;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    fn matrix(rows: usize, columns: usize, seed: f64) -> Mat<f64> {
        Mat::from_fn(rows, columns, |i, j| {
            (seed + 1.7 * i as f64 - 0.9 * j as f64).sin()
        })
    }

    fn rows_of(matrix: &Mat<f64>) -> Vec<f64> {
        let rows = matrix.row_iter();
        rows.flat_map(|row| row.iter().copied().collect::<Vec<_>>())
            .collect()
    }

    fn close(found: &[f64], expected: &Mat<f64>) {
        let expected = rows_of(expected);
        assert_eq!(found.len(), expected.len());
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() < 1e-13, "{f} {e}");
        }
    }

    #[test]
    fn products_are_those_of_matrices() {
        for (n, k, m) in [
            (12, 9, 22),
            (3, 3, 22),
            (3, 9, 9),
            (5, 1, 2),
            (1, 7, 6),
            (4, 4, 4),
        ] {
            let (a, b) = (matrix(n, k, 0.3), matrix(k, m, 1.1));
            let mut out = Vec::new();
            append_product(&mut out, &rows_of(&a), &rows_of(&b), [k, m]);
            close(&out, &(&a * &b));
            add_product(&mut out, &rows_of(&a), &rows_of(&b), [k, m]);
            close(&out, &(2.0 * &a * &b));
        }
    }

    #[test]
    fn upper_is_copied_to_lower() {
        let mut square = vec![1.0, 2.0, 0.0, 3.0];
        mirror(&mut square, 2);
        assert_eq!(square, [1.0, 2.0, 2.0, 3.0]);
    }

    #[test]
    fn nothing_times_nothing_is_nothing() {
        let mut out = Vec::new();
        append_product(&mut out, &[], &[], [0, 0]);
        append_product(&mut out, &[], &[1.0, 2.0], [1, 2]);
        assert!(out.is_empty());
    }
}
