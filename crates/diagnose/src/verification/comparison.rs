//! Measured minus predicted, reading by reading, and what an effect does to each.
//!
//! | kind | prediction | direction `n` in which a displacement counts |
//! | --- | --- | --- |
//! | positioning, linear | `n·(p_errors(q) - p_ideal(q))` | that of the axis |
//! | positioning, rotary | the same, an arc length | the tangent of the circle |
//! | ball bar (paper Eq. 24) | `∣p_errors - c∣ - ∣p_ideal - c∣` | `(p_ideal - c)/∣p_ideal - c∣` |
//!
//! Displacements are from the first reading or from home: the base model has a constant for that.

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::{Verification, VerificationKind};
use trueaxis_effects::{Circumstances, Effect, Subject};
use trueaxis_kinematics::{AxisKind, Branch, GeometricErrors, Ideal, MICROMETRE, Machine};

use crate::verification::arrivals::{Arrival, are_timed, arrivals, is_same};

/// One verification against a prediction.
#[derive(Debug, Clone)]
pub(crate) struct Comparison<'a> {
    /// The machine, with the reference points of the calibration.
    pub(crate) machine: &'a Machine,
    /// What was measured.
    pub(crate) kind: &'a VerificationKind,
    /// When, where and what.
    pub(crate) arrivals: Vec<Arrival>,
    /// Measured minus predicted, µm.
    pub(crate) difference_um: Vec<f64>,
    /// Where the measured point is and in which direction its displacement counts.
    pub(crate) points: Vec<MeasuredPoint>,
    /// Whether times are those of a clock, s; otherwise they count readings.
    pub(crate) timed: bool,
    /// Axes that have more than one position in the readings.
    pub(crate) moving: Vec<usize>,
    /// Axes that stand elsewhere than they did when the measured axis was calibrated.
    pub(crate) parked_elsewhere: Vec<usize>,
}

/// The measured point at an arrival.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MeasuredPoint {
    /// Commanded position of the point, mm.
    pub(crate) point_mm: Point3<f64>,
    /// Unit vector; zero where a rotary axis does not move the point.
    pub(crate) along: Vector3<f64>,
}

impl<'a> Comparison<'a> {
    /// Of the readings with the machine that `errors` predict.
    pub(crate) fn new(
        machine: &'a Machine,
        verification: &'a Verification,
        errors: &impl GeometricErrors,
    ) -> Self {
        let kind = &verification.kind;
        let measured = match *kind {
            VerificationKind::Positioning { axis, .. } => Some(axis),
            VerificationKind::Ballbar { .. } => None,
        };
        let arrivals = arrivals(&verification.readings, measured);
        let points = arrivals
            .iter()
            .map(|a| measured_point(machine, kind, &a.positions));
        let difference = arrivals
            .iter()
            .map(|a| a.value_um - predicted_um(machine, kind, errors, &a.positions));
        let moving = (0..machine.axes().len()).filter(|&axis| {
            let at = |arrival: &Arrival| arrival.positions[axis];
            arrivals.iter().any(|a| !is_same(at(a), at(&arrivals[0])))
        });
        Self {
            machine,
            kind,
            difference_um: difference.collect(),
            points: points.collect(),
            moving: moving.collect(),
            parked_elsewhere: Vec::new(),
            timed: are_timed(&verification.readings),
            arrivals,
        }
    }

    /// What one unit of a parameter of an effect does to each reading, µm.
    pub(crate) fn column(
        &self,
        effect: &Effect,
        subject: &Subject,
        parameter: usize,
        shape: f64,
    ) -> Vec<f64> {
        let rows = self.arrivals.iter().zip(&self.points);
        rows.map(|(arrival, point)| {
            // An effect of an axis sees the motion of this axis, whatever else moves.
            let axis = subject.axis.unwrap_or_else(|| self.axis());
            let at = Circumstances {
                time_s: arrival.time_s,
                elapsed_s: arrival.elapsed_s,
                progress: arrival.progress,
                turn_progress: arrival.progress,
                turn_elapsed_s: arrival.elapsed_s,
                carrier: Some(carrier(self.machine, self.kind)),
                axis,
                direction: arrival.sides[axis],
                speed_per_s: arrival.speeds_per_s[axis],
                positions: &arrival.positions,
                point_mm: point.point_mm,
                centroid_mm: point.point_mm,
                ..Circumstances::new(self.machine)
            };
            let displaced = effect.form(subject, parameter, shape, &at);
            displaced.along(&point.along) / MICROMETRE
        })
        .collect()
    }

