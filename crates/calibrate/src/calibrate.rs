//! The headline verb: from a campaign to all geometric errors.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Point3};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::{Machine, centroid};
use trueaxis_mistakes::Mistakes;
use trueaxis_poses::{LengthsAdjustment, MeasuredPoses, Poses, at_one_temperature, measure};
use trueaxis_predict::OutputCovariance;

use crate::Error;
use crate::explain::{explained, tried};
use crate::identify::apply_frame::mean_targets;
use crate::identify::axis_data::{AxisData, by_axis};
use crate::identify::context::Context;
use crate::identify::identify_axes::{Identified, identify_axes};
use crate::identify::plausibility::{check_motion, check_noise};
use crate::matrix_size::check_size;
use crate::propagate::dependence::Dependence;
use crate::propagate::factored_covariance::factored_covariance;
use crate::propagate::propagation::Propagation;
use crate::report::axis_results::{axis_results, station_results};
use crate::report::expansion::refer_to_20_degrees;
use crate::report::notices::{longer_alike, notices};
use crate::report::relative_locations::relative_locations;
use crate::report::run_misfit::{run_misfits, scatter_of_runs};
use crate::report::triangle::triangle;
use crate::report::uncertainty::statement;
use crate::result::calibration::{Calibration, TargetResult, Traceability};
use crate::result::numbered::results;
use crate::settings::{ReferencePoint, Settings};

/// Finds all component and location errors of the axes that a campaign measured, in the [reference
/// frame](crate#the-reference-frame).
///
/// # Errors
/// See [`Error`]; a result that is not converged or not determined is an error.
pub fn calibrate(campaign: &Campaign, settings: &Settings) -> Result<Calibration, Error> {
    let campaign = at_one_temperature(campaign);
    calibrate_in_parts(&campaign, settings).map(|(calibration, _)| calibration)
}

/// As [`calibrate`], with the adjustment of the lengths if there are any, for further analysis. Lengths should hold
/// [at one temperature](at_one_temperature).
pub fn calibrate_with_adjustment<'a>(
    campaign: &'a Campaign,
    settings: &Settings,
) -> Result<(Calibration, Option<LengthsAdjustment<'a>>), Error> {
    let (calibration, parts) = calibrate_in_parts(campaign, settings)?;
    Ok((calibration, parts.measured.lengths))
}

/// Intermediate results of a calibration.
pub(crate) struct Parts<'a> {
    pub(crate) machine: Machine,
    pub(crate) measured: MeasuredPoses<'a>,
    pub(crate) data: Vec<AxisData>,
    pub(crate) identified: Identified,
}

/// A calibration with its intermediate results. Contradictory data are tried again with the usual mistakes corrected.
pub(crate) fn calibrate_in_parts<'a>(
    campaign: &'a Campaign,
    settings: &Settings,
) -> Result<(Calibration, Parts<'a>), Error> {
    let mistakes = Mistakes {
        campaign,
        robust: settings.poses.robust,
        calibrate: &|changed, robust| tried(changed, settings, robust),
    };
    let (mut calibration, parts) =
        calibrate_as_given(campaign, settings).map_err(|error| explained(error, &mistakes))?;
    let rejected = calibration.adjustment.rejected.iter();
    let rejected: BTreeSet<usize> = rejected.map(|length| length.line).collect();
    let lost = mistakes.lost_sweeps(&rejected);
    calibration.notices.extend(lost);
    Ok((calibration, parts))
}

