//! The variance of a linear function of the points' errors.

use trueaxis_poses::ThroughSources;

/// Variance with the stations known, relative to the variances that cancel in it, below which it is
/// rounding.
const CANCELLED: f64 = 1e-12;

/// A variance in its parts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Variance {
    /// With the stations known.
    pub(crate) own: f64,
    /// What comes through the stations, and what all that is declared does.
    pub(crate) through: f64,
    /// Of that, what is declared.
    pub(crate) declared: f64,
    /// Sum of the variances whose combination `own` is.
    pub(crate) uncancelled: f64,
}

impl Variance {
    /// From `own` beside what comes through shared sources, and that.
    pub(crate) fn new(own: f64, uncancelled: f64, through: &ThroughSources) -> Self {
        Self {
            own: own + through.shapes,
            through: through.stations,
            declared: through.declared,
            uncancelled,
        }
    }

    /// Whether gauge or frame define the function, so that it does not depend on the points: every
    /// point has noise of its own, so nothing else has no variance with the stations known.
    pub(crate) fn is_defined_away(&self) -> bool {
        self.own < CANCELLED * self.uncancelled
    }
}
