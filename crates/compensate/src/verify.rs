//! Readings of other instruments against what a calibration predicts, with and without compensation.
//!
//! Readings at the same positions from the same side are one, with their mean. Where an instrument has its zero, where
//! the centre of a ball bar is and how long the bar is, the machine does not tell: these columns `X` (as in
//! `trueaxis-diagnose`) are fitted out of readings, predictions and covariance alike,
//!
//! ```text
//! M = I - X X⁺     r → M r     p → M p     C → M C M
//! E_n = (r - p) / √(U_r² + U_p²)           U = 2 u
//! ```
//!
//! (ISO/IEC 17043, B.3). `U_r` is what the campaign declares, `U_p` that of the calibration and of its interpolation.

pub(crate) mod iso_230_2;
pub(crate) mod iso_230_4;
mod json;
mod misfit;
pub(crate) mod mistaken;
pub(crate) mod notices;
pub(crate) mod parallel_lines;
mod point_checks;

use nalgebra::{DMatrix, DVector, Point3};
use trueaxis_campaign::{Campaign, Direction, Verification, VerificationKind};
use trueaxis_kinematics::{AxisKind, Ideal, MICROMETRE, Machine};
use trueaxis_leastsquares::last_digit;
use trueaxis_predict::{
    CalibratedMachine, MeasuredPoint, ball_bar_set_up, carrier, check_same_machine,
    measured_home_mm, positioning_lines, predicted_reading_um,
};

use crate::freedom::pseudo_inverse;
use crate::verify::misfit::chance;
use crate::verify::point_checks::verified_points;
use crate::{Error, Moved, correct};
pub use json::verification_json;

use iso_230_2::Positioning;
use iso_230_4::Circular;

/// Positions this close are one, mm or rad.
const SAME: f64 = 1e-9;

/// Parts of a unit vector that only rounding makes.
pub(crate) const ROUNDING: f64 = 1e-9;

/// Probability that a good prediction is refused.
const FALSE_ALARM: f64 = 0.01;

/// Share of |`E_n`| above 1 for normal errors and U for k = 2.
pub const EXPECTED_ABOVE_ONE: f64 = 0.0455;

/// One verification against its prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct Verified {
    /// Its name.
    pub name: String,
    /// What was measured; none if these are point checks.
    pub kind: Option<VerificationKind>,
    /// Each position and side, or each coordinate of each place.
    pub points: Vec<Point>,
    /// ISO 230-2, of each line of positioning, with the positions of all axes at its first reading.
    pub positioning: Vec<(Vec<f64>, Positioning)>,
    /// ISO 230-4, of a ball bar.
    pub circular: Option<Circular>,
    /// The probability that as many `E_n` exceed 1 if all is as uncertain as it is said to be; none without `E_n`.
    pub p_value: Option<f64>,
}

/// All readings at one position from one side; values in µm without what the set-up leaves open.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Commanded positions of all axes, mm or rad.
    pub positions: Vec<f64>,
    /// Side of approach; none of a point check.
    pub direction: Option<Direction>,
    /// Which coordinate of which point a point check measures.
    pub checked: Option<Checked>,
    /// Number of readings.
    pub readings: usize,
    /// Their mean.
    pub reading_um: f64,
    /// Predicted without compensation, by exact motions.
    pub predicted_um: f64,
    /// The same of a ball bar to first order: the paper's Eq. 24.
    pub first_order_um: f64,
    /// Predicted with the linear axes corrected in every command, as tables do.
    pub compensated_um: f64,
    /// Standard uncertainty of the prediction; NaN if the calibration has none.
    pub u_prediction_um: f64,
    /// Declared standard uncertainty of the reading.
    pub u_reading_um: Option<f64>,
    /// `E_n`, where that is declared.
    pub e_n: Option<f64>,
}

/// What a point check is of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checked {
    /// The point of the tool in the reference frame at home, mm.
    pub tool_home_mm: Point3<f64>,
    /// Its coordinate: 0, 1, 2 for x, y, z of the workpiece at home, which turn with it.
    pub coordinate: usize,
}

