//! Why a network cannot be screened.

/// Lengths that cannot be screened. Indices refer to the [`Network`](trueaxis_multilateration::Network).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// The lengths cannot be adjusted.
    #[error(transparent)]
    Adjustment(#[from] trueaxis_multilateration::Error),
    /// So many readings contradict the others that the others prove nothing.
    #[error(
        "{} of {readings} lengths contradict the others; more than {:.0} % are no accident",
        removed.len(),
        limit * 100.0
    )]
    TooManyGrossErrors {
        removed: Vec<usize>,
        readings: usize,
        /// Share that may be removed.
        limit: f64,
    },
    /// So many readings would leave a station or a group that the others prove nothing.
    #[error("{part:?} would lose {removed} of {readings} lengths, more than {limit:.2} of them")]
    PartLost {
        part: Part,
        removed: usize,
        readings: usize,
        /// Share that may be removed.
        limit: f64,
    },
    /// Readings of points contradict each other, and nothing shows which are wrong.
    #[error("readings contradict each other in pairs, and nothing tells which is wrong: {pairs:?}")]
    Undecidable {
        /// For each point one reading, and another that may equally be wrong.
        pairs: Vec<(usize, usize)>,
    },
}

impl Error {
    /// Whether lengths contradict each other too much.
    pub fn is_contradiction(&self) -> bool {
        matches!(
            self,
            Self::TooManyGrossErrors { .. } | Self::PartLost { .. } | Self::Undecidable { .. }
        )
    }
}

/// A part of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All readings of a station.
    Station(usize),
    /// All readings of a group: one step of the machine from all stations.
    Group(usize),
}
