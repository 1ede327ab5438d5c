//! The errors that poses or points have in common: those of the shared unknowns of the adjustment, and of the
//! scale ([`crate::lengths::scale`]) where it is unknown.
//!
//! ```text
//! x_i = ξ_i - Z_i t - q_i s     s = cᵀ t + ε     so that     x_i = ξ_i - [Z_i + q_i cᵀ | q_i] (t, ε)
//! ```
//!
//! with the place `q_i` of a point or a pose.

use nalgebra::{DMatrix, DVector};
use trueaxis_multilateration::{BlockNoise, Network, Solution};

use crate::lengths::scale::Scale;

/// The covariance of shared errors, and what depends on them.
pub(crate) struct SharedSources<'s> {
    scale: Option<&'s Scale>,
    /// Sources of the adjustment.
    width: usize,
    /// `Σ`.
    pub(crate) shared: DMatrix<f64>,
    /// The part of it that is declared, not of the noise of lengths.
    pub(crate) declared: DMatrix<f64>,
    /// Stations, x y z and dead path of each, as functions of the sources.
    pub(crate) stations: DMatrix<f64>,
}

impl<'s> SharedSources<'s> {
    /// Those of the whole noise of a solution of this network; without the network those of the noise of lengths alone.
    pub(crate) fn new(
        noise: &BlockNoise<'_>,
        network: Option<&Network>,
        solution: &Solution,
        scale: Option<&'s Scale>,
    ) -> Self {
        let shared = noise.shared();
        let width = shared.nrows();
        let none = || DMatrix::zeros(width, width);
        let declared = network.map_or_else(none, |network| solution.known_noise(network));
        let [of_scale, declared_of_scale] = match (scale, network) {
            (Some(scale), Some(_)) => [scale.of_noise + scale.declared, scale.declared],
            (Some(scale), None) => [scale.of_noise, 0.0],
            (None, _) => [0.0; 2],
        };
        let count = 4 * solution.stations.len();
        let mut stations = DMatrix::identity(count, width);
        if let Some(mean) = solution.mean_constant_column() {
            (0..solution.stations.len()).for_each(|j| stations[(4 * j + 3, mean)] = 1.0);
        }
        let mut sources = Self {
            scale,
            width,
            shared: with_one_more(shared, of_scale, scale),
            declared: with_one_more(&declared, declared_of_scale, scale),
            stations,
        };
        let places = solution.stations.iter();
        let places = places.flat_map(|s| [s.position_mm.x, s.position_mm.y, s.position_mm.z, 0.0]);
        let places = DVector::from_iterator(count, places);
        // Stations are + t where poses are - Z t.
        sources.stations = -sources.coupling(-&sources.stations, &places);
        sources
    }

    /// What depends on the sources of the adjustment with `-Z`, and has these places, as a function of all.
    pub(crate) fn coupling(&self, z: DMatrix<f64>, places: &DVector<f64>) -> DMatrix<f64> {
        let Some(scale) = self.scale else { return z };
        let mut coupling = z.insert_column(self.width, 0.0);
        coupling.ger(
            1.0,
            places,
            &scale.coefficients(self.width).transpose(),
            1.0,
        );
        coupling
    }
}

/// A covariance with an independent source behind the others where the scale is unknown.
fn with_one_more(covariance: &DMatrix<f64>, variance: f64, scale: Option<&Scale>) -> DMatrix<f64> {
    let width = covariance.nrows();
    let added = usize::from(scale.is_some());
    let mut all = covariance.clone().resize(width + added, width + added, 0.0);
    if added > 0 {
        all[(width, width)] = variance;
    }
    all
}
