//! What an effect does to one reading.

use nalgebra::Vector3;

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
    #[inline]
    pub fn along(&self, beam: &Vector3<f64>) -> f64 {
        beam.dot(&(self.point_mm - self.station_mm)) + self.length_mm
    }

    /// Adds `times` another one.
    pub(crate) fn add(&mut self, times: f64, other: &Self) {
        self.point_mm += other.point_mm * times;
        self.station_mm += other.station_mm * times;
        self.length_mm += other.length_mm * times;
    }
}

/// What several effects do together: each sees the circumstances and not what another one makes of them.
impl std::iter::Sum for Displaced {
    fn sum<I: Iterator<Item = Self>>(effects: I) -> Self {
        effects.fold(Self::default(), |mut sum, by| {
            sum.add(1.0, &by);
            sum
        })
    }
}
