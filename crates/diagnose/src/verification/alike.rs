//! Equal scale errors of several axes.

use crate::numbers::distinct;
use crate::said::Entry;
use crate::verification::series::Series;

/// Two sizes are equal up to a difference of this many standard uncertainties; a size is clear from this many on.
const COVERAGE: f64 = 2.0;
const CLEAR: f64 = 5.0;

/// The notice that all lines of two or more linear axes have equal scales: the instrument may be off instead.
pub(crate) fn alike_scales(entries: &[Entry], all: &[Series<'_>]) -> Option<String> {
    let mut axes: Vec<usize> = Vec::new();
    let mut sizes: Vec<(f64, f64)> = Vec::new();
    for (entry, series) in entries.iter().zip(all) {
        let comparison = series.plain.comparison;
        let line = comparison.line();
        let Some(axis) = line.filter(|_| !comparison.is_of_rotary_axis()) else {
            continue;
        };
        let mut causes = entry.causes.iter();
        let scale = causes.find(|cause| cause.effect.effect.is_scale_of_axis())?;
        let scale = scale.parameters.first()?;
        axes.push(axis);
        sizes.push((scale.value, scale.u));
    }
    let axes = distinct(axes);
    let are_alike = |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0).abs() <= COVERAGE * a.1.hypot(b.1);
    let all_alike = sizes.iter().all(|a| sizes.iter().all(|b| are_alike(a, b)));
    let are_clear = sizes.iter().all(|(size, u)| size.abs() > CLEAR * u);
    if axes.len() < 2 || !all_alike || !are_clear {
        return None;
    }
    let weights: f64 = sizes.iter().map(|(_, u)| u.powi(-2)).sum();
    let sum: f64 = sizes.iter().map(|(size, u)| size * u.powi(-2)).sum();
    Some(format!(
        "the scales of {} axes are off by the same {:+.1} ppm: first check the instrument that measured them (its wavelength, the air, \
         the temperature of the material that was entered)",
        axes.len(),
        sum / weights
    ))
}
