//! How people are told what files hold: symbols of units, units of long times, spans of rates, decimals of positions.

const DAY_S: f64 = 86_400.0;

const YEAR_S: f64 = 365.25 * DAY_S;

/// How many of a larger unit there must be before it is used.
const LEAST: f64 = 2.0;

/// The unit in which a value is told, and how many of the given unit it has: long times are told in days or years.
///
/// ```
/// use trueaxis_files::told_unit;
///
/// assert_eq!(told_unit(5210.0, "s"), ("s", 1.0));
/// assert_eq!(told_unit(864_000.0, "s"), ("days", 86_400.0));
/// assert_eq!(told_unit(864_000.0, "mm"), ("mm", 1.0));
/// ```
pub fn told_unit(value: f64, unit: &str) -> (&str, f64) {
    match value.abs() {
        s if unit == "s" && s >= LEAST * YEAR_S => ("years", YEAR_S),
        s if unit == "s" && s >= LEAST * DAY_S => ("days", DAY_S),
        _ => (unit, 1.0),
    }
}

/// A unit of the files as people write it.
///
/// ```
/// assert_eq!(trueaxis_files::unit_symbol("um/m2"), "µm/m²");
/// ```
pub fn unit_symbol(unit: &str) -> &str {
    match unit {
        "um" => "µm",
        "arcsec" => "″",
        "deg" => "°",
        "um/m" => "µm/m",
        "um/m2" => "µm/m²",
        "um/rad2" => "µm/rad²",
        "arcsec/rad" => "″/rad",
        "um/K" => "µm/K",
        "readings/1000" => "‰ of the time between two readings",
        other => other,
    }
}

/// The symbol of a unit as it stands behind a value: `″`, but `µm` with a space before it.
pub fn told_behind(unit: &str, space: char) -> String {
    match unit_symbol(unit) {
        glued @ ("″" | "°" | "") => glued.to_owned(),
        apart => format!("{space}{apart}"),
    }
}

/// A period in the unit in which it is told: whole seconds, tenths of days and years.
///
/// ```
/// use trueaxis_files::told_period;
///
/// assert_eq!(told_period(5210.4, "s"), "5210 s");
/// assert_eq!(told_period(207_360.0, "s"), "2.4 days");
/// ```
pub fn told_period(value: f64, unit: &str) -> String {
    let (unit, size) = told_unit(value, unit);
    let decimals = usize::from(size > 1.0);
    format!("{:.decimals$} {unit}", value / size)
}

/// The words that follow the value of a rate (` over an occupation`); empty for any other parameter.
#[must_use]
pub fn told_span(parameter: &str) -> &'static str {
    match parameter {
        "rate" => " over the readings",
        name if name.starts_with("rate_") => " over an occupation",
        _ => "",
    }
}

/// Decimals that tell positions from each other, mm: one of a machine, more of a short travel.
#[must_use]
pub fn told_places(positions: impl Iterator<Item = f64> + Clone) -> usize {
    let first = positions.clone().fold(f64::INFINITY, f64::min);
    let last = positions.fold(f64::NEG_INFINITY, f64::max);
    match last - first {
        travel if travel < TINY_TRAVEL_MM => 4,
        travel if travel < SHORT_TRAVEL_MM => 2,
        _ => 1,
    }
}

/// Of which one decimal would say little, and of which two would.
const SHORT_TRAVEL_MM: f64 = 20.0;
const TINY_TRAVEL_MM: f64 = 1.0;
