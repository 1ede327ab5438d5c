//! Levenberg–Marquardt steps in a region whose radius follows from their success.
//!
//! ```text
//! min |r + J δx|²   subject to   |D δx| ≤ Δ
//! ```
//!
//! `D` holds the greatest length that each column of `J` has had, which makes the iteration
//! invariant to the scale of the unknowns: J. J. Moré, The Levenberg-Marquardt algorithm:
//! implementation and theory, Lecture Notes in Mathematics 630 (1978). The step is taken from the
//! singular values of `J D⁻¹`, so that every radius costs no more than a few sums.

use super::linearised::{Linearised, norm, squares};
use super::model::Model;
use super::scaled_svd::ScaledSvd;
use crate::Error;

/// A step must bring this fraction of the decrease that the linear model predicts.
const LEAST_GAIN: f64 = 1e-4;
/// Below this fraction of the predicted decrease the region shrinks to [`SHRINK`] of the step, …
const POOR_GAIN: f64 = 0.25;
const SHRINK: f64 = 0.25;
/// … above this one it grows to [`GROW`] times the step.
const GOOD_GAIN: f64 = 0.75;
const GROW: f64 = 2.0;

/// The length of a damped step may differ from the radius by this fraction.
const RADIUS_SLACK: f64 = 0.1;

/// Values of λ tried for it; three are usual.
const MAX_TRIALS: usize = 60;

#[derive(Debug)]
pub(super) struct TrustRegion {
    scale: Vec<f64>,
    radius: f64,
}

/// A step in components of the scaled Jacobian.
struct Step {
    components: Vec<f64>,
    length: f64,
    /// Whether it is the whole Gauss–Newton step.
    whole: bool,
}

impl TrustRegion {
    /// Steps as long as the unknowns themselves, in what they contribute to the residuals; as the
    /// residuals if all unknowns are zero.
    pub(super) fn around(start: &Linearised) -> Self {
        let scale = start.column_lengths.clone();
        let terms = start.unknowns.iter().zip(&scale).map(|(x, d)| x * d);
        let size = norm(&terms.collect::<Vec<_>>());
        let radius = if size > 0.0 {
            size
        } else {
            norm(&start.residuals)
        };
        Self {
            scale,
            // An infinite radius could not shrink.
            radius: radius.min(f64::MAX),
        }
    }

    /// The next point with a lower sum of squares, or, where rounding hides the decrease of even
    /// the whole Gauss–Newton step, with none that is visibly higher. Nothing if there is no such
    /// point down to steps that are lost in rounding.
    pub(super) fn descend(
        &mut self,
        model: &dyn Model,
        here: &Linearised,
    ) -> Result<Option<Linearised>, Error> {
        for (scale, length) in self.scale.iter_mut().zip(&here.column_lengths) {
            *scale = scale.max(*length);
        }
        let svd = ScaledSvd::new(&here.jacobian, self.scale.clone())?;
        let residuals = svd.row_components(&here.residuals);
        loop {
            let step = step_within(self.radius, svd.singular_values(), &residuals);
            let unknowns = here.moved(&svd.unknowns(&step.components));
            if is_lost(&unknowns, &here.unknowns) {
                return Ok(None);
            }
            let changes = step.components.iter().zip(svd.singular_values());
            let predicted: f64 = changes
                .zip(&residuals)
                .map(|((z, s), r)| -z * s * (2.0 * r + z * s))
                .sum();
            let next_residuals = model.residuals(&unknowns);
            let decrease = here.decrease(&next_residuals);
            let rounding = here.decrease_rounding();
            let hidden = predicted <= rounding;
            if hidden && !step.whole {
                return Ok(None);
            }
            let accepted = decrease > LEAST_GAIN * predicted || (hidden && decrease >= -rounding);
            let next = if accepted {
                Linearised::at(model, unknowns, next_residuals)?
            } else {
                None
            };
            let gain = decrease / predicted;
            if next.is_none() || (gain < POOR_GAIN && !hidden) {
                self.radius = SHRINK * self.radius.min(step.length);
            } else if step.whole || gain > GOOD_GAIN {
                self.radius = f64::MAX.min(GROW * step.length);
            }
            if next.is_some() {
                return Ok(next);
            }
        }
    }
}

/// The Gauss–Newton step or, if it is longer than the radius, `-(S² + λ)⁻¹ S r` with the λ that
/// gives it this length.
fn step_within(radius: f64, singular_values: &[f64], residuals: &[f64]) -> Step {
    // Below the rounding of the largest, singular vectors are noise: no step along them.
    let noise = f64::EPSILON * singular_values.first().copied().unwrap_or(0.0);
    let damped = |lambda: f64| -> Vec<f64> {
        let pairs = singular_values.iter().zip(residuals);
        pairs
            .map(|(&s, r)| {
                if s > noise {
                    -r / (s + lambda / s)
                } else {
                    0.0
                }
            })
            .collect()
    };
    let components = damped(0.0);
    let length = norm(&components);
    if length <= (1.0 + RADIUS_SLACK) * radius {
        return Step {
            components,
            length,
            whole: true,
        };
    }
    // |z(λ)| ≤ |S r| / λ bounds λ; Newton's iteration on 1/|z(λ)| as in Moré, section 5.
    let slope = singular_values.iter().zip(residuals).map(|(s, r)| s * r);
    let (mut low, mut high) = (0.0, norm(&slope.collect::<Vec<_>>()) / radius);
    let (mut lambda, mut trials) = (0.0, 0);
    loop {
        let inside = lambda > low && lambda < high;
        if !inside {
            lambda = f64::max(1e-3 * high, (low * high).sqrt());
        }
        let components = damped(lambda);
        let length = norm(&components);
        trials += 1;
        // Any positive λ gives a step downhill, so the last one will do.
        if (length - radius).abs() <= RADIUS_SLACK * radius || trials == MAX_TRIALS {
            return Step {
                components,
                length,
                whole: false,
            };
        }
        if length > radius {
            low = lambda;
        } else {
            high = lambda;
        }
        let shrinkage: f64 = singular_values
            .iter()
            .zip(&components)
            .filter(|(s, _)| **s > noise)
            .map(|(s, z)| z * z / (s * s + lambda))
            .sum();
        lambda += (length / radius - 1.0) * squares(&components) / shrinkage;
    }
}

/// Whether a step is lost in the rounding of the unknowns, or is not a number.
fn is_lost(unknowns: &[f64], others: &[f64]) -> bool {
    let mut pairs = unknowns.iter().zip(others);
    !pairs.any(|(a, b)| (a - b).abs() > 0.0)
}
