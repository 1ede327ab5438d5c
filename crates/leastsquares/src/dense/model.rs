//! What is adjusted.

use nalgebra::DMatrix;

/// Residuals that depend on unknowns.
pub trait Model {
    /// Whitened residuals, the same number everywhere. Not finite outside the domain of the model.
    fn residuals(&self, unknowns: &[f64]) -> Vec<f64>;

    /// Their derivatives, a row for each residual, a column for each unknown.
    fn jacobian(&self, unknowns: &[f64]) -> DMatrix<f64>;

    /// Length by which rounding of data and in the model changes the residuals, beyond the
    /// rounding of the unknowns, which is always reckoned with. Worth stating where residuals
    /// are small differences of large numbers that do not depend on the unknowns.
    fn rounding(&self) -> f64 {
        0.0
    }
}
