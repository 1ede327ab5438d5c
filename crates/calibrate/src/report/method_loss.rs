//! What other methods would lose on the same lengths.
//!
//! The points of the same lengths without rigid stages give poses by nine or six equations. Their noise goes through
//! the dependence of the results on the poses, which is that of the joint adjustment: nothing is screened or
//! identified again.

use trueaxis_poses::{NoiseByEquations, PoseNoise};

use crate::propagate::propagation::{Noise, Propagation};
use crate::result::calibration::MethodLoss;

/// For each axis the ratios of standard uncertainties.
pub(crate) fn method_loss(
    by_equations: &NoiseByEquations,
    propagation: &Propagation<'_, '_>,
) -> Vec<MethodLoss> {
    let axes = propagation.dependence.context.data.len();
    let joint = squares(&propagation.whole, axes);
    let ratios = |noise: &PoseNoise| -> Vec<[f64; 6]> {
        let other = squares(&Noise::new(propagation.dependence, noise), axes);
        let ratio =
            |(a, b): (&[f64; 6], &[f64; 6])| std::array::from_fn(|c| (a[c] / b[c]).max(0.0).sqrt());
        other.iter().zip(&joint).map(ratio).collect()
    };
    let nine = ratios(&by_equations.nine);
    let six = by_equations.six.as_ref().map(ratios);
    let of_axis = |(k, nine)| MethodLoss {
        nine,
        six: six.as_ref().map(|six| six[k]),
    };
    nine.into_iter().enumerate().map(of_axis).collect()
}

/// Sums of the variances of each component over the nodes of each axis.
fn squares(noise: &Noise<'_>, axes: usize) -> Vec<[f64; 6]> {
    let of_axis = |k: usize| {
        let mut sums = [0.0; 6];
        for node in noise.components(k) {
            for (sum, variance) in sums.iter_mut().zip(node) {
                *sum += (variance.own + variance.through).max(0.0);
            }
        }
        sums
    };
    (0..axes).map(of_axis).collect()
}
