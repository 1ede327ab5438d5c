//! Units of an export.

use trueaxis_files::Alternatives;

/// A unit that an export may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// What is measured in it.
    pub(crate) quantity: Quantity,
    /// Of the table's unit (mm, degrees, s) in one of this.
    pub(crate) size: f64,
}

/// What a unit measures, with its unit in the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// mm.
    Length,
    /// Degrees.
    Angle,
    /// s.
    Time,
    /// A time of day as 10:21:33.
    Clock,
}

/// All units by their names; those of one line are the same.
const UNITS: &[(&[&str], Quantity, f64)] = &[
    (&["mm"], Quantity::Length, 1.0),
    (&["um", "µm", "μm"], Quantity::Length, 1e-3),
    (&["cm"], Quantity::Length, 10.0),
    (&["m"], Quantity::Length, 1e3),
    (&["in", "inch", "inches"], Quantity::Length, 25.4),
    (&["ft"], Quantity::Length, 304.8),
    (&["deg", "°", "degrees"], Quantity::Angle, 1.0),
    (&["rad"], Quantity::Angle, 180.0 / std::f64::consts::PI),
    (&["mrad"], Quantity::Angle, 0.18 / std::f64::consts::PI),
    (&["arcmin"], Quantity::Angle, 1.0 / 60.0),
    (&["arcsec"], Quantity::Angle, 1.0 / 3600.0),
    (&["s"], Quantity::Time, 1.0),
    (&["ms"], Quantity::Time, 1e-3),
    (&["min"], Quantity::Time, 60.0),
    (&["h"], Quantity::Time, 3600.0),
    (&["clock"], Quantity::Clock, 1.0),
];

/// Decimals of the table for lengths, angles and times: below what any instrument resolves, and enough that nothing
/// is lost of six decimals of an inch.
const DECIMALS: i32 = 7;

impl Unit {
    /// The unit of that name among those of `quantities`.
    pub(crate) fn named(name: &str, quantities: &[Quantity]) -> Result<Self, Alternatives> {
        let fitting = || UNITS.iter().filter(|unit| quantities.contains(&unit.1));
        let unit = fitting().find(|(names, ..)| names.contains(&name));
        unit.map(|&(_, quantity, size)| Self { quantity, size })
            .ok_or_else(|| Alternatives {
                known: fitting().map(|(names, ..)| names[0].to_owned()).collect(),
                ..Alternatives::new(name, fitting().flat_map(|(names, ..)| names.iter()))
            })
    }

    pub(crate) fn convert(self, value: f64) -> f64 {
        trueaxis_files::round(value * self.size, DECIMALS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inch_is_25_4_mm() {
        let unit = Unit::named("in", &[Quantity::Length]).unwrap();
        assert_eq!(unit.convert(1.2345).to_string(), "31.3563");
        let half_turn = Unit::named("rad", &[Quantity::Angle]).unwrap();
        assert_eq!(half_turn.convert(std::f64::consts::PI).to_string(), "180");
        let unknown = Unit::named("inc", &[Quantity::Length]).unwrap_err();
        assert_eq!(unknown.nearest.as_deref(), Some("in"));
        assert_eq!(unknown.known, ["mm", "um", "cm", "m", "in", "ft"]);
        assert!(Unit::named("deg", &[Quantity::Length]).is_err());
    }
}
