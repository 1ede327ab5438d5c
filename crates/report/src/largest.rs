//! The errors that matter most.
//!
//! Displacements and angles become comparable as displacements: an angle about x acts on half the diagonal of the travels of the linear
//! axes along y and z, and so on (where there are none on the distance of the farthest target from the origin); squareness on the travel
//! of its axis.

use serde::Serialize;

use trueaxis_files::decimals;

use crate::calibration::{Calibration, Curve, Kind};
use crate::locations::Measured;
use crate::numbers::{expanded, fixed, with_u};
use crate::words;

/// An error with what it does.
#[derive(Serialize)]
pub(crate) struct Largest {
    name: String,
    words: String,
    /// Largest amount with its U, `+14.5 ± 1.4 µm`.
    value: String,
    /// What that makes at the lever, µm.
    displacement_um: f64,
    shown_um: String,
}

/// How many are shown.
const MOST: usize = 3;

const ARCSEC: f64 = std::f64::consts::PI / 180.0 / 3600.0;

pub(crate) fn largest(calibration: &Calibration) -> Vec<Largest> {
    let levers_um = [0, 1, 2].map(|about| 1e3 * lever_mm(calibration, about));
    // Of `EAX`, of `A0C`.
    let lever_um = |letter: Option<char>| match letter {
        Some('A') => levers_um[0],
        Some('B') => levers_um[1],
        _ => levers_um[2],
    };
    let curves = calibration.axes.iter().flat_map(|axis| {
        let curves = axis.components.iter();
        curves.filter_map(move |(name, curve)| {
            let (value, u) = largest_of(curve)?;
            let expanded = expanded(u, curve.dof);
            let words = words::component(name, &axis.name, &calibration.machine);
            let lever = curve.is_angular().then(|| lever_um(name.chars().nth(1)));
            Some(entry(name, words, [value, expanded], lever))
        })
    });
    let locations = calibration
        .location_errors
        .iter()
        .filter_map(|(name, error)| {
            let measured = Measured::of(error).filter(|measured| !measured.of_targets)?;
            let words = words::location(name, &calibration.machine);
            let lever = measured.is_angular.then(|| {
                stroke_um(name, calibration).unwrap_or_else(|| lever_um(name.chars().next()))
            });
            Some(entry(
                name,
                words,
                [measured.value, measured.expanded],
                lever,
            ))
        });
    let mut all: Vec<Largest> = curves.chain(locations).collect();
    all.retain(|error| error.displacement_um > 0.0 && error.displacement_um.is_finite());
    all.sort_by(|a, b| b.displacement_um.total_cmp(&a.displacement_um));
    all.truncate(MOST);
    all
}

fn entry(name: &str, words: String, [value, expanded]: [f64; 2], lever_um: Option<f64>) -> Largest {
    let unit = if lever_um.is_some() { "″" } else { " µm" };
    let digits = decimals(expanded).min(2);
    let displacement_um = lever_um.map_or(1.0, |lever| lever * ARCSEC) * value.abs();
    Largest {
        name: name.to_owned(),
        words,
        value: with_u(value, expanded, digits) + unit,
        displacement_um,
        shown_um: fixed(displacement_um, if displacement_um < 9.95 { 1 } else { 0 }),
    }
}

/// The value with the largest amount, and its u.
fn largest_of(curve: &Curve) -> Option<(f64, f64)> {
    let values = curve.values().iter().zip(curve.u());
    let finite = values.filter(|(value, _)| value.is_finite());
    finite
        .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
        .map(|(value, u)| (*value, *u))
}

/// The lever of an angle about x, y or z (0, 1, 2).
fn lever_mm(calibration: &Calibration, about: usize) -> f64 {
    let axes = calibration.machine.axes.iter();
    let linear = axes.filter(|axis| axis.kind == Kind::Linear);
    let travelled = linear.filter_map(|axis| Some((axis.direction, axis.travel?)));
    let extent_mm = |along: usize| -> f64 {
        let parts = travelled.clone();
        parts
            .map(|(d, [low, high])| d[along].abs() * (high - low))
            .sum()
    };
    let across = (0..3).filter(|along| *along != about);
    let diagonal = across
        .map(|along| extent_mm(along).powi(2))
        .sum::<f64>()
        .sqrt();
    if diagonal > 0.0 {
        return 0.5 * diagonal;
    }
    let far = calibration.targets.iter().map(|target| {
        let [x, y, z] = target.position_mm;
        (x * x + y * y + z * z).sqrt()
    });
    far.fold(0.0, f64::max)
}

/// The travel of the axis whose squareness `name` is.
fn stroke_um(name: &str, calibration: &Calibration) -> Option<f64> {
    let (_, axis) = name.split_once('0')?;
    let mut axes = calibration.machine.axes.iter();
    let axis = axes.find(|nominal| nominal.name == axis && nominal.kind == Kind::Linear)?;
    axis.travel.map(|[low, high]| 1e3 * (high - low))
}
