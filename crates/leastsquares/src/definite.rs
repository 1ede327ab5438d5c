//! A small symmetric positive definite system.
//!
//! `A = L D Lᵀ` by elimination without exchanges, which definite matrices do not need (N. Higham, *Accuracy
//! and Stability of Numerical Algorithms*, chapter 10). The rows of `L⁻¹`, which are what the same
//! elimination makes of the unit matrix, take the places that become zero: they give the solution without
//! substitution, and the trace of the inverse tells how far the matrix is from a singular one.
//!
//! ```text
//! x = L⁻ᵀ D⁻¹ L⁻¹ g      gᵀ A⁻¹ g = |D^(-1/2) L⁻¹ g|²      tr A⁻¹ = |D^(-1/2) L⁻¹|²
//! ```

/// Solution of `A x = g`.
pub(crate) struct Definite {
    pub(crate) solution: Vec<f64>,
    /// `gᵀ A⁻¹ g`.
    pub(crate) square: f64,
    /// `tr A⁻¹`, not below the largest eigenvalue of the inverse.
    pub(crate) trace_of_inverse: f64,
}

/// Solves a system whose matrix has its upper triangle in contiguous rows; what is below does not
/// matter, and nothing of it is left. None if the matrix is not definite.
#[inline(always)]
pub(crate) fn solve_definite(matrix: &mut [f64], mut right: Vec<f64>) -> Option<Definite> {
    let n = right.len();
    let mut solved = Definite {
        solution: vec![0.0; n],
        square: 0.0,
        trace_of_inverse: 0.0,
    };
    for k in 0..n {
        let (above, below) = matrix.split_at_mut((k + 1) * n);
        let row_k = &above[k * n..];
        let pivot = row_k[k];
        if pivot.is_nan() || pivot <= 0.0 {
            return None;
        }
        let reciprocal = 1.0 / pivot;
        for (row, i) in below.chunks_exact_mut(n).zip(k + 1..) {
            let factor = row_k[i] * reciprocal;
            subtract(&mut row[..k], factor, &row_k[..k]);
            row[k] = -factor;
            subtract(&mut row[i..], factor, &row_k[i..]);
            right[i] -= factor * right[k];
        }
        // Row k of L⁻¹ up to its diagonal, which is one.
        let along = right[k] * reciprocal;
        solved.square += along * right[k];
        let mut squares = 1.0;
        for (x, inverse) in solved.solution.iter_mut().zip(&row_k[..k]) {
            *x += along * inverse;
            squares += inverse * inverse;
        }
        solved.solution[k] = along;
        solved.trace_of_inverse += squares * reciprocal;
    }
    Some(solved)
}

/// `x <- x - factor y`.
#[inline(always)]
fn subtract(x: &mut [f64], factor: f64, y: &[f64]) {
    for (x, y) in x.iter_mut().zip(y) {
        *x -= factor * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_and_tells_the_trace_of_the_inverse() {
        // A = L D Lᵀ with L = [1 0 0; 2 1 0; -1 3 1] and D = diag(4, 1, 0.25).
        let mut matrix = [4.0, 8.0, -4.0, 0.0, 17.0, -5.0, 0.0, 0.0, 13.25];
        // A (1, -1, 2).
        let right = vec![-12.0, -19.0, 27.5];
        let square = -12.0 + 19.0 + 55.0;
        let solved = solve_definite(&mut matrix, right).unwrap();
        for (x, expected) in solved.solution.iter().zip([1.0, -1.0, 2.0]) {
            assert!((x - expected).abs() < 1e-13, "{x}");
        }
        assert!((solved.square - square).abs() < 1e-12);
        // L⁻¹ = [1 0 0; -2 1 0; 7 -3 1].
        let trace = 1.0 / 4.0 + 5.0 + 59.0 / 0.25;
        assert!((solved.trace_of_inverse - trace).abs() < 1e-11);
    }

    #[test]
    fn refuses_what_is_not_definite() {
        assert!(solve_definite(&mut [1.0, 2.0, 0.0, 4.0], vec![0.0; 2]).is_none());
        assert!(solve_definite(&mut [1.0, 2.0, 0.0, 3.0], vec![0.0; 2]).is_none());
        assert!(solve_definite(&mut [f64::NAN], vec![0.0]).is_none());
        assert!(solve_definite(&mut [], Vec::new()).is_some());
    }
}
