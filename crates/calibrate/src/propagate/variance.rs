//! The variance of a linear function of the poses' errors.

use trueaxis_poses::ThroughSources;

/// Variance with the stations known, relative to the variances that cancel in it, below which it is rounding.
const CANCELLED: f64 = 1e-12;

/// A variance in its parts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Variance {
    /// With the stations known.
    pub(crate) own: f64,
    /// Through stations, dead paths and datum, declared parts included.
    pub(crate) through: f64,
    /// The declared part of `through`.
    pub(crate) declared: f64,
    /// Sum of the variances that combine to `own`.
    pub(crate) uncancelled: f64,
}

impl Variance {
    /// From `own` without shared sources, and the variances that come through them.
    pub(crate) fn new(own: f64, uncancelled: f64, through: &ThroughSources) -> Self {
        Self {
            own: own + through.shapes,
            through: through.stations,
            declared: through.declared,
            uncancelled,
        }
    }

    /// Whether gauge or frame define the function, so that it does not depend on the poses. Every pose has noise of
    /// its own, so no other function has zero variance with the stations known.
    pub(crate) fn is_defined_away(&self) -> bool {
        self.own < CANCELLED * self.uncancelled
    }
}
