//! What the best compensation leaves over the working volume.

use nalgebra::Vector6;
use trueaxis_kinematics::MotionError;
use trueaxis_predict::{CalibratedMachine, Places};

use crate::{Error, Moved, Sizes, correct};

/// Places that are evaluated: statistics do not gain from more.
const MOST_PLACES: usize = 1000;

/// What stays of the errors as calibrated when every command is corrected.
#[derive(Debug, Clone, PartialEq)]
pub struct Remains {
    /// Number of places.
    pub places: usize,
    /// With the linear axes alone corrected.
    pub linear: Sizes,
    /// With all axes corrected.
    pub all: Sizes,
    /// What the calibration does not know of the displacement, and no compensation takes away: rms and largest of
    /// `√trace` of the covariance, mm (k = 1); NaN if the calibration has no uncertainties.
    pub u_rms_mm: f64,
    /// See above.
    pub u_max_mm: f64,
}

/// What stays at (at most a thousand of) the places, and how well it is known.
///
/// # Errors
/// [`Error::NotContracting`] at a place without corrected positions.
pub fn remains(machine: &CalibratedMachine, places: &Places) -> Result<Remains, Error> {
    let chosen = places.some(MOST_PLACES);
    let chosen: Vec<_> = chosen
        .map(|number| (places.at(number), places.tool_home_mm))
        .collect();
    let at_home = vec![0.0; machine.machine().axes().len()];
    let left = |moved| -> Result<Sizes, Error> {
        let left_at = |commanded: &[f64]| -> Result<MotionError, Error> {
            let tool_mm = places.tool_home_mm;
            Ok(correct(machine.machine(), machine, commanded, tool_mm, moved)?.left)
        };
        // A displacement that is there at home is that of the workpiece's zero.
        let home_mm = left_at(&at_home)?.translation_mm;
        let found = chosen.iter().map(|(commanded, _)| {
            let left = left_at(commanded)?;
            Ok(MotionError::new(left.translation_mm - home_mm, left.rotation_rad).to_vector())
        });
        Ok(Sizes::of(&found.collect::<Result<Vec<_>, Error>>()?))
    };
    let predictions = machine.predict_all(&chosen);
    let u = predictions.iter().map(|prediction| {
        let u = prediction.u();
        Vector6::new(u[0], u[1], u[2], 0.0, 0.0, 0.0)
    });
    let mut u = Sizes::of(&u.collect::<Vec<_>>());
    if !machine.has_uncertainties {
        // Which the largest of many would hide.
        (u.rms_mm, u.max_mm) = (f64::NAN, f64::NAN);
    }
    Ok(Remains {
        places: chosen.len(),
        linear: left(Moved::Linear)?,
        all: left(Moved::All)?,
        u_rms_mm: u.rms_mm,
        u_max_mm: u.max_mm,
    })
}
