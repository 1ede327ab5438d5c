//! Measured minus predicted, as in `verify` ([`CalibratedMachine::predicted_reading_um`]), reading by reading, and
//! the change of each by an effect.

use std::collections::BTreeMap;

use trueaxis_campaign::{Direction, Verification, VerificationKind};
use trueaxis_effects::{CROSS_COUPLING, Circumstances, GivenEffect, Shape, Subject};
use trueaxis_kinematics::{Axis, AxisKind, Component, Ideal, MICROMETRE, Machine};
use trueaxis_predict::{
    CalibratedMachine, MeasuredPoint, carrier, predicted_reading_um, stands_alike,
};
use trueaxis_selection::Hypothesis;

use crate::engine::waves_of;
use crate::numbers::extremes;
use crate::verification::arrivals::{Arrival, are_timed, arrivals, groups_in_order, is_same};
use crate::verification::not_at_rest::{Running, running};
use crate::verification::resolution::Digit;
use crate::verification::whitening::lags;

/// A change of a reading for a unit of a parameter below which it counts as none, µm.
const ROUNDING_UM: f64 = 1e-9;

/// One verification against a prediction.
#[derive(Debug, Clone)]
pub(crate) struct Comparison<'a> {
    /// The machine, with the reference points of the calibration.
    pub(crate) machine: &'a Machine,
    /// The name of the verification.
    pub(crate) name: &'a str,
    /// What was measured.
    pub(crate) kind: &'a VerificationKind,
    /// The readings as arrivals: when, where and how much.
    pub(crate) arrivals: Vec<Arrival>,
    /// For each arrival the time since the previous one, in units of the usual time.
    pub(crate) lags: Vec<f64>,
    /// The last digit of the readings; `None` if all arrivals are equal.
    pub(crate) digit: Option<Digit>,
    /// Whether its axis was read before it came to rest.
    pub(crate) running: Option<Running>,
    /// Measured minus predicted, µm.
    pub(crate) difference_um: Vec<f64>,
    /// Position of the measured point, and the direction in which its displacement counts.
    pub(crate) points: Vec<MeasuredPoint>,
    /// Whether times are those of a clock, s; otherwise they count readings.
    pub(crate) timed: bool,
    /// For each reading the index of its pass: consecutive readings of one cycle in one direction.
    pub(crate) passes: Vec<usize>,
    /// For a ball bar its angle, rad, -π to π.
    pub(crate) around: Vec<f64>,
    /// First and last position of [`Comparison::axis`], mm or rad.
    pub(crate) range: [f64; 2],
    /// Axes with more than one position in the readings.
    pub(crate) moving: Vec<usize>,
    /// Axes that stand elsewhere than when the measured axis was calibrated.
    pub(crate) parked_elsewhere: Vec<usize>,
    /// For each calibrated axis the positions of all axes, whose effects there are in its curves, mm or rad (home where
    /// it is not known); a missing one was measured with the others at home, or not at all.
    calibrated_at: BTreeMap<usize, Vec<f64>>,
    /// Couplings subtracted from the measurements, so that no curve contains them.
    taken_out: Vec<GivenEffect>,
}

impl<'a> Comparison<'a> {
    /// Of the readings with the prediction of a calibration, or of an ideal machine.
    pub(crate) fn new(
        machine: &'a Machine,
        verification: &'a Verification,
        calibration: Option<&CalibratedMachine>,
    ) -> Self {
        let kind = &verification.kind;
        let arrivals = arrivals(&verification.readings, line(kind));
        let points = arrivals
            .iter()
            .map(|a| MeasuredPoint::new(machine, kind, &a.positions));
        let points: Vec<MeasuredPoint> = points.collect();
        let predicted_um = |a: &Arrival| match calibration {
            Some(calibration) => calibration.predicted_reading_um(kind, &a.positions, came_from(a)),
            None => predicted_reading_um(machine, kind, &Ideal, &a.positions, &a.positions),
        };
        let difference = arrivals.iter().map(|a| a.value_um - predicted_um(a));
        let moving = (0..machine.axes().len()).filter(|&axis| {
            let at = |arrival: &Arrival| arrival.positions[axis];
            arrivals.iter().any(|a| !is_same(at(a), at(&arrivals[0])))
        });
        let passes = groups_in_order(&arrivals, Arrival::is_of_pass);
        let timed = are_timed(&verification.readings);
        let taken_out = calibration.map_or(&[][..], |own| &own.effects_taken_out);
        let taken_out = taken_out
            .iter()
            .filter(|own| own.effect == CROSS_COUPLING.id);
        let mut comparison = Self {
            machine,
            name: &verification.name,
            kind,
            passes,
            range: [0.0; 2],
            difference_um: difference.collect(),
            around: around(&points),
            points,
            moving: moving.collect(),
            parked_elsewhere: Vec::new(),
            calibrated_at: calibration.map_or_else(BTreeMap::new, calibrated_at),
            taken_out: taken_out.cloned().collect(),
            timed,
            lags: lags(&arrivals, timed),
            digit: digit(verification, &arrivals),
            running: line(kind).and_then(|_| running(&verification.readings, &arrivals)),
            arrivals,
        };
        let axis = comparison.axis();
        comparison.range = extremes(comparison.arrivals.iter().map(|a| a.positions[axis]));
        if let (Some(axis), Some(calibration)) = (comparison.line(), calibration) {
            comparison.parked_elsewhere = comparison.parked_elsewhere(axis, calibration);
        }
        comparison
    }

