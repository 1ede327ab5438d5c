//! Tail of the χ² distribution by its logarithm: p-values are often too small for an f64.

use statrs::function::erf::erfc;

/// Natural logarithm of `P(χ²_k > x)`.
///
/// By the recursion `Q_{k+2} = Q_k + (x/2)^{k/2} e^{-x/2} / Γ(k/2 + 1)` from `Q_0 = 0` or
/// `Q_1 = erfc √(x/2)`, with `e^{-x/2}` taken out.
pub fn ln_chi_squared(x: f64, degrees_of_freedom: usize) -> f64 {
    if degrees_of_freedom == 0 || x <= 0.0 {
        return 0.0;
    }
    let half = 0.5 * x;
    let odd = degrees_of_freedom % 2 == 1;
    // Q_k e^{x/2}, and the next term.
    let (mut sum, mut term, mut k) = if odd {
        (
            scaled_erfc(half.sqrt()),
            2.0 * (half / std::f64::consts::PI).sqrt(),
            1,
        )
    } else {
        (0.0, 1.0, 0)
    };
    while k < degrees_of_freedom {
        sum += term;
        k += 2;
        term *= half / (0.5 * k as f64);
    }
    (sum.ln() - half).min(0.0)
}

/// `e^{z²} erfc z`; for large z the first terms of its asymptotic series, whose error is below
/// `2/z⁶`.
fn scaled_erfc(z: f64) -> f64 {
    if z < LARGE {
        return (z * z).exp() * erfc(z);
    }
    let q = 0.5 / (z * z);
    (1.0 - q + 3.0 * q * q) / (z * std::f64::consts::PI.sqrt())
}

/// Smallest z at which the series has ten digits; `erfc` is still far from underflow.
const LARGE: f64 = 20.0;

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::function::gamma::gamma_ur;

    #[test]
    fn agrees_with_the_incomplete_gamma_function() {
        for k in 1..8 {
            for x in [0.01, 0.7, 3.0, 20.0, 150.0, 650.0] {
                let expected = gamma_ur(0.5 * k as f64, 0.5 * x).ln();
                let found = ln_chi_squared(x, k);
                assert!(
                    (found - expected).abs() < 1e-8 * expected.abs().max(1.0),
                    "{k} {x}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn goes_on_where_the_probability_underflows() {
        assert!((ln_chi_squared(4000.0, 2) + 2000.0).abs() < 1e-9);
        let (one, three) = (ln_chi_squared(4000.0, 1), ln_chi_squared(4000.0, 3));
        assert!(-2006.0 < one && one < -2000.0 && three > one);
    }
}
