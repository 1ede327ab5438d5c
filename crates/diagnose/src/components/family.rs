//! The number of tests made.

use std::collections::BTreeMap;

use trueaxis_selection::Null;

/// The tests of each effect, on the whole machine.
#[derive(Debug, Clone, Default)]
pub(crate) struct Family {
    tests: BTreeMap<&'static str, Vec<Null>>,
}

/// Largest family-wise p-value of a named cause.
pub(crate) const LEVEL: f64 = 0.01;

impl Family {
    pub(crate) fn add(&mut self, effect: &'static str, tests: Null) {
        self.tests.entry(effect).or_default().push(tests);
    }

    /// Family-wise p-value of an effect. Each effect has the same share of the level, which its own tests share, so
    /// that an effect with one hypothesis for an axis does not pay for the many periods of another.
    pub(crate) fn p_value(&self, effect: &str, ln_p: f64) -> f64 {
        let own = self.tests.get(effect).into_iter().flatten();
        let own: f64 = own.map(|null| null.tests_at(ln_p)).sum();
        let tests = own.max(1.0) * self.tests.len().max(1) as f64;
        Null::independent(tests).family_wise(ln_p).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_share_alike() {
        let mut family = Family::default();
        family.add("cyclic_error", Null::independent(90.0));
        family.add("cyclic_error", Null::independent(10.0));
        family.add("scale_error", Null::independent(1.0));
        let p = |effect| family.p_value(effect, 1e-6_f64.ln());
        assert!((p("cyclic_error") - 2e-4).abs() < 1e-7);
        assert!((p("scale_error") - 2e-6).abs() < 1e-9);
    }
}
