//! Causes that cancel each other.
//!
//! Lost motion, and an offset of the time stamps at a nearly even feed, change readings in nearly the same way:
//! opposite to each other they can have any size, because of the small variation of the feed.

use trueaxis_selection::{Fit, Projection, combined, gram_matrix};

/// Ratio of the squares of one effect to those of all effects together.
const OPPOSED: f64 = 25.0;

/// Whether the effect of one cause is far larger than that of all causes together, after what a model absorbs. `effects`
/// has the whitened effect of each.
pub(crate) fn are_opposed(model: &Projection, effects: &[Vec<f64>]) -> bool {
    let matrix = gram_matrix(model, effects);
    let each = (0..effects.len()).map(|k| matrix[k * (effects.len() + 1)]);
    let together: f64 = matrix.iter().sum();
    each.fold(0.0, f64::max) > OPPOSED * together
}

/// The effect of each cause, with all sizes fitted together.
pub(crate) fn fitted_effects(model: &Projection, of_each: &[Vec<Vec<f64>>]) -> Vec<Vec<f64>> {
    let fit = Fit::new(model, &of_each.concat());
    let mut sizes = fit.estimates.as_slice();
    let effects = of_each.iter().map(|columns| {
        let (own, others) = sizes.split_at(columns.len());
        sizes = others;
        combined(model.rows(), columns, own)
    });
    effects.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two equal effects, 700 against 690 leave 10; of 7 against 3 the larger is left.
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
