//! The headline verb: a campaign to all geometric errors.

use nalgebra::Point3;
use trueaxis_campaign::Campaign;
use trueaxis_identify::triangle_mismatch;
use trueaxis_kinematics::{Axis, AxisKind, Component, MICROMETRE, Machine};
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_multilateration::Solution;

use crate::axis_data::{AxisData, by_axis};
use crate::calibration::{
    AdjustmentReport, AxisResult, Calibration, LocationResult, NodeResult, StationResult,
    TargetResult, TriangleSide,
};
use crate::identify_axes::{Identified, identify_axes, mean_targets};
use crate::measured::Measured;
use crate::records::Context;
use crate::rigid_fit::centroid;
use crate::settings::{ReferencePoint, Settings};
use crate::uncertainty::{FrameDependent, of_components, of_frame_dependent};
use crate::{Error, from_lengths, from_points, rigidity};

/// Significance at which the declared noise is given up for the residuals' own: one clean campaign
/// in a thousand gets larger uncertainties than it needs.
const GLOBAL_TEST_LEVEL: f64 = 1e-3;

/// A measured distance between targets that differs less from nominal needs no word, mm.
const TRIANGLE_TOL_MM: f64 = 0.01;

/// The same in standard deviations of the distance at one step.
const TRIANGLE_TOL_SIGMAS: f64 = 5.0;

/// Component errors beyond these are no errors but another motion: wrong unit, sign or axis.
const IMPLAUSIBLE_MM: f64 = 50.0;
const IMPLAUSIBLE_RAD: f64 = 0.1;

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
    let (mut measured, solution) = match (&campaign.lengths, &campaign.points) {
        (Some(lengths), _) => {
            let (measured, solution) =
                from_lengths::measure(campaign, lengths, settings.by_direction)?;
            (measured, Some(solution))
        }
        (None, Some(points)) => (
            from_points::measure(campaign, points, settings.by_direction),
            None,
        ),
        (None, None) => return Err(Error::NothingMeasured),
    };
    let machine = with_reference_points(campaign, settings.reference_point);
    let data = by_axis(campaign, &measured)?;
    if data.is_empty() {
        return Err(Error::NothingMeasured);
    }
    let context = Context {
        campaign,
        machine: &machine,
        measured: &measured,
        method: settings.method,
    };
    let identified = identify_axes(&context, &data)?;
    check_plausible(&machine, &data, &identified)?;

    let mut notices = Vec::new();
    let adjustment = report(
        campaign,
        settings.by_direction,
        &measured,
        &data,
        &identified,
        solution.as_ref(),
        &mut notices,
    );
    measured.noise.variance_factor = adjustment.uncertainty_factor.powi(2);

    let context = Context {
        campaign,
        machine: &machine,
        measured: &measured,
        method: settings.method,
    };
    let ref_from_datum = identified.state.ref_from_datum;
    let stations_in_ref: Vec<Point3<f64>> = solution
        .iter()
        .flat_map(|s| &s.stations)
        .map(|station| ref_from_datum * station.position_mm)
        .collect();
    let frame_dependent = of_frame_dependent(&context, &data, &identified, &stations_in_ref);
    let axes = (0..data.len())
        .map(|k| axis_result(&context, &data, &identified, k, &frame_dependent))
        .collect();
    let targets = mean_targets(&data, &identified.state, campaign.targets.len());
    let triangle = triangle(&context, &data, &targets);
    let misfits = rigidity::misfits(&context, &data, &identified, adjustment.uncertainty_factor);
    notices.extend(unmeasured_axes(campaign, &data));
    notices.extend(solution.as_ref().filter(|s| s.mirror_image_open).map(|_| {
        "all points lie in one plane, and the lengths fit as well with all stations on its other side: \
         errors across the plane may have the wrong sign; give `approx_mm` of one station to be sure"
            .to_owned()
    }));
    Ok(Calibration {
        campaign: campaign.name.clone(),
        method: settings.method,
        stations: stations(
            campaign,
            solution.as_ref(),
            &stations_in_ref,
            &frame_dependent,
        ),
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
        misfits,
        triangle,
        notices,
    })
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

