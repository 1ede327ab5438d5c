//! What a user must know before using the numbers.

use trueaxis_campaign::Campaign;
use trueaxis_kinematics::{ARCSEC, AxisKind, Component, MICROMETRE};
use trueaxis_mistakes::{absurd_scale, common_scale, stations_elsewhere, targets_elsewhere};
use trueaxis_poses::{ScaleBasis, ScaleResult};

use crate::report::home::homes_out_of_reach;
use crate::result::calibration::{AxisResult, Calibration, NodeResult, TargetResult};

/// Linear errors and tilts beyond these get a notice: no machine in use is that bad, but a mistyped position or
/// direction is.
const ABSURD_MM: f64 = 1.0;
const ABSURD_RAD: f64 = 5e-3;

/// The notices about a calibration beside those about its poses.
pub(crate) fn notices(
    campaign: &Campaign,
    calibration: &Calibration,
    mirror_image_open: bool,
) -> Vec<String> {
    let axes = &calibration.axes;
    let differing = |axis| differing_sides(campaign, axis);
    let mut notices: Vec<String> = axes.iter().filter_map(differing).collect();
    notices.extend(axes.iter().filter_map(contradicting_runs));
    notices.extend(unmeasured_axes(campaign, axes));
    notices.extend(axes.iter().filter_map(without_straightness));
    notices.extend(homes_out_of_reach(campaign, axes));
    notices.extend(elsewhere(campaign, &calibration.targets));
    notices.extend(axes.iter().flat_map(absurd_errors));
    let stations_mm = calibration.stations.iter().map(|s| s.position_mm);
    notices.extend(stations_elsewhere(campaign, stations_mm));
    let scale = calibration.scale.map(|scale| scale.value);
    notices.extend(scale.and_then(absurd_scale));
    if mirror_image_open {
        notices.push(
            "all points lie in one plane, and the lengths fit as well with all stations on its other side: \
             errors across the plane may have the wrong sign; give `approx_mm` of one station to be sure"
                .to_owned(),
        );
    }
    notices
}

/// The notice that the joined curve of an axis is the mean of two that differ. For the positioning error the
/// difference is the mean reversal value of ISO 230-2, forward less backward: the opposite of lost motion.
fn differing_sides(campaign: &Campaign, axis: &AxisResult) -> Option<String> {
    let (name, sides) = (&axis.name, axis.sides?);
    let significance = |c: &Component| (sides.value[c.index()] / sides.u[c.index()]).abs();
    let most = Component::ALL
        .into_iter()
        .max_by(|a, b| significance(a).total_cmp(&significance(b)))?;
    let (size, unit) = unit_of(most);
    let [value, u] = [sides.value, sides.u].map(|of| of[most.index()] / size);
    let direction = campaign.machine.axes()[axis.axis].direction();
    let along = direction[most.index() % 3];
    let is_position = along.abs() > 0.5 && most.is_angular() == (axis.kind == AxisKind::Rotary);
    let reversal = match is_position {
        true => format!("; reversal value {:+.2}{unit}", value * along.signum()),
        false => String::new(),
    };
    Some(format!(
        "axis {name}: forward and backward approach differ, {} by {value:+.2}{unit} (U {:.2}{unit}{reversal}): its \
         curves are the mean of both sides; --by-direction keeps them apart",
        most.name(name),
        2.0 * u
    ))
}

/// The notice that the curves of an axis are the mean of contradictory runs.
fn contradicting_runs(axis: &AxisResult) -> Option<String> {
    let runs = axis.runs.as_ref()?;
    let (size, unit) = unit_of(runs.component);
    let at = place(axis, runs.position);
    Some(format!(
        "axis {}: runs {} contradict each other, {} at {at} by {:.2}{unit} ({}): its curves are their \
         weighted mean with {:.1} times the U that the noise makes, and U of all location errors contains how the \
         lines of the runs differ; its errors depend on where the other axes stand, or changed \
         between the runs: calibrate the runs one at a time and compare",
        axis.name,
        runs.runs.join(", "),
        runs.component.name(&axis.name),
        runs.difference / size,
        trueaxis_files::p_value(runs.p_value),
        runs.birge_ratio()
    ))
}

