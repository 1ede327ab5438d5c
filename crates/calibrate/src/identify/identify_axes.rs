//! Combines the axes of a machine: pose errors, gauge and reference frame, repeated until the exact model reproduces
//! the measured poses.

use nalgebra::{Matrix6, MatrixXx6, Point3, Vector3, Vector6};
use trueaxis_files::counted;
use trueaxis_kinematics::{AxisKind, LocationComponent, MotionError};
use trueaxis_poses::turned_about;

use crate::Error;
use crate::identify::apply_frame::apply_frame;
use crate::identify::axis_data::AxisData;
use crate::identify::basis::Basis;
use crate::identify::context::Context;
use crate::identify::frame::FrameRule;
use crate::identify::gauge::{GaugeDefect, LeastSquaresGauge, PER_RUN};
use crate::identify::start::average_lines_and_axes;
use crate::identify::state::{AxisState, State};
use crate::in_order;

/// The identified machine with the linear maps that its uncertainties need.
pub(crate) struct Identified {
    pub(crate) state: State,
    /// How the results of each axis follow from its poses.
    pub(crate) sensitivities: Vec<Sensitivity>,
    /// How location errors and component errors are separated on each axis.
    pub(crate) gauges: Vec<LeastSquaresGauge>,
    pub(crate) frame: FrameRule,
    /// For each axis the location errors that the frame does not define.
    pub(crate) reported: Vec<Vec<LocationComponent>>,
}

/// How the results of an axis follow from the errors `x_i` of its poses ([`trueaxis_poses`]), seen from its base as
/// if the base were known: with the maps `A_i` of [`Context::error_maps`] and the gauge
///
/// ```text
/// e_i = A_i x_i     y = Σ Γ_i e_i     E_k = mean e - Λ_k y
/// ```
pub(crate) struct Sensitivity {
    /// `A` of each pose.
    pub(crate) poses: Vec<Matrix6<f64>>,
    /// `Γ A` of each pose.
    pub(crate) parameters: Vec<MatrixXx6<f64>>,
}

/// Each pass leaves about a ten-thousandth (the size of the errors in rad) of the previous change; coarse machines,
/// degrees off, need more.
const MAX_PASSES: usize = 60;

/// No pass changes a coordinate by more than this, mm, if the machine can be identified.
const DIVERGED_MM: f64 = 1e4;

/// Converged when no coordinate changes by more than this, mm; a picometre in the results is rounding.
const CONVERGED_MM: f64 = 1e-9;

/// Finds the errors of all axes and the reference frame from the measured poses.
pub(crate) fn identify_axes(context: &Context<'_>) -> Result<Identified, Error> {
    let frame = FrameRule::new(context);
    let gauge = |(k, data): (usize, &AxisData)| {
        LeastSquaresGauge::new(context.axis(k), data).map_err(|d| defect(context, k, &d))
    };
    let gauges = context.data.iter().enumerate().map(gauge);
    let gauges = gauges.collect::<Result<Vec<_>, _>>()?;
    let mut state = average_lines_and_axes(context);
    let mut worst = (0.0, 0);
    for _ in 0..MAX_PASSES {
        let changes_mm = improve_all(context, &gauges, &frame, &mut state);
        worst = changes_mm.axes;
        let change_mm = worst.0.max(changes_mm.frame);
        if change_mm.is_nan() || change_mm > DIVERGED_MM {
            break;
        }
        if change_mm <= CONVERGED_MM {
            let sensitivity = |(k, gauge): (usize, &LeastSquaresGauge)| {
                let poses = context.error_maps(&state, k);
                let parameters = in_order::map(poses.len(), |i| &gauge.shares[i] * poses[i]);
                Sensitivity { poses, parameters }
            };
            let axes = context.data.iter().map(|data| data.axis);
            return Ok(Identified {
                sensitivities: gauges.iter().enumerate().map(sensitivity).collect(),
                reported: axes
                    .map(|axis| frame.reported(context.machine, axis))
                    .collect(),
                state,
                gauges,
                frame,
            });
        }
    }
    Err(Error::NotConverged {
        passes: MAX_PASSES,
        change_mm: worst.0,
        axis: context.axis(worst.1).name().to_owned(),
    })
}

