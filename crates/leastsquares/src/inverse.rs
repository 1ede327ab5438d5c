//! Inverse of a small symmetric matrix that need not be definite.
//!
//! The reduced system has some twenty unknowns; a blocked factorisation spends more on its set-up than
//! this takes.

/// Inverts a matrix in place, of which the upper triangle is given in contiguous rows, by Gauss–Jordan
/// elimination with row exchanges, and makes the inverse symmetric. False if it is singular to the last
/// bit; the contents are then of no use.
pub(crate) fn invert(matrix: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        for j in 0..i {
            matrix[i * n + j] = matrix[j * n + i];
        }
    }
    let mut exchanged = vec![0; n];
    let mut pivot_row = vec![0.0; n];
    for k in 0..n {
        let size = |row: usize| matrix[row * n + k].abs();
        let pivot = (k..n).fold(
            k,
            |best, row| if size(row) > size(best) { row } else { best },
        );
        let value = matrix[pivot * n + k];
        if value.abs() < f64::MIN_POSITIVE {
            return false;
        }
        exchanged[k] = pivot;
        // Row k of the system, divided by its pivot, in the place of the pivot's column the inverse's.
        pivot_row.copy_from_slice(&matrix[pivot * n..(pivot + 1) * n]);
        matrix.copy_within(k * n..(k + 1) * n, pivot * n);
        pivot_row[k] = 1.0;
        pivot_row.iter_mut().for_each(|x| *x /= value);
        for (i, row) in matrix.chunks_exact_mut(n).enumerate() {
            if i == k {
                row.copy_from_slice(&pivot_row);
                continue;
            }
            let factor = std::mem::take(&mut row[k]);
            for (x, p) in row.iter_mut().zip(&pivot_row) {
                *x -= factor * p;
            }
        }
    }
    // Exchanged rows of the matrix are exchanged columns of its inverse.
    for k in (0..n).rev() {
        if exchanged[k] != k {
            for row in matrix.chunks_exact_mut(n) {
                row.swap(k, exchanged[k]);
            }
        }
    }
    for i in 0..n {
        for j in 0..i {
            let mean = 0.5 * (matrix[i * n + j] + matrix[j * n + i]);
            (matrix[i * n + j], matrix[j * n + i]) = (mean, mean);
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverts_an_indefinite_matrix_without_usable_diagonal() {
        let matrix = [
            [0.0, 2.0, -1.0, 0.5],
            [2.0, 0.0, 3.0, 1.0],
            [-1.0, 3.0, 0.0, -2.0],
            [0.5, 1.0, -2.0, 1.0],
        ];
        let mut inverse = matrix.concat();
        assert!(invert(&mut inverse, 4));
        for (i, row) in matrix.iter().enumerate() {
            for j in 0..4 {
                let product: f64 = (0..4).map(|k| row[k] * inverse[k * 4 + j]).sum();
                let unit = if i == j { 1.0 } else { 0.0 };
                assert!((product - unit).abs() < 1e-14, "{i} {j}: {product}");
            }
        }
    }

    #[test]
    fn says_what_is_singular() {
        assert!(!invert(&mut [1.0, 0.0, 0.0, 0.0], 2));
        assert!(!invert(&mut [0.0; 9], 3));
        assert!(invert(&mut [], 0));
    }
}
