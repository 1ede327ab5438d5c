//! The scale of the laser that reads a line.
//!
//! An axis that grows by `α τ q` and a wavelength that drifts by as much, since the air or the material sensor does, read
//! the same. The catalogue has that drift among lengths, where stations and axes tell the two apart. Nor have several axes
//! equal scale errors by chance.

use trueaxis_effects::{ResolvedEffect, Subject, effect};
use trueaxis_selection::Hypothesis;

use crate::Rival;
use crate::numbers::distinct;
use crate::said::Entry;
use crate::verification::comparison::Comparison;
use crate::verification::series::Series;

/// Most that air, or a sensor for the temperature of the material, takes a laser's scale wrong by, ppm: some kelvin of steel.
const MOST_PPM: f64 = 50.0;

/// The drift of the laser's scale that reads like the growth of a linear axis with these values.
pub(crate) fn instead(
    comparison: &Comparison<'_>,
    hypothesis: &Hypothesis,
    (parameters, delta_bic): (&[f64], f64),
) -> Option<Rival> {
    let axis = comparison.line()?;
    let is_linear = !comparison.is_of_rotary_axis();
    let grows = hypothesis.effect.grows_axis() && hypothesis.subject.axis == Some(axis);
    let effect = effect("refraction_drift").filter(|_| is_linear && grows)?;
    if parameters.iter().any(|ppm| ppm.abs() > MOST_PPM) {
        return None;
    }
    Some(Rival::Effect {
        effect: ResolvedEffect {
            effect,
            subject: Subject::default(),
            parameters: parameters.to_vec(),
            shape: 0.0,
        },
        delta_bic,
    })
}

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
