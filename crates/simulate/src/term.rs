//! The terms of an error curve.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueaxis_kinematics::AxisKind;

use crate::Error;
use crate::check;

/// One term of an error curve; a curve is the sum of its terms.
///
/// Values are µm for translations and arcsec for rotations, positions q are mm or deg.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum Term {
    /// `c0 + c1 s + c2 s² + ...`, where s runs from -1 to 1 over the travel of the axis.
    Polynomial {
        /// `c0, c1, ...`.
        coefficients: Vec<f64>,
    },
    /// `amplitude · sin(2π q / period + phase)`.
    Sine {
        /// Amplitude.
        amplitude: f64,
        /// Period of a linear axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        period_mm: Option<f64>,
        /// Period of a rotary axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        period_deg: Option<f64>,
        /// Phase at q = 0.
        #[serde(default)]
        phase_deg: f64,
    },
    /// Straight lines between the entries; before the first and after the last their values.
    Table {
        /// Positions, increasing, mm or deg.
        positions: Vec<f64>,
        /// Value at each position.
        values: Vec<f64>,
    },
}

impl Term {
    /// Refuses what has no value everywhere: `field` is the term's path in the scenario.
    pub(crate) fn check(&self, field: &str, kind: AxisKind) -> Result<(), Error> {
        match self {
            Self::Polynomial { coefficients } => {
                check::finite(&format!("{field}.coefficients"), coefficients)
            }
            Self::Sine {
                amplitude,
                period_mm,
                period_deg,
                phase_deg,
            } => {
                check::finite(field, &[*amplitude, *phase_deg])?;
                let (name, own, other) = match kind {
                    AxisKind::Linear => ("period_mm", period_mm, period_deg),
                    AxisKind::Rotary => ("period_deg", period_deg, period_mm),
                };
                match (own, other) {
                    (Some(period), None) => check::positive(&format!("{field}.{name}"), *period),
                    _ => {
                        let expected = format!("`{name}` alone for a {} axis", kind.name());
                        Err(check::expected(field, expected))
                    }
                }
            }
            Self::Table { positions, values } => {
                let places = ("positions", &positions[..]);
                check::table(field, "positions", places, ("values", values))
            }
        }
    }

    /// Value at the position `q` of an axis with the given travel, all mm or deg.
    pub(crate) fn value(&self, q: f64, travel: [f64; 2]) -> f64 {
        match self {
            Self::Polynomial { coefficients } => {
                let s = normalised(q, travel);
                coefficients.iter().rev().fold(0.0, |sum, c| sum * s + c)
            }
            Self::Sine {
                amplitude,
                period_mm,
                period_deg,
                phase_deg,
            } => {
                let period = period_mm.or(*period_deg).unwrap_or(f64::INFINITY);
                amplitude * (TAU * q / period + phase_deg.to_radians()).sin()
            }
            Self::Table { positions, values } => interpolate(positions, values, q),
        }
    }
}

/// Position in the travel: -1 at its low end, 1 at its high end.
fn normalised(q: f64, [low, high]: [f64; 2]) -> f64 {
    if high > low {
        (2.0 * q - low - high) / (high - low)
    } else {
        0.0
    }
}

/// Linear interpolation between rising positions; the end values are held outside.
pub(crate) fn interpolate(positions: &[f64], values: &[f64], q: f64) -> f64 {
    let behind = positions.partition_point(|position| *position < q);
    let at = |k: usize| Some((*positions.get(k)?, *values.get(k)?));
    match (behind.checked_sub(1).and_then(at), at(behind)) {
        (Some((p, v)), Some((position, value))) => v + (value - v) * (q - p) / (position - p),
        (Some((_, value)), None) | (None, Some((_, value))) => value,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRAVEL: [f64; 2] = [100.0, 500.0];

    #[test]
    fn table_interpolates_and_holds_its_ends() {
        let term = Term::Table {
            positions: vec![0.0, 10.0, 30.0],
            values: vec![1.0, 3.0, -1.0],
        };
        let cases = [
            (-5.0, 1.0),
            (0.0, 1.0),
            (5.0, 2.0),
            (10.0, 3.0),
            (25.0, 0.0),
            (30.0, -1.0),
            (99.0, -1.0),
        ];
        for (q, expected) in cases {
            assert!((term.value(q, TRAVEL) - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn a_period_has_the_unit_of_its_axis() {
        let term = Term::Sine {
            amplitude: 2.0,
            period_mm: Some(40.0),
            period_deg: None,
            phase_deg: 0.0,
        };
        assert!(term.check("term", AxisKind::Linear).is_ok());
        let refused = term.check("term", AxisKind::Rotary).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "field term: expected `period_deg` alone for a rotary axis"
        );
    }

    #[test]
    fn a_table_needs_a_value_for_each_position() {
        let term = Term::Table {
            positions: vec![0.0, 10.0],
            values: vec![1.0],
        };
        assert!(term.check("term", AxisKind::Linear).is_err());
    }
}