impl Verified {
    /// How many of the `E_n` exceed 1, and of how many.
    pub fn above_one(&self) -> (usize, usize) {
        let all = self.points.iter().filter_map(|point| point.e_n);
        let above = all.clone().filter(|e_n| e_n.abs() > 1.0).count();
        (above, all.count())
    }

    /// Whether more `E_n` exceed 1 than chance explains, with a probability of 1 %.
    pub fn is_misfit(&self) -> bool {
        self.p_value.is_some_and(|p| p < FALSE_ALARM)
    }
}

/// Compares all verifications of a campaign with the predictions of a calibration; `is_compensated`: the readings were
/// taken with the compensation switched on.
///
/// # Errors
/// [`Error::OtherMachine`] if the calibration is that of another machine, [`Error::NothingRead`] without readings,
/// [`Error::NotContracting`] if its errors have no inverse.
pub fn verify(
    machine: &CalibratedMachine,
    campaign: &Campaign,
    is_compensated: bool,
) -> Result<Vec<Verified>, Error> {
    check_same_machine(machine.machine(), &campaign.machine)?;
    if campaign.verification.is_empty() && campaign.point_checks.is_empty() {
        return Err(Error::NothingRead);
    }
    let readings = campaign.verification.iter();
    let readings = readings.map(|verification| verified(machine, verification, is_compensated));
    let checks = campaign.point_checks.iter();
    let checks = checks.map(|check| verified_points(machine, check, is_compensated));
    readings.chain(checks).collect()
}

/// The campaign with the verification readings as they would be without compensation, to first order: those that were taken with it
/// plus what it took away, in steps of their last digit, so that they show no more digits than before. Point checks stay as they are.
///
/// # Errors
/// [`Error::OtherMachine`], [`Error::NotContracting`] as in [`verify()`].
pub fn uncompensated(machine: &CalibratedMachine, campaign: &Campaign) -> Result<Campaign, Error> {
    check_same_machine(machine.machine(), &campaign.machine)?;
    let mut without = campaign.clone();
    for verification in &mut without.verification {
        let values_um = verification.readings.iter().map(|reading| reading.value_um);
        let digit_um = last_digit(values_um).map_or(FINEST_UM, |digit| digit.max(FINEST_UM));
        for reading in &mut verification.readings {
            let (at, from) = (&reading.positions, reading.direction);
            let [predicted_um, compensated_um] =
                predicted_um(machine, &verification.kind, at, from)?;
            reading.value_um += ((predicted_um - compensated_um) / digit_um).round() * digit_um;
        }
    }
    Ok(without)
}

/// The last digit of readings is taken for no less, µm: no instrument shows more.
const FINEST_UM: f64 = 1e-3;

/// What is predicted to be read at commanded positions, without compensation and with it, µm. Tables move the linear axes:
/// a rotary axis that turned the tool back would take the measured point along, and a linear axis, seen from the bed, more
/// with it.
fn predicted_um(
    machine: &CalibratedMachine,
    kind: &VerificationKind,
    at: &[f64],
    from: Direction,
) -> Result<[f64; 2], Error> {
    let nominal = machine.machine();
    let home_mm = measured_home_mm(kind);
    let corrected = correct(nominal, machine, at, home_mm, Moved::Linear)?.positions;
    Ok([
        machine.predicted_reading_um(kind, at, from),
        predicted_reading_um(nominal, kind, machine, at, &corrected),
    ])
}

