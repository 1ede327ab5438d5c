//! Logged air and machine states that no workshop has.
//!
//! A state outside the ranges below is an error in its row: a sensor that failed, a decimal point that was lost, or another unit.
//! The ranges are wide, so that what is refused cannot be right anywhere a machine is measured.

use crate::{LoggedColumn, LoggedQuantity, Problem};

/// What a quantity can be, and what it is like in a workshop.
struct Range {
    quantity: &'static str,
    unit: &'static str,
    possible: [f64; 2],
    usual: [f64; 2],
    others: &'static [OtherUnit],
}

/// Another unit: its name with what to do with the values, its zero and its factor; `(value - zero) factor` is in the
/// unit of the format.
type OtherUnit = (&'static str, f64, f64);

const TEMPERATURES: [OtherUnit; 2] = [
    ("kelvin: subtract 273.15", 273.15, 1.0),
    ("Fahrenheit: subtract 32, divide by 1.8", 32.0, 1.0 / 1.8),
];

const PRESSURES: [OtherUnit; 4] = [
    ("Pa: divide by 100", 0.0, 0.01),
    ("kPa: multiply by 10", 0.0, 10.0),
    ("bar: multiply by 1000", 0.0, 1000.0),
    ("inches of mercury: multiply by 33.8639", 0.0, 33.8639),
];

impl LoggedQuantity {
    fn range(self) -> Range {
        let temperature = |possible| Range {
            quantity: "a temperature",
            unit: "deg C",
            possible,
            usual: [10.0, 40.0],
            others: &TEMPERATURES,
        };
        match self {
            Self::AirTemperature => temperature([-40.0, 60.0]),
            // A spindle's bearing is hotter than any workshop.
            Self::MachineTemperature => temperature([-40.0, 150.0]),
            // From the highest towns to the highest reading at sea level.
            Self::AirPressure => Range {
                quantity: "a pressure",
                unit: "hPa",
                possible: [500.0, 1100.0],
                usual: [850.0, 1060.0],
                others: &PRESSURES,
            },
            Self::AirHumidity => Range {
                quantity: "a relative humidity",
                unit: "%",
                // Sensors show somewhat more where the air is saturated.
                possible: [0.0, 105.0],
                usual: [10.0, 90.0],
                others: &[],
            },
        }
    }

    /// Refuses a value that no workshop has.
    pub(crate) fn check(self, value: f64) -> Result<(), Problem> {
        let range = self.range();
        let within = |[low, high]: [f64; 2], value: f64| (low..=high).contains(&value);
        if within(range.possible, value) {
            return Ok(());
        }
        let unit = range.unit;
        let [low, high] = range.possible;
        let is_usual =
            |&&(_, zero, factor): &&OtherUnit| within(range.usual, (value - zero) * factor);
        let looks_like = range.others.iter().find(is_usual);
        let shifted = [10.0, 100.0, 1000.0].map(|factor| value / factor);
        let lost_point = shifted.into_iter().find(|&v| within(range.usual, v));
        let hint = match (looks_like, lost_point) {
            (Some((other, ..)), _) => format!("it looks like {other}"),
            (None, Some(value)) => format!("is the decimal point missing, as in {value}?"),
            (None, None) => "leave the cell empty if nothing was measured".to_owned(),
        };
        Err(Problem::value(
            format!("{} of {value} {unit}", range.quantity),
            format!("{low} to {high} {unit}; {hint}"),
        ))
    }
}

/// Notices on columns that say nothing, or say it in another unit.
pub(crate) fn notices(file_name: &str, logged: &[LoggedColumn]) -> Vec<String> {
    let notices = logged.iter().filter_map(|column| {
        let name = &column.name;
        let values = || column.values.iter().flatten();
        let is_humidity = column.quantity() == Some(LoggedQuantity::AirHumidity);
        if values().next().is_none() {
            Some(format!(
                "{file_name}, column {name}: every cell is empty; remove the column, or correct what \
                 wrote it"
            ))
        } else if is_humidity && values().all(|&v| v <= 1.0) && values().any(|&v| v > 0.0) {
            Some(format!(
                "{file_name}, column {name}: no value is above 1, expected %; the values look like \
                 parts of one: multiply them by 100"
            ))
        } else {
            None
        }
    });
    notices.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(quantity: LoggedQuantity, value: f64) -> Option<String> {
        quantity
            .check(value)
            .err()
            .map(|problem| problem.to_string())
    }

    #[test]
    fn what_a_hall_has_is_accepted() {
        for (quantity, values) in [
            (LoggedQuantity::AirTemperature, [-5.0, 20.0, 38.0]),
            (LoggedQuantity::MachineTemperature, [0.0, 20.0, 95.0]),
            (LoggedQuantity::AirPressure, [640.0, 1013.25, 1060.0]),
            (LoggedQuantity::AirHumidity, [0.0, 45.0, 100.0]),
        ] {
            for value in values {
                assert_eq!(refusal(quantity, value), None);
            }
        }
    }

    #[test]
    fn what_no_hall_has_is_refused_with_what_it_looks_like() {
        for (quantity, value, says) in [
            (
                LoggedQuantity::MachineTemperature,
                2930.0,
                "a temperature of 2930 deg C; expected -40 to 150 deg C; is the decimal point missing, \
                 as in 29.3?",
            ),
            (LoggedQuantity::MachineTemperature, 293.15, "kelvin"),
            (LoggedQuantity::AirTemperature, 68.0, "Fahrenheit"),
            (
                LoggedQuantity::AirTemperature,
                -999.0,
                "leave the cell empty",
            ),
            (LoggedQuantity::AirTemperature, 215.0, "as in 21.5?"),
            (LoggedQuantity::AirPressure, 101_325.0, "Pa: divide by 100"),
            (LoggedQuantity::AirPressure, 101.325, "kPa: multiply by 10"),
            (LoggedQuantity::AirPressure, 1.013, "bar: multiply by 1000"),
            (LoggedQuantity::AirPressure, 29.92, "inches of mercury"),
            (LoggedQuantity::AirHumidity, 455.0, "as in 45.5?"),
            (LoggedQuantity::AirHumidity, -1.0, "expected 0 to 105 %"),
        ] {
            let refusal = refusal(quantity, value).unwrap();
            assert!(refusal.contains(says), "{value}: {refusal}");
        }
    }
}
