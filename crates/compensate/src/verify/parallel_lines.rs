//! Pitch and yaw of a linear axis from its positioning along parallel lines (the paper's Fig. 11).
//!
//! A line through the place `r` of the axis' stage reads, beside what all lines of one position have in common,
//!
//! ```text
//! n · (ε × r) = ε · (r × n)         n: direction of the axis
//! ```
//!
//! so that for X the lines at `y₁` and `z₁` against the one at the origin give `ε_y = (ΔL₃ - ΔL₁)/z₁` and
//! `ε_z = -(ΔL₂ - ΔL₁)/y₁`. The paper has `ε_z` without the minus: its yaw has the opposite sign of the right-hand rule. Here
//! all lines of an axis are solved by least squares, at the positions that they share. As each line has a zero of its own,
//! the mean of an angle over the positions is open; it is taken out of what is measured and what is predicted.

use nalgebra::{DMatrix, DVector, Vector3};
use trueaxis_campaign::VerificationKind;
use trueaxis_kinematics::{AxisKind, Component, Ideal};
use trueaxis_leastsquares::dense::Svd;
use trueaxis_predict::{CalibratedMachine, carrier, positioning_lines};

use crate::export::rising;
use crate::verify::{Point, SAME, Verified, came_from};

/// Distances of lines below this tell no angle, mm.
const LEAST_LEVER_MM: f64 = 1.0;

/// The angles of an axis from its lines.
#[derive(Debug, Clone, PartialEq)]
pub struct ParallelLines {
    /// Index of the axis.
    pub axis: usize,
    /// Names of the verifications that the lines are of, once for each line.
    pub lines: Vec<String>,
    /// Positions that all lines share, mm, rising.
    pub positions: Vec<f64>,
    /// Pitch and yaw, as far as the places of the lines tell them.
    pub angles: Vec<AngleCurve>,
}

/// An angular error over the positions, rad; each without its mean.
#[derive(Debug, Clone, PartialEq)]
pub struct AngleCurve {
    /// Which one.
    pub component: Component,
    /// From the readings.
    pub measured: Vec<f64>,
    /// By the same arithmetic from what is predicted for them.
    pub predicted: Vec<f64>,
    /// Standard uncertainty of that; NaN if the calibration has none.
    pub u_predicted: Vec<f64>,
    /// Standard uncertainty of what is measured, where that of the readings is declared.
    pub u_measured: Option<Vec<f64>>,
}

impl AngleCurve {
    /// The largest difference of measured and predicted, rad.
    pub fn largest_difference(&self) -> f64 {
        let pairs = self.measured.iter().zip(&self.predicted);
        pairs.map(|(m, p)| (m - p).abs()).fold(0.0, f64::max)
    }

    /// Standard uncertainty of the difference where it is the largest, rad, with what is known of that of the readings; none if
    /// the calibration has no uncertainties.
    pub fn u_largest(&self) -> Option<f64> {
        let difference = |k: &usize| (self.measured[*k] - self.predicted[*k]).abs();
        let all = 0..self.measured.len();
        let largest = all.max_by(|a, b| difference(a).total_cmp(&difference(b)))?;
        let of_readings = self.u_measured.as_ref().map_or(0.0, |u| u[largest]);
        Some(self.u_predicted[largest].hypot(of_readings)).filter(|u| !u.is_nan())
    }
}

/// One line: readings with the other axes at the same positions.
struct Line<'a> {
    verified: &'a Verified,
    kind: &'a VerificationKind,
    points: Vec<&'a Point>,
    /// Where it is on the stage of the axis, mm.
    place: Vector3<f64>,
}

/// The angles of all axes that have two lines or more beside each other, by [`crate::verify()`] with the same arguments.
pub fn parallel_lines(
    machine: &CalibratedMachine,
    verified: &[Verified],
    is_compensated: bool,
) -> Vec<ParallelLines> {
    let axes = 0..machine.machine().axes().len();
    let of_axis = |axis| {
        let lines = lines(machine, verified, axis);
        angles(machine, axis, &lines, is_compensated)
    };
    axes.filter_map(of_axis).collect()
}

fn lines<'a>(machine: &CalibratedMachine, verified: &'a [Verified], axis: usize) -> Vec<Line<'a>> {
    let nominal = machine.machine();
    let mut all: Vec<Line<'a>> = Vec::new();
    if nominal.axes()[axis].kind() != AxisKind::Linear {
        return all;
    }
    for verified in verified {
        let Some(kind) = &verified.kind else {
            continue;
        };
        let target_mm = match *kind {
            VerificationKind::Positioning {
                axis: own,
                target_mm,
            } if own == axis => target_mm,
            _ => continue,
        };
        let positions = verified.points.iter().map(|p| p.positions.as_slice());
        let numbers = positioning_lines(axis, positions);
        for number in 0..numbers.iter().max().map_or(0, |last| last + 1) {
            let own = verified.points.iter().zip(&numbers);
            let points: Vec<&Point> = own.filter(|(_, n)| **n == number).map(|(p, _)| p).collect();
            // The axis and those that carry it stand at home, those that it carries where they are.
            let mut positions = points[0].positions.clone();
            for &below in nominal.chain(axis) {
                positions[below] = 0.0;
            }
            let last = carrier(nominal, kind);
            all.push(Line {
                verified,
                kind,
                points,
                place: nominal.position(&Ideal, last, &positions, target_mm).coords,
            });
        }
    }
    all
}

