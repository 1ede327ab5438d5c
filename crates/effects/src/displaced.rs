//! What an effect does to one reading.

use nalgebra::Vector3;

use crate::{Circumstances, Effect, Shape, Subject};

/// Displacements in the reference frame, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Displaced {
    /// Of the target.
    pub point_mm: Vector3<f64>,
    /// Of the station.
    pub station_mm: Vector3<f64>,
    /// What the instrument shows beyond the distance.
    pub length_mm: f64,
}

impl Displaced {
    /// A displacement of the target alone.
    pub fn point(point_mm: Vector3<f64>) -> Self {
        Self {
            point_mm,
            ..Self::default()
        }
    }

    /// A displacement of the station alone.
    pub fn station(station_mm: Vector3<f64>) -> Self {
        Self {
            station_mm,
            ..Self::default()
        }
    }

    /// A change of what is shown alone.
    pub fn length(length_mm: f64) -> Self {
        Self {
            length_mm,
            ..Self::default()
        }
    }

    /// Change of a length measured along the unit vector `beam` from station to target, to first
    /// order: `u·D_p - u·D_S + D_l`, mm.
    pub fn along(&self, beam: &Vector3<f64>) -> f64 {
        beam.dot(&(self.point_mm - self.station_mm)) + self.length_mm
    }
}

/// What an effect with the values `parameters` (in the units of [`Effect::parameters`]) and the
/// shape does to a reading.
pub fn displacement(
    effect: &dyn Effect,
    subject: &Subject,
    parameters: &[f64],
    shape: f64,
    at: &Circumstances<'_>,
) -> Displaced {
    let mut sum = Displaced::default();
    if effect.shape() == Shape::Instant && at.time_s <= shape {
        return sum;
    }
    for (k, value) in parameters.iter().enumerate() {
        let unit = effect.form(subject, k, shape, at);
        sum.point_mm += unit.point_mm * *value;
        sum.station_mm += unit.station_mm * *value;
        sum.length_mm += unit.length_mm * value;
    }
    sum
}