fn verified(
    machine: &CalibratedMachine,
    verification: &Verification,
    is_compensated: bool,
) -> Result<Verified, Error> {
    let (nominal, kind) = (machine.machine(), &verification.kind);
    let mut points = grouped(verification);
    for point in &mut points {
        let at = &point.positions;
        [point.predicted_um, point.compensated_um] =
            predicted_um(machine, kind, at, came_from(point))?;
        let MeasuredPoint { point_mm, along } = MeasuredPoint::new(nominal, kind, at);
        let home_mm = measured_home_mm(kind);
        let actual = nominal.position(machine, carrier(nominal, kind), at, home_mm);
        // Eq. 24.
        point.first_order_um = along.dot(&(actual - point_mm)) / MICROMETRE;
        point.u_reading_um = declared_u_um(nominal, verification, at);
    }
    let readings: Vec<_> = points
        .iter()
        .map(|point| (kind, point.positions.as_slice(), came_from(point)))
        .collect();
    let covariance = machine.covariance_of_readings(&readings);
    let set_up = set_up(nominal, kind, &points.iter().collect::<Vec<_>>());
    let p_value = judge(machine, &mut points, &covariance, &set_up, is_compensated);
    Ok(Verified {
        name: verification.name.clone(),
        kind: Some(kind.clone()),
        positioning: positioning(verification),
        circular: Circular::new(nominal, kind, &grouped(verification)),
        points,
        p_value,
    })
}

/// Takes what the set-up leaves open out of readings, predictions and their covariance, and judges what is left: the
/// probability of as many `E_n` above 1.
fn judge(
    machine: &CalibratedMachine,
    points: &mut [Point],
    covariance: &DMatrix<f64>,
    set_up: &DMatrix<f64>,
    is_compensated: bool,
) -> Option<f64> {
    let free = set_up * pseudo_inverse(set_up, ROUNDING * set_up.norm());
    let projection = DMatrix::identity(points.len(), points.len()) - free;
    let with_readings = covariance
        + DMatrix::from_diagonal(&DVector::from_iterator(
            points.len(),
            points.iter().map(|p| p.u_reading_um.unwrap_or(0.0).powi(2)),
        ));
    let [covariance, with_readings] =
        [covariance, &with_readings].map(|covariance| &projection * covariance * &projection);
    let values: [fn(&mut Point) -> &mut f64; 4] = [
        |point| &mut point.reading_um,
        |point| &mut point.predicted_um,
        |point| &mut point.first_order_um,
        |point| &mut point.compensated_um,
    ];
    for value in values {
        let column = DVector::from_iterator(points.len(), points.iter_mut().map(|p| *value(p)));
        let left = &projection * column;
        let pairs = points.iter_mut().zip(left.iter());
        pairs.for_each(|(point, left)| *value(point) = *left);
    }
    for (i, point) in points.iter_mut().enumerate() {
        let variance = covariance[(i, i)];
        // Rounding may leave less than zero; what is not known stays so.
        point.u_prediction_um = if variance < 0.0 { 0.0 } else { variance.sqrt() };
        // A reading that the set-up takes up whole says nothing.
        let says = machine.has_uncertainties && projection[(i, i)] > ROUNDING;
        let u_um = point.u_um().filter(|_| says);
        point.e_n =
            u_um.map(|u| (point.reading_um - point.expected_um(is_compensated)) / (2.0 * u));
    }
    let e_n = |i: usize| points[i].e_n;
    let judged: Vec<usize> = (0..points.len()).filter(|&i| e_n(i).is_some()).collect();
    let above = judged.iter().filter_map(|&i| e_n(i));
    let above = above.filter(|e_n| e_n.abs() > 1.0).count();
    let limits = judged.iter().filter_map(|&i| points[i].u_um());
    let limits: Vec<f64> = limits.map(|u| 2.0 * u).collect();
    let covariance = with_readings.select_rows(&judged).select_columns(&judged);
    (!judged.is_empty()).then(|| chance(above, &covariance, &limits))
}

fn came_from(point: &Point) -> Direction {
    point.direction.unwrap_or(Direction::Forward)
}

/// Readings by position and side, in the order in which they first occur.
fn grouped(verification: &Verification) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    for reading in &verification.readings {
        let same = points.iter_mut().find(|point| {
            point.direction == Some(reading.direction)
                && are_same(&point.positions, &reading.positions)
        });
        if let Some(point) = same {
            point.readings += 1;
            point.reading_um += (reading.value_um - point.reading_um) / point.readings as f64;
        } else {
            let direction = Some(reading.direction);
            points.push(Point {
                direction,
                ..Point::new(&reading.positions, reading.value_um)
            });
        }
    }
    points
}