impl Line<'_> {
    /// The points at a position, from both sides.
    fn at(&self, axis: usize, position: f64) -> impl Iterator<Item = &Point> {
        let own = self.points.iter().copied();
        own.filter(move |point| is_at(point, axis, position))
    }
}

fn is_at(point: &Point, axis: usize, position: f64) -> bool {
    (point.positions[axis] - position).abs() <= SAME
}

fn angles(
    machine: &CalibratedMachine,
    axis: usize,
    lines: &[Line<'_>],
    is_compensated: bool,
) -> Option<ParallelLines> {
    if lines.len() < 2 {
        return None;
    }
    let geometry = &machine.machine().axes()[axis];
    let across = Component::ALL.into_iter().filter(|component| {
        component.is_angular() && component.index() != 3 + geometry.principal()
    });
    let across: Vec<Component> = across.collect();
    let direction = geometry.direction().into_inner();
    let mean = lines.iter().map(|line| line.place).sum::<Vector3<f64>>() / lines.len() as f64;
    let levers = DMatrix::from_fn(lines.len(), 2, |line, i| {
        let lever = (lines[line].place - mean).cross(&direction);
        lever[across[i].index() - 3]
    });
    let svd = Svd::new(&levers).ok()?;
    let seen = seen(&levers, &svd);
    let positions = shared_positions(axis, lines);
    if !seen.contains(&true) || positions.len() < 2 {
        return None;
    }
    let angle_of_line = svd.pseudo_inverse(LEAST_LEVER_MM);

    // The points of all lines in one row, and each angle as a function of them.
    let points: Vec<(usize, &Point)> = lines
        .iter()
        .enumerate()
        .flat_map(|(k, line)| line.points.iter().map(move |point| (k, *point)))
        .collect();
    let curves = (0..2).filter(|&i| seen[i]).map(|i| {
        let mut function = DMatrix::from_fn(positions.len(), points.len(), |row, column| {
            let (position, (k, point)) = (positions[row], points[column]);
            if !is_at(point, axis, position) {
                return 0.0;
            }
            let count = lines[k].at(axis, position).count() as f64;
            // µm are 1e-3 mm.
            angle_of_line[(i, k)] / count * 1e-3
        });
        // Without the mean over the positions.
        let mean = function.row_mean();
        function.row_iter_mut().for_each(|mut row| row -= &mean);
        curve(
            machine,
            across[i],
            &function,
            lines,
            &points,
            is_compensated,
        )
    });
    Some(ParallelLines {
        axis,
        lines: lines
            .iter()
            .map(|line| line.verified.name.clone())
            .collect(),
        angles: curves.collect(),
        positions,
    })
}

/// Which of the two angles the places of the lines tell.
fn seen(levers: &DMatrix<f64>, svd: &Svd) -> [bool; 2] {
    let alone = [0, 1].map(|i| levers.column(i).norm() >= LEAST_LEVER_MM);
    match svd.rank(LEAST_LEVER_MM) {
        2 => [true, true],
        // In one plane: an angle, if the plane is that of two reference axes.
        _ if alone[0] != alone[1] => alone,
        _ => [false, false],
    }
}

/// Positions at which every line was read.
fn shared_positions(axis: usize, lines: &[Line<'_>]) -> Vec<f64> {
    let first = lines.first().map_or(&[][..], |line| line.points.as_slice());
    let mut positions = rising(first.iter().map(|point| point.positions[axis]), SAME);
    positions.retain(|&q| lines.iter().all(|line| line.at(axis, q).next().is_some()));
    positions
}

fn curve(
    machine: &CalibratedMachine,
    component: Component,
    function: &DMatrix<f64>,
    lines: &[Line<'_>],
    points: &[(usize, &Point)],
    is_compensated: bool,
) -> AngleCurve {
    let of = |value: &dyn Fn(&Point) -> f64| -> Vec<f64> {
        let values = points.iter().map(|(_, point)| value(point));
        let values = DVector::from_iterator(points.len(), values);
        (function * values).as_slice().to_vec()
    };
    let readings: Vec<_> = points
        .iter()
        .map(|&(k, point)| (lines[k].kind, point.positions.as_slice(), came_from(point)))
        .collect();
    let covariance = function * machine.covariance_of_readings(&readings) * function.transpose();
    let u = covariance.diagonal();
    let declared: Option<Vec<f64>> = points.iter().map(|(_, point)| point.u_reading_um).collect();
    AngleCurve {
        component,
        measured: of(&|point| point.reading_um),
        predicted: of(&|point| point.expected_um(is_compensated)),
        u_predicted: u
            .iter()
            .map(|v| if *v < 0.0 { 0.0 } else { v.sqrt() })
            .collect(),
        u_measured: declared.map(|u| {
            let rows = function.row_iter();
            rows.map(|row| {
                let squares = row.iter().zip(&u).map(|(x, u)| (x * u).powi(2));
                squares.sum::<f64>().sqrt()
            })
            .collect()
        }),
    }
}