/// The changes of a pass, mm.
struct Changes {
    /// The largest change of an axis, and the index of that axis.
    axes: (f64, usize),
    frame: f64,
}

/// Updates all values, one axis after the other from the bed outwards: each is seen from those before it, already
/// updated.
fn improve_all(
    context: &Context<'_>,
    gauges: &[LeastSquaresGauge],
    frame: &FrameRule,
    state: &mut State,
) -> Changes {
    let mut worst = (0.0, 0);
    for k in context.outwards() {
        let change_mm = improve(context, &gauges[k], state, k);
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
        frame: apply_frame(context, frame, state),
    }
}

/// A replay has converged when no coordinate changes by more than this, mm: a millionth of what can be measured.
const REPLAY_CONVERGED_MM: f64 = 1e-10;

impl Identified {
    /// The values for poses near the identified ones. `None` if they do not converge.
    pub(crate) fn replayed(&self, context: &Context<'_>) -> Option<State> {
        let mut state = self.state.clone();
        for _ in 0..MAX_PASSES {
            let changes_mm = improve_all(context, &self.gauges, &self.frame, &mut state);
            if changes_mm.axes.0.max(changes_mm.frame) <= REPLAY_CONVERGED_MM {
                return Some(state);
            }
        }
        None
    }
}

/// Updates the values of axis `k`; returns the largest change of a coordinate, mm (infinite if it is not a number).
fn improve(context: &Context<'_>, gauge: &LeastSquaresGauge, state: &mut State, k: usize) -> f64 {
    let (own, axis) = (&context.data[k], context.axis(k));
    let reference = axis.reference_at_home_mm(&state.axes[k].location);
    let pose_errors = context.pose_errors(state, k);
    let x = gauge.apply(&pose_errors);

    // Component errors: the weighted mean over the poses of a node, without what the gauge takes out.
    let mut curve = vec![Vector6::zeros(); own.nodes.len()];
    for ((pose, error), effect) in own.poses.iter().zip(&pose_errors).zip(&gauge.effects) {
        curve[pose.node] += (error - effect * &x) * pose.weight;
    }
    let lever_mm = lever_mm(context, own, &state.axes[k], &reference);
    let mut change_mm = 0.0_f64;
    let mut changed = |translation: Vector3<f64>, rotation: Vector3<f64>| {
        let size_mm = translation.norm() + lever_mm * rotation.norm();
        // `max` would ignore NaN.
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

    // The placements of the bodies: their twist on the stage.
    for (r, run) in own.runs.iter().enumerate() {
        let first = gauge.location_parameters + PER_RUN * r;
        let twist: Vector6<f64> = x.fixed_rows::<PER_RUN>(first).into_owned();
        let inside = context
            .errors(state)
            .chain_motion(&run.inner, &run.positions);
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
    let runs = axis.runs.iter().zip(&values.placements);
    let distances = runs.flat_map(|(run, placement)| {
        let shape_mm = context.poses.bodies[run.body].home_mm.iter();
        shape_mm.map(move |p| (placement * p - reference).norm())
    });
    distances.fold(0.0, f64::max)
}

fn defect(context: &Context<'_>, k: usize, defect: &GaugeDefect) -> Error {
    let (axis, name) = (&context.data[k], context.axis(k).name());
    let (what, hint) = match defect {
        GaugeDefect::Positions { singular_value } => (
            format!(
                "axis {name}: measured at {}, which does not tell its location errors from its component \
                 errors (relative singular value {singular_value:.1e})",
                counted(axis.nodes.len(), "position")
            ),
            "measure it at more positions, over more of its travel",
        ),
        GaugeDefect::Disjoint => {
            let runs = context.run_names(k).join(", ");
            (
                format!("axis {name}: runs {runs} share no position"),
                "measure at least two common positions in every run of an axis, or calibrate the runs one at \
                 a time",
            )
        }
    };
    trueaxis_poses::Error::not_identifiable(what, hint).into()
}
