//! The deviations of the axes along the line on which one axis moves the tool point.

use nalgebra::Vector3;
use trueaxis_campaign::Direction;
use trueaxis_kinematics::{AxisKind, Branch, Machine, MotionError};
use trueaxis_predict::Approach;

use crate::export::{Request, Rule};
use crate::freedom::Freedom;
use crate::{Error, Moved};

/// Slopes beyond this are no errors of a machine, mm per mm.
const STEEPEST: f64 = 0.01;

/// What a spacing may miss the range by, relative.
const DIVIDES: f64 = 1e-6;

/// Distances that differ by no more than this are equal, relative.
const EQUAL: f64 = 1e-6;

/// One axis moves, all others stand at home.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    /// The axis that moves.
    pub(crate) axis: usize,
    /// Its positions, rising, mm or rad.
    pub(crate) positions: Vec<f64>,
    /// For each position the deviations of all axes (mm or rad, actual minus commanded), approached from below and from
    /// above; the mean of both is zero at home.
    pub(crate) forward: Vec<Vec<f64>>,
    pub(crate) backward: Vec<Vec<f64>>,
}

impl Line {
    /// At the steps of the axis, or at the spacing that is asked for.
    pub(crate) fn new(request: &Request<'_>, axis: usize) -> Result<Self, Error> {
        Self::of(request, axis, deviations)
    }

    /// The same for a table that moves no axis but this one: what it can take away alone.
    pub(crate) fn alone(request: &Request<'_>, axis: usize) -> Result<Self, Error> {
        Self::of(request, axis, |request, axis, _, error| {
            own_deviation(request, axis, error)
        })
    }

    /// With what an error of the tool makes of all axes, an axis being at its place of these commanded positions.
    fn of(
        request: &Request<'_>,
        axis: usize,
        deviations: impl Fn(&Request<'_>, usize, &[f64], &MotionError) -> Vec<f64>,
    ) -> Result<Self, Error> {
        let positions = positions(request, axis)?;
        let machine = request.machine.machine();
        let commanded = |position: f64| {
            let mut commanded = vec![0.0; machine.axes().len()];
            commanded[axis] = position;
            commanded
        };
        let from = |direction| {
            let approach = Approach {
                machine: request.machine,
                axis,
                direction,
            };
            let at = |&position: &f64| -> Vec<f64> {
                let commanded = commanded(position);
                let error = machine.tool_error(&approach, &commanded, request.at);
                deviations(request, axis, &commanded, &error)
            };
            positions.iter().map(at).collect()
        };
        let mut line = Self {
            axis,
            forward: from(Direction::Forward),
            backward: from(Direction::Backward),
            positions,
        };
        // What the table itself has there, where no point may be.
        let axes = 0..machine.axes().len();
        let home: Vec<f64> = axes.map(|of| line.at(of, 0.0)).collect();
        take_off(line.forward.iter_mut().chain(&mut line.backward), &home);
        line.check_slopes(request)?;
        Ok(line)
    }

    /// The deviations of axis `of` at a position: linear between the positions, constant outside; the mean of both sides.
    pub(crate) fn at(&self, of: usize, position: f64) -> f64 {
        interpolate(&self.positions, |k| self.mean(of, k), position)
    }

    /// The mean of both sides of the deviation of axis `of` at position number `k`.
    pub(crate) fn mean(&self, of: usize, k: usize) -> f64 {
        0.5 * (self.forward[k][of] + self.backward[k][of])
    }

    /// Mean slope of the deviation of axis `of`, by least squares.
    pub(crate) fn slope(&self, of: usize) -> f64 {
        let count = self.positions.len() as f64;
        let mean_position = self.positions.iter().sum::<f64>() / count;
        let (mut products, mut squares) = (0.0, 0.0);
        for (k, position) in self.positions.iter().enumerate() {
            products += (position - mean_position) * self.mean(of, k);
            squares += (position - mean_position).powi(2);
        }
        if squares > 0.0 {
            products / squares
        } else {
            0.0
        }
    }

    /// Lost motion of the axis itself, mm or degrees, if it is not less than its U (k = 2), as far as that is known: the mean of
    /// backward minus forward. Positive where the encoder leads the machine: forward it stops short.
    pub(crate) fn known_lost_motion(&self, request: &Request<'_>) -> Option<f64> {
        let pairs = self.forward.iter().zip(&self.backward);
        let sum: f64 = pairs.map(|(f, b)| f[self.axis] - b[self.axis]).sum();
        let lost = request.in_file(self.axis, -sum / self.positions.len() as f64);
        let u = request
            .machine
            .u_of_lost_motion(self.axis, &self.positions, request.at);
        let is_less = lost.abs() < request.in_file(self.axis, 2.0 * u);
        (!is_less).then_some(lost)
    }

    fn check_slopes(&self, request: &Request<'_>) -> Result<(), Error> {
        let own = [&self.forward, &self.backward]
            .into_iter()
            .flat_map(|side| {
                let pairs = side.windows(2).zip(self.positions.windows(2));
                pairs.map(|(d, q)| ((d[1][self.axis] - d[0][self.axis]) / (q[1] - q[0])).abs())
            });
        let slope = own.fold(0.0, f64::max);
        if slope <= STEEPEST {
            return Ok(());
        }
        Err(Error::Slope {
            axis: request.name(self.axis).to_owned(),
            format: request.format.name(),
            slope,
            most: STEEPEST,
        })
    }
}

/// Takes what a table has at home off all its rows.
pub(crate) fn take_off<'a>(rows: impl IntoIterator<Item = &'a mut Vec<f64>>, home: &[f64]) {
    for row in rows {
        row.iter_mut()
            .zip(home)
            .for_each(|(value, home)| *value -= home);
    }
}

