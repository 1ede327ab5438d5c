//! The headline verb: a campaign to all geometric errors.

use std::sync::Arc;

use nalgebra::Point3;
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::{ARCSEC, AxisKind, Component, LocationComponent, MICROMETRE, Machine};
use trueaxis_multilateration::{Screened, Solution};

use crate::axis_data::{AxisData, by_axis};
use crate::calibration::{
    AxisResult, Calibration, LocationResult, NodeResult, SideDifference, StationResult,
    TargetResult,
};
use crate::identify_axes::{Identified, identify_axes, mean_targets};
use crate::measure::{Measured, measure};
use crate::method_loss::method_loss;
use crate::output_covariance::{OutputCovariance, check_size};
use crate::pose_errors::Context;
use crate::rigid_fit::centroid;
use crate::settings::{Method, ReferencePoint, Settings};
use crate::uncertainty::{Dependence, Propagation, Uncertainty};
use crate::{Error, rigidity, triangle};

/// Component errors beyond these are no errors but another motion: wrong unit, sign or axis.
const IMPLAUSIBLE_MM: f64 = 50.0;
const IMPLAUSIBLE_RAD: f64 = 0.1;

/// A paced-off position of a station is right to this, mm.
const APPROXIMATE_MM: f64 = 500.0;

/// Linear errors and tilts beyond these are worth a word: no machine in use is that bad, a mistyped
/// position or direction is.
const ABSURD_MM: f64 = 1.0;
const ABSURD_RAD: f64 = 5e-3;

/// Finds all component and location errors of the axes that a campaign measured.
///
/// The reference frame: x-like along the average line of the first linear axis, the second linear
/// axis in the plane of the nominal directions, origin where the targets of these axes are at home
/// in the mean at their nominal positions. With one linear axis the rotation about it, with none
/// the whole frame is the best fit of the targets at home to their nominal positions.
///
/// # Errors
/// See [`Error`]; nothing is returned that is not converged or not determined.
pub fn calibrate(campaign: &Campaign, settings: &Settings) -> Result<Calibration, Error> {
    calibrate_in_parts(campaign, settings).map(|(calibration, _)| calibration)
}

/// The adjustment of the lengths that a calibration rests on.
#[derive(Debug, Clone)]
pub struct LengthsAdjustment {
    /// How component errors follow from it.
    pub method: Method,
    /// Whether the sides of approach have poses of their own.
    pub by_direction: bool,
    /// The screened network with its solution and noise.
    pub screened: Arc<Screened>,
}

/// As [`calibrate`], with the adjustment if lengths were measured: whoever looks further at the lengths starts
/// from it.
///
/// # Errors
/// Those of [`calibrate`].
pub fn calibrate_with_adjustment(
    campaign: &Campaign,
    settings: &Settings,
) -> Result<(Calibration, Option<LengthsAdjustment>), Error> {
    let (calibration, parts) = calibrate_in_parts(campaign, settings)?;
    let adjustment = parts.measured.screened().map(|screened| LengthsAdjustment {
        method: settings.method,
        by_direction: settings.by_direction,
        screened: Arc::clone(screened),
    });
    Ok((calibration, adjustment))
}

/// What a calibration rests on.
pub(crate) struct Parts<'a> {
    pub(crate) machine: Machine,
    pub(crate) measured: Measured<'a>,
    pub(crate) data: Vec<AxisData>,
    pub(crate) identified: Identified,
}

