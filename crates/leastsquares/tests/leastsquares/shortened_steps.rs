//! A step that raises the cost is shortened, from what was linearised where it begins.

use trueaxis_leastsquares::{Adjustment, Error, Factors, Reduced, adjust};

/// `0 = atan x + e`: from beyond 1.39 a whole step leads to where the cost is higher. Beyond `limit` it is not reduced.
struct Arc {
    limit: f64,
}

impl Adjustment for Arc {
    type State = f64;
    /// Where it was linearised.
    type Linearised = f64;

    fn reduce(&self, x: &f64, linearised: &mut f64) -> Result<Reduced, Error> {
        *linearised = *x;
        let mut reduced = Reduced::new(1, 0);
        reduced.observe(&[(0, 1.0 / (1.0 + x * x))], -x.atan());
        Ok(reduced)
    }

    fn reduce_with_datum(&self, x: &f64) -> Result<(Reduced, Factors), Error> {
        Ok((self.reduce(x, &mut 0.0)?, Factors::default()))
    }

    fn step(&self, from: (&f64, &mut f64), s: &[f64], factor: f64, next: &mut f64) -> f64 {
        assert_eq!(from.0.to_bits(), from.1.to_bits(), "linearised elsewhere");
        *next = from.0 + s[0] * factor;
        next.atan().powi(2)
    }

    fn step_and_reduce(
        &self,
        (x, linearised): (&f64, &mut f64),
        s: &[f64],
        next: &mut f64,
    ) -> (f64, Result<Reduced, Error>) {
        let squares = self.step((x, linearised), s, 1.0, next);
        let reduced = self.reduce(next, linearised);
        let is_inside = next.abs() < self.limit;
        let refused = Err(Error::NotFinite { what: "the arc" });
        (squares, if is_inside { reduced } else { refused })
    }

    fn free_motions(&self, _: &f64) -> Vec<Vec<f64>> {
        Vec::new()
    }

    fn apply_datum(&self, _: &mut f64) {}
}

#[test]
fn a_step_that_raises_the_cost_is_shortened_from_where_it_began() {
    for start in [-1.9, -1.2, 0.5, 1.45, 1.9] {
        let adjusted = adjust(&Arc { limit: 2.0 }, &start).unwrap();
        assert!(adjusted.termination.is_converged(), "from {start}");
        assert!(adjusted.state.abs() < 1e-9, "from {start}");
    }
}

#[test]
fn an_error_where_a_step_leads_counts_if_it_is_made() {
    let arc = Arc { limit: 1e-3 };
    let outcome = adjust(&arc, &0.5);
    assert!(matches!(outcome, Err(Error::NotFinite { what: "the arc" })));
}
