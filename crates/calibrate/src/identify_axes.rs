//! Composes single axes to a machine: nine equations, gauge and reference frame, repeated until
//! the exact model reproduces the measured poses.

use nalgebra::{DMatrix, Point3, Vector3, Vector6};
use trueaxis_kinematics::{Axis, AxisKind, LocationComponent, MotionError};

use crate::Error;
use crate::axis_data::{AxisData, RunData};
use crate::basis::Basis;
use crate::frame::{FrameRule, SmallMotion};
use crate::gauge::{Gauge, GaugeDefect, PER_RUN};
use crate::records::{Context, PoseFit, RecordFit, around};
use crate::sensitivity::Sensitivity;
use crate::start::average_lines_and_axes;
use crate::state::{AxisState, ModelErrors, State};
use crate::weights::weights;

/// The identified machine with the linear maps that its uncertainties need.
pub(crate) struct Identified {
    pub(crate) state: State,
    /// Fits of the last pass, for each axis and record.
    pub(crate) fits: Vec<Vec<RecordFit>>,
    /// The covariances with which they were weighted ([`crate::weights`]).
    pub(crate) weights: Vec<Vec<DMatrix<f64>>>,
    /// How the results of each axis follow from its points.
    pub(crate) sensitivities: Vec<Sensitivity>,
    /// How location errors and component errors are told apart on each axis.
    pub(crate) gauges: Vec<Gauge>,
    pub(crate) frame: FrameRule,
    /// For each axis the location errors that the frame does not define away.
    pub(crate) reported: Vec<Vec<LocationComponent>>,
}

/// Each pass leaves about a ten-thousandth of the change before it (the size of the errors in rad);
/// coarse machines, degrees off, need more.
const MAX_PASSES: usize = 60;

/// No pass of a machine that can be identified changes a coordinate by more, mm.
const DIVERGED_MM: f64 = 1e4;

/// Settled when no coordinate changes by more, mm: a picometre of the results is rounding.
const SETTLED_MM: f64 = 1e-9;

pub(crate) fn identify_axes(context: &Context<'_>, data: &[AxisData]) -> Result<Identified, Error> {
    let frame = FrameRule::new(context.campaign, context.machine, data);
    let gauges = data
        .iter()
        .map(|axis| {
            Gauge::new(&context.machine.axes()[axis.axis], axis)
                .map_err(|d| defect(context, axis, &d))
        })
        .collect::<Result<Vec<_>, _>>()?;
    let weights: Vec<_> = data.iter().map(|axis| weights(context, axis)).collect();
    let mut state = average_lines_and_axes(context, data);
    let mut worst = (0.0, 0);
    for _ in 0..MAX_PASSES {
        let changes_mm = improve_all(context, data, &gauges, &frame, &mut state, |state, k| {
            context.fit_poses(data, state, k, &weights[k])
        })?;
        worst = changes_mm.axes;
        let change_mm = worst.0.max(changes_mm.frame);
        if change_mm.is_nan() || change_mm > DIVERGED_MM {
            break;
        }
        if change_mm <= SETTLED_MM {
            let fits = (0..data.len())
                .map(|k| context.fit_records(data, &state, k, &weights[k]))
                .collect::<Result<Vec<_>, _>>()?;
            let sensitivities = data
                .iter()
                .zip(&gauges)
                .zip(&fits)
                .map(|((axis, gauge), fits)| Sensitivity::new(axis, gauge, fits))
                .collect();
            let reported = data.iter().enumerate();
            let reported = reported
                .map(|(k, axis)| reported_errors(&context.machine.axes()[axis.axis], &frame, k))
                .collect();
            return Ok(Identified {
                reported,
                state,
                fits,
                weights,
                sensitivities,
                gauges,
                frame,
            });
        }
    }
    let axis = context.machine.axes()[data[worst.1].axis].name().to_owned();
    Err(Error::NotSettled {
        passes: MAX_PASSES,
        change_mm: worst.0,
        axis,
    })
}

