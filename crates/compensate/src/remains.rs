//! What the best compensation leaves over the working volume.

use nalgebra::Vector6;
use trueaxis_kinematics::MotionError;
use trueaxis_predict::{CalibratedMachine, Places};

use crate::{Error, Moved, correct};

/// Places that are evaluated: statistics do not gain from more.
const MOST_PLACES: usize = 1000;

/// What stays when every command is corrected.
#[derive(Debug, Clone, PartialEq)]
pub struct Remains {
    /// Number of places.
    pub places: usize,
    /// With the linear axes alone corrected.
    pub linear: Left,
    /// With all axes corrected.
    pub all: Left,
    /// What the calibration does not know of the displacement, and no compensation takes away: rms and largest of
    /// `√trace` of the covariance, mm (k = 1); NaN if the calibration has no uncertainties.
    pub u_rms_mm: f64,
    /// See above.
    pub u_max_mm: f64,
}

/// Of the errors as calibrated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Left {
    /// Displacement of the tool point, less that at home, mm.
    pub rms_mm: f64,
    /// Its largest, mm.
    pub max_mm: f64,
    /// Rotation of the tool, rad.
    pub rotation_rms_rad: f64,
    /// Its largest, rad.
    pub rotation_max_rad: f64,
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
    let left = |moved| -> Result<Left, Error> {
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
        Ok(Left::of(&found.collect::<Result<Vec<_>, Error>>()?))
    };
    let predictions = machine.predict_all(&chosen);
    let u = predictions.iter().map(|prediction| {
        let u = prediction.u();
        Vector6::new(u[0], u[1], u[2], 0.0, 0.0, 0.0)
    });
    let mut u = Left::of(&u.collect::<Vec<_>>());
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

impl Left {
    fn of(errors: &[Vector6<f64>]) -> Self {
        let sizes = |first: usize| {
            let sizes = errors.iter().map(move |e| e.fixed_rows::<3>(first).norm());
            let squares: f64 = sizes.clone().map(|size| size * size).sum();
            let rms = (squares / errors.len().max(1) as f64).sqrt();
            (rms, sizes.fold(0.0, f64::max))
        };
        let ((rms_mm, max_mm), (rotation_rms_rad, rotation_max_rad)) = (sizes(0), sizes(3));
        Self {
            rms_mm,
            max_mm,
            rotation_rms_rad,
            rotation_max_rad,
        }
    }
}
