//! Composes single axes to a machine: pose errors, gauge and reference frame, repeated until the exact
//! model reproduces the measured poses.

use nalgebra::{Isometry3, Matrix6, MatrixXx6, Point3, Translation3, Vector3, Vector6};
use trueaxis_kinematics::{AxisKind, LocationComponent, MotionError};
use trueaxis_poses::turned_about;

use crate::Error;
use crate::identify::axis_data::AxisData;
use crate::identify::basis::Basis;
use crate::identify::frame::{Anchor, FrameRule, SmallMotion};
use crate::identify::gauge::{Gauge, GaugeDefect, PER_RUN};
use crate::identify::pose_errors::Context;
use crate::identify::start::average_lines_and_axes;
use crate::identify::state::{AxisState, ModelErrors, State};
use crate::in_order;

/// The identified machine with the linear maps that its uncertainties need.
pub(crate) struct Identified {
    pub(crate) state: State,
    /// How the results of each axis follow from its poses.
    pub(crate) sensitivities: Vec<Sensitivity>,
    /// How location errors and component errors are told apart on each axis.
    pub(crate) gauges: Vec<Gauge>,
    pub(crate) frame: FrameRule,
    /// For each axis the location errors that the frame does not define away.
    pub(crate) reported: Vec<Vec<LocationComponent>>,
}

/// How the results of an axis follow from the errors `x_i` of its poses ([`trueaxis_poses`]), seen from its
/// base as if that were known: with the maps `A_i` of [`Context::error_maps`] and the gauge
///
/// ```text
/// e_i = A_i x_i     y = Σ Γ_i e_i     E_k = mean e - Λ_k y
/// ```
pub(crate) struct Sensitivity {
    /// Number of the axis' own parameters, which come first in `y`.
    pub(crate) location_parameters: usize,
    /// `A` of each record.
    pub(crate) poses: Vec<Matrix6<f64>>,
    /// `Γ A` of each record.
    pub(crate) parameters: Vec<MatrixXx6<f64>>,
}

