//! The targets of a replay: where they are at home against where they should be.
//!
//! The reference frame has its origin at the mean of the targets that the first linear axis moves and, without
//! two linear axes, its directions from the targets, too. A scenario must say so to the last digit, so what rounding left of
//! that mean and rotation is taken out here.

use nalgebra::{Matrix3, Vector3};
use trueaxis_calibrate::Calibration;
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::AxisKind;
use trueaxis_simulate::TargetSpec;

/// Rests of mean (mm) and rotation (rad) that an iterated frame may leave; more is not of this frame.
const FRAME_REST: f64 = 1e-6;

/// Sine of the angle from which two axes span a plane.
const SPANS: f64 = 0.1;

pub(super) fn targets(
    campaign: &Campaign,
    calibration: &Calibration,
) -> Result<Vec<TargetSpec>, String> {
    let mut errors_mm = Vec::new();
    for target in &campaign.targets {
        let found = calibration.targets.iter().find(|t| t.name == target.name);
        let found = found.ok_or_else(|| format!("target {} was not measured", target.name))?;
        errors_mm.push(found.position_mm - target.home_mm);
    }
    into_the_frame(campaign, &mut errors_mm)?;
    let targets = campaign.targets.iter().zip(errors_mm);
    let specs = targets.map(|(target, error_mm)| TargetSpec {
        name: target.name.clone(),
        position_mm: target.home_mm.into(),
        carried_by: campaign.machine.axes()[target.carrier].name().to_owned(),
        mounting_error_mm: error_mm.into(),
    });
    Ok(specs.collect())
}

fn into_the_frame(campaign: &Campaign, errors_mm: &mut [Vector3<f64>]) -> Result<(), String> {
    let machine = &campaign.machine;
    let mut linear: Vec<usize> = (0..machine.axes().len())
        .filter(|&axis| machine.axes()[axis].kind() == AxisKind::Linear)
        .filter(|&axis| campaign.runs.iter().any(|run| run.axis == axis))
        .collect();
    linear.sort_by_key(|&axis| machine.axes()[axis].principal());
    let direction = |axis: usize| machine.axes()[axis].direction().into_inner();
    let first = linear.first().copied();
    let oriented = first.is_some_and(|first| {
        linear
            .iter()
            .any(|&axis| direction(first).cross(&direction(axis)).norm() > SPANS)
    });
    let anchors: Vec<usize> = (0..errors_mm.len())
        .filter(|&target| {
            let chain = machine.chain(campaign.targets[target].carrier);
            first.is_none_or(|first| chain.contains(&first))
        })
        .collect();
    let count = anchors.len().max(1) as f64;
    let mean: Vector3<f64> = anchors.iter().map(|&i| errors_mm[i]).sum::<Vector3<f64>>() / count;
    refuse_far(mean.norm())?;
    for error in errors_mm.iter_mut() {
        *error -= mean;
    }
    if oriented {
        return Ok(());
    }
    let home = |i: usize| campaign.targets[i].home_mm.coords;
    let centroid = anchors.iter().map(|&i| home(i)).sum::<Vector3<f64>>() / count;
    // Σ (|r|² I - r rᵀ) ω = Σ r × m
    let (mut inertia, mut moment) = (Matrix3::zeros(), Vector3::zeros());
    for &i in &anchors {
        let r = home(i) - centroid;
        inertia += Matrix3::identity() * r.norm_squared() - r * r.transpose();
        moment += r.cross(&errors_mm[i]);
    }
    let rotation = inertia
        .try_inverse()
        .map_or_else(Vector3::zeros, |inverse| inverse * moment);
    refuse_far(rotation.norm())?;
    for &i in &anchors {
        errors_mm[i] -= rotation.cross(&(home(i) - centroid));
    }
    Ok(())
}

fn refuse_far(rest: f64) -> Result<(), String> {
    if rest > FRAME_REST {
        return Err(
            "the frame of the calibration has directions that a scenario takes from its targets"
                .to_owned(),
        );
    }
    Ok(())
}
