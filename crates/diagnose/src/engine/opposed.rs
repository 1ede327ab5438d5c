//! Causes that take each other away.
//!
//! Lost motion, and an offset of the time stamps at an almost even feed, do nearly the same to readings: against each other they can be
//! as large as they like, for what little the feed varies.

use trueaxis_selection::{Fit, Projection, combined, gram_matrix};

/// What one cause does against what all do together, in squares.
const OPPOSED: f64 = 25.0;

/// Whether one of some causes does far more to the data than all of them together, beside what a model absorbs. `does` is what each
/// does, whitened.
pub(crate) fn are_opposed(model: &Projection, does: &[Vec<f64>]) -> bool {
    let matrix = gram_matrix(model, does);
    let each = (0..does.len()).map(|k| matrix[k * (does.len() + 1)]);
    let together: f64 = matrix.iter().sum();
    each.fold(0.0, f64::max) > OPPOSED * together
}

/// What each of some causes does, with the sizes that they have beside each other.
pub(crate) fn does_with(model: &Projection, of_each: &[Vec<Vec<f64>>]) -> Vec<Vec<f64>> {
    let fit = Fit::new(model, &of_each.concat());
    let mut sizes = fit.estimates.as_slice();
    let does = of_each.iter().map(|columns| {
        let (own, others) = sizes.split_at(columns.len());
        sizes = others;
        combined(model.rows(), columns, own)
    });
    does.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two that are alike: 700 against 690 leave 10; of 7 against 3 the larger one is left.
    #[test]
    fn two_that_cancel_are_opposed() {
        let at = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let one = |size: f64| (0..40).map(|i| size * at(i)).collect::<Vec<f64>>();
        let other = |size: f64| {
            let uneven = (0..40).map(|i| 1.0 + if i < 8 { 0.01 } else { 0.0 });
            let column = uneven.enumerate().map(|(i, uneven)| size * uneven * at(i));
            column.collect::<Vec<f64>>()
        };
        let model = Projection::dense(vec![0.0; 40], &[vec![1.0; 40]]);
        assert!(are_opposed(&model, &[one(-700.0), other(690.0)]));
        assert!(!are_opposed(&model, &[one(7.0), other(3.0)]));
        assert!(!are_opposed(&model, &[one(7.0), other(-3.0)]));
        assert!(!are_opposed(&model, &[one(5.0)]));
    }
}