/// A calibration with what it rests on: measure, identify, propagate, report.
pub(crate) fn calibrate_in_parts<'a>(
    campaign: &'a Campaign,
    settings: &Settings,
) -> Result<(Calibration, Parts<'a>), Error> {
    let mut notices = Vec::new();
    let machine = with_reference_points(campaign, settings.reference_point);
    let mut measured = measure(campaign, settings, &mut notices)?;
    let data = by_axis(campaign, measured.poses())?;
    if data.is_empty() {
        return Err(Error::NothingMeasured);
    }
    if settings.covariance {
        check_size(&machine, &data, measured.solution())?;
    }
    let found = measured.isometries();
    let identified = identify_axes(&measured.context(&machine, &found), &data)?;
    check_plausible(&machine, &data, &identified)?;

    let adjustment = measured.report(settings.by_direction, &mut notices);
    if adjustment.degrees_of_freedom == 0 && !adjustment.noise_declared {
        return Err(Error::NotIdentifiable {
            what: "the noise is not declared and nothing checks the measurement, so that no \
                   uncertainty can be given"
                .to_owned(),
            mend: "declare `length_sigma_um` (or `sigma_um` of the points), or measure more"
                .to_owned(),
        });
    }
    measured.follow(&adjustment);

    let context = measured.context(&machine, &found);
    let ref_from_datum = identified.state.ref_from_datum;
    let adjusted = measured.solution();
    let stations_in_ref: Vec<Point3<f64>> = adjusted
        .iter()
        .flat_map(|solution| &solution.stations)
        .map(|station| ref_from_datum * station.position_mm)
        .collect();
    let dependence = Dependence::new(&context, &data, &identified, &stations_in_ref);
    let propagation = Propagation::new(&dependence, measured.poses());
    let losses = method_loss(campaign, &measured, &propagation);
    let sides = measured.side_differences(&machine, &data, &identified, settings.by_direction);
    notices.extend(sides_in_words(&machine, &data, &sides));
    let axes: Vec<AxisResult> = losses
        .into_iter()
        .zip(sides)
        .enumerate()
        .map(|(k, (u_ratio, sides))| AxisResult {
            u_ratio,
            sides,
            ..axis_result(&context, &measured, &propagation, k)
        })
        .collect();
    let stations = stations(
        campaign,
        measured.solution(),
        &stations_in_ref,
        &propagation,
    );
    let covariance = settings
        .covariance
        .then(|| OutputCovariance::new(&propagation, &axes, &stations));
    let targets = mean_targets(&context, &data, &identified.state);
    let points = measured.points.as_ref();
    let triangle = triangle::triangle(&context, &data, &targets, points.map(|(points, _)| points));
    let mut misfits = points.map_or_else(Vec::new, |(_, found)| {
        rigidity::misfits(campaign, found, adjustment.noise_declared)
    });
    if let (Some(lengths), Some(screened)) = (&campaign.lengths, measured.screened()) {
        misfits.extend(rigidity::lost_targets(campaign, lengths, screened));
    }
    notices.extend(unmeasured_axes(campaign, &data));
    notices.extend(absurd(&axes));
    notices.extend(far_from_approximate(campaign, &stations_in_ref));
    notices.extend(measured.solution().filter(|s| s.mirror_image_open).map(|_| {
        "all points lie in one plane, and the lengths fit as well with all stations on its other side: \
         errors across the plane may have the wrong sign; give `approx_mm` of one station to be sure"
            .to_owned()
    }));
    let calibration = Calibration {
        campaign: campaign.name.clone(),
        method: measured.method,
        stations,
        targets: campaign
            .targets
            .iter()
            .zip(&targets)
            .filter_map(|(target, position)| {
                position.map(|position_mm| TargetResult {
                    name: target.name.clone(),
                    position_mm,
                })
            })
            .collect(),
        adjustment,
        axes,
        covariance,
        misfits,
        triangle,
        effects: Vec::new(),
        notices,
    };
    let parts = Parts {
        machine,
        measured,
        data,
        identified,
    };
    Ok((calibration, parts))
}

/// The machine with the reference points of δ that the settings ask for.
fn with_reference_points(campaign: &Campaign, reference: ReferencePoint) -> Machine {
    let machine = &campaign.machine;
    machine.with_axes(|index, axis| match reference {
        ReferencePoint::Origin => axis,
        ReferencePoint::At(point) => axis.with_reference(point),
        ReferencePoint::Centroid => {
            let moved: Vec<Point3<f64>> = campaign
                .targets
                .iter()
                .filter(|target| machine.chain(target.carrier).contains(&index))
                .map(|target| target.home_mm)
                .collect();
            if moved.is_empty() {
                axis
            } else {
                axis.with_reference(centroid(&moved))
            }
        }
    })
}

fn check_plausible(
    machine: &Machine,
    data: &[AxisData],
    identified: &Identified,
) -> Result<(), Error> {
    for (axis, values) in data.iter().zip(&identified.state.axes) {
        let largest = values
            .curve
            .iter()
            .fold((0.0_f64, 0.0_f64), |worst, error| {
                (
                    worst.0.max(error.translation_mm.amax()),
                    worst.1.max(error.rotation_rad.amax()),
                )
            });
        if largest.0 > IMPLAUSIBLE_MM || largest.1 > IMPLAUSIBLE_RAD {
            return Err(Error::NotThatMotion {
                axis: machine.axes()[axis.axis].name().to_owned(),
                translation_mm: largest.0,
                rotation_deg: largest.1.to_degrees(),
            });
        }
    }
    Ok(())
}

fn axis_result(
    context: &Context<'_>,
    measured: &Measured<'_>,
    propagation: &Propagation<'_>,
    k: usize,
) -> AxisResult {
    let Dependence {
        data, identified, ..
    } = propagation.dependence;
    let own = &data[k];
    let axis = &context.machine.axes()[own.axis];
    let values = &identified.state.axes[k];
    let nodes = own
        .nodes
        .iter()
        .zip(&values.curve)
        .zip(propagation.components(k))
        .map(|((node, &error), uncertainties)| NodeResult {
            position: node.position,
            direction: node.direction,
            error,
            u: uncertainties.map(|c| c.u),
            dof: uncertainties.map(|c| c.dof),
            budget: uncertainties.map(|c| c.budget),
        });
    let uncertainties = propagation.location(k);
    let location_errors = identified.reported[k]
        .iter()
        .map(|&component| {
            let Uncertainty { u, dof, budget } = uncertainties[place_of(component)];
            LocationResult {
                component,
                value: component.of(&values.location),
                u,
                dof,
                budget,
            }
        })
        .collect();
    AxisResult {
        name: axis.name().to_owned(),
        axis: own.axis,
        kind: axis.kind(),
        reference_point_mm: axis.reference_mm(),
        nodes: nodes.collect(),
        location: values.location,
        location_errors,
        noise_gain: measured.noise_gain(context.machine, own),
        u_ratio: None,
        sides: None,
    }
}