/// Measure, identify, propagate, report.
pub(crate) fn calibrate_as_given<'a>(
    campaign: &'a Campaign,
    settings: &Settings,
) -> Result<(Calibration, Parts<'a>), Error> {
    // Measure: poses, by the axis under test.
    let machine = with_reference_points(campaign, settings.reference_point);
    let mut measured = measure(campaign, &settings.poses)?;
    let instrument = std::mem::take(&mut measured.poses.instrument);
    let poses = &measured.poses;
    let stations = &measured.of_lengths(LengthsAdjustment::stations)[..];
    let data = by_axis(campaign, poses)?;
    if settings.covariance {
        check_covariance(&machine, &data, stations.len())?;
    }

    // Identify: component errors, location errors and the reference frame.
    let found = found(poses);
    let context = Context {
        campaign,
        machine: &machine,
        poses,
        measured: &found,
        data: &data,
    };
    let identified = identify_axes(&context)?;
    check_motion(&context, &identified)?;
    check_noise(&measured.adjustment)?;

    // Propagate: how all results depend on the poses, and the poses on the noise.
    let dependence = Dependence::new(&context, &identified, stations);
    let mut propagation = Propagation::new(&dependence, poses, &instrument);
    let runs = run_misfits(&propagation);
    for k in (0..runs.len()).filter(|&k| runs[k].is_some()) {
        let scatter = scatter_of_runs(&propagation, k);
        propagation.add_to_location(k, &scatter);
    }

    let lengths = measured.lengths.as_ref();
    if let Some(slow) = lengths.and_then(|lengths| lengths.slow) {
        propagation.widen_locations(slow.ratio);
    }

    // Report.
    let axes = axis_results(&measured, &propagation, runs);
    let stations = station_results(campaign, stations, &propagation);
    let relative_locations = relative_locations(&propagation);
    // Both noises are large; that of the instrument is not needed any more.
    let noise = propagation.whole;
    drop(instrument);
    let residuals = measured.residuals();
    let factors = factored_covariance(&noise, &axes, &stations);
    let covariance = settings.covariance.then(|| {
        let results = results(&axes, &stations);
        OutputCovariance::new(&factors, results.map(|result| result.output).collect())
    });
    let mut targets_mm = mean_targets(&context, &identified.state);
    for (target, in_datum_mm) in measured.of_lengths(LengthsAdjustment::targets_on_bed) {
        targets_mm[target] = Some(identified.state.ref_from_datum * in_datum_mm);
    }
    let mut calibration = Calibration {
        campaign: campaign.name.clone(),
        machine: campaign.machine.clone(),
        machine_spec: campaign.machine_spec(),
        method: measured.method,
        adjustment: measured.adjustment.clone(),
        stations,
        reflectors: measured.of_lengths(LengthsAdjustment::reflectors),
        reflectors_are_relative: lengths
            .is_none_or(|l| l.screened.solution.mean_constant_mm.is_none()),
        scale: measured.of_lengths(LengthsAdjustment::scale),
        uncertainty: statement(campaign, &measured),
        targets: target_results(campaign, &targets_mm),
        relative_locations,
        axes,
        factors,
        covariance,
        misfits: measured.misfits.clone(),
        turned_runs: measured.turned_runs.clone(),
        known_misfits: measured.of_lengths(|lengths| lengths.known_misfits.clone()),
        residuals,
        triangle: triangle(&context, &targets_mm, measured.point_variance_mm2),
        effects: Vec::new(),
        notices: measured.notices.clone(),
        traceability: Traceability {
            date: campaign.date.clone(),
            operator: campaign.operator.clone(),
            instrument: campaign.instrument.name.clone(),
            serial: campaign.instrument.serial.clone(),
            inputs: Vec::new(),
        },
    };
    let mirror_image_open = lengths.is_some_and(|l| l.screened.solution.mirror_image_open);
    let more = notices(campaign, &calibration, mirror_image_open);
    calibration.notices.extend(more);
    refer_to_20_degrees(campaign, &mut calibration);
    let alike = longer_alike(&calibration);
    calibration.notices.extend(alike);
    let parts = Parts {
        machine,
        measured,
        data,
        identified,
    };
    Ok((calibration, parts))
}

/// Refuses a covariance of all results that would not fit.
fn check_covariance(machine: &Machine, data: &[AxisData], stations: usize) -> Result<(), Error> {
    let of_axis = |data: &AxisData| {
        6 * data.nodes.len() + machine.axes()[data.axis].location_components().len()
    };
    let outputs = data.iter().map(of_axis).sum::<usize>() + 4 * stations;
    let matrix = || format!("the covariance of all {outputs} results");
    let instead = "calibrate without it, or calibrate the runs of fewer axes at a time";
    check_size(matrix, [outputs; 2], instead)
}

/// The measured poses (datum from home).
pub(crate) fn found(poses: &Poses) -> Vec<Isometry3<f64>> {
    let observations = poses.observations.iter();
    observations.map(|pose| pose.datum_from_home).collect()
}

/// The machine with the reference points of δ that the settings choose.
fn with_reference_points(campaign: &Campaign, reference: ReferencePoint) -> Machine {
    let machine = &campaign.machine;
    machine.with_axes(|index, axis| match reference {
        ReferencePoint::Origin => axis,
        ReferencePoint::At(point) => axis.with_reference(point),
        ReferencePoint::Centroid => {
            let is_moved = |carrier: Option<usize>| machine.chain(carrier).contains(&index);
            let targets = campaign.targets.iter().filter(|t| is_moved(t.carrier));
            let moved: Vec<Point3<f64>> = targets.map(|target| target.home_mm).collect();
            match moved.is_empty() {
                true => axis,
                false => axis.with_reference(centroid(&moved)),
            }
        }
    })
}

/// The targets that were measured.
fn target_results(campaign: &Campaign, mean_mm: &[Option<Point3<f64>>]) -> Vec<TargetResult> {
    let targets = campaign.targets.iter().zip(mean_mm);
    let measured = targets.filter_map(|(target, position_mm)| {
        Some(TargetResult {
            name: target.name.clone(),
            position_mm: (*position_mm)?,
        })
    });
    measured.collect()
}
