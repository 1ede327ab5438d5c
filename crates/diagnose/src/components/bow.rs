//! A bent guideway: two curves with one cause.
//!
//! The straightness gives one estimate of the bow, the slope of the matching angle another. Under the rest of the
//! curves alone their p-values are independent, and `-2 Σ ln p` is χ² with four degrees of freedom (Fisher). A bow is
//! named only if each curve shows it by itself ([`EACH`]) and both estimates agree ([`AGREE`]); its value is their
//! weighted mean. Its uncertainty is widened by what the other guideways show of the machine
//! ([`variance_factor`]), and by the Birge ratio.

use nalgebra::DMatrix;
use trueaxis_effects::{Scene, Subject, effect};
use trueaxis_selection::{Score, ln_chi_squared};

use crate::cause::{Cause, EstimatedParameter};
use crate::components::candidates::Candidate;
use crate::components::curve_set::CurveSet;
use crate::components::estimate::{Estimate, estimate};
use crate::components::judgement::Judgement;
use crate::components::report;
use crate::components::search::{Found, SetSearch};

/// Id of the effect.
pub(crate) const BOW: &str = "guideway_bow";

/// Largest p-value at which a curve shows a bow by itself.
const EACH: f64 = 0.05;

/// Largest difference of the two estimates in standard uncertainties: one true bow in 370 fails.
const AGREE: f64 = 3.0;

/// The cause, with its sagitta over the measured positions.
pub(crate) fn cause_of_bow(straightness: &CurveSet, found: &Found, scene: &Scene) -> Cause {
    let mut cause = report::cause(straightness, found, scene);
    // b (L/2)², b in µm/m².
    let metres = 0.5e-3 * straightness.travel();
    let bow = &cause.parameters[0];
    cause.parameters.push(EstimatedParameter {
        name: "sagitta".to_owned(),
        value: bow.value * metres * metres,
        u: bow.u * metres * metres,
        unit: "um",
    });
    cause
}

/// The bow by a straightness and by its matching angle, each with all effects found in that curve in the model.
pub(crate) struct Pair {
    candidate: Candidate,
    pub(crate) straightness: OfCurve,
    pub(crate) angle: OfCurve,
}

/// The bow by one curve.
pub(crate) struct OfCurve {
    score: Score,
    estimate: Estimate,
}

impl Pair {
    pub(crate) fn new(straightness: &SetSearch, angle: &SetSearch, scene: &Scene) -> Option<Self> {
        let set = &straightness.set;
        let subject = Subject::component(set.axis, set.components[0]);
        let candidate = Candidate::new(effect(BOW)?, subject, vec![0.0], scene);
        Some(Self {
            straightness: OfCurve::new(straightness, &candidate)?,
            angle: OfCurve::new(angle, &candidate)?,
            candidate,
        })
    }

    /// Whether both curves show the same bow.
    pub(crate) fn is_bent(&self) -> bool {
        let [(b1, v1), (b2, v2)] = [&self.straightness, &self.angle].map(OfCurve::bow);
        let each = self.straightness.score.ln_p.max(self.angle.score.ln_p) < EACH.ln();
        each && (b1 - b2).abs() <= AGREE * (v1 + v2).sqrt() && b1 * b2 > 0.0
    }

    /// The bow, with the factors on the variances of both curves ([`variance_factor`]); its family-wise p-value is
    /// filled in later.
    pub(crate) fn found(self, [of_straightness, of_angle]: [f64; 2]) -> Found {
        let [(b1, v1), (b2, v2)] = [&self.straightness, &self.angle].map(OfCurve::bow);
        let (v1, v2) = (v1 * of_straightness, v2 * of_angle);
        let mean = (b1 / v1 + b2 / v2) / (1.0 / v1 + 1.0 / v2);
        // Birge ratio: estimates that differ by more than they should are less certain.
        let birge = ((b1 - b2).powi(2) / (v1 + v2)).max(1.0);
        let (own, score, score_angle) = (
            self.straightness.estimate,
            self.straightness.score,
            self.angle.score,
        );
        let ln_p = ln_chi_squared(-2.0 * (score.ln_p + score_angle.ln_p), 4);
        let estimate = Estimate {
            parameters: vec![mean],
            covariance: DMatrix::from_element(1, 1, birge / (1.0 / v1 + 1.0 / v2)),
            curve: own.curve.iter().map(|y| y * mean / b1).collect(),
            ..own
        };
        Found {
            candidate: self.candidate,
            estimate,
            score: Score {
                ln_p,
                statistic: score.statistic + score_angle.statistic,
                bic: score.bic + score_angle.bic,
                two_ln_b: score.two_ln_b + score_angle.two_ln_b,
                ..score
            },
            p_value: 1.0,
            rivals: Vec::new(),
        }
    }
}

impl OfCurve {
    fn new(search: &SetSearch, candidate: &Candidate) -> Option<Self> {
        let backgrounds = search.backgrounds(&search.found);
        let judgement = Judgement::new(&search.set, &backgrounds, candidate);
        Some(Self {
            score: judgement.score(&backgrounds, candidate, 0)?,
            estimate: estimate(&search.set, &backgrounds, candidate, 0.0),
        })
    }

    /// The bow and its variance.
    fn bow(&self) -> (f64, f64) {
        (
            self.estimate.parameters[0],
            self.estimate.covariance[(0, 0)],
        )
    }

    /// The square of the bow in standard uncertainties.
    pub(crate) fn square(&self) -> f64 {
        let (bow, variance) = self.bow();
        bow * bow / variance
    }
}

/// Factor on the variance of a bow in a curve by the model of the rest, from the bows of similar curves without one,
/// as squares in units of their variances.
///
/// How steep a guideway is relative to its bends is an assumption of the model, which its own curve cannot test. If
/// the assumption holds, the mean of the squares is 1. If they are larger, the bow is as likely to be off: its
/// distribution is Student's, with the variance of `n/(n - 2)` mean squares.
pub(crate) fn variance_factor(squares: &[f64]) -> f64 {
    match squares.len() {
        0..=2 => 1.0,
        n => (squares.iter().sum::<f64>() / (n - 2) as f64).max(1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slopes of straight guideways that are steeper than the model assumes, and some that it expects.
    #[test]
    fn steep_curves_of_straight_guideways_widen_a_bow() {
        assert!((variance_factor(&[4.0, 9.0, 1.0, 0.0, 1.0]) - 5.0).abs() < 1e-12);
        for as_expected in [&[0.5, 0.1, 1.2, 0.4, 0.3][..], &[25.0, 25.0], &[]] {
            assert!((variance_factor(as_expected) - 1.0).abs() < 1e-12);
        }
    }
}