impl Point {
    /// Standard uncertainty of reading less prediction, where that of the reading is declared.
    fn u_um(&self) -> Option<f64> {
        self.u_reading_um.map(|u| u.hypot(self.u_prediction_um))
    }

    /// What is predicted with or without compensation.
    fn expected_um(&self, is_compensated: bool) -> f64 {
        match is_compensated {
            true => self.compensated_um,
            false => self.predicted_um,
        }
    }

    /// Of one reading, of which nothing is predicted yet.
    fn new(positions: &[f64], reading_um: f64) -> Self {
        Self {
            positions: positions.to_vec(),
            direction: None,
            checked: None,
            readings: 1,
            reading_um,
            predicted_um: 0.0,
            first_order_um: 0.0,
            compensated_um: 0.0,
            u_prediction_um: 0.0,
            u_reading_um: None,
            e_n: None,
        }
    }
}

fn are_same(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME)
}

/// With the commanded position of the axis (mm; an arc for a rotary one) or the nominal length.
fn declared_u_um(machine: &Machine, verification: &Verification, at: &[f64]) -> Option<f64> {
    let length_mm = match verification.kind {
        VerificationKind::Positioning { axis, target_mm } => match machine.axes()[axis].kind() {
            AxisKind::Linear => at[axis],
            AxisKind::Rotary => {
                let from_axis = target_mm - machine.axes()[axis].reference_mm();
                let direction = machine.axes()[axis].direction().into_inner();
                at[axis] * direction.cross(&from_axis).norm()
            }
        },
        VerificationKind::Ballbar {
            ball_mm,
            ball_carrier,
            center_mm,
            ..
        } => (machine.position(&Ideal, ball_carrier, at, ball_mm) - center_mm).norm(),
    };
    u_of_length_um(verification.u_um, verification.u_ppm, length_mm)
}

/// √(a² + (b l)²), where it is declared.
fn u_of_length_um(u_um: Option<f64>, u_ppm: Option<f64>, length_mm: f64) -> Option<f64> {
    // ppm of mm are nm.
    let proportional = u_ppm.unwrap_or(0.0) * length_mm / 1000.0;
    Some(u_um.unwrap_or(0.0).hypot(proportional)).filter(|u| *u > 0.0)
}

/// Columns of what the machine does not tell.
fn set_up(machine: &Machine, kind: &VerificationKind, points: &[&Point]) -> DMatrix<f64> {
    let columns: Vec<Vec<f64>> = match *kind {
        VerificationKind::Positioning { axis, .. } => {
            let lines = positioning_lines(axis, points.iter().map(|p| p.positions.as_slice()));
            let count = lines.iter().max().map_or(0, |last| last + 1);
            let of_line = |line| {
                let is_on = lines.iter().map(|&own| f64::from(u8::from(own == line)));
                is_on.collect()
            };
            (0..count).map(of_line).collect()
        }
        VerificationKind::Ballbar { .. } => {
            let along = points
                .iter()
                .map(|p| MeasuredPoint::new(machine, kind, &p.positions).along);
            ball_bar_set_up(&along.collect::<Vec<_>>())
        }
    };
    DMatrix::from_fn(points.len(), columns.len(), |row, column| {
        columns[column][row]
    })
}

fn positioning(verification: &Verification) -> Vec<(Vec<f64>, Positioning)> {
    let VerificationKind::Positioning { axis, .. } = verification.kind else {
        return Vec::new();
    };
    let readings = &verification.readings;
    let lines = positioning_lines(axis, readings.iter().map(|r| r.positions.as_slice()));
    let count = lines.iter().max().map_or(0, |last| last + 1);
    let of_line = |line: usize| {
        let own = readings.iter().zip(&lines).filter(|(_, own)| **own == line);
        let own: Vec<_> = own.map(|(reading, _)| reading).collect();
        let passes = own
            .iter()
            .map(|r| (r.positions[axis], r.direction, r.value_um));
        let positioning = Positioning::new(&passes.collect::<Vec<_>>());
        (own[0].positions.clone(), positioning)
    };
    (0..count).map(of_line).collect()
}
