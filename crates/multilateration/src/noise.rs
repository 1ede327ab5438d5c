//! The noise of lengths, and the weights that follow from it.
//!
//! A length has a standard deviation of its own; and at every visit the machine returns to a
//! slightly different place, which moves all points read then by the same small translation:
//!
//! ```text
//! C = diag(σ_l²) + σ_m² U Uᵀ        U: unit vectors station -> point, one row for each length
//! ```
//!
//! Lengths are whitened visit by visit with the Cholesky factor of `C`, so correlation costs
//! nothing beyond a matrix of a few rows.

use nalgebra::Vector3;

use crate::Error;

/// Standard deviations of lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Constant part of a length's standard deviation, mm.
    pub length_sigma_mm: f64,
    /// Part proportional to the distance, mm per mm (ppm × 1e-6).
    pub length_sigma_relative: f64,
    /// Standard deviation per coordinate of the position that the machine returns to, mm.
    pub return_sigma_mm: f64,
}

impl Default for Noise {
    /// One µm for every length and a machine that returns exactly.
    fn default() -> Self {
        Self {
            length_sigma_mm: 1e-3,
            length_sigma_relative: 0.0,
            return_sigma_mm: 0.0,
        }
    }
}

impl Noise {
    pub(crate) fn check(&self) -> Result<(), Error> {
        let Self {
            length_sigma_mm: a,
            length_sigma_relative: b,
            return_sigma_mm: m,
        } = *self;
        let usable =
            a.is_finite() && b.is_finite() && m.is_finite() && a > 0.0 && b >= 0.0 && m >= 0.0;
        if usable {
            Ok(())
        } else {
            let what = format!(
                "noise must have a positive length_sigma_mm and no negative part, found {self:?}"
            );
            Err(Error::Malformed { what })
        }
    }

    /// Standard deviation of a length at a distance, `√(a² + (b·l)²)`, mm.
    pub fn length_sigma_at_mm(&self, distance_mm: f64) -> f64 {
        // The same bits at a tenth of the cost: most instruments are given no such part.
        if self.length_sigma_relative == 0.0 {
            return self.length_sigma_mm;
        }
        self.length_sigma_mm
            .hypot(self.length_sigma_relative * distance_mm)
    }

    /// Lower Cholesky factor of the covariance of one visit's lengths, appended row by row (`k`
    /// elements of row `k - 1`).
    pub(crate) fn append_factor(&self, beams: &[Beam], factor: &mut Vec<f64>) {
        let start = factor.len();
        let row_start = |i: usize| start + i * (i + 1) / 2;
        let return_variance = self.return_sigma_mm * self.return_sigma_mm;
        for (i, beam) in beams.iter().enumerate() {
            for (j, other) in beams.iter().enumerate().take(i + 1) {
                let mut c = return_variance * beam.direction.dot(&other.direction);
                if i == j {
                    c += self.length_sigma_at_mm(beam.distance_mm).powi(2) * beam.variance_factor;
                }
                for k in 0..j {
                    c -= factor[row_start(i) + k] * factor[row_start(j) + k];
                }
                // The diagonal stays positive: it keeps at least σ_l².
                let value = if i == j {
                    c.sqrt()
                } else {
                    c / factor[row_start(j) + j]
                };
                factor.push(value);
            }
        }
    }
}

/// What the noise of one length depends on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beam {
    /// Unit vector from the station to the point.
    pub(crate) direction: Vector3<f64>,
    pub(crate) distance_mm: f64,
    /// Factor on the variance of the length's own noise.
    pub(crate) variance_factor: f64,
}

/// Elements of the factor of a visit with `readings` lengths.
pub(crate) fn factor_len(readings: usize) -> usize {
    readings * (readings + 1) / 2
}

/// `x <- L⁻¹ x` for a factor made by [`Noise::append_factor`].
pub(crate) fn whiten(factor: &[f64], x: &mut [f64]) {
    let mut row = factor;
    for i in 0..x.len() {
        let (this, rest) = row.split_at(i + 1);
        let below: f64 = this[..i].iter().zip(&x[..i]).map(|(l, x)| l * x).sum();
        x[i] = (x[i] - below) / this[i];
        row = rest;
    }
}

/// Row `i` of the factor `L` of a visit, up to the diagonal.
pub(crate) fn unwhiten_row(factor: &[f64], i: usize) -> &[f64] {
    &factor[factor_len(i)..factor_len(i + 1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    #[test]
    fn factor_reproduces_the_covariance() {
        let noise = Noise {
            length_sigma_mm: 3e-4,
            length_sigma_relative: 5e-7,
            return_sigma_mm: 1e-3,
        };
        let beams = [
            (Vector3::new(1.0, 2.0, 2.0) / 3.0, 900.0, 1.0),
            (Vector3::new(2.0, -1.0, 2.0) / 3.0, 1100.0, 25.0),
            (Vector3::new(0.6, 0.0, 0.8), 1000.0, 1.0),
        ]
        .map(|(direction, distance_mm, variance_factor)| Beam {
            direction,
            distance_mm,
            variance_factor,
        });
        let mut l = Vec::new();
        noise.append_factor(&beams, &mut l);
        let l = Matrix3::new(l[0], 0.0, 0.0, l[1], l[2], 0.0, l[3], l[4], l[5]);
        let found = l * l.transpose();
        for i in 0..3 {
            for j in 0..3 {
                let own = if i == j {
                    (9e-8 + (5e-7 * beams[i].distance_mm).powi(2)) * beams[i].variance_factor
                } else {
                    0.0
                };
                let expected = own + 1e-6 * beams[i].direction.dot(&beams[j].direction);
                assert!((found[(i, j)] - expected).abs() < 1e-20);
            }
        }
    }
}
