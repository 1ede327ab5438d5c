//! What a laser interferometer or a ball bar reads on a machine with errors, and how well that and displacements of the tool are known.
//!
//! | kind | reading | direction `n` in which a displacement counts |
//! | --- | --- | --- |
//! | positioning, linear | `n·(p_errors(q) - p_ideal(q))` | that of the axis |
//! | positioning, rotary | the same, an arc length | the tangent of the circle |
//! | ball bar (paper Eq. 24) | `∣p_errors - c∣ - ∣p_ideal - c∣` | `(p_ideal - c)/∣p_ideal - c∣` |
//!
//! Displacements are from home: where an instrument has its zero, and where the centre of a bar is, is not the machine's.

use nalgebra::{DMatrix, Matrix6xX, Point3, RowDVector, RowVector3, Vector3, Vector6};
use trueaxis_campaign::{Direction, VerificationKind};
use trueaxis_kinematics::axis_twist::TRANSLATION;
use trueaxis_kinematics::{AxisKind, Branch, GeometricErrors, Ideal, MICROMETRE, Machine, Twist};

use crate::approach::Approach;
use crate::calibrated_machine::{CalibratedAxis, CalibratedMachine};
use crate::curve::Gap;
use crate::predict::influences;

/// Positions of an axis this close are one, mm or rad.
const SAME: f64 = 1e-9;

/// Parts of a unit vector that only rounding makes: the bar lies in a plane.
const ROUNDING: f64 = 1e-9;

/// What the set-up of a ball bar makes of its readings, one for each direction of the bar: columns of the offset of its
/// centre, as far as the directions see it, and of its length.
pub fn ball_bar_set_up(along: &[Vector3<f64>]) -> Vec<Vec<f64>> {
    let centre = (0..3).map(|c| along.iter().map(|along| along[c]).collect());
    let is_seen = |column: &Vec<f64>| column.iter().any(|x| x.abs() > ROUNDING);
    let length = vec![1.0; along.len()];
    centre.filter(is_seen).chain([length]).collect()
}

/// For each reading of the positioning of `axis` the number of its line, from 0 in the order in which the lines begin: readings
/// with the other axes at the same positions (mm or rad) are on one line, for which the instrument is set to zero.
pub fn positioning_lines<'a>(axis: usize, all: impl IntoIterator<Item = &'a [f64]>) -> Vec<usize> {
    let mut first: Vec<&[f64]> = Vec::new();
    let mut number = |positions: &'a [f64]| {
        let is_known = |line: &&[f64]| {
            let mut pairs = line.iter().zip(positions).enumerate();
            pairs.all(|(i, (a, b))| i == axis || (a - b).abs() <= SAME)
        };
        first.iter().position(is_known).unwrap_or_else(|| {
            first.push(positions);
            first.len() - 1
        })
    };
    all.into_iter().map(&mut number).collect()
}

/// The measured point at commanded positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredPoint {
    /// Commanded position of the point, mm.
    pub point_mm: Point3<f64>,
    /// Unit vector in which a displacement counts; zero where a rotary axis does not move the point.
    pub along: Vector3<f64>,
}

impl MeasuredPoint {
    /// Of a verification at commanded positions of all axes, mm or rad.
    pub fn new(machine: &Machine, kind: &VerificationKind, positions: &[f64]) -> Self {
        match *kind {
            VerificationKind::Positioning { axis, target_mm } => {
                let point_mm =
                    machine.position(&Ideal, carrier(machine, kind), positions, target_mm);
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
                Self { point_mm, along }
            }
            VerificationKind::Ballbar {
                ball_mm,
                ball_carrier,
                center_mm,
                ..
            } => {
                let point_mm = machine.position(&Ideal, ball_carrier, positions, ball_mm);
                let bar = point_mm - center_mm;
                let along = bar.try_normalize(MICROMETRE).unwrap_or_default();
                Self { point_mm, along }
            }
        }
    }
}

