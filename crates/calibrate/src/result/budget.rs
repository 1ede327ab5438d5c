//! The parts of a variance, and how well it is known.
//!
//! With `u²` of a result, `u_s²` what is left of it with the stations known, and `u_l²` the part of `u_s²` that
//! lengths without the machine's repeatability would cause:
//!
//! ```text
//! laser u_l²     repeatability u_s² - u_l²     station geometry u² - u_s²
//! ```
//!
//! What is declared (the scale of the instrument, known lengths and dead paths, constants of reflectors, nests of
//! targets, temperatures) is not noise of the campaign and is a part of its own. So is, where effects were removed
//! from the lengths, the uncertainty of their values.
//!
//! No part is negative, because no result depends on the datum: the covariance of the points with the stations known
//! is that of an adjustment without datum, the estimated stations add the variance that comes through them, and the
//! noise of the machine's return adds to that of the lengths with the same weights.
//!
//! # Degrees of freedom
//!
//! The noise has two variance factors, of the lengths and of the machine's repeatability. Let them be estimated with
//! the covariance `K` relative to their values. Beside declared parts, which count as known, `u² = g_1 + g_2` (from
//! the lengths, including what goes through the stations, and from the return) then has the variance `gᵀ K g`, and
//! matching a chi-squared distribution gives (Welch 1947, Satterthwaite 1946; JCGM 100:2008 G.4.1 with correlation)
//!
//! ```text
//! ν = 2 u⁴ / gᵀ K g
//! ```

use nalgebra::{Matrix2, Vector2};

/// Parts of a variance u², mm² or rad².
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Budget {
    /// The lengths' own noise with the stations known; for a points campaign the instrument's
    /// scatter.
    pub laser: f64,
    /// The repeatability with the stations known.
    pub repeatability: f64,
    /// What is added because the stations are estimated, whatever noise causes it.
    pub station_geometry: f64,
    /// Declared parts common to many lengths: scale, known lengths, dead paths, reflectors, nests of targets,
    /// temperatures.
    pub systematic: f64,
    /// The uncertainty of the values of effects that were removed from the lengths.
    pub effects: f64,
    /// All that the lengths' own noise causes: `laser` and its part of `station_geometry`. The machine's return
    /// causes the rest of u², except `systematic` and `effects`.
    pub laser_in_all: f64,
}

/// Negative parts up to this share of u² are rounding.
const ROUNDING: f64 = 1e-9;

impl Budget {
    /// From the variances with the stations known, of the laser alone and of all noise; the same with the stations
    /// estimated; and the declared part of the latter.
    pub(crate) fn new(stations_known: [f64; 2], in_all: [f64; 2], systematic: f64) -> Self {
        let [laser, known] = stations_known;
        let [laser_in_all, all] = in_all;
        let not_negative = |part: f64| {
            if part < 0.0 && part >= -ROUNDING * all {
                0.0
            } else {
                part
            }
        };
        Self {
            laser: not_negative(laser),
            repeatability: not_negative(known - laser),
            station_geometry: not_negative(all - known - systematic),
            systematic,
            effects: 0.0,
            laser_in_all: not_negative(laser_in_all),
        }
    }

    pub(crate) fn times(&self, factor: f64) -> Self {
        Self {
            laser: factor * self.laser,
            repeatability: factor * self.repeatability,
            station_geometry: factor * self.station_geometry,
            systematic: factor * self.systematic,
            effects: factor * self.effects,
            laser_in_all: factor * self.laser_in_all,
        }
    }

    /// u².
    pub fn variance(&self) -> f64 {
        let of_noise = self.laser + self.repeatability + self.station_geometry;
        of_noise + self.systematic + self.effects
    }

    /// The five parts as shares of u²; `None` if it is zero.
    pub fn shares(&self) -> Option<[f64; 5]> {
        let variance = self.variance();
        let parts = [
            self.laser,
            self.repeatability,
            self.station_geometry,
            self.systematic,
            self.effects,
        ];
        (variance > 0.0).then(|| parts.map(|part| part / variance))
    }

    /// `ν = 2 u⁴ / gᵀ K g` (Welch–Satterthwaite, with correlated factors) for the relative covariance `K` of the
    /// variance factors; infinite if these are known.
    pub(crate) fn degrees_of_freedom(&self, relative_covariance: &Matrix2<f64>) -> f64 {
        let variance = self.variance();
        let of_repeatability = variance - self.laser_in_all - self.systematic - self.effects;
        let g = Vector2::new(self.laser_in_all, of_repeatability);
        let of_variance = g.dot(&(relative_covariance * g));
        if of_variance > 0.0 {
            2.0 * variance * variance / of_variance
        } else {
            f64::INFINITY
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_of_freedom_follow_from_the_variance_factors() {
        let budget = Budget::new([1.0, 4.0], [2.0, 5.0], 0.0);
        assert!((budget.variance() - 5.0).abs() < 1e-15);
        let of = |k: Matrix2<f64>| budget.degrees_of_freedom(&k);
        assert!(of(Matrix2::zeros()).is_infinite());
        // One common factor with ν degrees of freedom: variance 2/ν, fully correlated.
        assert!((of(Matrix2::repeat(2.0 / 17.0)) - 17.0).abs() < 1e-12);
        // Independent factors: the formula of Welch and Satterthwaite.
        let (laser, machine) = (40.0, 9.0);
        let expected = 25.0 / (2.0 * 2.0 / laser + 3.0 * 3.0 / machine);
        let found = of(Matrix2::new(2.0 / laser, 0.0, 0.0, 2.0 / machine));
        assert!((found - expected).abs() < 1e-12);
    }

    /// Declared parts are known: they add degrees of freedom, and no other part contains them.
    #[test]
    fn what_is_declared_is_no_noise() {
        let noise = Budget::new([1.0, 4.0], [2.0, 5.0], 0.0);
        let with = Budget::new([1.0, 4.0], [2.0, 8.0], 3.0);
        assert!((with.station_geometry - noise.station_geometry).abs() < 1e-15);
        assert!((with.shares().unwrap().iter().sum::<f64>() - 1.0).abs() < 1e-15);
        let k = Matrix2::new(2.0 / 40.0, 0.0, 0.0, 2.0 / 9.0);
        let ratio = with.degrees_of_freedom(&k) / noise.degrees_of_freedom(&k);
        assert!((ratio - (8.0_f64 / 5.0).powi(2)).abs() < 1e-12);
    }

    #[test]
    fn only_rounding_is_taken_for_zero() {
        let rounded = Budget::new([1.0 + 1e-12, 1.0], [1.0, 1.0], 0.0);
        assert!(rounded.repeatability.abs() < f64::MIN_POSITIVE);
        let wrong = Budget::new([1.1, 1.0], [1.0, 1.0], 0.0);
        assert!(wrong.repeatability < -0.05);
    }
}
