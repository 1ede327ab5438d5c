//! Readings whose values look like those of another unit, or like positions, and positions that look like inches.

use trueaxis_campaign::VerificationKind;
use trueaxis_leastsquares::dot;
use trueaxis_selection::Projection;

use crate::numbers::extremes;
use crate::verification::base::base_columns;
use crate::verification::comparison::Comparison;

/// Positions in units in which readings are given: the reading for each mm, the share of the range that it may be off
/// by, and the name. A scale may be wrong by a thousandth, but hardly by exactly that.
const POSITIONS: [(f64, f64, &str); 6] = [
    (1.0, 0.005, "mm"),
    (1e3, 0.05, "µm"),
    (1e6, 0.05, "nm"),
    (1.0 / INCH_MM, 0.005, "inches"),
    (1e3 / INCH_MM, 0.005, "thousandths of an inch"),
    (1e6 / INCH_MM, 0.05, "microinches"),
];

const INCH_MM: f64 = 25.4;

/// How much larger than predicted readings in another unit look, the share that this may be off by, and the share of the
/// squares that the prediction then explains.
const PREDICTED: [(f64, &str); 4] = [
    (1e3, "nanometres"),
    (1e-3, "millimetres"),
    (1.0 / INCH_MM, "thousandths of an inch"),
    (1e3 / INCH_MM, "microinches"),
];
const LIKE_PREDICTED: f64 = 0.05;
const EXPLAINED: f64 = 0.9;

/// Share by which lengths of a bar may be off.
const LIKE_LENGTH: f64 = 0.01;

/// Positions planned in mm are multiples of this one, mm; as inches they are rounded to a few digits.
const PLANNED_MM: f64 = 0.5;
const ROUNDED_MM: f64 = 0.0005;

/// Positions given as planned have no digits below this one, mm.
const FINEST_MM: f64 = 0.01;

/// Fewest positions of a line.
const LEAST_POSITIONS: usize = 3;

/// Deviations that no linear axis or bar in use has, µm; those of a rotary axis have any radius.
const BEYOND_MACHINES_UM: f64 = 5e3;

/// Few machines stay within a range of the first, µm, over one of the second, mm.
const BENEATH_MACHINES_UM: f64 = 0.5;
const LEAST_RANGE_MM: f64 = 10.0;

/// Standard uncertainty from a last digit of 0.0005 µm: few instruments show µm so finely, but 0.0001 mm is common.
const LEAST_DIGIT_UM: f64 = 1.45e-4;

/// What the readings are instead, with the numbers that show it: whatever else they say is none of the machine's.
pub(crate) fn mistake(comparison: &Comparison<'_>) -> Option<String> {
    if let Some(unit) = position_unit(comparison) {
        return Some(format!(
            "the readings look like positions in {unit}; deviation_um is measured less commanded position, in µm"
        ));
    }
    if are_lengths_of_bar(comparison) {
        return Some(
            "the readings look like lengths of the bar; delta_um is the change of its length, in µm"
                .to_owned(),
        );
    }
    let of_predicted = times_predicted(comparison, &base_columns(comparison, true))?;
    let is = |times: f64| (of_predicted / times - 1.0).abs() < LIKE_PREDICTED;
    let what = match PREDICTED.iter().find(|(times, _)| is(*times)) {
        Some((_, unit)) => unit,
        None if is(-1.0) && is_turned_beyond_slope(comparison) => {
            "commanded less measured position, or a compensation that was on twice"
        }
        None => return None,
    };
    Some(format!(
        "the readings are {of_predicted:.4} times what is predicted, and look like {what}"
    ))
}