/// The outermost axis that moves the measured point. The reflector of a positioning line is where the
/// tool or the workpiece is, so it moves with every axis of the branch of the measured one.
pub fn carrier(machine: &Machine, kind: &VerificationKind) -> usize {
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

/// The point that is measured, at home in the reference frame, mm.
pub fn measured_home_mm(kind: &VerificationKind) -> Point3<f64> {
    match *kind {
        VerificationKind::Positioning { target_mm, .. } => target_mm,
        VerificationKind::Ballbar { ball_mm, .. } => ball_mm,
    }
}

/// The reading of a machine with `errors` that is meant to be at `commanded` and is sent to `positions` (the same
/// without compensation), µm.
pub fn predicted_reading_um(
    machine: &Machine,
    kind: &VerificationKind,
    errors: &impl GeometricErrors,
    commanded: &[f64],
    positions: &[f64],
) -> f64 {
    let MeasuredPoint { point_mm, along } = MeasuredPoint::new(machine, kind, commanded);
    let home_mm = measured_home_mm(kind);
    let actual = machine.position(errors, carrier(machine, kind), positions, home_mm);
    let mm = match *kind {
        VerificationKind::Positioning { .. } => along.dot(&(actual - point_mm)),
        VerificationKind::Ballbar { center_mm, .. } => {
            (actual - center_mm).norm() - (point_mm - center_mm).norm()
        }
    };
    mm / MICROMETRE
}

impl CalibratedMachine {
    /// What is read on this machine at commanded positions without compensation, µm: on a line whose axis comes from one side, with
    /// the error curve of that side, where the sides are apart.
    pub fn predicted_reading_um(
        &self,
        kind: &VerificationKind,
        commanded: &[f64],
        from: Direction,
    ) -> f64 {
        let machine = &self.machine;
        match *kind {
            VerificationKind::Positioning { axis, .. } => {
                let approach = Approach {
                    machine: self,
                    axis,
                    direction: from,
                };
                predicted_reading_um(machine, kind, &approach, commanded, commanded)
            }
            VerificationKind::Ballbar { .. } => {
                predicted_reading_um(machine, kind, self, commanded, commanded)
            }
        }
    }

    /// The covariance of the readings that [`CalibratedMachine::predicted_reading_um`] predicts, each of a kind, at commanded positions
    /// and with the side that its axis comes from, from that of the calibration and of the interpolation, µm²: to first order by the
    /// displacement of the point along the direction that counts. NaN if the calibration has no uncertainties.
    pub fn covariance_of_readings(
        &self,
        readings: &[(&VerificationKind, &[f64], Direction)],
    ) -> DMatrix<f64> {
        let rows = readings.iter();
        let rows = rows.map(|(kind, at, from)| self.row(kind, at, *from));
        self.covariance_of_rows(&rows.collect::<Vec<_>>())
    }

    /// The same for the displacements of the tool that [`CalibratedMachine::predict`] gives, each at commanded positions, for the
    /// tool point that is at the second place at home: x, y and z of the first, of the second and so on.
    pub fn covariance_of_displacements(&self, places: &[(&[f64], Point3<f64>)]) -> DMatrix<f64> {
        let rows = places.iter().flat_map(|&(positions, tool_home_mm)| {
            let effects = self.effects(positions, tool_home_mm);
            [0, 1, 2].map(|c| {
                let counts =
                    |(axis, effect): &(_, Matrix6xX<f64>)| (*axis, effect.row(c).into_owned());
                self.row_of(effects.iter().map(counts), positions, None)
            })
        });
        self.covariance_of_rows(&rows.collect::<Vec<_>>())
    }

    fn covariance_of_rows(&self, rows: &[Row]) -> DMatrix<f64> {
        if !self.has_uncertainties {
            return DMatrix::from_element(rows.len(), rows.len(), f64::NAN);
        }
        let mut shared = DMatrix::zeros(rows.len(), self.factors.shared.nrows());
        for (i, row) in rows.iter().enumerate() {
            for &(place, coefficient) in &row.results {
                for (column, x) in self.factors.sensitivities.row(place) {
                    shared[(i, column)] += coefficient * x;
                }
            }
        }
        let mut covariance = &shared * &self.factors.shared * shared.transpose();
        let steps: Vec<Vec<_>> = rows.iter().map(|row| row.steps().collect()).collect();
        for i in 0..rows.len() {
            for j in 0..=i {
                let own = self.own(&steps[i], &steps[j]) + between_steps(&rows[i], &rows[j]);
                covariance[(i, j)] += own;
                if i != j {
                    covariance[(j, i)] += own;
                }
            }
        }
        covariance / (MICROMETRE * MICROMETRE)
    }

    /// How a reading depends on the results, on a line with the curve of the side that its axis comes from.
    fn row(&self, kind: &VerificationKind, commanded: &[f64], from: Direction) -> Row {
        let from = match *kind {
            VerificationKind::Positioning { axis, .. } => Some((axis, from)),
            VerificationKind::Ballbar { .. } => None,
        };
        let along: RowVector3<f64> = MeasuredPoint::new(&self.machine, kind, commanded)
            .along
            .transpose();
        let last = carrier(&self.machine, kind);
        let home_mm = measured_home_mm(kind);
        let point = self.machine.position(self, last, commanded, home_mm);
        let twists = self.twists(self.machine.chain(last), commanded);
        let counts = |(axis, twist): &(_, Twist)| (*axis, along * twist.at(point));
        self.row_of(twists.iter().map(counts), commanded, from)
    }

    /// The same, from what one unit of each of [`trueaxis_kinematics::axis_twist`] of each axis does to the reading.
    fn row_of<'a>(
        &self,
        axes: impl Iterator<Item = (&'a CalibratedAxis, RowDVector<f64>)>,
        commanded: &[f64],
        from: Option<(usize, Direction)>,
    ) -> Row {
        let mut row = Row::default();
        for (axis, counts) in axes {
            let position = commanded[axis.axis];
            let mut effect = Matrix6xX::zeros(counts.ncols());
            effect.set_row(0, &counts);
            let sample = match from {
                Some((measured, side)) if measured == axis.axis => {
                    axis.curve.at_from(position, side)
                }
                _ => axis.curve.at(position),
            };
            let places = influences(&self.machine, axis, &sample, &effect);
            row.results
                .extend(places.into_iter().map(|(place, c)| (place, c[0])));
            let of_components = counts.fixed_columns::<6>(TRANSLATION).transpose();
            let u = axis.remainder.u(&sample);
            let side = from.filter(|(measured, _)| *measured == axis.axis);
            let gap = axis.curve.gap(position, side.map(|(_, side)| side));
            row.interpolated
                .push((axis.axis, gap, of_components.component_mul(&u)));
        }
        row
    }

    /// What two readings have in common of the steps' own errors.
    fn own(&self, a: &[&[Influence]], b: &[&[Influence]]) -> f64 {
        let mut sum = 0.0;
        for of_a in a {
            let step = step_of(&of_a[0]);
            let Some(own) = self.factors.own.get(step) else {
                continue;
            };
            for of_b in b.iter().filter(|of_b| step_of(&of_b[0]) == step) {
                for (i, by_a) in *of_a {
                    let all = of_b.iter();
                    sum += all
                        .map(|(j, by_b)| by_a * by_b * own[(i % 6, j % 6)])
                        .sum::<f64>();
                }
            }
        }
        sum
    }
}

/// The place of a result and its coefficient, mm per mm or rad.
type Influence = (usize, f64);

/// The six components of a step come one after the other.
fn step_of((place, _): &Influence) -> usize {
    place / 6
}

/// A reading as a function of the results.
#[derive(Default)]
struct Row {
    results: Vec<Influence>,
    /// For each axis the gap in which it stands and what the interpolation of its six components may be off by, mm.
    interpolated: Vec<(usize, Gap, Vector6<f64>)>,
}

impl Row {
    /// The results of each step.
    fn steps(&self) -> impl Iterator<Item = &[Influence]> {
        self.results.chunk_by(|a, b| step_of(a) == step_of(b))
    }
}

/// Between the same two steps the interpolation is off to the same side: `ω` keeps its sign, and the divided difference
/// hardly changes.
fn between_steps(a: &Row, b: &Row) -> f64 {
    let pairs = a.interpolated.iter().zip(&b.interpolated);
    pairs
        .filter(|(a, b)| (a.0, &a.1) == (b.0, &b.1))
        .map(|(a, b)| a.2.dot(&b.2))
        .sum()
}