impl Sensitivity {
    fn new(gauge: &Gauge, poses: Vec<Matrix6<f64>>) -> Self {
        Self {
            location_parameters: gauge.location_parameters,
            parameters: in_order::map(poses.len(), |i| &gauge.shares[i] * poses[i]),
            poses,
        }
    }
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
    let gauge = |axis: &AxisData| {
        Gauge::new(&context.machine.axes()[axis.axis], axis).map_err(|d| defect(context, axis, &d))
    };
    let gauges = data.iter().map(gauge).collect::<Result<Vec<_>, _>>()?;
    let mut state = average_lines_and_axes(context, data);
    let mut worst = (0.0, 0);
    for _ in 0..MAX_PASSES {
        let changes_mm = improve_all(context, data, &gauges, &frame, &mut state);
        worst = changes_mm.axes;
        let change_mm = worst.0.max(changes_mm.frame);
        if change_mm.is_nan() || change_mm > DIVERGED_MM {
            break;
        }
        if change_mm <= SETTLED_MM {
            let sensitivity =
                |(k, gauge)| Sensitivity::new(gauge, context.error_maps(data, &state, k));
            let reported = data
                .iter()
                .map(|axis| frame.reported(context.machine, axis.axis));
            return Ok(Identified {
                sensitivities: gauges.iter().enumerate().map(sensitivity).collect(),
                reported: reported.collect(),
                state,
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
/// it as they are found.
fn improve_all(
    context: &Context<'_>,
    data: &[AxisData],
    gauges: &[Gauge],
    frame: &FrameRule,
    state: &mut State,
) -> Changes {
    let depth = |k: &usize| context.machine.chain(data[*k].axis).len();
    let mut order: Vec<usize> = (0..data.len()).collect();
    order.sort_by_key(depth);
    let mut worst = (0.0, 0);
    for k in order {
        let change_mm = improve(context, data, &gauges[k], state, k);
        if change_mm > worst.0 {
            worst = (change_mm, k);
        }
        if change_mm > DIVERGED_MM {
            // Results relative to a diverged axis are invalid: the diverged axis is reported.
            break;
        }
    }
    Changes {
        axes: worst,
        frame: settle_frame(context, data, frame, state),
    }
}

/// A replay is settled when no coordinate changes by more, mm: a millionth of what can be measured.
const REPLAY_SETTLED_MM: f64 = 1e-10;

impl Identified {
    /// The values for other poses near those that were identified. `None` if they do not settle.
    pub(crate) fn replayed(&self, context: &Context<'_>, data: &[AxisData]) -> Option<State> {
        let mut state = self.state.clone();
        for _ in 0..MAX_PASSES {
            let changes_mm = improve_all(context, data, &self.gauges, &self.frame, &mut state);
            if changes_mm.axes.0.max(changes_mm.frame) <= REPLAY_SETTLED_MM {
                return Some(state);
            }
        }
        None
    }
}

/// Updates the values of axis `k`; returns the largest change of a coordinate, mm (infinite where
/// it is not a number).
fn improve(
    context: &Context<'_>,
    data: &[AxisData],
    gauge: &Gauge,
    state: &mut State,
    k: usize,
) -> f64 {
    let own = &data[k];
    let axis = &context.machine.axes()[own.axis];
    let reference = axis.reference_at_home_mm(&state.axes[k].location);
    let pose_errors = context.pose_errors(data, state, k);
    let x = gauge.apply(&pose_errors);

    // Component errors: the mean over the records of a node, without what the gauge takes.
    let mut curve = vec![Vector6::zeros(); own.nodes.len()];
    for ((record, error), effect) in own.records.iter().zip(&pose_errors).zip(&gauge.effects) {
        curve[record.node] += (error - effect * &x) / own.nodes[record.node].records.len() as f64;
    }
    let lever_mm = lever_mm(context, own, &state.axes[k], &reference);
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
    for (value, error) in state.axes[k].curve.iter_mut().zip(&curve) {
        let new = MotionError::from_vector(error);
        changed(
            new.translation_mm - value.translation_mm,
            new.rotation_rad - value.rotation_rad,
        );
        *value = new;
    }

    // The places of the bodies: their twist on the stage.
    for (r, run) in own.runs.iter().enumerate() {
        let first = gauge.location_parameters + PER_RUN * r;
        let twist: Vector6<f64> = x.fixed_rows::<PER_RUN>(first).into_owned();
        let (_, inner) = run.around(context.machine, own.axis);
        let inside =
            context
                .machine
                .chain_motion(&ModelErrors { data, state }, inner, &run.positions);
        let placement = &mut state.axes[k].placements[r];
        *placement = inside.inverse() * turned_about(&reference, &twist) * inside * *placement;
        let part = |first: usize| twist.fixed_rows::<3>(first).into_owned();
        changed(part(0), part(3));
    }

    // Location errors.
    let across = Basis::of(axis).across;
    let combine = |first: usize| across[0] * x[first] + across[1] * x[first + 1];
    let location = &mut state.axes[k].location;
    match axis.kind() {
        AxisKind::Linear => {
            location.tilt_rad += combine(0);
            changed(Vector3::zeros(), combine(0));
        }
        AxisKind::Rotary => {
            location.offset_mm += combine(0);
            location.tilt_rad += combine(2);
            changed(combine(0), combine(2));
        }
    }
    change_mm
}

/// The largest distance of a target at home from the reference point of an axis, mm.
fn lever_mm(
    context: &Context<'_>,
    axis: &AxisData,
    values: &AxisState,
    reference: &Point3<f64>,
) -> f64 {
    let of_run = |(run, placement): (&crate::identify::axis_data::RunData, &Isometry3<f64>)| {
        let shape_mm = &context.poses.bodies[run.body].home_mm;
        let distances = shape_mm.iter().map(|p| (placement * p - reference).norm());
        distances.fold(0.0, f64::max)
    };
    let runs = axis.runs.iter().zip(&values.placements);
    runs.map(of_run).fold(0.0, f64::max)
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
        .map(|&k| next.axes[k].location.tilt_rad)
        .collect();
    let homes_mm = home_positions(context, data, next);
    let shift = |anchor: &Anchor| {
        let target = data[anchor.data].runs[anchor.run].targets[anchor.place];
        let home_mm = homes_mm[anchor.data][anchor.run][anchor.place];
        home_mm - context.campaign.targets[target].home_mm
    };
    let shifts: Vec<Vector3<f64>> = frame.anchors.iter().map(shift).collect();
    let motion = frame.motion(&tilts, &shifts);
    take_out(context, data, &motion, next);
    let pivots = context.poses.observations.iter().map(|pose| pose.pivot_mm);
    let distances = pivots.map(|p| (p - motion.pivot).norm());
    let size_mm = distances.fold(0.0, f64::max);
    let mut change_mm = motion.translation.norm() + motion.rotation.norm() * size_mm;

    for (k, axis) in data.iter().enumerate() {
        let geometry = &context.machine.axes()[axis.axis];
        if geometry.kind() == AxisKind::Rotary && frame.places_along_itself(axis.axis) {
            let along = geometry.direction().into_inner();
            let shift_mm = mean_axial_shift(context, data, next, k, along);
            let values = &mut next.axes[k];
            values.location.offset_mm += along * shift_mm;
            let back = Translation3::from(-along * shift_mm);
            for placement in &mut values.placements {
                *placement = back * *placement;
            }
            change_mm = change_mm.max(shift_mm.abs());
        }
    }
    change_mm
}

/// Where the targets of each run of each axis are at home in the reference frame, mm.
fn home_positions(
    context: &Context<'_>,
    data: &[AxisData],
    state: &State,
) -> Vec<Vec<Vec<Point3<f64>>>> {
    let errors = ModelErrors { data, state };
    let of_run = |place| errors.targets_mm(context.machine, &context.poses.bodies, place);
    let of_axis =
        |(k, axis): (usize, &AxisData)| (0..axis.runs.len()).map(|r| of_run((k, r))).collect();
    data.iter().enumerate().map(of_axis).collect()
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
        for placement in &mut values.placements {
            *placement = removal * *placement;
        }
    }
}

/// How far the targets of a rotary axis are from nominal along it, in the mean.
fn mean_axial_shift(
    context: &Context<'_>,
    data: &[AxisData],
    state: &State,
    k: usize,
    along: Vector3<f64>,
) -> f64 {
    let errors = ModelErrors { data, state };
    let mut shifts = Vec::new();
    for (r, run) in data[k].runs.iter().enumerate() {
        let found = errors.targets_mm(context.machine, &context.poses.bodies, (k, r));
        let nominal = run.nominal_mm(context.campaign);
        shifts.extend(
            found
                .iter()
                .zip(&nominal)
                .map(|(p, home)| (p - home).dot(&along)),
        );
    }
    shifts.iter().sum::<f64>() / shifts.len().max(1) as f64
}

fn defect(context: &Context<'_>, axis: &AxisData, defect: &GaugeDefect) -> Error {
    let name = context.machine.axes()[axis.axis].name();
    let (what, mend) = match defect {
        GaugeDefect::Positions { singular_value } => (
            format!(
                "axis {name}: {} position(s) do not tell its location errors from its component \
                 errors (relative singular value {singular_value:.1e})",
                axis.nodes.len()
            ),
            "measure it at more positions, over more of its travel",
        ),
        GaugeDefect::Disjoint => {
            let runs = axis
                .runs
                .iter()
                .map(|run| context.campaign.runs[run.run].name.as_str());
            let runs = runs.collect::<Vec<_>>().join(", ");
            (
                format!("axis {name}: runs {runs} share no position"),
                "measure at least two common positions in every run of an axis, or calibrate the runs one at \
                 a time",
            )
        }
    };
    Error::NotIdentifiable {
        what,
        mend: mend.to_owned(),
    }
}

/// Mean position of each target over the runs that measured it, in the reference frame at home.
pub(crate) fn mean_targets(
    context: &Context<'_>,
    data: &[AxisData],
    state: &State,
) -> Vec<Option<Point3<f64>>> {
    let mut sums = vec![(Vector3::zeros(), 0.0); context.campaign.targets.len()];
    for (axis, homes_mm) in data.iter().zip(home_positions(context, data, state)) {
        for (run, positions) in axis.runs.iter().zip(homes_mm) {
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
