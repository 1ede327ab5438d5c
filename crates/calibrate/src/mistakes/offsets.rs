//! Lengths that are all off by the same amount, against what the others predict.

use trueaxis_campaign::Campaign;
use trueaxis_kinematics::MICROMETRE;

use crate::mistakes::mistake::What;
use crate::mistakes::scope::Scope;
use crate::result::calibration::Calibration;

/// Scatter about the mean that the machine's repeatability and the noise may have, mm: more is no constant.
const SCATTER_MM: f64 = 20.0 * MICROMETRE;

/// A constant is named if it is at least this many times its scatter.
const SIGNIFICANT: f64 = 10.0;

/// Fewer lengths prove nothing.
const LEAST: usize = 5;

/// The mean difference of the lengths of a part to a target from what a calibration without them predicts, if it is
/// a constant.
pub(crate) fn measured(
    campaign: &Campaign,
    calibration: &Calibration,
    target: usize,
    scope: &Scope,
) -> Option<What> {
    let lengths = campaign.lengths.as_ref()?;
    let content = &campaign.targets[target];
    let mut targets = calibration.targets.iter();
    let home_mm = targets.find(|t| t.name == content.name)?.position_mm;
    let reflector = content.reflector.as_ref().unwrap_or(&content.name);
    let mut reflectors = calibration.reflectors.iter();
    let constant = reflectors.find(|r| r.name == *reflector);
    let constant_mm = constant.map_or(0.0, |reflector| reflector.constant_mm);
    let chain = campaign.machine.chain(content.carrier);
    let errors = calibration.calibrated_machine();
    let mut differences_mm = Vec::new();
    for stop in scope.stops(campaign, lengths) {
        let positions = &campaign.steps[stop.step].positions;
        let motion = campaign.machine.chain_motion(&errors, chain, positions);
        let station = &calibration.stations[stop.station];
        let distance_mm = (motion * home_mm - station.position_mm).norm();
        let predicted_mm = distance_mm - station.dead_path_mm + constant_mm;
        let readings = lengths.readings[stop.readings.clone()].iter();
        let of_target = readings.filter(|reading| reading.target == target);
        differences_mm.extend(of_target.map(|reading| reading.length_mm - predicted_mm));
    }
    let count = differences_mm.len();
    if count < LEAST {
        return None;
    }
    let offset_mm = differences_mm.iter().sum::<f64>() / count as f64;
    let squares: f64 = differences_mm.iter().map(|d| (d - offset_mm).powi(2)).sum();
    let scatter_mm = (squares / (count - 1) as f64).sqrt();
    let u_mm = scatter_mm / (count as f64).sqrt();
    let is_constant = scatter_mm < SCATTER_MM && offset_mm.abs() > SIGNIFICANT * scatter_mm;
    is_constant.then_some(What::Offset {
        target,
        offset_mm,
        u_mm,
    })
}