/// Place of a location error among shift and tilt.
pub(crate) fn place_of(component: LocationComponent) -> usize {
    match component {
        LocationComponent::Offset(i) => i,
        LocationComponent::Tilt(i) => 3 + i,
    }
}

fn stations(
    campaign: &Campaign,
    solution: Option<&Solution>,
    in_ref: &[Point3<f64>],
    propagation: &Propagation<'_>,
) -> Vec<StationResult> {
    let adjusted = solution.iter().flat_map(|s| &s.stations);
    campaign
        .stations
        .iter()
        .zip(adjusted)
        .zip(in_ref.iter().enumerate())
        .map(|((station, adjusted), (j, &position_mm))| {
            let [x, y, z, dead_path] = propagation.station(j);
            StationResult {
                name: station.name.clone(),
                position_mm,
                u_mm: [x.u, y.u, z.u],
                dof: [x.dof, y.dof, z.dof],
                dead_path_mm: adjusted.dead_path_mm,
                u_dead_path_mm: dead_path.u,
                dof_dead_path: dead_path.dof,
            }
        })
        .collect()
}

/// Axes of which the joined curve is the mean of two that differ.
fn sides_in_words(
    machine: &Machine,
    data: &[AxisData],
    sides: &[Option<SideDifference>],
) -> Vec<String> {
    let in_words = |(axis, sides): (&AxisData, &Option<SideDifference>)| {
        let (name, sides) = (machine.axes()[axis.axis].name(), sides.as_ref()?);
        let significance = |c: &Component| (sides.value[c.index()] / sides.u[c.index()]).abs();
        let most = Component::ALL
            .into_iter()
            .max_by(|a, b| significance(a).total_cmp(&significance(b)))?;
        let (size, unit) = match most.is_angular() {
            true => (ARCSEC, "″"),
            false => (MICROMETRE, " µm"),
        };
        let (value, u) = (
            sides.value[most.index()] / size,
            sides.u[most.index()] / size,
        );
        Some(format!(
            "axis {name}: forward and backward approach differ, {} by {value:+.2}{unit} (U {:.2}{unit}): its \
             curves are the mean of both sides; --by-direction keeps them apart",
            most.name(name),
            2.0 * u
        ))
    };
    data.iter().zip(sides).filter_map(in_words).collect()
}

/// Errors that are more likely mistakes in the campaign.
fn absurd(axes: &[AxisResult]) -> Vec<String> {
    let mut found = Vec::new();
    for axis in axes {
        let position = |node: &NodeResult| match axis.kind {
            AxisKind::Linear => format!("{} mm", node.position),
            AxisKind::Rotary => format!("{:.4}°", node.position.to_degrees()),
        };
        for component in Component::ALL {
            let c = component.index();
            let (limit, unit, scale) = if component.is_angular() {
                (ABSURD_RAD, "°", 1_f64.to_degrees())
            } else {
                (ABSURD_MM, " mm", 1.0)
            };
            let size = |node: &&NodeResult| node.error.to_vector()[c].abs();
            let worst = axis.nodes.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
            if let Some(node) = worst.filter(|node| size(node) > limit) {
                found.push(format!(
                    "axis {}: {} reaches {:.2}{unit} at {}: check the positions in the rows, and \
                     the direction of the axis in the campaign",
                    axis.name,
                    component.name(&axis.name),
                    size(&node) * scale,
                    position(node)
                ));
            }
        }
        let tilt_rad = axis.location.tilt_rad.norm();
        if tilt_rad > ABSURD_RAD {
            found.push(format!(
                "axis {} is {:.2}° off its nominal direction: check `direction` in the campaign",
                axis.name,
                tilt_rad.to_degrees()
            ));
        }
    }
    found
}

/// Stations that are not where the campaign says they are, roughly.
fn far_from_approximate(campaign: &Campaign, found: &[Point3<f64>]) -> Vec<String> {
    let stations = campaign.stations.iter().zip(found);
    let far = stations.filter_map(|(station, found)| {
        let distance_mm = (found - station.approx_mm?).norm();
        (distance_mm > APPROXIMATE_MM).then(|| {
            format!(
                "station {} was found {distance_mm:.0} mm from its approx_mm: check its name and \
                 `approx_mm`",
                station.name
            )
        })
    });
    far.collect()
}

fn unmeasured_axes(campaign: &Campaign, data: &[AxisData]) -> Option<String> {
    let names: Vec<&str> = campaign
        .machine
        .axes()
        .iter()
        .enumerate()
        .filter(|(index, _)| data.iter().all(|axis| axis.axis != *index))
        .map(|(_, axis)| axis.name())
        .collect();
    (!names.is_empty()).then(|| {
        format!(
            "no run measures {}: taken as free of errors ({} components unknown)",
            names.join(", "),
            names.len() * Component::ALL.len()
        )
    })
}
