//! The results of axes and stations with their uncertainties.

use trueaxis_campaign::Campaign;
use trueaxis_kinematics::GeometricErrors;
use trueaxis_poses::{MeasuredPoses, SideDifference, Station};
use trueaxis_predict::stands_alike;

use crate::propagate::dependence::Dependence;
use crate::propagate::propagation::{Propagation, Uncertainty, place_of};
use crate::report::method_loss::method_loss;
use crate::report::run_misfit::widen;
use crate::result::calibration::{
    AxisResult, LocationResult, NodeResult, RunMisfit, StationResult,
};

/// The errors of all axes.
pub(crate) fn axis_results(
    measured: &MeasuredPoses<'_>,
    propagation: &Propagation<'_, '_>,
    runs: Vec<Option<RunMisfit>>,
) -> Vec<AxisResult> {
    let losses = measured.by_equations.as_ref();
    let losses = losses.map(|by_equations| method_loss(by_equations, propagation));
    let sides = side_differences(measured, propagation.dependence);
    let axes = sides.into_iter().zip(runs).enumerate();
    let axes = axes.map(|(k, (sides, runs))| AxisResult {
        u_ratio: losses.as_ref().map(|losses| losses[k]),
        sides,
        runs,
        ..axis_result(measured, propagation, k)
    });
    let mut axes: Vec<AxisResult> = axes.collect();
    widen(&mut axes);
    axes
}

/// For each axis the difference between sides of approach that share its curves.
fn side_differences(
    measured: &MeasuredPoses<'_>,
    dependence: &Dependence<'_>,
) -> Vec<Option<SideDifference>> {
    let (context, identified) = dependence.parts();
    let errors = context.errors(&identified.state);
    let reference_mm = |step: usize| {
        let axis = context.campaign.axis_under_test(step).unwrap_or_default();
        let step = &context.campaign.steps[step];
        let geometry = &context.machine.axes()[axis];
        let at_home_mm = geometry.reference_at_home_mm(&errors.location(axis));
        context.machine.motion(&errors, axis, &step.positions) * at_home_mm
    };
    let axes: Vec<usize> = context.data.iter().map(|data| data.axis).collect();
    measured.lengths.as_ref().map_or_else(
        || vec![None; axes.len()],
        |lengths| lengths.side_differences(&axes, reference_mm),
    )
}

/// The errors of axis `k` of the data.
fn axis_result(
    measured: &MeasuredPoses<'_>,
    propagation: &Propagation<'_, '_>,
    k: usize,
) -> AxisResult {
    let (context, identified) = propagation.dependence.parts();
    let (own, axis) = (&context.data[k], context.axis(k));
    let values = &identified.state.axes[k];
    let nodes = own.nodes.iter().zip(&values.curve);
    let nodes = nodes.zip(propagation.components(k));
    let nodes = nodes.map(|((node, &error), uncertainties)| NodeResult {
        position: node.position,
        direction: node.direction,
        error,
        u: uncertainties.map(|c| c.u),
        dof: uncertainties.map(|c| c.dof),
        budget: uncertainties.map(|c| c.budget),
    });
    let uncertainties = propagation.location(k);
    let location_errors = identified.reported[k].iter().map(|&component| {
        let place = place_of(component);
        let Uncertainty { u, dof, budget } = uncertainties[place];
        LocationResult {
            relative_to_targets: propagation.dependence.depends_on_nests(k, place),
            component,
            value: component.of(&values.location),
            u,
            dof,
            budget,
        }
    });
    let others = context.machine.axes().iter().enumerate();
    let parked = others.map(|(other, geometry)| {
        let mut stood = own.runs.iter().map(|run| run.positions[other]);
        let first = stood.next().filter(|_| other != own.axis).unwrap_or(0.0);
        let is_same = |q| other == own.axis || stands_alike(geometry.kind(), first, q);
        stood.all(is_same).then_some(first)
    });
    let poses: Vec<usize> = own.poses.iter().map(|pose| pose.index).collect();
    AxisResult {
        name: axis.name().to_owned(),
        axis: own.axis,
        kind: axis.kind(),
        parked: parked.collect(),
        reference_point_mm: axis.reference_mm(),
        nodes: nodes.collect(),
        location: values.location,
        location_errors: location_errors.collect(),
        noise_gain: measured.noise_gain(context.machine, &poses),
        u_ratio: None,
        sides: None,
        runs: None,
    }
}

/// Stations in the reference frame, with their dead paths.
pub(crate) fn station_results(
    campaign: &Campaign,
    adjusted: &[Station],
    propagation: &Propagation<'_, '_>,
) -> Vec<StationResult> {
    let in_ref = &propagation.dependence.stations_in_ref;
    let stations = campaign.stations.iter().zip(adjusted);
    let stations = stations.zip(in_ref).enumerate();
    stations
        .map(|(j, ((station, adjusted), &position_mm))| {
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
