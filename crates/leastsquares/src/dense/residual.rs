//! Residuals as if computed in twice the working precision.
//!
//! Error-free transformations of sum and product with the errors carried along: `Dot2` of Ogita,
//! Rump, Oishi, Accurate sum and dot product, SIAM J. Sci. Comput. 26 (2005).

use nalgebra::DMatrix;

/// `y - A x`, rounded once at the end.
pub(super) fn twofold_residual(
    matrix: &DMatrix<f64>,
    unknowns: &[f64],
    right_side: &[f64],
) -> Vec<f64> {
    let row = |i: usize| {
        let (mut sum, mut error) = (right_side[i], 0.0);
        for (j, &x) in unknowns.iter().enumerate() {
            let a = -matrix[(i, j)];
            let product = a * x;
            let product_error = a.mul_add(x, -product);
            let next = sum + product;
            let virtual_product = next - sum;
            let sum_error = (sum - (next - virtual_product)) + (product - virtual_product);
            sum = next;
            error += sum_error + product_error;
        }
        sum + error
    };
    (0..right_side.len()).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_what_cancellation_would_lose() {
        // (1 + e)² - 1 - 2 e = e², far below the rounding of its parts.
        let e = f64::EPSILON;
        let matrix = DMatrix::from_fn(1, 3, |_, j| [1.0 + e, -1.0, -2.0 * e][j]);
        let unknowns = [1.0 + e, 1.0, 1.0];
        let residual = twofold_residual(&matrix, &unknowns, &[0.0]);
        assert!((residual[0] + e * e).abs() < e * e * e);
    }
}
