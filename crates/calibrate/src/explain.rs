//! A calibration as input of the search for mistakes ([`trueaxis_mistakes`]).

use trueaxis_campaign::{Campaign, Stop};
use trueaxis_mistakes::{Mistakes, OffNominal, Refused, Trial};

use crate::Error;
use crate::report::nominal_positions::targets_elsewhere;
use crate::report::notices::absurd_errors;
use crate::result::calibration::Calibration;

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

pub(crate) fn refused(error: &Error) -> Refused {
    match error.is_contradiction() {
        true => Refused::Contradiction,
        false => Refused::Other,
    }
}

pub(crate) fn trial(campaign: &Campaign, calibration: Calibration) -> Trial {
    let elsewhere = targets_elsewhere(campaign, &calibration.targets);
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