/// What a pass changed, mm.
struct Changes {
    /// The largest change of an axis, and which.
    axes: (f64, usize),
    frame: f64,
}

/// Updates all values, one axis after the other from the bed outwards: each is seen from those before
/// it as they are found. `poses` are those of the records of an axis at the present values.
fn improve_all(
    context: &Context<'_>,
    data: &[AxisData],
    gauges: &[Gauge],
    frame: &FrameRule,
    state: &mut State,
    poses: impl Fn(&State, usize) -> Result<Vec<PoseFit>, Error>,
) -> Result<Changes, Error> {
    let depth = |k: &usize| context.machine.chain(data[*k].axis).len();
    let mut order: Vec<usize> = (0..data.len()).collect();
    order.sort_by_key(depth);
    let mut worst = (0.0, 0);
    for k in order {
        let poses = poses(state, k)?;
        let mut next = state.axes[k].clone();
        let change_mm = improve(context, data, state, k, &gauges[k], &poses, &mut next);
        state.axes[k] = next;
        if change_mm > worst.0 {
            worst = (change_mm, k);
        }
        if change_mm > DIVERGED_MM {
            // What is seen from an axis that went astray means nothing, and is not its fault.
            break;
        }
    }
    Ok(Changes {
        axes: worst,
        frame: settle_frame(context, data, frame, state),
    })
}

/// A replay is settled when no coordinate changes by more, mm: a millionth of what can be measured.
const REPLAY_SETTLED_MM: f64 = 1e-10;

impl Identified {
    /// The values for other points near those that were identified: Newton's method with the operators
    /// of the solution. `None` if it does not settle.
    pub(crate) fn replayed(&self, context: &Context<'_>, data: &[AxisData]) -> Option<State> {
        let mut state = self.state.clone();
        for _ in 0..MAX_PASSES {
            let changes_mm = improve_all(
                context,
                data,
                &self.gauges,
                &self.frame,
                &mut state,
                |state, k| Ok(context.poses(data, state, k, &self.fits[k])),
            );
            let changes_mm = changes_mm.ok()?;
            if changes_mm.axes.0.max(changes_mm.frame) <= REPLAY_SETTLED_MM {
                return Some(state);
            }
        }
        None
    }
}

/// Updates the values of one axis; returns the largest change of a coordinate, mm (infinite where
/// it is not a number).
fn improve(
    context: &Context<'_>,
    data: &[AxisData],
    state: &State,
    k: usize,
    gauge: &Gauge,
    poses: &[PoseFit],
    next: &mut AxisState,
) -> f64 {
    let own = &data[k];
    let axis = &context.machine.axes()[own.axis];
    let pose_errors: Vec<Vector6<f64>> = poses.iter().map(|pose| pose.error).collect();
    let x = gauge.apply(&pose_errors);

    // Component errors: the mean over the records of a node, without what the gauge takes.
    let mut curve = vec![Vector6::zeros(); own.nodes.len()];
    for ((record, error), effect) in own.records.iter().zip(&pose_errors).zip(&gauge.effects) {
        curve[record.node] += (error - effect * &x) / own.nodes[record.node].records as f64;
    }
    let lever_mm = poses.iter().map(|pose| pose.lever_mm).fold(0.0, f64::max);
    let mut change_mm = 0.0_f64;
    let mut changed = |translation: Vector3<f64>, rotation: Vector3<f64>| {
        let size_mm = translation.norm() + lever_mm * rotation.norm();
        // `max` would drop what is not a number.
        change_mm = if size_mm.is_nan() {
            f64::INFINITY
        } else {
            change_mm.max(size_mm)
        };
    };
    for (value, error) in next.curve.iter_mut().zip(&curve) {
        let new = MotionError::from_vector(error);
        changed(
            new.translation_mm - value.translation_mm,
            new.rotation_rad - value.rotation_rad,
        );
        *value = new;
    }

    // Location errors.
    let across = Basis::of(axis).across;
    let combine = |first: usize| across[0] * x[first] + across[1] * x[first + 1];
    match axis.kind() {
        AxisKind::Linear => {
            next.location.tilt_rad += combine(0);
            changed(Vector3::zeros(), combine(0));
        }
        AxisKind::Rotary => {
            next.location.offset_mm += combine(0);
            next.location.tilt_rad += combine(2);
            changed(combine(0), combine(2));
        }
    }

    // Targets: their twist on the stage and the mean of what is not rigid.
    let reference = axis.reference_at_home_mm(&state.axes[k].location);
    let errors = ModelErrors { data, state };
    let distortions = mean_distortions(own, poses);
    for (r, run) in own.runs.iter().enumerate() {
        let first = gauge.location_parameters + PER_RUN * r;
        let twist = MotionError::new(
            x.fixed_rows::<3>(first).into_owned(),
            x.fixed_rows::<3>(first + 3).into_owned(),
        );
        let positions = context.positions_of(&own.records[run.first_record]);
        for (place, &target) in run.targets.iter().enumerate() {
            let (_, inner) = around(
                context.machine,
                context.campaign.targets[target].carrier,
                own.axis,
            );
            let inside = context.machine.chain_motion(&errors, inner, positions);
            let on_stage = inside * state.axes[k].targets_mm[r][place];
            let shift = twist.displacement_mm(on_stage - reference) + distortions[r][place];
            next.targets_mm[r][place] = inside.inverse() * (on_stage + shift);
            changed(shift, Vector3::zeros());
        }
    }
    change_mm
}

