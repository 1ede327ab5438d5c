//! How far the points are from what was fitted to them.

/// Residuals of a fit in one look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Root mean square of the orthogonal distances, mm.
    pub rms_mm: f64,
    /// Residual coordinates less unknowns: `2n - 4` for a line, `2n - 6` for a circle,
    /// `2n - 4 - 2k` for `k` circles about one axis.
    pub degrees_of_freedom: usize,
    /// Standard deviation of one coordinate of one point as the residuals show it, mm; `None`
    /// where the fit is exact by construction (no degrees of freedom).
    pub sigma_mm: Option<f64>,
}

impl Scatter {
    /// `sum_mm2`: sum of squared orthogonal distances. `residuals` counts the residual
    /// coordinates, two for each point.
    pub(crate) fn new(sum_mm2: f64, points: usize, unknowns: usize) -> Self {
        let degrees_of_freedom = (2 * points).saturating_sub(unknowns);
        Self {
            rms_mm: (sum_mm2 / points as f64).sqrt(),
            degrees_of_freedom,
            sigma_mm: (degrees_of_freedom > 0)
                .then(|| (sum_mm2 / degrees_of_freedom as f64).sqrt()),
        }
    }

    /// Variance of one coordinate, mm²: from `sigma_mm` if it is given, else from the residuals.
    pub(crate) fn variance_mm2(&self, sigma_mm: Option<f64>) -> Option<f64> {
        sigma_mm
            .or(self.sigma_mm)
            .map(|sigma_mm| sigma_mm * sigma_mm)
    }
}