/// Size and name of the unit in which a component error is stated.
fn unit_of(component: Component) -> (f64, &'static str) {
    match component.is_angular() {
        true => (ARCSEC, "″"),
        false => (MICROMETRE, " µm"),
    }
}

/// A position of an axis (mm or rad) as text with its unit.
fn place(axis: &AxisResult, position: f64) -> String {
    match axis.kind {
        AxisKind::Linear => format!("{position} mm"),
        AxisKind::Rotary => format!("{:.4}°", position.to_degrees()),
    }
}

fn unmeasured_axes(campaign: &Campaign, measured: &[AxisResult]) -> Option<String> {
    let all = campaign.machine.axes().iter().enumerate();
    let unmeasured = all.filter(|(index, _)| measured.iter().all(|axis| axis.axis != *index));
    let names: Vec<&str> = unmeasured.map(|(_, axis)| axis.name()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "no run measures {}: taken as free of errors ({} components unknown)",
            names.join(", "),
            names.len() * Component::ALL.len()
        )
    })
}

/// The notice about an axis with two positions, whose straightness is zero by definition.
fn without_straightness(axis: &AxisResult) -> Option<String> {
    (axis.nodes.len() == 2).then(|| {
        format!(
            "axis {}: measured at two positions: the line through them is its axis, so that its straightness is zero, with U zero, by \
             definition and not by measurement; measure more positions",
            axis.name
        )
    })
}

/// Errors that are more likely mistakes in the campaign.
pub(crate) fn absurd_errors(axis: &AxisResult) -> Vec<String> {
    let worst = |component: Component| {
        let (limit, unit, scale) = match component.is_angular() {
            true => (ABSURD_RAD, "°", 1_f64.to_degrees()),
            false => (ABSURD_MM, " mm", 1.0),
        };
        let size = |node: &NodeResult| node.error.to_vector()[component.index()].abs();
        let nodes = axis.nodes.iter();
        let node = nodes.max_by(|a, b| size(a).total_cmp(&size(b)))?;
        (size(node) > limit).then(|| {
            format!(
                "axis {}: {} reaches {:.2}{unit} at {}: check the positions in the rows, and \
                 the direction of the axis in the campaign",
                axis.name,
                component.name(&axis.name),
                size(node) * scale,
                place(axis, node.position)
            )
        })
    };
    let mut found: Vec<String> = Component::ALL.into_iter().filter_map(worst).collect();
    let tilt_rad = axis.location.tilt_rad.norm();
    if tilt_rad > ABSURD_RAD {
        found.push(format!(
            "axis {} is {:.2}° off its nominal direction: check `direction` in the campaign, and whether coordinates are right-handed, \
             with x, y and z in their places",
            axis.name,
            tilt_rad.to_degrees()
        ));
    }
    found
}

/// Targets that are not at their nominal positions.
pub(crate) fn elsewhere(campaign: &Campaign, targets: &[TargetResult]) -> Vec<String> {
    let found = targets.iter().map(|t| (t.name.as_str(), t.position_mm));
    targets_elsewhere(campaign, &found.collect::<Vec<_>>())
}

/// Linear axes that are longer than commanded alike, where no known length says that they are.
pub(crate) fn longer_alike(calibration: &Calibration) -> Option<String> {
    let scale = |axis: &'_ AxisResult| {
        let direction = calibration.machine.axes()[axis.axis].direction();
        let ends = [axis.nodes.first()?, axis.nodes.last()?];
        let [a, b] = ends.map(|n| (n.position, n.error.translation_mm.dot(&direction)));
        (a.0 < b.0).then(|| (b.1 - a.1) / (b.0 - a.0))
    };
    let linear = calibration
        .axes
        .iter()
        .filter(|axis| axis.kind == AxisKind::Linear);
    let scales = linear.filter_map(|axis| Some((axis.name.as_str(), scale(axis)?)));
    let is_known = |scale: ScaleResult| scale.basis != ScaleBasis::Declared;
    common_scale(&scales.collect::<Vec<_>>()).filter(|_| !calibration.scale.is_some_and(is_known))
}
