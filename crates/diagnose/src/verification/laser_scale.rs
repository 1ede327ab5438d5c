//! The scale of the laser that reads a line.
//!
//! An axis that grows by `α τ q` and a wavelength that drifts by as much, since the air or the material sensor does, read
//! the same. The catalogue has that drift among lengths, where stations and axes tell the two apart.

use trueaxis_effects::{ResolvedEffect, Subject, effect};
use trueaxis_selection::Hypothesis;

use crate::Rival;
use crate::verification::comparison::Comparison;

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