/// What the residuals say about the noise.
fn report(
    campaign: &Campaign,
    by_direction: bool,
    measured: &Measured,
    data: &[AxisData],
    identified: &Identified,
    solution: Option<&Solution>,
    notices: &mut Vec<String>,
) -> AdjustmentReport {
    let instrument = &campaign.instrument;
    let (squares, observations, degrees_of_freedom, declared) = match solution {
        Some(solution) => (
            solution.squares,
            solution.observations,
            solution.degrees_of_freedom(),
            instrument.length_sigma_um.is_some(),
        ),
        None => {
            let (squares, degrees_of_freedom) = rigidity::total(data, identified);
            let readings = campaign.points.iter().flat_map(|points| &points.readings);
            let declared = readings
                .into_iter()
                .all(|reading| reading.sigma_um.is_some());
            (
                squares,
                3 * measured.points_mm.len(),
                degrees_of_freedom,
                declared,
            )
        }
    };
    let sigma0 = if degrees_of_freedom > 0 {
        (squares / degrees_of_freedom as f64).sqrt()
    } else {
        1.0
    };
    let p_value = chi_squared_upper_tail(squares, degrees_of_freedom as f64);
    let scaled = !declared || p_value < GLOBAL_TEST_LEVEL;
    if degrees_of_freedom == 0 {
        notices.push(
            "nothing checks the measurement: there are no more observations than unknowns"
                .to_owned(),
        );
    } else if !declared {
        notices.push(format!(
            "the noise is not declared: uncertainties follow from the residuals ({degrees_of_freedom} \
             degrees of freedom)"
        ));
    } else if p_value < GLOBAL_TEST_LEVEL {
        notices.push(format!(
            "the residuals are {sigma0:.2} times what the declared noise explains (p = {p_value:.1e}): \
             the model or the declared noise is wrong; all uncertainties are multiplied by {sigma0:.2}"
        ));
        if !by_direction && approached_from_both_sides(campaign) {
            notices.push(
                "positions were approached from both sides: lost motion makes such residuals; \
                 --by-direction gives each side curves of its own"
                    .to_owned(),
            );
        }
    } else if p_value > 1.0 - GLOBAL_TEST_LEVEL {
        notices.push(format!(
            "the residuals are only {sigma0:.2} times what the declared noise explains: it is declared \
             too large, and so are the uncertainties"
        ));
    }
    AdjustmentReport {
        observations,
        unknowns: observations - degrees_of_freedom,
        degrees_of_freedom,
        sigma0,
        p_value,
        uncertainty_factor: if scaled { sigma0 } else { 1.0 },
        rms_residual_mm: match solution {
            Some(solution) => solution.rms_residual_mm(),
            None => rigidity::rms_mm(identified),
        },
        length_sigma_mm: solution.map(|_| {
            instrument
                .length_sigma_um
                .map_or(MICROMETRE, |um| um * MICROMETRE)
        }),
        repeatability_mm: instrument.repeatability_um.unwrap_or(0.0) * MICROMETRE,
        iterations: solution.map_or(0, |solution| solution.iterations),
        termination: solution.map_or_else(
            || "points measured directly, nothing to adjust".to_owned(),
            |solution| solution.termination.to_string(),
        ),
    }
}

fn approached_from_both_sides(campaign: &Campaign) -> bool {
    let lengths = campaign.lengths.iter().flat_map(|lengths| &lengths.stops);
    let points = campaign.points.iter().flat_map(|points| &points.stops);
    let mut directions = lengths.chain(points).map(|stop| stop.direction);
    let first = directions.next();
    directions.any(|direction| Some(direction) != first)
}

