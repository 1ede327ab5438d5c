//! A bent guideway: two curves with one cause.
//!
//! The straightness gives one estimate of the bow, the slope of the matching angle another. Under the
//! rest of the curves alone their p-values are independent, and `-2 Σ ln p` is χ² with four degrees of
//! freedom (Fisher). A bow is named only if each curve asks for it by itself ([`EACH`]) and both ask for
//! the same one ([`AGREE`]); its value is their weighted mean, its
//! uncertainty widened by the Birge ratio.

use nalgebra::DMatrix;
use trueaxis_effects::{Scene, Subject, effect};

use crate::cause::{Cause, EstimatedParameter};
use crate::components::candidates::Candidate;
use crate::components::curve_set::CurveSet;
use crate::components::estimate::{Estimate, estimate};
use crate::components::judgement::Judgement;
use crate::components::ln_chi_squared::ln_chi_squared;
use crate::components::report;
use crate::components::search::{Found, SetSearch};
use crate::selection::Score;

/// Its effect.
pub(crate) const BOW: &str = "guideway_bow";

/// Probability that a curve without a bow asks for one, below which it does by itself.
const EACH: f64 = 0.05;

/// Largest difference of the two estimates in standard uncertainties: one true bow in 370 fails.
const AGREE: f64 = 3.0;

/// The cause, with the sagitta over the measured positions.
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

/// The bow of a straightness and its matching angle, if both ask for the same one; its p-value beside others is to be filled in.
pub(crate) fn find_bow(
    straightness: &SetSearch,
    angle: &SetSearch,
    scene: &Scene,
) -> Option<Found> {
    let set = &straightness.set;
    let subject = Subject::component(set.axis, set.components[0]);
    let candidate = Candidate::new(effect(BOW)?, subject, vec![0.0], scene);
    let (score, own) = of_curve(straightness, &candidate)?;
    let (score_angle, of_angle) = of_curve(angle, &candidate)?;
    let (b1, b2) = (own.parameters[0], of_angle.parameters[0]);
    let (v1, v2) = (own.covariance[(0, 0)], of_angle.covariance[(0, 0)]);
    let each = score.ln_p.max(score_angle.ln_p) < EACH.ln();
    let agree = (b1 - b2).abs() <= AGREE * (v1 + v2).sqrt() && b1 * b2 > 0.0;
    if !each || !agree {
        return None;
    }
    let mean = (b1 / v1 + b2 / v2) / (1.0 / v1 + 1.0 / v2);
    // Birge ratio: two curves that differ by more than they should know the bow less well.
    let birge = ((b1 - b2).powi(2) / (v1 + v2)).max(1.0);
    let ln_p = ln_chi_squared(-2.0 * (score.ln_p + score_angle.ln_p), 4);
    let estimate = Estimate {
        parameters: vec![mean],
        covariance: DMatrix::from_element(1, 1, birge / (1.0 / v1 + 1.0 / v2)),
        curve: own.curve.iter().map(|y| y * mean / b1).collect(),
        ..own
    };
    Some(Found {
        candidate,
        estimate,
        score: Score {
            ln_p,
            statistic: score.statistic + score_angle.statistic,
            bic: score.bic + score_angle.bic,
            evidence: score.evidence + score_angle.evidence,
            ..score
        },
        p_value: 1.0,
        rivals: Vec::new(),
    })
}

/// What one of the two curves says by itself, with all that was found in it in the model.
fn of_curve(search: &SetSearch, candidate: &Candidate) -> Option<(Score, Estimate)> {
    let backgrounds = search.backgrounds(None);
    let judgement = Judgement::new(&search.set, &backgrounds, candidate);
    let score = judgement.score(&backgrounds, candidate, 0)?;
    let estimate = estimate(&search.set, &backgrounds, candidate, 0.0);
    Some((score, estimate))
}
