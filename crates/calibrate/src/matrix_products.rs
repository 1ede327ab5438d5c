//! Sums of products of small matrices, without the packing that products of large ones begin with.
//!
//! Columns that lie one after the other are the rows of the transpose, of which
//! [`trueaxis_leastsquares::row_products`] makes the products: `(A B)ᵀ = Bᵀ Aᵀ`.

use nalgebra::{Dim, IsContiguous, Matrix, RawStorage, RawStorageMut};
use trueaxis_leastsquares::row_products;

/// `sum += A B`.
///
/// # Panics
/// If the sizes do not fit.
pub(crate) fn add_product<N, K, L, M, S, A, B>(
    sum: &mut Matrix<f64, N, M, S>,
    a: &Matrix<f64, N, K, A>,
    b: &Matrix<f64, L, M, B>,
) where
    N: Dim,
    K: Dim,
    L: Dim,
    M: Dim,
    S: RawStorageMut<f64, N, M> + IsContiguous,
    A: RawStorage<f64, N, K> + IsContiguous,
    B: RawStorage<f64, L, M> + IsContiguous,
{
    assert_eq!(a.ncols(), b.nrows(), "columns of A and rows of B");
    assert_eq!(sum.shape(), (a.nrows(), b.ncols()), "size of A B");
    let sizes = [a.ncols(), a.nrows()];
    row_products::add_product(sum.as_mut_slice(), b.as_slice(), a.as_slice(), sizes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, Matrix6xX};

    #[test]
    fn products_are_those_of_matrices() {
        let a = Matrix6xX::from_fn(9, |i, j| (i as f64 - 0.7 * j as f64).sin());
        let b = DMatrix::from_fn(9, 22, |i, j| (0.3 * i as f64 + 1.1 * j as f64).cos());
        let mut sum = Matrix6xX::repeat(22, 1.0);
        add_product(&mut sum, &a, &b);
        assert!((sum - (&a * &b).add_scalar(1.0)).amax() < 1e-14);
    }

    #[test]
    fn nothing_adds_nothing() {
        let (a, b) = (Matrix6xX::zeros(0), DMatrix::zeros(0, 4));
        let mut sum = Matrix6xX::repeat(4, 2.0);
        add_product(&mut sum, &a, &b);
        assert_eq!(sum, Matrix6xX::repeat(4, 2.0));
        let mut empty = Matrix6xX::zeros(0);
        add_product(
            &mut empty,
            &Matrix6xX::repeat(3, 1.0),
            &DMatrix::zeros(3, 0),
        );
        assert_eq!(empty.len(), 0);
    }
}