fn axis_result(
    context: &Context<'_>,
    data: &[AxisData],
    identified: &Identified,
    k: usize,
    frame_dependent: &FrameDependent,
) -> AxisResult {
    let own = &data[k];
    let axis = &context.machine.axes()[own.axis];
    let values = &identified.state.axes[k];
    let u = of_components(context, data, identified, k);
    let nodes = own
        .nodes
        .iter()
        .zip(&values.curve)
        .zip(u)
        .map(|((node, &error), u)| NodeResult {
            position: node.position,
            direction: node.direction,
            error,
            u,
        });
    let fits = &identified.fits[k];
    let mean_gain = |gain: &dyn Fn(usize) -> [f64; 6]| {
        let mut mean = [0.0; 6];
        for i in 0..fits.len() {
            for (sum, g) in mean.iter_mut().zip(gain(i)) {
                *sum += g / fits.len() as f64;
            }
        }
        mean
    };
    let location_u = &frame_dependent.locations[k];
    let location_errors = reported(axis, identified, k)
        .into_iter()
        .map(|component| LocationResult {
            component,
            value: component.of(&values.location),
            u: component.of(location_u),
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
        noise_gain: mean_gain(&|i| fits[i].noise_gain.into()),
        noise_gain_nine: mean_gain(&|i| fits[i].noise_gain_nine.into()),
    }
}

/// The location errors that the reference frame does not define away.
fn reported(
    axis: &Axis,
    identified: &Identified,
    k: usize,
) -> Vec<trueaxis_kinematics::LocationComponent> {
    use trueaxis_kinematics::LocationComponent::Tilt;
    let all = axis.location_components();
    if axis.kind() == AxisKind::Rotary {
        return all;
    }
    match identified
        .frame
        .lines
        .iter()
        .position(|&(line, _)| line == k)
    {
        Some(0) => Vec::new(),
        Some(_) => {
            // Only the tilt within the plane of the two lines: about the normal of the plane.
            let (first, second) = (identified.frame.lines[0].1, identified.frame.lines[1].1);
            let normal = first.cross(&second).iamax();
            all.into_iter()
                .filter(|component| *component == Tilt(normal))
                .collect()
        }
        None => all,
    }
}

fn stations(
    campaign: &Campaign,
    solution: Option<&Solution>,
    in_ref: &[Point3<f64>],
    frame_dependent: &FrameDependent,
) -> Vec<StationResult> {
    let adjusted = solution.iter().flat_map(|s| &s.stations);
    campaign
        .stations
        .iter()
        .zip(adjusted)
        .zip(in_ref.iter().zip(&frame_dependent.stations))
        .map(
            |((station, adjusted), (&position_mm, &[x, y, z, dead_path]))| StationResult {
                name: station.name.clone(),
                position_mm,
                u_mm: [x, y, z],
                dead_path_mm: adjusted.dead_path_mm,
                u_dead_path_mm: dead_path,
            },
        )
        .collect()
}

/// Distances between the targets of each run that differ from nominal by more than measurement
/// explains.
fn triangle(
    context: &Context<'_>,
    data: &[AxisData],
    mean_mm: &[Option<Point3<f64>>],
) -> Vec<TriangleSide> {
    let targets = &context.campaign.targets;
    let mut found: Vec<TriangleSide> = Vec::new();
    for axis in data {
        for run in &axis.runs {
            let seen: Vec<(usize, Point3<f64>)> = run
                .targets
                .iter()
                .filter_map(|&t| mean_mm[t].map(|p| (t, p)))
                .collect();
            let nominal: Vec<_> = seen.iter().map(|&(t, _)| targets[t].home_mm).collect();
            let measured: Vec<_> = seen.iter().map(|&(_, p)| p).collect();
            let Ok(sides) = triangle_mismatch(&nominal, &measured) else {
                continue;
            };
            let noise = context
                .measured
                .noise
                .total(axis.records[run.first_record].group);
            let variance_mm2 = noise.diagonal().max() * 2.0;
            let limit_mm = TRIANGLE_TOL_MM.max(TRIANGLE_TOL_SIGMAS * variance_mm2.sqrt());
            for side in sides {
                let names = [side.first, side.second].map(|i| targets[seen[i].0].name.clone());
                let known = found.iter().any(|other| other.targets == names);
                if !known && (side.measured_mm - side.nominal_mm).abs() > limit_mm {
                    found.push(TriangleSide {
                        targets: names,
                        nominal_mm: side.nominal_mm,
                        measured_mm: side.measured_mm,
                    });
                }
            }
        }
    }
    found
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
