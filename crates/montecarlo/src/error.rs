//! Why a propagation or its comparison cannot be made.

/// A propagation that cannot be made as asked, or a trial that failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// The coverage probability is not between 0 and 1.
    #[error("the coverage probability is {coverage}, but must lie between 0 and 1")]
    Coverage { coverage: f64 },
    /// The model has nothing to propagate to.
    #[error("the model has no outputs")]
    NoOutputs,
    /// All trials would lie inside the coverage interval.
    #[error(
        "{trials} trials are too few for an interval that covers {coverage}: none would lie \
         outside ({:.0} are recommended)",
        1e4 / (1.0 - coverage)
    )]
    TooFewTrials { trials: usize, coverage: f64 },
    /// Stability is judged from the scatter between blocks, so there must be two.
    #[error("{most} trials at most cannot hold two blocks of {block}: allow {} or more", 2 * block)]
    TooFewForBlocks { most: usize, block: usize },
    /// A number of significant digits that an f64 does not have.
    #[error("{significant_digits} significant digits are asked for, but 1 to {most} are possible")]
    SignificantDigits { significant_digits: u32, most: u32 },
    /// The values of all trials need more memory than the settings allow.
    #[error(
        "{trials} trials of {outputs} outputs take {bytes} bytes, but the limit is {limit_bytes}; \
         {fitting_trials} trials fit"
    )]
    Memory {
        outputs: usize,
        trials: usize,
        bytes: u128,
        limit_bytes: u64,
        fitting_trials: u128,
    },
    /// The system does not have the memory that the settings allow.
    #[error("no memory for {trials} trials of {outputs} outputs")]
    Allocation { outputs: usize, trials: usize },
    /// The threads could not be started.
    #[error("{threads} threads could not be started: {reason}")]
    Threads { threads: usize, reason: String },
    /// A trial failed: one of its outputs is infinite or not a number. It is the first such trial
    /// on any number of threads.
    #[error("trial {trial}: output {output} is {value}")]
    NotFinite {
        /// Number of the trial, from 0; also the number of its random stream.
        trial: u64,
        /// The first output of that trial that is not finite, from 0.
        output: usize,
        value: f64,
    },
    /// The values of an output are finite, but so large that their squares are not.
    #[error("output {output}: the values are too large, the standard deviation overflows")]
    Overflow {
        /// The output, from 0.
        output: usize,
    },
    /// A first-order result with a number that is infinite or not a number.
    #[error(
        "first-order result {value}, standard uncertainty {u}, coverage factor {coverage_factor}: \
         all must be finite"
    )]
    FirstOrderNotFinite {
        value: f64,
        u: f64,
        coverage_factor: f64,
    },
}