/// For each run and target the mean over the run's records of what no rigid motion explains of the
/// target's position.
fn mean_distortions(own: &AxisData, poses: &[PoseFit]) -> Vec<Vec<Vector3<f64>>> {
    let of_run = |run: &RunData| vec![Vector3::zeros(); run.targets.len()];
    let mut sums: Vec<Vec<Vector3<f64>>> = own.runs.iter().map(of_run).collect();
    for (record, pose) in own.records.iter().zip(poses) {
        for (sum, distortion_mm) in sums[record.run].iter_mut().zip(&pose.distortion_mm) {
            *sum += distortion_mm;
        }
    }
    for (sums, run) in sums.iter_mut().zip(&own.runs) {
        sums.iter_mut().for_each(|sum| *sum /= run.records as f64);
    }
    sums
}

/// Moves the reference frame and the axial places of rotary axes to where the rule wants them;
/// returns the largest change, mm.
fn settle_frame(
    context: &Context<'_>,
    data: &[AxisData],
    frame: &FrameRule,
    next: &mut State,
) -> f64 {
    let tilts: Vec<Vector3<f64>> = frame
        .lines
        .iter()
        .map(|&(k, _)| next.axes[k].location.tilt_rad)
        .collect();
    let shifts: Vec<Vector3<f64>> = frame
        .anchors
        .iter()
        .map(|anchor| {
            let target = data[anchor.data].runs[anchor.run].targets[anchor.place];
            next.axes[anchor.data].targets_mm[anchor.run][anchor.place]
                - context.campaign.targets[target].home_mm
        })
        .collect();
    let motion = frame.motion(&tilts, &shifts);
    take_out(context, data, &motion, next);
    let size_mm = context
        .points_mm
        .iter()
        .map(|p| (p - motion.pivot).norm())
        .fold(0.0, f64::max);
    let mut change_mm = motion.translation.norm() + motion.rotation.norm() * size_mm;

    for (axis, values) in data.iter().zip(&mut next.axes) {
        let geometry = &context.machine.axes()[axis.axis];
        if geometry.kind() == AxisKind::Rotary && frame.places_along_itself(axis.axis) {
            let along = geometry.direction().into_inner();
            let shift_mm = mean_axial_shift(context, axis, values, along);
            values.location.offset_mm += along * shift_mm;
            for target in values.targets_mm.iter_mut().flatten() {
                *target -= along * shift_mm;
            }
            change_mm = change_mm.max(shift_mm.abs());
        }
    }
    change_mm
}

