//! The headline verb: a campaign to a diagnosis.

use trueaxis_calibrate::{Calibration, calibrate};
use trueaxis_campaign::{Campaign, Lengths};

use crate::changes::changes;
use crate::lengths::{LengthsOutcome, diagnose_lengths};
use crate::{Diagnosis, Error, Settings};

/// Says what the rigid, quasi-static model gets wrong in a campaign's data, why, what the better model
/// looks like and what it gains on data that it did not use.
///
/// # Errors
/// [`Error`] if the campaign cannot be calibrated or nothing was measured that could contradict.
pub fn diagnose(campaign: &Campaign, settings: &Settings) -> Result<Diagnosis, Error> {
    let Some(lengths) = &campaign.lengths else {
        return Err(Error::NothingMeasured);
    };
    let calibration = calibrated(campaign, settings)?;
    let LengthsOutcome {
        scene,
        verdict,
        report,
        mut causes,
        unexplained,
        not_observable,
        notices,
        effects_mm,
    } = diagnose_lengths(campaign, lengths)?;
    if !causes.is_empty() {
        let corrected = without_effects(campaign, lengths, &effects_mm);
        let better = calibrated(&corrected, settings)?;
        for cause in &mut causes {
            cause.changes = changes(&calibration, &better);
        }
    }
    Ok(Diagnosis {
        campaign: campaign.name.clone(),
        scene,
        verdict,
        levels: vec![report],
        causes,
        unexplained,
        not_observable,
        notices,
    })
}

/// A calibration even of data that the screening refuses: what is wrong with them is the question here.
fn calibrated(campaign: &Campaign, settings: &Settings) -> Result<Calibration, Error> {
    let plain = trueaxis_calibrate::Settings {
        robust: false,
        ..settings.calibration
    };
    match calibrate(campaign, &settings.calibration) {
        Err(_) if settings.calibration.robust => Ok(calibrate(campaign, &plain)?),
        other => Ok(other?),
    }
}

/// The campaign with lengths less what the causes do to them.
fn without_effects(campaign: &Campaign, lengths: &Lengths, effects_mm: &[f64]) -> Campaign {
    let mut corrected = lengths.clone();
    for (reading, effect_mm) in corrected.readings.iter_mut().zip(effects_mm) {
        reading.length_mm -= effect_mm;
    }
    Campaign {
        lengths: Some(corrected),
        ..campaign.clone()
    }
}
