//! The noise of lengths, and the weights that follow from it.
//!
//! A length has a standard deviation of its own; and at every visit the machine returns to a slightly different
//! place, which moves all points read in the visit by the same small translation:
//!
//! ```text
//! C = diag(σ_l²) + σ_m² U Uᵀ        U: unit vectors station -> point, one row for each length
//! ```
//!
//! With [`Return`](crate::Return) `σ_m` is that of the group, and the machine also returns turned about an axis: `U` then
//! has a fourth column, the lever of the beam times the ratio of the standard deviations of angle and coordinate.
//!
//! Lengths are whitened visit by visit with the Cholesky factor of `C`, so correlation costs
//! nothing beyond a matrix of a few rows.

use crate::Error;

/// Standard deviations of lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Constant part of a length's standard deviation, mm.
    pub length_sigma_mm: f64,
    /// Part proportional to the distance, mm per mm (ppm × 1e-6).
    pub length_sigma_relative: f64,
    /// Standard deviation per coordinate of the position that the machine returns to, mm.
    pub repeatability_mm: f64,
}

impl Default for Noise {
    /// One µm for every length and a machine that returns exactly.
    fn default() -> Self {
        Self {
            length_sigma_mm: 1e-3,
            length_sigma_relative: 0.0,
            repeatability_mm: 0.0,
        }
    }
}

impl Noise {
    pub(crate) fn check(&self) -> Result<(), Error> {
        let Self {
            length_sigma_mm: a,
            length_sigma_relative: b,
            repeatability_mm: m,
        } = *self;
        let usable =
            a.is_finite() && b.is_finite() && m.is_finite() && a > 0.0 && b >= 0.0 && m >= 0.0;
        if usable {
            Ok(())
        } else {
            let what = format!(
                "noise must have a positive length_sigma_mm and no negative part, found {self:?}"
            );
            Err(Error::malformed(what))
        }
    }

    /// Standard deviation of a length at a distance, `√(a² + (b·l)²)`, mm.
    pub fn length_sigma_at_mm(&self, distance_mm: f64) -> f64 {
        // Most instruments have no proportional part: the same bits at a tenth of the cost.
        if self.length_sigma_relative == 0.0 {
            return self.length_sigma_mm;
        }
        self.length_sigma_mm
            .hypot(self.length_sigma_relative * distance_mm)
    }
}

/// Elements of the factor of a visit with `readings` lengths.
pub(crate) fn factor_len(readings: usize) -> usize {
    readings * (readings + 1) / 2
}
