//! What is no calibration although everything converged.

use trueaxis_poses::AdjustmentReport;

use crate::Error;
use crate::identify::context::Context;
use crate::identify::identify_axes::Identified;

/// Component errors beyond these are no errors but another motion: wrong unit, sign or axis.
const IMPLAUSIBLE_MM: f64 = 50.0;
const IMPLAUSIBLE_RAD: f64 = 0.1;

/// Refuses axes that moved otherwise than commanded.
pub(crate) fn check_motion(context: &Context<'_>, identified: &Identified) -> Result<(), Error> {
    for (k, values) in identified.state.axes.iter().enumerate() {
        let translations_mm = values.curve.iter().map(|e| e.translation_mm.amax());
        let rotations_rad = values.curve.iter().map(|e| e.rotation_rad.amax());
        let translation_mm = translations_mm.fold(0.0, f64::max);
        let rotation_rad = rotations_rad.fold(0.0, f64::max);
        if translation_mm > IMPLAUSIBLE_MM || rotation_rad > IMPLAUSIBLE_RAD {
            return Err(Error::NotThatMotion {
                axis: context.axis(k).name().to_owned(),
                translation_mm,
                rotation_deg: rotation_rad.to_degrees(),
            });
        }
    }
    Ok(())
}

/// Refuses a measurement that neither declares its noise nor shows it.
pub(crate) fn check_noise(adjustment: &AdjustmentReport) -> Result<(), Error> {
    if adjustment.degrees_of_freedom == 0 && !adjustment.noise_declared {
        return Err(Error::NotIdentifiable {
            what: "the noise is not declared and nothing checks the measurement, so that no \
                   uncertainty can be given"
                .to_owned(),
            hint: "declare `length_sigma_um` (or `sigma_um` of the points), or measure more"
                .to_owned(),
        });
    }
    Ok(())
}
