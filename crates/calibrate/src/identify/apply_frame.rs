//! The reference frame of each pass, by the rule.

use nalgebra::{DMatrix, Point3, Translation3, Vector3};
use trueaxis_kinematics::{AxisKind, SmallMotion};

use crate::identify::context::Context;
use crate::identify::frame::{Anchor, FrameRule};
use crate::identify::state::State;

/// Moves the reference frame and the axial positions of rotary axes to fulfil the rule; returns the largest change,
/// mm.
pub(crate) fn apply_frame(context: &Context<'_>, frame: &FrameRule, next: &mut State) -> f64 {
    let tilts = frame.lines.iter().map(|&k| next.axes[k].location.tilt_rad);
    let tilts: Vec<Vector3<f64>> = tilts.collect();
    let homes_mm = home_positions(context, next);
    let shift = |anchor: &Anchor| {
        let target = context.data[anchor.data].runs[anchor.run].targets[anchor.place];
        let home_mm = homes_mm[anchor.data][anchor.run][anchor.place];
        home_mm - context.campaign.targets[target].home_mm
    };
    let shifts: Vec<Vector3<f64>> = frame.anchors.iter().map(shift).collect();
    let motion = frame.motion(&tilts, &shifts);
    take_out(context, &motion, next);
    let pivots = context.poses.observations.iter().map(|pose| pose.pivot_mm);
    let distances = pivots.map(|p| (p - motion.pivot).norm());
    let size_mm = distances.fold(0.0, f64::max);
    let mut change_mm = motion.translation.norm() + motion.rotation.norm() * size_mm;

    let along = |k: usize| context.axis(k).direction().into_inner();
    let shifts = (0..context.data.len()).map(|k| match frame.is_placed(k) {
        true => mean_axial_shift(context, next, k, along(k)),
        false => 0.0,
    });
    let places = frame.axial_places(&DMatrix::from_iterator(context.data.len(), 1, shifts));
    for (k, (values, &place_mm)) in next.axes.iter_mut().zip(&places).enumerate() {
        values.location.offset_mm += along(k) * place_mm;
        let back = Translation3::from(-along(k) * place_mm);
        for placement in &mut values.placements {
            *placement = back * *placement;
        }
        change_mm = change_mm.max(place_mm.abs());
    }
    change_mm
}

/// Home positions of the targets of each run of each axis, in the reference frame, mm.
fn home_positions(context: &Context<'_>, state: &State) -> Vec<Vec<Vec<Point3<f64>>>> {
    let errors = context.errors(state);
    let of_axis = |k: usize| {
        let runs = 0..context.data[k].runs.len();
        runs.map(|r| errors.targets_mm(k, r)).collect()
    };
    (0..context.data.len()).map(of_axis).collect()
}

/// Takes a motion of the whole out of the frame and of the values found in it, to first order; the next pass corrects
/// the rest.
fn take_out(context: &Context<'_>, motion: &SmallMotion, next: &mut State) {
    let removal = motion.removal();
    next.ref_from_datum = removal * next.ref_from_datum;
    for (k, values) in next.axes.iter_mut().enumerate() {
        let axis = context.axis(k);
        let along = axis.direction().into_inner();
        let across = |v: Vector3<f64>| v - along * along.dot(&v);
        values.location.tilt_rad -= across(motion.rotation);
        if axis.kind() == AxisKind::Rotary {
            let reference = axis.reference_mm();
            values.location.offset_mm += across(removal * reference - reference);
        }
        for placement in &mut values.placements {
            *placement = removal * *placement;
        }
    }
}

/// The mean shift of the targets of a rotary axis from nominal, along the axis.
fn mean_axial_shift(context: &Context<'_>, state: &State, k: usize, along: Vector3<f64>) -> f64 {
    let (errors, targets) = (context.errors(state), &context.campaign.targets);
    let mut shifts = Vec::new();
    for (r, run) in context.data[k].runs.iter().enumerate() {
        let nominal = run.targets.iter().map(|&t| targets[t].home_mm);
        let found = errors.targets_mm(k, r).into_iter().zip(nominal);
        shifts.extend(found.map(|(p, home)| (p - home).dot(&along)));
    }
    shifts.iter().sum::<f64>() / shifts.len().max(1) as f64
}

/// Mean position of each target over the runs that measured it, in the reference frame at home.
pub(crate) fn mean_targets(context: &Context<'_>, state: &State) -> Vec<Option<Point3<f64>>> {
    let mut sums = vec![(Vector3::zeros(), 0.0); context.campaign.targets.len()];
    let runs = context.data.iter().flat_map(|axis| &axis.runs);
    for (run, positions) in runs.zip(home_positions(context, state).iter().flatten()) {
        for (&target, position) in run.targets.iter().zip(positions) {
            sums[target].0 += position.coords;
            sums[target].1 += 1.0;
        }
    }
    let mean = |(sum, n)| (n > 0.0).then(|| Point3::from(sum / n));
    sums.into_iter().map(mean).collect()
}
