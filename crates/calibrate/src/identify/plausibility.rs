//! Converged results that are no calibration.

use trueaxis_kinematics::MotionError;
use trueaxis_mistakes::displaced_once;
use trueaxis_poses::{AdjustmentReport, step_in_words};

use crate::Error;
use crate::identify::context::Context;
use crate::identify::identify_axes::Identified;

/// Component errors beyond these are not errors but another motion: wrong unit, sign or axis.
const IMPLAUSIBLE_MM: f64 = 50.0;
const IMPLAUSIBLE_RAD: f64 = 0.1;

/// Refuses axes that did not move as commanded.
pub(crate) fn check_motion(context: &Context<'_>, identified: &Identified) -> Result<(), Error> {
    for (k, values) in identified.state.axes.iter().enumerate() {
        let data = &context.data[k];
        let size = |e: &MotionError| {
            let mm = e.translation_mm.amax() / IMPLAUSIBLE_MM;
            mm.max(e.rotation_rad.amax() / IMPLAUSIBLE_RAD)
        };
        let nodes = values.curve.iter().zip(&data.poses_of);
        let worst = nodes.max_by(|(a, _), (b, _)| size(a).total_cmp(&size(b)));
        if let Some((error, poses)) = worst.filter(|(error, _)| size(error) > 1.0) {
            let worst = &data.poses[poses[0]];
            let run = data.runs[worst.run].run;
            if let Some(displaced) = displaced_once(context.campaign, context.poses, run) {
                return Err(displaced.into());
            }
            let step = context.poses.observations[worst.index].step;
            return Err(Error::NotThatMotion {
                axis: context.axis(k).name().to_owned(),
                step: step_in_words(context.campaign, step),
                translation_mm: error.translation_mm.amax(),
                rotation_deg: error.rotation_rad.amax().to_degrees(),
            });
        }
    }
    Ok(())
}

/// Refuses a measurement that neither declares its noise nor shows it.
pub(crate) fn check_noise(adjustment: &AdjustmentReport) -> Result<(), Error> {
    if adjustment.degrees_of_freedom == 0 && !adjustment.noise_declared {
        let open = trueaxis_poses::Error::not_identifiable(
            "the noise is not declared and nothing checks the measurement, so that no uncertainty can be given",
            "declare `length_sigma_um` (or `sigma_um` of the points), or measure more",
        );
        return Err(open.into());
    }
    Ok(())
}
