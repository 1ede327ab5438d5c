//! Squareness and location of the axes.

use serde::Serialize;
use serde_json::Value;

use trueaxis_files::decimals;

use crate::calibration::Calibration;
use crate::numbers::{expanded, fixed, signed};
use crate::words;

/// A location error as people read it.
#[derive(Serialize)]
pub(crate) struct Location {
    name: String,
    words: String,
    value: String,
    expanded: String,
    unit: &'static str,
    /// `by definition of the frame`, or `*` if it is relative to the nests of the targets.
    note: &'static str,
}

/// A location error in numbers.
pub(crate) struct Measured {
    /// µm or arcsec.
    pub(crate) value: f64,
    pub(crate) expanded: f64,
    pub(crate) is_angular: bool,
    /// It is that of the nests of the targets as well as of the axis.
    pub(crate) of_targets: bool,
}

impl Measured {
    pub(crate) fn of(error: &Value) -> Option<Self> {
        let number = |field: &str| error.get(field).and_then(Value::as_f64);
        let (is_angular, [value, u]) = match number("value_arcsec") {
            Some(value) => (true, [value, number("u_arcsec")?]),
            None => (false, [1e3 * number("value_mm")?, 1e3 * number("u_mm")?]),
        };
        Some(Self {
            value,
            expanded: expanded(u, number("dof")),
            is_angular,
            of_targets: error.get("relative_to").is_some(),
        })
    }

    pub(crate) fn is_defined(&self) -> bool {
        self.value.abs() < f64::MIN_POSITIVE && self.expanded < f64::MIN_POSITIVE
    }
}

pub(crate) fn locations(calibration: &Calibration) -> Vec<Location> {
    let errors = calibration.location_errors.iter();
    let shown = errors.filter_map(|(name, error)| {
        let words = words::location(name, &calibration.machine);
        location(name.clone(), words, error)
    });
    shown.chain(relative(calibration)).collect()
}

/// Where rotary axes lie relative to each other.
fn relative(calibration: &Calibration) -> impl Iterator<Item = Location> {
    let pairs = calibration.relative_locations.iter();
    pairs.flat_map(|pair| {
        let name = format!("{} to {}", pair.axis, pair.to);
        let along = direction(pair.direction);
        [
            location(name.clone(), format!("offset along {along}"), &pair.offset),
            location(name, format!("angle about {along}"), &pair.angle),
        ]
        .into_iter()
        .flatten()
    })
}

/// `Y`, or the coordinates of a direction that is none of the frame's.
fn direction(direction: [f64; 3]) -> String {
    const PRINCIPAL: f64 = 1.0 - 1e-8;
    match direction.iter().position(|x| *x > PRINCIPAL) {
        Some(k) => ["X", "Y", "Z"][k].to_owned(),
        None => direction.map(|x| fixed(x, 3)).join(" "),
    }
}

fn location(name: String, words: String, error: &Value) -> Option<Location> {
    let measured = Measured::of(error)?;
    let digits = decimals(measured.expanded).min(2);
    let (value, expanded) = match measured.is_defined() {
        true => ("0".to_owned(), "–".to_owned()),
        false => (
            signed(measured.value, digits),
            fixed(measured.expanded, digits),
        ),
    };
    Some(Location {
        words,
        name,
        value,
        expanded,
        unit: if measured.is_angular { "″" } else { " µm" },
        note: match (measured.is_defined(), measured.of_targets) {
            (true, _) => "by definition of the frame",
            (false, true) => "*",
            (false, false) => "",
        },
    })
}
