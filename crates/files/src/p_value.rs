//! P-values as people read them.

/// Below this a p-value is a bound: the tails of the distributions underflow soon after.
const LEAST: f64 = 1e-300;

/// A p-value as an equation: `p = 0.042`, `p = 3e-12`, `p < 1e-300`.
pub fn p_value(p: f64) -> String {
    match p < LEAST {
        true => format!("p < {LEAST:.0e}"),
        false => format!("p = {}", probability(p)),
    }
}

/// The same without its name: `0.042`, `3e-12`, `below 1e-300`.
pub fn probability(p: f64) -> String {
    match p {
        p if p < LEAST => format!("below {LEAST:.0e}"),
        p if p < 1e-3 => format!("{p:.0e}"),
        p => format!("{p:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_underflows_is_a_bound() {
        assert_eq!(p_value(0.0), "p < 1e-300");
        assert_eq!(p_value(3.4e-12), "p = 3e-12");
        assert_eq!(p_value(0.0417), "p = 0.042");
        assert_eq!(probability(0.0), "below 1e-300");
        assert_eq!(probability(3.4e-12), "3e-12");
    }
}
