//! The F test of a drop of the sum of squares, by its logarithm: p-values are often too small for an f64.

use statrs::function::beta::{beta_reg, ln_beta};

/// Natural logarithm of the probability that `rank` columns without an effect lower the sum `squares` by as much as
/// `drop`; `degrees_of_freedom` are those before:
/// `I_y((ν - k)/2, k/2)`, `y = 1 - drop/squares`.
pub fn ln_f_test(drop: f64, squares: f64, rank: usize, degrees_of_freedom: f64) -> f64 {
    let (k, rest) = (rank as f64, degrees_of_freedom - rank as f64);
    if rank == 0 || rest <= 0.0 || drop <= 0.0 || squares <= 0.0 {
        return 0.0;
    }
    let left = (1.0 - drop / squares).max(f64::MIN_POSITIVE);
    let (a, b) = (0.5 * rest, 0.5 * k);
    let p = beta_reg(a, b, left);
    if p > SMALL {
        return p.ln();
    }
    // I_y(a, b) = y^a (1 - y)^b / (a B(a, b)) Σ_n y^n (a + b)_n / (a + 1)_n
    let (mut sum, mut term, mut n) = (1.0, 1.0, 0.0);
    while term > NEGLIGIBLE * sum && n < MOST_TERMS {
        term *= left * (a + b + n) / (a + 1.0 + n);
        sum += term;
        n += 1.0;
    }
    let tail = (1.0 - left).max(f64::MIN_POSITIVE);
    a * left.ln() + b * tail.ln() - a.ln() - ln_beta(a, b) + f64::ln(sum)
}

/// Terms of the series below this share are negligible; where p is small, terms fall like powers of y, which is well
/// below one.
const NEGLIGIBLE: f64 = 1e-14;
const MOST_TERMS: f64 = 1e5;

/// The probability of [`ln_f_test`].
pub fn f_test(drop: f64, squares: f64, rank: usize, degrees_of_freedom: f64) -> f64 {
    ln_f_test(drop, squares, rank, degrees_of_freedom).exp()
}

/// Below this value the series of the incomplete beta function has lost its digits.
const SMALL: f64 = 1e-280;

#[cfg(test)]
mod tests {
    use super::*;

    /// For k = 2 the tail is elementary: `(1 - T/S)^((ν-2)/2)`.
    #[test]
    fn agrees_with_the_closed_form_for_two_columns() {
        for drop in [0.5, 10.0, 200.0, 900.0] {
            let (squares, dof): (f64, f64) = (1000.0, 1002.0);
            let expected = 500.0 * (1.0 - drop / squares).ln();
            let found = ln_f_test(drop, squares, 2, dof);
            assert!(
                (found - expected).abs() < 1e-6 * expected.abs().max(1.0),
                "{drop}: {found} {expected}"
            );
        }
    }
}