/// Takes a motion of the whole out of the frame and of what was found in it: to first order, which the
/// next pass mends, so that it begins where this one ended.
fn take_out(context: &Context<'_>, data: &[AxisData], motion: &SmallMotion, next: &mut State) {
    let removal = motion.removal();
    next.ref_from_datum = removal * next.ref_from_datum;
    for (axis, values) in data.iter().zip(&mut next.axes) {
        let geometry = &context.machine.axes()[axis.axis];
        let along = geometry.direction().into_inner();
        let across = |v: Vector3<f64>| v - along * along.dot(&v);
        values.location.tilt_rad -= across(motion.rotation);
        if geometry.kind() == AxisKind::Rotary {
            let reference = geometry.reference_mm();
            values.location.offset_mm += across(removal * reference - reference);
        }
        for target in values.targets_mm.iter_mut().flatten() {
            *target = removal * *target;
        }
    }
}

/// How far the targets of a rotary axis are from nominal along it, in the mean.
fn mean_axial_shift(
    context: &Context<'_>,
    axis: &AxisData,
    values: &AxisState,
    along: Vector3<f64>,
) -> f64 {
    let mut sum = 0.0;
    let mut count = 0.0;
    for (run, targets_mm) in axis.runs.iter().zip(&values.targets_mm) {
        for (&target, position) in run.targets.iter().zip(targets_mm) {
            sum += (position - context.campaign.targets[target].home_mm).dot(&along);
            count += 1.0;
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

fn defect(context: &Context<'_>, axis: &AxisData, defect: &GaugeDefect) -> Error {
    let name = context.machine.axes()[axis.axis].name();
    let runs: Vec<&str> = axis
        .runs
        .iter()
        .map(|run| context.campaign.runs[run.run].name.as_str())
        .collect();
    match defect {
        GaugeDefect::Positions { singular_value } => Error::NotIdentifiable {
            what: format!(
                "axis {name}: {} position(s) do not tell its location errors from its component \
                 errors (relative singular value {singular_value:.1e})",
                axis.nodes.len()
            ),
            mend: "measure it at more positions, over more of its travel".to_owned(),
        },
        GaugeDefect::Disjoint => Error::NotIdentifiable {
            what: format!("axis {name}: runs {} share no position", runs.join(", ")),
            mend:
                "measure at least two common positions in every run of an axis, or calibrate the \
                   runs one at a time"
                    .to_owned(),
        },
    }
}

/// Mean position of each target over the runs that measured it, in the reference frame at home.
pub(crate) fn mean_targets(
    data: &[AxisData],
    state: &State,
    targets: usize,
) -> Vec<Option<Point3<f64>>> {
    let mut sums = vec![(Vector3::zeros(), 0.0); targets];
    for (axis, values) in data.iter().zip(&state.axes) {
        for (run, positions) in axis.runs.iter().zip(&values.targets_mm) {
            for (&target, position) in run.targets.iter().zip(positions) {
                sums[target].0 += position.coords;
                sums[target].1 += 1.0;
            }
        }
    }
    sums.into_iter()
        .map(|(sum, n)| (n > 0.0).then(|| Point3::from(sum / n)))
        .collect()
}

/// Part of a unit normal below which it has none in that direction.
const NORMAL_TOL: f64 = 1e-9;

/// The location errors that the reference frame does not define away.
fn reported_errors(axis: &Axis, frame: &FrameRule, k: usize) -> Vec<LocationComponent> {
    let all = axis.location_components();
    if axis.kind() == AxisKind::Rotary {
        return all;
    }
    match frame.lines.iter().position(|&(line, _)| line == k) {
        Some(0) => Vec::new(),
        Some(_) => {
            // Only the tilt within the plane of the two lines is left: about the normal of the
            // plane, of which more than one part may be reported if the lines are oblique.
            let (first, second) = (frame.lines[0].1, frame.lines[1].1);
            let normal = first.cross(&second).normalize();
            all.into_iter()
                .filter(|component| matches!(component, LocationComponent::Tilt(i) if normal[*i].abs() > NORMAL_TOL))
                .collect()
        }
        None => all,
    }
}
