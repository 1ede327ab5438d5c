//! Several observations of one value: their weighted mean, and which of them contradict it.
//!
//! ```text
//! y = 1 x + e     x = (1ᵀ V⁻¹ y) / (1ᵀ V⁻¹ 1)     w_k = eᵀV⁻¹r / √(eᵀV⁻¹ Q V⁻¹e)     Q = V - u² 1 1ᵀ
//! ```
//!
//! with Baarda's `w` of each, as for lengths.

use nalgebra::{DMatrix, DVector};
use trueaxis_leastsquares::chi_squared_upper_tail;

use crate::report::KnownMisfit;

/// The mean of what does not contradict the others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CommonValue {
    pub(crate) value: f64,
    /// Of each observation; zero for those that were removed.
    pub(crate) weights: Vec<f64>,
    /// How those that contradict the others differ from them: all that were removed, and several of which nothing
    /// tells which is wrong.
    pub(crate) misfits: Vec<Contradiction>,
}

/// An observation that contradicts the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Contradiction {
    pub(crate) observation: usize,
    /// By how much it differs from what the others say.
    pub(crate) difference: f64,
    /// Square of Baarda's `w`.
    pub(crate) chi_squared: f64,
    pub(crate) p_value: f64,
}

impl Contradiction {
    /// In words; the difference is the known value less the one found, in mm.
    pub(crate) fn of(&self, what: String, difference_mm: f64) -> KnownMisfit {
        KnownMisfit {
            what,
            difference_mm,
            chi_squared: self.chi_squared,
            p_value: self.p_value,
        }
    }
}

/// Tests that differ by less are equal: two observations contradict each other, and nothing tells which is wrong.
const TIE: f64 = 0.01;

/// Nothing checks an observation of which the others leave less than this part.
const CHECKED: f64 = 1e-6;

/// The mean of observations with this covariance; the first `may_leave` of them are removed, one after the other, if
/// their `|w|` is beyond `limit`. `None` if nothing is left.
pub(crate) fn common_value(
    observed: &[f64],
    covariance: &DMatrix<f64>,
    may_leave: usize,
    limit: f64,
) -> Option<CommonValue> {
    let mut kept: Vec<usize> = (0..observed.len()).collect();
    let mut misfits = Vec::new();
    loop {
        if kept.is_empty() {
            return None;
        }
        let v = covariance.select_rows(&kept).select_columns(&kept);
        let inverse = v.try_inverse()?;
        let y = DVector::from_iterator(kept.len(), kept.iter().map(|&k| observed[k]));
        let ones = DVector::from_element(kept.len(), 1.0);
        let variance = 1.0 / ones.dot(&(&inverse * &ones));
        let weights = &inverse * &ones * variance;
        let value = weights.dot(&y);
        let left = &inverse * (y - &ones * value);
        let redundant = &inverse - &weights * weights.transpose() / variance;
        let test = |i: usize| {
            let checked = redundant[(i, i)] > CHECKED * inverse[(i, i)];
            let w = left[i] / redundant[(i, i)].sqrt();
            (checked && w.abs() > limit).then(|| Contradiction {
                observation: kept[i],
                difference: left[i] / redundant[(i, i)],
                chi_squared: w * w,
                p_value: chi_squared_upper_tail(w * w, 1.0),
            })
        };
        let suspects = (0..kept.len()).filter(|&i| kept[i] < may_leave);
        let mut suspects: Vec<Contradiction> = suspects.filter_map(test).collect();
        suspects.sort_by(|a, b| b.chi_squared.total_cmp(&a.chi_squared));
        let tied =
            |other: &Contradiction| other.chi_squared >= (1.0 - TIE) * suspects[0].chi_squared;
        match suspects.iter().filter(|other| tied(other)).count() {
            1 => {
                misfits.push(suspects[0]);
                kept.retain(|&k| k != suspects[0].observation);
            }
            ties => {
                misfits.extend_from_slice(&suspects[..ties]);
                let mut of_all = vec![0.0; observed.len()];
                for (&k, weight) in kept.iter().zip(weights.iter()) {
                    of_all[k] = *weight;
                }
                return Some(CommonValue {
                    value,
                    weights: of_all,
                    misfits,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_three_leaves_and_of_two_none() {
        let v = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1.0, 4.0]));
        let found = common_value(&[10.0, 0.0, 1.0], &v, 3, 3.0).unwrap();
        assert_eq!(found.misfits.len(), 1);
        assert_eq!(found.misfits[0].observation, 0);
        // The others say 1/5, and the difference to that is 9.8.
        assert!((found.misfits[0].difference - 9.8).abs() < 1e-12);
        assert!((found.value - 0.2).abs() < 1e-12);
        assert!((found.weights[1] - 0.8).abs() < 1e-12);

        let two = DMatrix::from_diagonal_element(2, 2, 1.0);
        let found = common_value(&[10.0, 0.0], &two, 2, 3.0).unwrap();
        assert_eq!(found.misfits.len(), 2);
        assert!((found.value - 5.0).abs() < 1e-12);
        // Beside what is declared the other one leaves.
        let found = common_value(&[10.0, 0.0], &two, 1, 3.0).unwrap();
        assert_eq!(found.misfits.len(), 1);
        assert!(found.value.abs() < 1e-12);
        let one = DMatrix::from_element(1, 1, 1.0);
        let found = common_value(&[10.0], &one, 1, 3.0).unwrap();
        assert!(found.misfits.is_empty() && (found.value - 10.0).abs() < 1e-12);
    }
}