    /// Axes that at all readings of a line stand elsewhere than where its axis was calibrated.
    fn parked_elsewhere(&self, axis: usize, calibration: &CalibratedMachine) -> Vec<usize> {
        let name = self.machine.axes()[axis].name();
        if calibration.unmeasured().contains(&name) {
            return Vec::new();
        }
        let calibrated = self.calibrated_at.get(&axis);
        let is_elsewhere = |other: &usize| {
            let kind = self.machine.axes()[*other].kind();
            let is_off = |from: f64| {
                let mut read = self.arrivals.iter().map(|a| a.positions[*other]);
                read.all(|q| !stands_alike(kind, q, from))
            };
            let calibrated = calibrated.map_or(0.0, |positions| positions[*other]);
            // What was subtracted counts from home.
            *other != axis && (is_off(calibrated) || !self.taken_out.is_empty() && is_off(0.0))
        };
        let others = 0..self.machine.axes().len();
        others.filter(is_elsewhere).collect()
    }

    /// Change of each reading by one unit of a parameter of an effect, µm; for a coupling less its part in the curves
    /// of both axes, `q_A q_B - q_A b - a q_B` where A was calibrated with B at b, and B with A at a.
    pub(crate) fn column(&self, of: &Hypothesis, parameter: usize, shape: f64) -> Vec<f64> {
        let rows = self.arrivals.iter().zip(&self.points);
        rows.map(|(arrival, point)| {
            // An effect of an axis depends on the motion of this axis, whatever else moves.
            let axis = of.subject.axis.unwrap_or_else(|| self.axis());
            // An instant may divide the readings of a stop.
            let (time_s, part) = match of.effect.shape {
                Shape::Instant => (f64::INFINITY, arrival.part_after(shape)),
                _ => (arrival.time_s, 1.0),
            };
            let at = Circumstances {
                time_s,
                elapsed_s: arrival.elapsed_s,
                progress: arrival.progress,
                occupation_progress: arrival.progress,
                occupation_elapsed_s: arrival.elapsed_s,
                carrier: Some(carrier(self.machine, self.kind)),
                axis,
                direction: arrival.sides[axis],
                speed_per_s: arrival.speeds_per_s[axis],
                positions: &arrival.positions,
                point_mm: point.point_mm,
                centroid_mm: point.point_mm,
                ..Circumstances::new(self.machine)
            };
            let change_mm =
                |at: &Circumstances<'_>| of.form(parameter, shape, at).along(&point.along);
            let mut all_mm = change_mm(&at);
            for axis in self.coupled(of) {
                let calibrated = self.calibrated_at.get(&axis);
                let Some(calibrated) = calibrated.filter(|_| at.is_carried_by(axis)) else {
                    continue;
                };
                let mut positions = calibrated.clone();
                positions[axis] = arrival.positions[axis];
                let in_curve = Circumstances {
                    positions: &positions,
                    ..at
                };
                all_mm -= change_mm(&in_curve);
            }
            let change_um = part * all_mm / MICROMETRE;
            // A displacement across the line of sight would be a column of rounding errors.
            if change_um.abs() < ROUNDING_UM {
                0.0
            } else {
                change_um
            }
        })
        .collect()
    }

    /// The two axes of a coupling whose curves contain it; none if it was subtracted.
    fn coupled(&self, of: &Hypothesis) -> impl Iterator<Item = usize> + use<> {
        let mut taken_out = self.taken_out.iter();
        let is_in_curves =
            of.effect == CROSS_COUPLING && !taken_out.any(|own| self.is_of(own, &of.subject));
        let axes = [of.subject.axis, of.subject.other_axis];
        axes.into_iter().flatten().filter(move |_| is_in_curves)
    }

    /// Whether a coupling given by names is that of a subject.
    fn is_of(&self, given: &GivenEffect, subject: &Subject) -> bool {
        let name = |axis: Option<usize>| axis.map(|axis| self.machine.axes()[axis].name());
        let component = subject.component.zip(name(subject.axis));
        let component = component.map(|(component, axis)| component.name(axis));
        let own = &given.subject;
        own.axis.as_deref() == name(subject.axis)
            && own.other_axis.as_deref() == name(subject.other_axis)
            && own.component == component
    }

    /// The axis of a line; `None` for a ball bar.
    pub(crate) fn line(&self) -> Option<usize> {
        line(self.kind)
    }

