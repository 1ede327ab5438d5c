//! A calibration as input of the search for mistakes ([`trueaxis_mistakes`]).

use std::path::Path;

use trueaxis_campaign::{Campaign, Problem, Stop, read_uncompared};
use trueaxis_mistakes::{MOST_ACCIDENTS, Mistakes, OffNominal, Refused, Trial};
use trueaxis_poses::at_one_temperature;

use crate::Error;
use crate::calibrate::calibrate_as_given;
use crate::report::notices::{absurd_errors, elsewhere};
use crate::result::calibration::Calibration;
use crate::settings::Settings;

/// The mistake that explains why a campaign cannot be read: lengths that its machine cannot have caused, for no reason of units.
pub fn mistake_behind(
    error: &trueaxis_campaign::Error,
    path: &Path,
    settings: &Settings,
) -> Option<String> {
    let Problem::LengthsTooLarge { mistake: None, .. } = error.problem else {
        return None;
    };
    let campaign = read_uncompared(path).ok()?;
    let campaign = at_one_temperature(&campaign);
    let mistakes = Mistakes {
        campaign: &campaign,
        robust: settings.poses.robust,
        calibrate: &|changed, robust| tried(changed, settings, robust),
    };
    mistakes.explanation()
}

/// The calibration of a campaign in which a mistake may be undone.
pub(crate) fn tried(
    campaign: &Campaign,
    settings: &Settings,
    robust: bool,
) -> Result<Trial, Refused> {
    let mut settings = *settings;
    settings.covariance = false;
    settings.poses.robust = robust;
    settings.poses.most_removed = MOST_ACCIDENTS;
    match calibrate_as_given(campaign, &settings) {
        Ok((calibration, _)) => Ok(trial(campaign, calibration)),
        Err(error) if error.is_contradiction() => Err(Refused::Contradiction),
        Err(_) => Err(Refused::Other),
    }
}

/// The error with the mistakes that would explain it, if any do; other errors unchanged.
pub(crate) fn explained(error: Error, mistakes: &Mistakes<'_>) -> Error {
    let is_contradiction = error.is_contradiction();
    let explanation = is_contradiction.then(|| mistakes.explanation());
    match explanation.flatten() {
        None => error,
        Some(explanation) => Error::Mistaken {
            error: Box::new(error),
            explanation,
        },
    }
}

fn trial(campaign: &Campaign, calibration: Calibration) -> Trial {
    let elsewhere = elsewhere(campaign, &calibration.targets);
    let mut axes = calibration.axes.iter();
    let is_plausible = elsewhere.is_empty() && axes.all(|axis| absurd_errors(axis).is_empty());
    Trial {
        adjustment: calibration.adjustment.clone(),
        off_nominal: off_nominal(campaign, &calibration),
        is_plausible,
        lengths_mm: Box::new(move |campaign, target, stops| {
            lengths_mm(&calibration, campaign, target, stops)
        }),
    }
}

/// Distances of targets and stations from where the campaign has them; nominal positions on the bed do not matter.
fn off_nominal(campaign: &Campaign, calibration: &Calibration) -> OffNominal {
    let targets = calibration.targets.iter().filter_map(|found| {
        let target = campaign.targets.iter().find(|t| t.name == found.name)?;
        target.carrier?;
        Some((found.position_mm - target.home_mm).norm())
    });
    let stations = calibration.stations.iter().filter_map(|found| {
        let mut stations = campaign.stations.iter();
        let approx_mm = stations.find(|s| s.name == found.name)?.approx_mm?;
        Some((found.position_mm - approx_mm).norm())
    });
    OffNominal {
        targets_mm: targets.collect(),
        stations_mm: stations.collect(),
    }
}

/// The lengths to a target at stops, mm; `None` if the target was not measured.
fn lengths_mm(
    calibration: &Calibration,
    campaign: &Campaign,
    target: usize,
    stops: &[&Stop],
) -> Option<Vec<f64>> {
    let target = &campaign.targets[target];
    let mut targets = calibration.targets.iter();
    let home_mm = targets.find(|t| t.name == target.name)?.position_mm;
    let reflector = target.reflector.as_ref().unwrap_or(&target.name);
    let mut reflectors = calibration.reflectors.iter();
    let constant = reflectors.find(|r| r.name == *reflector);
    let constant_mm = constant.map_or(0.0, |reflector| reflector.constant_mm);
    let chain = campaign.machine.chain(target.carrier);
    let errors = calibration.calibrated_machine();
    let of_stop = |stop: &&Stop| {
        let positions = &campaign.steps[stop.step].positions;
        let motion = campaign.machine.chain_motion(&errors, chain, positions);
        let station = &calibration.stations[stop.station];
        let distance_mm = (motion * home_mm - station.position_mm).norm();
        distance_mm - station.dead_path_mm + constant_mm
    };
    Some(stops.iter().map(of_stop).collect())
}
