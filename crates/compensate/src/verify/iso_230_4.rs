//! Circular tests by ISO 230-4:2005, 3, as far as the set-up of the bar leaves them determined.
//!
//! - `G`: circular deviation, the distance of two concentric circles around a path, here about its least-squares centre;
//!   `G(b)`: the same around both paths, clockwise and counter-clockwise, about their common centre.
//! - `H`: circular hysteresis, the largest difference of the two paths.
//!
//! The radial deviations F and D need the true length of the bar, which a set-up does not know.

/// The quantities, µm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circular {
    /// G of the readings with direction +1.
    pub g_forward_um: Option<f64>,
    /// G of those with direction -1.
    pub g_backward_um: Option<f64>,
    /// G(b), both.
    pub g_both_um: Option<f64>,
    /// H.
    pub h_um: Option<f64>,
}

/// Largest minus smallest of what is left.
pub(crate) fn circular_deviation(left: &[f64]) -> Option<f64> {
    let high = left.iter().copied().reduce(f64::max)?;
    Some(high - left.iter().copied().reduce(f64::min)?)
}