/// What the unit of the readings or positions may be instead.
pub(crate) fn doubt(comparison: &Comparison<'_>) -> Option<String> {
    let values = || comparison.arrivals.iter().map(|a| a.value_um);
    if are_inches(comparison) {
        return Some(
            "the positions look like inches; they are taken as millimetres (if the readings come from the same file, they may not \
             be in µm, either)"
                .to_owned(),
        );
    }
    let largest_um = values().fold(0.0_f64, |most, x| most.max(x.abs()));
    let range_mm = linear_range_mm(comparison);
    let is_length = range_mm.is_some() || comparison.line().is_none();
    if is_length && largest_um > BEYOND_MACHINES_UM {
        return Some(format!(
            "readings of up to {:.1} mm look like nanometres; they are taken as micrometres",
            1e-3 * largest_um
        ));
    }
    let [low, high] = extremes(values());
    let span_um = high - low;
    let range_mm = range_mm.filter(|range_mm| *range_mm >= LEAST_RANGE_MM)?;
    let is_small = span_um < BENEATH_MACHINES_UM && comparison.resolution_um()? < LEAST_DIGIT_UM;
    is_small.then(|| {
        format!(
            "readings within {span_um:.2} µm over {range_mm:.0} mm look like millimetres or inches; they are taken as micrometres"
        )
    })
}

/// Length of a line of a linear axis, mm.
fn linear_range_mm(comparison: &Comparison<'_>) -> Option<f64> {
    let is_linear = comparison.line().is_some() && !comparison.is_of_rotary_axis();
    is_linear.then_some(comparison.range[1] - comparison.range[0])
}

/// Whether readings are as long as the bar.
fn are_lengths_of_bar(comparison: &Comparison<'_>) -> bool {
    let VerificationKind::Ballbar { center_mm, .. } = comparison.kind else {
        return false;
    };
    let mut pairs = comparison.arrivals.iter().zip(&comparison.points);
    pairs.all(|(arrival, point)| {
        let length_um = 1e3 * (point.point_mm - center_mm).norm();
        (arrival.value_um / length_um - 1.0).abs() < LIKE_LENGTH
    })
}

/// Whether more than a slope, which any scale may turn, has the opposite sign.
fn is_turned_beyond_slope(comparison: &Comparison<'_>) -> bool {
    let mut open = base_columns(comparison, true);
    let along = comparison.line().map(|axis| {
        let positions = comparison.arrivals.iter().map(|a| a.positions[axis]);
        positions.collect()
    });
    open.extend(along);
    times_predicted(comparison, &open).is_some_and(|times| times < 0.0)
}

/// The readings as a multiple of the prediction, without columns that are open, where it explains them.
fn times_predicted(comparison: &Comparison<'_>, open: &[Vec<f64>]) -> Option<f64> {
    let read: Vec<f64> = comparison.arrivals.iter().map(|a| a.value_um).collect();
    let pairs = read.iter().zip(&comparison.difference_um);
    let predicted: Vec<f64> = pairs.map(|(read, more)| read - more).collect();
    let [read, predicted] = [read, predicted].map(|of| Projection::dense(of, open).residuals);
    let [of_read, of_predicted] = [&read, &predicted].map(|values| dot(values, values));
    let together = dot(&read, &predicted);
    let is_explained =
        of_predicted > 0.0 && together * together >= EXPLAINED * of_read * of_predicted;
    is_explained.then(|| together / of_predicted)
}

/// Whether positions times 25.4 are whole or half millimetres, and not all are multiples of 0.01 mm before.
fn are_inches(comparison: &Comparison<'_>) -> bool {
    if linear_range_mm(comparison).is_none() {
        return false;
    }
    let mut positions = comparison.positions(comparison.axis());
    positions.retain(|at| *at != 0.0);
    let off = |at: f64, of: f64| (at - of * (at / of).round()).abs();
    positions.len() >= LEAST_POSITIONS
        && positions
            .iter()
            .all(|at| off(INCH_MM * at, PLANNED_MM) < ROUNDED_MM)
        && positions.iter().any(|at| off(*at, FINEST_MM) > ROUNDED_MM)
}

/// The unit in which the readings are positions, from any zero.
fn position_unit(comparison: &Comparison<'_>) -> Option<&'static str> {
    let range_mm = linear_range_mm(comparison)?;
    let axis = comparison.axis();
    let arrivals = &comparison.arrivals;
    if comparison.positions(axis).len() < LEAST_POSITIONS {
        return None;
    }
    let is_position = |(of_mm, part, _): &&(f64, f64, &str)| {
        let rest = arrivals.iter();
        let rest = rest.map(|a| a.value_um - of_mm * a.positions[axis]);
        let [low, high] = extremes(rest);
        high - low < 2.0 * part * of_mm * range_mm
    };
    POSITIONS.iter().find(is_position).map(|(_, _, unit)| *unit)
}
