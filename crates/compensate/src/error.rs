//! What can go wrong.

/// A correction that cannot be found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The errors change too fast with the position for the iteration.
    #[error(
        "no corrected positions for {positions:?} (mm, rad): each iteration leaves {contraction:.2} of the one before, \
         expected less than {limit}; the errors jump or are larger than those of a machine"
    )]
    NotContracting {
        /// Commanded positions of all axes, mm or rad.
        positions: Vec<f64>,
        /// Largest ratio of two corrections that follow each other.
        contraction: f64,
        /// The largest ratio that is accepted.
        limit: f64,
    },
}
