//! The errors that matter most.
//!
//! Displacements and angles become comparable as displacements: an angle acts on a lever, half the diagonal of the
//! travels of the linear axes (without linear axes the distance of the farthest target from the origin);
//! squareness on the travel of its axis.

use serde::Serialize;

use crate::calibration::{Calibration, Curve, Kind};
use crate::locations::Measured;
use crate::numbers::{decimals, expanded, fixed, signed};
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
    let lever_um = 1e3 * lever_mm(calibration);
    let curves = calibration.axes.iter().flat_map(|axis| {
        let curves = axis.components.iter();
        curves.filter_map(move |(name, curve)| {
            let (value, u) = largest_of(curve)?;
            let expanded = expanded(u, curve.dof);
            let words = words::component(name, &axis.name, &calibration.machine);
            let lever = curve.is_angular().then_some(lever_um);
            Some(entry(name, words, [value, expanded], lever))
        })
    });
    let locations = calibration
        .location_errors
        .iter()
        .filter_map(|(name, error)| {
            let measured = Measured::of(error).filter(|measured| !measured.of_targets)?;
            let words = words::location(name, &calibration.machine);
            let lever = measured
                .is_angular
                .then(|| stroke_um(name, calibration).unwrap_or(lever_um));
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
        value: format!(
            "{} ± {}{unit}",
            signed(value, digits),
            fixed(expanded, digits)
        ),
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

pub(crate) fn lever_mm(calibration: &Calibration) -> f64 {
    let axes = calibration.machine.axes.iter();
    let linear = axes.filter(|axis| axis.kind == Kind::Linear);
    let strokes: Vec<f64> = linear
        .filter_map(|axis| axis.travel)
        .map(|[low, high]| high - low)
        .collect();
    if !strokes.is_empty() {
        return 0.5 * strokes.iter().map(|s| s * s).sum::<f64>().sqrt();
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
