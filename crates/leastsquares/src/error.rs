//! Why a least-squares problem has no unique answer.

/// A problem that cannot be solved as posed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// A block has fewer rows than unknowns.
    #[error("block {block} has {rows} rows for {unknowns} unknowns")]
    TooFewRows {
        /// Number of the block, in the order of elimination.
        block: usize,
        rows: usize,
        unknowns: usize,
    },
    /// The rows of a block leave a combination of its unknowns free.
    #[error(
        "block {block}: unknown {unknown} is not determined (pivot {pivot:.1e} of its column, \
         limit {limit:.1e})"
    )]
    BlockRank {
        /// Number of the block, in the order of elimination.
        block: usize,
        unknown: usize,
        /// What is left of its column after those before it, relative.
        pivot: f64,
        limit: f64,
    },
    /// Shared unknowns are free beyond the motions that the datum fixes.
    #[error(
        "shared unknowns are not determined (free combinations: {defect}; eigenvalue \
         {eigenvalue:.1e} relative, limit {limit:.1e})"
    )]
    SharedRank {
        /// Free combinations beyond those that the datum fixes.
        defect: usize,
        /// The largest relative eigenvalue that counts as zero.
        eigenvalue: f64,
        limit: f64,
        /// Shared unknowns in the free combinations with their share (0 to 1), largest first.
        free: Vec<(usize, f64)>,
    },
    /// A dense design matrix does not have full column rank.
    #[error(
        "design matrix has rank {rank} of {unknowns} (singular value {singular_value:.1e} relative, \
         limit {limit:.1e})"
    )]
    DenseRank {
        rank: usize,
        unknowns: usize,
        /// The smallest relative singular value.
        singular_value: f64,
        limit: f64,
        /// For each unknown its share in the free combinations (0 to 1).
        free: Vec<f64>,
    },
    /// A number is infinite or not a number.
    #[error("{what} is not finite")]
    NotFinite { what: &'static str },
    /// A decomposition did not converge.
    #[error("the {what} did not converge")]
    Decomposition { what: &'static str },
}
