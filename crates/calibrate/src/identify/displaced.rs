//! Whether the targets of a run are displaced once, between two of its poses, and stay so.
//!
//! With the axes outside the one under test (`B`) and its commanded motion (`T`), both without errors, the body changes
//! from a pose `P` to the next by the motion `D`:
//!
//! ```text
//! B⁻¹ P_i = T(q_i) H_i     D_i = H_(i+1) H_i⁻¹
//! ```
//!
//! A wrong direction or unit makes all `D_i` large. An axis that jumps makes one large, and that one is a motion of the
//! axis. Targets that were remounted may be displaced in any way, but stay so where steps from before are measured again.

use nalgebra::{Isometry3, Point3};
use trueaxis_campaign::Campaign;
use trueaxis_files::round;
use trueaxis_kinematics::{AxisKind, Ideal, LocationError, MotionError, centroid};
use trueaxis_poses::step_in_words;

use crate::Error;
use crate::identify::axis_data::AxisPose;
use crate::identify::context::Context;

/// Share of the largest change below which others do not count, nor what a jump leaves of it: the datum, a best fit of
/// all targets, is off by some of the displacement, and turns with a rotary axis.
const SMALL: f64 = 0.33;

const AGAINST_TARGETS: &str = "steps from before were measured again later, where the targets are not displaced: that \
    speaks against the targets; check the positions in the table, the axis, and what touches the targets there";
const FOR_TARGETS: &str =
    "that speaks for the targets; measure the run again without touching them";
const FOR_EITHER: &str = "that fits both; reference the axis and measure a step from before again: if they are \
    displaced there, the targets were moved";

/// The error of a run (by its place) of the axis `data[k]` whose targets are displaced once; `None` for any other.
pub(crate) fn displaced_once<'a>(context: &Context<'a>, k: usize, run: usize) -> Option<Error> {
    let (data, axis) = (&context.data[k], context.axis(k));
    let own = &data.runs[run];
    let base = context
        .machine
        .chain_motion(&Ideal, &own.outer, &own.positions);
    let commanded = |q| axis.motion(q, &LocationError::default(), &MotionError::default());
    let position = |pose: &AxisPose| data.nodes[pose.node].position;
    let at_home = |pose: &AxisPose| {
        (base * commanded(position(pose))).inverse() * context.measured[pose.index]
    };
    let shape_mm = &context.poses.bodies[own.body].home_mm;
    let step = |pose: &AxisPose| context.poses.observations[pose.index].step;
    let measured = measured_steps(context.campaign);
    let first = |pose: &&AxisPose| measured.iter().position(|&other| other == step(pose));
    let mut poses: Vec<&'a AxisPose> = data.poses.iter().filter(|pose| pose.run == run).collect();
    poses.sort_by_key(first);
    let change = |pair: &[&'a AxisPose]| {
        let before = at_home(pair[0]);
        Change {
            poses: [pair[0], pair[1]],
            motion: at_home(pair[1]) * before.inverse(),
            targets_mm: shape_mm.iter().map(|p| before * p).collect(),
            distance: (position(pair[1]) - position(pair[0])).abs(),
        }
    };
    // Two sides of approach at one position are one step.
    let changes = poses.windows(2).map(change).filter(|c| c.distance > 0.0);
    let changes: Vec<Change<'_>> = changes.collect();
    let sizes_mm: Vec<f64> = changes.iter().map(|c| c.size_mm(&c.motion)).collect();
    let largest = (0..changes.len()).max_by(|&a, &b| sizes_mm[a].total_cmp(&sizes_mm[b]))?;
    // Steps are not equally long: what grows with the distance is no jump either.
    let is_small = |i: usize| {
        let longer = changes[largest].distance / changes[i].distance;
        sizes_mm[i] * longer.max(1.0) < SMALL * sizes_mm[largest]
    };
    let mut others = (0..changes.len()).filter(|&i| i != largest);
    // A single step that is off, the first or the last, does not say that it stays so.
    let is_inside = largest > 0 && largest + 1 < changes.len();
    if !is_inside || !others.all(is_small) {
        return None;
    }

    let change = &changes[largest];
    let direction = axis.direction();
    let (jump, told) = match axis.kind() {
        AxisKind::Linear => {
            let centre_mm = centroid(&change.targets_mm);
            let jump_mm = (change.motion * centre_mm - centre_mm).dot(&direction);
            (jump_mm, format!("{} mm", round(jump_mm, 1)))
        }
        AxisKind::Rotary => {
            let jump_rad = change.motion.rotation.scaled_axis().dot(&direction);
            (jump_rad, format!("{}°", round(jump_rad.to_degrees(), 1)))
        }
    };
    let left_mm = change.size_mm(&(commanded(jump).inverse() * change.motion));
    let [before, after] = change.poses.map(step);
    let undisplaced = poses.iter().map(|pose| step(pose));
    let undisplaced: Vec<usize> = undisplaced.take_while(|&other| other != after).collect();
    let mut later = measured.iter().skip_while(|&&other| other != after);
    let conclusion = if later.any(|other| undisplaced.contains(other)) {
        AGAINST_TARGETS
    } else if left_mm < SMALL * sizes_mm[largest] {
        FOR_EITHER
    } else {
        FOR_TARGETS
    };
    let [before, after] = [before, after].map(|step| step_in_words(context.campaign, step));
    Some(Error::DisplacedOnce {
        axis: axis.name().to_owned(),
        between: format!("{before} and {after}"),
        displaced_mm: sizes_mm[largest],
        jump: told,
        left_mm,
        conclusion,
    })
}

/// The step of each stop, in measuring order.
fn measured_steps(campaign: &Campaign) -> Vec<usize> {
    let lengths = campaign.lengths.as_ref().map(|lengths| &lengths.stops);
    let points = campaign.points.as_ref().map(|points| &points.stops);
    let stops = lengths.or(points).into_iter().flatten();
    stops.map(|stop| stop.step).collect()
}

/// What changes from one pose to the next.
struct Change<'a> {
    poses: [&'a AxisPose; 2],
    /// Seen from the base of the axis, with the axis at home.
    motion: Isometry3<f64>,
    /// The targets before it, mm.
    targets_mm: Vec<Point3<f64>>,
    /// How far the axis was commanded, mm or rad.
    distance: f64,
}

impl Change<'_> {
    /// By how much a motion displaces the targets at most, mm.
    fn size_mm(&self, motion: &Isometry3<f64>) -> f64 {
        let moved_mm = self.targets_mm.iter().map(|p| (motion * p - p).norm());
        moved_mm.fold(0.0, f64::max)
    }
}