/// Linear between points, constant outside.
pub(crate) fn interpolate(positions: &[f64], value: impl Fn(usize) -> f64, position: f64) -> f64 {
    let above = positions.partition_point(|&p| p < position);
    if above == 0 {
        return value(0);
    }
    if above == positions.len() {
        return value(above - 1);
    }
    let (a, b) = (positions[above - 1], positions[above]);
    let weight = (position - a) / (b - a);
    (1.0 - weight) * value(above - 1) + weight * value(above)
}

/// The distance of positions of an axis (mm or rad, rising), which must be one.
pub(crate) fn spacing(request: &Request<'_>, axis: usize, positions: &[f64]) -> Result<f64, Error> {
    let gaps = positions.windows(2).map(|pair| pair[1] - pair[0]);
    let least = gaps.clone().fold(f64::INFINITY, f64::min);
    let most = gaps.fold(0.0, f64::max);
    if most - least <= EQUAL * most && most > 0.0 {
        return Ok((positions[positions.len() - 1] - positions[0]) / (positions.len() - 1) as f64);
    }
    Err(Error::UnequalSteps {
        axis: request.name(axis).to_owned(),
        format: request.format.name(),
        least: request.in_file(axis, least),
        most: request.in_file(axis, most),
        unit: request.unit(axis),
    })
}

/// The positions of a table.
pub(crate) fn positions(request: &Request<'_>, axis: usize) -> Result<Vec<f64>, Error> {
    let steps = request.machine.steps(axis);
    let (first, last) = (steps[0], steps[steps.len() - 1]);
    let Some(step) = request.step else {
        return Ok(steps);
    };
    let step = match request.machine.machine().axes()[axis].kind() {
        AxisKind::Linear => step,
        AxisKind::Rotary => step.to_radians(),
    };
    let intervals = ((last - first) / step).round().max(1.0);
    if ((last - first) / step - intervals).abs() > DIVIDES * intervals {
        return Err(Error::Step {
            axis: request.name(axis).to_owned(),
            step: request.in_file(axis, step),
            range: request.in_file(axis, last - first),
            nearest: request.in_file(axis, (last - first) / intervals),
            unit: request.unit(axis),
        });
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number of intervals: whole and positive; what is too large is too many points"
    )]
    let count = intervals.min(1e7) as usize;
    Ok((0..=count)
        .map(|k| first + (last - first) * k as f64 / count as f64)
        .collect())
}

/// What tables of lines take away: positioning, and straightness of the linear axes by each other.
pub(crate) struct Sums {
    lines: Vec<Line>,
    linear: Vec<bool>,
}

impl Sums {
    pub(crate) fn new(request: &Request<'_>, lines: Vec<Line>) -> Self {
        let axes = request.machine.machine().axes().iter();
        let linear = axes.map(|axis| axis.kind() == AxisKind::Linear).collect();
        Self { lines, linear }
    }

    /// What the control makes of the tables.
    pub(crate) fn rule(self) -> Box<Rule> {
        Box::new(move |commanded| Ok(self.added(commanded)))
    }

    pub(crate) fn added(&self, commanded: &[f64]) -> Vec<f64> {
        let mut added = vec![0.0; commanded.len()];
        for line in &self.lines {
            for (of, sum) in added.iter_mut().enumerate() {
                if of == line.axis || (self.linear[of] && self.linear[line.axis]) {
                    *sum -= line.at(of, commanded[line.axis]);
                }
            }
        }
        added
    }
}

/// How far the axes are off by an error of the tool with axis `axis` at its place and all others at home, mm or rad: linear
/// axes by the position of the tool point, of which it takes its own part itself, where another one is parallel; a rotary
/// axis by its angle.
fn deviations(
    request: &Request<'_>,
    axis: usize,
    commanded: &[f64],
    error: &MotionError,
) -> Vec<f64> {
    let machine = request.machine.machine();
    let freedom = Freedom::new(machine, commanded, request.at, Moved::Linear);
    let own = own_deviation(request, axis, error);
    let mut rest = *error;
    if machine.axes()[axis].kind() == AxisKind::Linear {
        rest.translation_mm -= direction(machine, axis) * own[axis];
    }
    let of_rest = freedom.undoing(&rest).into_iter();
    of_rest.zip(own).map(|(by, own)| own - by).collect()
}

/// How far the axis itself is off, along or about its direction: nothing for the others.
pub(crate) fn own_deviation(request: &Request<'_>, axis: usize, error: &MotionError) -> Vec<f64> {
    let machine = request.machine.machine();
    let part = match machine.axes()[axis].kind() {
        AxisKind::Linear => error.translation_mm,
        AxisKind::Rotary => error.rotation_rad,
    };
    let mut own = vec![0.0; machine.axes().len()];
    own[axis] = direction(machine, axis).dot(&part);
    own
}

/// In which an axis moves the tool against the workpiece, all others at home.
pub(crate) fn direction(machine: &Machine, axis: usize) -> Vector3<f64> {
    let direction = machine.axes()[axis].direction().into_inner();
    match machine.branch(Branch::Workpiece).contains(&axis) {
        true => -direction,
        false => direction,
    }
}
