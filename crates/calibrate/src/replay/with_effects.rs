//! A calibration of lengths from which known effects were removed.
//!
//! With the effects' values `θ` each length loses what the effects do to it (exact distances at the adjusted
//! geometry, [`EffectsOnLengths`]), and everything is calibrated anew. The values are estimates with a covariance `C`
//! from the residuals of the adjustment, which are uncorrelated with the adjusted values, so that variances add:
//!
//! ```text
//! cov(x) = cov(x; θ known) + J C Jᵀ        J = ∂x/∂θ
//! ```
//!
//! For the joint adjustment, in which a diagnosis estimates θ, this is exact to first order, and nearly so for the
//! nine equations, which weight the points almost as it does. `J C Jᵀ` is summed over the columns of a square root of
//! `C`: each moves θ by one standard deviation, and the change of the lengths goes through the whole calibration
//! ([`crate::Replay::responses`]). Shapes (instants, time constants) count as known.

use nalgebra::{DMatrix, DVector};
use trueaxis_campaign::Campaign;
use trueaxis_effects::{GivenEffect, ResolvedEffect, ResolvedEffects};
use trueaxis_poses::{EffectsOnLengths, at_one_temperature, scene_of};

use crate::replay::calibrate_for_replay;
use crate::result::calibration::Calibration;
use crate::{Error, Settings};

/// Calibrates the lengths of a campaign less what `effects` do to them; the effects must be resolved in the scene of
/// this campaign ([`scene_of`]).
///
/// Without a covariance the effects count as exact.
///
/// # Errors
/// Those of [`crate::calibrate()`], and [`trueaxis_poses::Error::EffectsWithoutLengths`].
pub fn calibrate_with_effects(
    campaign: &Campaign,
    effects: &ResolvedEffects,
    settings: &Settings,
) -> Result<Calibration, Error> {
    let campaign = &*at_one_temperature(campaign);
    let on_lengths = EffectsOnLengths::new(campaign)?;
    let effects_mm = on_lengths.of(&effects.effects);
    let corrected = on_lengths.taken_out(&effects_mm);
    let (mut calibration, replay) = calibrate_for_replay(&corrected, settings)?;
    if let Some(covariance) = &effects.covariance {
        let mut responses = replay.responses();
        for step in root(covariance).column_iter() {
            let moved_mm = on_lengths.of(&moved(&effects.effects, step.as_slice()));
            let used = replay.trials.used_lengths().iter();
            let errors_mm: Vec<f64> = used.map(|&i| effects_mm[i] - moved_mm[i]).collect();
            let mut changes = responses.to(&errors_mm);
            for (change, result) in changes.iter_mut().zip(replay.results()) {
                *change *= result.output.unit().size();
            }
            calibration.add_uncertainty(&campaign.machine, &changes, |budget| &mut budget.effects);
        }
        let contains = &mut calibration.uncertainty.contains;
        contains.push("effects taken out".to_owned());
    }
    calibration.effects = given(campaign, effects);
    Ok(calibration)
}

/// Correlations with eigenvalues below this are rounding: the direction is known exactly.
const KNOWN_DIRECTION: f64 = 1e-12;

/// `R` with `R Rᵀ` the covariance, from the eigenvectors of the correlations, without columns of zero variance.
fn root(covariance: &[Vec<f64>]) -> DMatrix<f64> {
    let count = covariance.len();
    let u = DVector::from_fn(count, |i, _| covariance[i][i].sqrt());
    let inverse = u.map(|u| if u > 0.0 { u.recip() } else { 0.0 });
    let correlation = DMatrix::from_fn(count, count, |i, j| {
        0.5 * (covariance[i][j] + covariance[j][i]) * inverse[i] * inverse[j]
    });
    let eigen = correlation.symmetric_eigen();
    let columns: Vec<DVector<f64>> = eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
        .filter(|(value, _)| **value > KNOWN_DIRECTION)
        .map(|(value, vector)| vector.component_mul(&u) * value.sqrt())
        .collect();
    DMatrix::from_fn(count, columns.len(), |i, j| columns[j][i])
}

/// The effects with their parameters moved by `step`, effect after effect.
fn moved(effects: &[ResolvedEffect], step: &[f64]) -> Vec<ResolvedEffect> {
    let mut steps = step.iter();
    let mut moved = effects.to_vec();
    for effect in &mut moved {
        for (value, step) in effect.parameters.iter_mut().zip(&mut steps) {
            *value += step;
        }
    }
    moved
}

/// The effects by name, with the uncertainties that were used.
fn given(campaign: &Campaign, effects: &ResolvedEffects) -> Vec<GivenEffect> {
    let scene = scene_of(campaign);
    let mut first = 0;
    let given = effects.effects.iter().map(|effect| {
        let mut given = effect.to_given(&scene);
        let count = effect.parameters.len();
        if let Some(covariance) = &effects.covariance {
            for (k, parameter) in given.parameters.iter_mut().take(count).enumerate() {
                parameter.u = Some(covariance[first + k][first + k].sqrt());
            }
        }
        first += count;
        given
    });
    given.collect()
}
