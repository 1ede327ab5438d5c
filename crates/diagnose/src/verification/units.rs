//! Readings whose numbers look like those of another unit, or like positions.

use trueaxis_kinematics::AxisKind;

use crate::verification::comparison::Comparison;
use crate::verification::resolution::resolution_um;

/// Positions in units that readings come in: the reading for each mm, the part of the range that it may be off by, and the name. A
/// scale may be wrong by a thousandth, but hardly by just that.
const POSITIONS: [(f64, f64, &str); 3] = [(1.0, 0.005, "mm"), (1e3, 0.05, "µm"), (1e6, 0.05, "nm")];

/// Positions that make a line.
const LEAST_POSITIONS: usize = 3;

/// Deviations that no linear axis or bar in use has, µm; those of a rotary axis have any radius.
const BEYOND_MACHINES_UM: f64 = 5e3;

/// A range of readings that few machines stay within, µm, over so many mm.
const BENEATH_MACHINES_UM: f64 = 0.5;
const LEAST_RANGE_MM: f64 = 10.0;

/// Standard uncertainty from a last digit of 0.0005 µm: few instruments show readings in µm that finely, but 0.0001 mm is common.
const LEAST_DIGIT_UM: f64 = 1.45e-4;

/// What the unit of the readings may be instead, with the numbers that say so.
pub(crate) fn doubt(comparison: &Comparison<'_>) -> Option<String> {
    let values = || comparison.arrivals.iter().map(|a| a.value_um);
    if let Some(unit) = position_unit(comparison) {
        return Some(format!(
            "the readings look like positions in {unit}; deviation_um is measured less commanded position, in µm"
        ));
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
    let low = values().fold(f64::INFINITY, f64::min);
    let span_um = values().fold(f64::NEG_INFINITY, f64::max) - low;
    let range_mm = range_mm.filter(|range_mm| *range_mm >= LEAST_RANGE_MM)?;
    let is_small = span_um < BENEATH_MACHINES_UM && resolution_um(comparison)? < LEAST_DIGIT_UM;
    is_small.then(|| {
        format!(
            "readings within {span_um:.2} µm over {range_mm:.0} mm look like millimetres; they are taken as micrometres"
        )
    })
}

/// Length of a line of a linear axis, mm.
fn linear_range_mm(comparison: &Comparison<'_>) -> Option<f64> {
    let axis = comparison.line()?;
    let is_linear = comparison.machine.axes()[axis].kind() == AxisKind::Linear;
    is_linear.then_some(comparison.range[1] - comparison.range[0])
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
        let rest = || {
            arrivals
                .iter()
                .map(|a| a.value_um - of_mm * a.positions[axis])
        };
        let spread =
            rest().fold(f64::NEG_INFINITY, f64::max) - rest().fold(f64::INFINITY, f64::min);
        spread < 2.0 * part * of_mm * range_mm
    };
    POSITIONS.iter().find(is_position).map(|(_, _, unit)| *unit)
}
