//! Whether the targets of a run are displaced once, between two of its poses, and stay so.
//!
//! With the commanded motion `T` of the axis under test and of those outside it, without errors, the body changes from a
//! pose `P` to the next by the motion `D`:
//!
//! ```text
//! P_i = T(q_i) H_i     D_i = H_(i+1) H_i⁻¹
//! ```
//!
//! A wrong direction or unit makes all `D_i` large. An axis that jumps makes one large, and that one is a motion of the
//! axis. Targets that were remounted may be displaced in any way, but stay so where steps from before are measured again.

use nalgebra::{Isometry3, Point3};
use trueaxis_campaign::Campaign;
use trueaxis_files::round;
use trueaxis_kinematics::{AxisKind, Ideal, LocationError, MotionError, centroid};
use trueaxis_poses::{PoseObservation, Poses, step_in_words};

/// The targets of a run are displaced between two of its steps, and stay so.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "axis {axis}: its targets do not move as commanded: between {between} they are displaced by up to {displaced_mm:.0} mm, \
     and stay so; either they were moved or remounted there, or the axis jumped (encoder, drive, or positions in the \
     table); a jump of {axis} by {jump} leaves {left_mm:.0} mm of it; {conclusion}"
)]
pub struct DisplacedOnce {
    /// The axis.
    pub axis: String,
    /// The last step before it and the first one after it.
    pub between: String,
    /// Largest displacement of a target, mm.
    pub displaced_mm: f64,
    /// The jump of the axis that explains most of it, with its unit.
    pub jump: String,
    /// Largest displacement of a target that the jump leaves, mm.
    pub left_mm: f64,
    /// Which of the two explanations the data speak for, and what to do.
    pub conclusion: &'static str,
}

/// Share of the largest change below which others do not count, nor what a jump leaves of it: the datum, a best fit of
/// all targets, is off by some of the displacement, and turns with a rotary axis.
const SMALL: f64 = 0.33;

const AGAINST_TARGETS: &str = "steps from before were measured again later, where the targets are not displaced: that \
    speaks against the targets; check the positions in the table, the axis, and what touches the targets there";
const FOR_TARGETS: &str =
    "that speaks for the targets; measure the run again without touching them";
const FOR_EITHER: &str = "that fits both; reference the axis and measure a step from before again: if they are \
    displaced there, the targets were moved";

/// How the targets of a run are displaced once, by its poses; `None` if they are displaced otherwise or not at all.
///
/// # Panics
/// If the campaign has no such run, or the poses are not of its steps.
pub fn displaced_once(campaign: &Campaign, poses: &Poses, run: usize) -> Option<DisplacedOnce> {
    let (machine, under_test) = (&campaign.machine, campaign.runs[run].axis);
    let axis = &machine.axes()[under_test];
    let is_of_run = |pose: &&PoseObservation| campaign.steps[pose.step].run == Some(run);
    let mut of_run: Vec<_> = poses.observations.iter().filter(is_of_run).collect();
    // Steps are numbered as they were first measured.
    of_run.sort_by_key(|pose| pose.step);
    let change = |pair: &[&PoseObservation]| {
        let steps = [pair[0].step, pair[1].step];
        let [from, to] = steps.map(|step| &campaign.steps[step].positions);
        let [from_home, to_home] = [from, to].map(|q| machine.motion(&Ideal, under_test, q));
        let before = from_home.inverse() * pair[0].datum_from_home;
        let after = to_home.inverse() * pair[1].datum_from_home;
        let shape_mm = &poses.bodies[pair[0].body].home_mm;
        Change {
            steps,
            motion: after * before.inverse(),
            targets_mm: shape_mm.iter().map(|p| before * p).collect(),
            distance: (to[under_test] - from[under_test]).abs(),
        }
    };
    // Two sides of approach at one position are one step.
    let changes = of_run.windows(2).map(change).filter(|c| c.distance > 0.0);
    let changes: Vec<Change> = changes.collect();
    let size_mm = |c: &Change| c.displaced_mm(&c.motion);
    let by_size = |&a: &usize, &b: &usize| size_mm(&changes[a]).total_cmp(&size_mm(&changes[b]));
    let (before, rest) = changes.split_at((0..changes.len()).max_by(by_size)?);
    let (largest, after) = rest.split_first()?;
    let displaced_mm = size_mm(largest);
    // Steps are not equally long: what grows with the distance is no jump either.
    let is_small = |c: &Change| {
        let longer = largest.distance / c.distance;
        size_mm(c) * longer.max(1.0) < SMALL * displaced_mm
    };
    // A single step that is off, the first or the last, does not say that it stays so.
    let stays = !before.is_empty() && !after.is_empty();
    if !stays || !before.iter().chain(after).all(is_small) {
        return None;
    }

    let direction = axis.direction();
    let (jump, told, unit) = match axis.kind() {
        AxisKind::Linear => {
            let centre_mm = centroid(&largest.targets_mm);
            let jump_mm = (largest.motion * centre_mm - centre_mm).dot(&direction);
            (jump_mm, jump_mm, " mm")
        }
        AxisKind::Rotary => {
            let jump_rad = largest.motion.rotation.scaled_axis().dot(&direction);
            (jump_rad, jump_rad.to_degrees(), "°")
        }
    };
    let jumped = axis.motion(jump, &LocationError::default(), &MotionError::default());
    let left_mm = largest.displaced_mm(&(jumped.inverse() * largest.motion));
    let [last, first] = largest.steps;
    let later = campaign.stops().iter().map(|stop| stop.step);
    let mut later = later.skip_while(|&step| step != first);
    let conclusion = if later.any(|step| step < first && campaign.steps[step].run == Some(run)) {
        AGAINST_TARGETS
    } else if left_mm < SMALL * displaced_mm {
        FOR_EITHER
    } else {
        FOR_TARGETS
    };
    let [last, first] = [last, first].map(|step| step_in_words(campaign, step));
    Some(DisplacedOnce {
        axis: axis.name().to_owned(),
        between: format!("{last} and {first}"),
        displaced_mm,
        jump: format!("{}{unit}", round(told, 1)),
        left_mm,
        conclusion,
    })
}

/// What changes from one pose to the next.
struct Change {
    steps: [usize; 2],
    /// Seen from the base of the axis, with the axis at home.
    motion: Isometry3<f64>,
    /// The targets before it, mm.
    targets_mm: Vec<Point3<f64>>,
    /// How far the axis was commanded, mm or rad.
    distance: f64,
}

impl Change {
    /// By how much a motion displaces the targets at most, mm.
    fn displaced_mm(&self, motion: &Isometry3<f64>) -> f64 {
        let moved_mm = self.targets_mm.iter().map(|p| (motion * p - p).norm());
        moved_mm.fold(0.0, f64::max)
    }
}
