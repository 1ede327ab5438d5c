//! What the interpolation between steps may be off by.
//!
//! Leaving out the step at `q_j` and interpolating from its four neighbours leaves
//! `r_j = f[q_{j-2}, …, q_{j+2}] ω_j`, Newton's remainder there ([`crate::curve`]), and between the true
//! steps, which are nearer, the remainder is `f[…] ω(q)`. So what leaving steps out shows is taken to the true
//! spacing by the divided differences, whose mean square beyond the noise is
//!
//! ```text
//! s² = mean_j ((Σ w_jk f_k)² - w_jᵀ cov(f) w_j)     u(q) = s |ω(q)|
//! ```
//!
//! over all windows of five steps of a curve (0 if that is negative). In the middle between steps of equal distance
//! `r_j` is 64/9 times as large, so that an interpolation error that is hidden in the noise is small beside it. For
//! a wave of amplitude a the error of a sample at random is a part of a wave as well, whose rms this is; it holds
//! for waves of four steps and more (u is 15 % too small at five). What fits between the steps unseen is unseen.
//!
//! Outside the steps the errors of the nearest are held, whose remainder is `f[q_0, q] (q - q_0)`: the same with the
//! slopes of the curve.

use nalgebra::Vector6;
use trueaxis_kinematics::MotionError;

use crate::curve::{Curve, Sample};
use crate::factored_covariance::FactoredCovariance;

/// `s` of the six components, for both orders.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Remainder {
    between: Vector6<f64>,
    slope: Vector6<f64>,
}

impl Remainder {
    /// Of the errors of an axis; its component errors begin at `first` among the results.
    pub(crate) fn new(
        curve: &Curve,
        errors: &[MotionError],
        factors: &FactoredCovariance,
        first: usize,
    ) -> Self {
        let rms = |differences: &[Vec<(usize, f64)>]| {
            let mut sum = Vector6::zeros();
            for difference in differences {
                let mut value: Vector6<f64> = Vector6::zeros();
                let mut places = Vec::new();
                for &(node, weight) in difference {
                    value += errors[node].to_vector() * weight;
                    places.extend((0..6).map(|c| (first + 6 * node + c, Vector6::ith(c, weight))));
                }
                let noise = factors.of_functions(&places, &places).diagonal();
                sum += value.component_mul(&value) - noise;
            }
            sum.map(|sum| (sum.max(0.0) / differences.len().max(1) as f64).sqrt())
        };
        Self {
            between: rms(&curve.divided_differences(false)),
            slope: rms(&curve.divided_differences(true)),
        }
    }

    /// Standard uncertainty of a sample of the curve beside that of the data, mm and rad.
    pub(crate) fn u(&self, sample: &Sample) -> Vector6<f64> {
        self.between * sample.remainder + self.slope * sample.beyond
    }
}