    /// The axis measured, or the outermost one that moves the ball.
    pub(crate) fn axis(&self) -> usize {
        match *self.kind {
            VerificationKind::Positioning { axis, .. } => axis,
            VerificationKind::Ballbar { ball_carrier, .. } => ball_carrier,
        }
    }

    /// The cycles in order.
    pub(crate) fn cycles(&self) -> Vec<u32> {
        let mut cycles: Vec<u32> = self.arrivals.iter().map(|a| a.cycle).collect();
        cycles.sort_unstable();
        cycles.dedup();
        cycles
    }
}

/// The outermost axis that moves the measured point. The reflector of a positioning line is where the
/// tool or the workpiece is, so it moves with every axis of the branch of the measured one.
pub(crate) fn carrier(machine: &Machine, kind: &VerificationKind) -> usize {
    match *kind {
        VerificationKind::Positioning { axis, .. } => {
            let branches = [Branch::Tool, Branch::Workpiece].map(|b| machine.branch(b));
            let own = branches.into_iter().find(|branch| branch.contains(&axis));
            own.and_then(|branch| branch.last().copied())
                .unwrap_or(axis)
        }
        VerificationKind::Ballbar { ball_carrier, .. } => ball_carrier,
    }
}

/// Point and direction from commanded positions.
fn measured_point(machine: &Machine, kind: &VerificationKind, positions: &[f64]) -> MeasuredPoint {
    match *kind {
        VerificationKind::Positioning { axis, target_mm } => {
            let point_mm = machine.position(&Ideal, carrier(machine, kind), positions, target_mm);
            let chain = machine.chain(axis);
            let before = machine.chain_motion(&Ideal, &chain[..chain.len() - 1], positions);
            let content = &machine.axes()[axis];
            let direction = before.rotation * content.direction().into_inner();
            let along = match content.kind() {
                AxisKind::Linear => direction,
                AxisKind::Rotary => {
                    let on_axis = before * content.reference_mm();
                    let tangent = direction.cross(&(point_mm - on_axis));
                    tangent.try_normalize(MICROMETRE).unwrap_or_default()
                }
            };
            MeasuredPoint { point_mm, along }
        }
        VerificationKind::Ballbar {
            ball_mm,
            ball_carrier,
            center_mm,
        } => {
            let point_mm = machine.position(&Ideal, ball_carrier, positions, ball_mm);
            let bar = point_mm - center_mm;
            let along = bar.try_normalize(MICROMETRE).unwrap_or_default();
            MeasuredPoint { point_mm, along }
        }
    }
}

/// The reading that a machine with `errors` gives, µm.
pub(crate) fn predicted_um(
    machine: &Machine,
    kind: &VerificationKind,
    errors: &impl GeometricErrors,
    positions: &[f64],
) -> f64 {
    let MeasuredPoint { point_mm, along } = measured_point(machine, kind, positions);
    let mm = match *kind {
        VerificationKind::Positioning { target_mm, .. } => {
            let actual = machine.position(errors, carrier(machine, kind), positions, target_mm);
            along.dot(&(actual - point_mm))
        }
        VerificationKind::Ballbar {
            ball_mm,
            ball_carrier,
            center_mm,
        } => {
            let actual = machine.position(errors, ball_carrier, positions, ball_mm);
            (actual - center_mm).norm() - (point_mm - center_mm).norm()
        }
    };
    mm / MICROMETRE
}