    /// Whether it is a line of a rotary axis.
    pub(crate) fn is_of_rotary_axis(&self) -> bool {
        let kind = |axis: usize| self.machine.axes()[axis].kind();
        self.line()
            .is_some_and(|axis| kind(axis) == AxisKind::Rotary)
    }

    /// The axis measured, or the outermost one that moves the ball.
    pub(crate) fn axis(&self) -> usize {
        match *self.kind {
            VerificationKind::Positioning { axis, .. } => axis,
            VerificationKind::Ballbar { ball_carrier, .. } => ball_carrier,
        }
    }

    /// Position of an arrival in that range, 0 to 1.
    pub(crate) fn travelled(&self, arrival: &Arrival) -> f64 {
        let [low, high] = self.range;
        (arrival.positions[self.axis()] - low) / (high - low).max(f64::MIN_POSITIVE)
    }

    /// Commanded positions of an axis, each once, ascending.
    pub(crate) fn positions(&self, axis: usize) -> Vec<f64> {
        let mut positions: Vec<f64> = self.arrivals.iter().map(|a| a.positions[axis]).collect();
        positions.sort_by(f64::total_cmp);
        positions.dedup();
        positions
    }

    /// Half waves of the position of that axis over the range of its positions, from one on, in each group.
    pub(crate) fn waves_of_position(&self, count: usize, groups: Vec<usize>) -> Vec<Vec<f64>> {
        let at = self.arrivals.iter().map(|a| self.travelled(a));
        waves_of(groups.into_iter().zip(at).map(Some), false, count)
    }

    /// Whether a line was read at one position after the other, at each of them once for all: then nothing separates
    /// position from time.
    pub(crate) fn is_position_after_position(&self) -> bool {
        let Some(axis) = self.line() else {
            return false;
        };
        let at = |arrival: &Arrival| arrival.positions[axis];
        let stays = self.arrivals.chunk_by(|a, b| is_same(at(a), at(b)));
        stays.count() == self.positions(axis).len()
    }

    /// Standard uncertainty of an arrival from the last digit of its readings, µm. `None` if all are equal.
    pub(crate) fn resolution_um(&self) -> Option<f64> {
        self.digit.map(|digit| digit.of_stop_um())
    }

    /// The unit of a count: without a clock times count readings.
    pub(crate) fn unit_of(&self, unit: &'static str) -> &'static str {
        match unit {
            "s" if !self.timed => "readings",
            "ms" if !self.timed => "readings/1000",
            _ => unit,
        }
    }
}

/// The last digit of readings; `None` if all arrivals are equal.
fn digit(verification: &Verification, arrivals: &[Arrival]) -> Option<Digit> {
    let [low, high] = extremes(arrivals.iter().map(|a| a.value_um));
    let values_um = verification.readings.iter().map(|r| r.value_um);
    let values_um: Vec<f64> = values_um.collect();
    let mut rest = values_um.as_slice();
    let stop = |arrival: &Arrival| rest.split_off(..arrival.readings);
    let stops: Vec<&[f64]> = arrivals.iter().filter_map(stop).collect();
    (high > low).then(|| Digit::new(&stops)).flatten()
}

/// Positions of the axes while each one was calibrated; home where an axis stood at several positions.
fn calibrated_at(calibration: &CalibratedMachine) -> BTreeMap<usize, Vec<f64>> {
    let all = calibration.parked.iter().map(|(&axis, parked)| {
        let positions = parked.iter().map(|position| position.unwrap_or(0.0));
        (axis, positions.collect())
    });
    all.collect()
}

/// The error of an axis along or about itself.
pub(crate) fn along_itself(axis: &Axis) -> Component {
    match axis.kind() {
        AxisKind::Linear => Component::ALL[axis.principal()],
        AxisKind::Rotary => Component::ALL[axis.principal() + 3],
    }
}

/// The side that the measured axis of a line came from.
pub(crate) fn came_from(arrival: &Arrival) -> Direction {
    match arrival.direction > 0.0 {
        true => Direction::Forward,
        false => Direction::Backward,
    }
}

/// The axis of a line; `None` for a ball bar.
pub(crate) fn line(kind: &VerificationKind) -> Option<usize> {
    match *kind {
        VerificationKind::Positioning { axis, .. } => Some(axis),
        VerificationKind::Ballbar { .. } => None,
    }
}

/// Angle of the bar in the plane of its first directions; for a ball on an axis of rotation whose centre lies on the
/// axis, that of the axis.
fn around(points: &[MeasuredPoint]) -> Vec<f64> {
    let first = points.first().map(|p| p.along).unwrap_or_default();
    let across = points.iter().map(|p| p.along - first * first.dot(&p.along));
    let second = across
        .max_by(|a, b| a.norm().total_cmp(&b.norm()))
        .unwrap_or_default();
    let second = second.try_normalize(f64::EPSILON).unwrap_or_default();
    let angle = |along: nalgebra::Vector3<f64>| along.dot(&second).atan2(along.dot(&first));
    points.iter().map(|p| angle(p.along)).collect()
}
