//! The targets of a replay: where they are at home against where they should be.
//!
//! A scenario must agree with the reference frame to the last digit, so what rounding left of the motion
//! that the frame takes out is taken out here.

use nalgebra::Vector3;
use trueaxis_campaign::{Campaign, frame_rule};

use super::ReplayError;
use crate::{TargetSpec, Truth};

/// Remainders of mean (mm) and rotation (rad) that an iterated frame may leave; more is another frame.
const FRAME_REST: f64 = 1e-6;

pub(super) fn targets(campaign: &Campaign, truth: &Truth) -> Result<Vec<TargetSpec>, ReplayError> {
    let mut errors_mm = Vec::new();
    for target in &campaign.targets {
        let found = truth.targets.iter().find(|t| t.name == target.name);
        let found = found.ok_or_else(|| ReplayError::TargetNotMeasured {
            target: target.name.clone(),
        })?;
        errors_mm.push(found.home_mm - target.home_mm);
    }
    into_the_frame(campaign, &mut errors_mm)?;
    let targets = campaign.targets.iter().zip(errors_mm);
    let specs = targets.map(|(target, error_mm)| TargetSpec {
        name: target.name.clone(),
        position_mm: target.home_mm.into(),
        carried_by: target
            .carrier
            .map(|axis| campaign.machine.axes()[axis].name().to_owned()),
        mounting_error_mm: error_mm.into(),
        reflector: target.reflector.clone(),
        position_sigma_mm: target.position_sigma_mm,
    });
    Ok(specs.collect())
}

fn into_the_frame(campaign: &Campaign, errors_mm: &mut [Vector3<f64>]) -> Result<(), ReplayError> {
    let lengths = campaign.lengths.iter();
    let measured = lengths.flat_map(|lengths| {
        lengths.stops.iter().flat_map(|stop| {
            let axis = campaign.axis_under_test(stop.step);
            let readings = &lengths.readings[stop.readings.clone()];
            readings
                .iter()
                .filter_map(move |reading| Some((axis?, reading.target)))
        })
    });
    let frame = frame_rule(&campaign.machine, &campaign.targets, measured);
    let tilts = vec![Vector3::zeros(); frame.lines().count()];
    let shifts: Vec<_> = frame.anchors().map(|target| errors_mm[target]).collect();
    let motion = frame.motion(&tilts, &shifts);
    let off = motion.translation.norm().max(motion.rotation.norm());
    if off > FRAME_REST {
        return Err(ReplayError::OtherFrame {
            off,
            most: FRAME_REST,
        });
    }
    for (target, error_mm) in campaign.targets.iter().zip(errors_mm) {
        *error_mm -= motion.at(target.home_mm);
    }
    Ok(())
}
