//! Why an adjustment stopped.

/// Why the iteration of [`adjust`](super::adjust()) stopped. Lengths are in the unit of the
/// residuals.
#[derive(Debug, Clone, PartialEq)]
pub enum Termination {
    /// A minimum: full rank, positive curvature, and Newton's step is below the tolerance.
    Converged {
        /// Length by which Newton's step changes the residuals, `|J δx|`.
        offset: f64,
        /// The tolerance: a fraction of the residuals or, if larger, their rounding.
        tolerance: f64,
    },
    /// Stationary, but combinations of the unknowns are not determined there.
    RankDefect {
        /// Numerical rank of the Jacobian.
        rank: usize,
        /// Number of unknowns.
        unknowns: usize,
        /// Its least singular value with unit columns, relative to the largest.
        singular_value: f64,
        /// The least value accepted.
        limit: f64,
        /// For each unknown its share in the free combinations (0 to 1).
        free: Vec<f64>,
    },
    /// Stationary, but the sum of squares falls away from there: a saddle or a maximum.
    NoMinimum {
        /// Least curvature of the sum of squares relative to that of the linearised residuals.
        /// Not a number if the Jacobian is not finite beside this point.
        curvature: f64,
    },
    /// No step lowers the sum of squares, and the offset is longer than rounding explains.
    Stalled {
        /// `|J δx|` of the step without damping.
        offset: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// The most iterations were used up.
    MaxIterations {
        /// `|J δx|` of the step without damping.
        offset: f64,
        /// The tolerance.
        tolerance: f64,
    },
}

impl Termination {
    /// Whether the result is a minimum.
    pub fn is_converged(&self) -> bool {
        matches!(self, Self::Converged { .. })
    }
}
