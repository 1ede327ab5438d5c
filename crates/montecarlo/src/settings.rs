//! How a propagation is made.

use std::num::NonZeroUsize;

use crate::coverage;
use crate::error::Error;
use crate::stability;
use crate::tolerance;

/// How many trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trials {
    /// This many.
    Fixed(usize),
    /// As many blocks of max(10⁴, 100/(1 - p)) trials as it takes until every output has stabilised
    /// to the digits asked for (JCGM 101, 7.9.4; see [`Stability`](crate::Stability)).
    Adaptive {
        /// Number of significant decimal digits of the standard uncertainty, 1 to 15.
        significant_digits: u32,
        /// Stop here even when the results have not stabilised; whole blocks, at least two.
        most: usize,
    },
}

/// How a propagation is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Number of trials. With the default, 10⁵, one significant digit of the standard uncertainty and of a 95 %
    /// interval is stable for a distribution close to normal.
    pub trials: Trials,
    /// Seed of the random streams.
    pub seed: u64,
    /// Coverage probability of the intervals, default 0.95.
    pub coverage: f64,
    /// Number of threads; without it, the rayon pool that the call is made in. It does not change
    /// the result.
    pub threads: Option<NonZeroUsize>,
    /// Most bytes that the kept values may take, default 2 GiB. Sorting takes 8 bytes per trial
    /// and thread on top.
    pub memory_limit_bytes: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            trials: Trials::Fixed(100_000),
            seed: 0,
            coverage: 0.95,
            threads: None,
            memory_limit_bytes: 2 << 30,
        }
    }
}

impl Settings {
    /// Whether a propagation of this number of outputs can be made as asked.
    pub(crate) fn check(&self, outputs: usize) -> Result<(), Error> {
        let coverage = self.coverage;
        if !(coverage > 0.0 && coverage < 1.0) {
            return Err(Error::Coverage { coverage });
        }
        if outputs == 0 {
            return Err(Error::NoOutputs);
        }
        let most = match self.trials {
            Trials::Fixed(trials) => {
                if trials < 2 || coverage::ranks(trials, coverage).is_none() {
                    return Err(Error::TooFewTrials { trials, coverage });
                }
                trials
            }
            Trials::Adaptive {
                significant_digits,
                most,
            } => {
                tolerance::check_digits(significant_digits)?;
                let block = stability::block_trials(coverage);
                if most / 2 < block {
                    return Err(Error::TooFewForBlocks { most, block });
                }
                most
            }
        };
        check_memory(outputs, most, self.memory_limit_bytes)
    }
}

/// Whether the values of this number of trials stay within the limit.
fn check_memory(outputs: usize, trials: usize, limit_bytes: u64) -> Result<(), Error> {
    let value_bytes = size_of::<f64>() as u128;
    let row_bytes = outputs as u128 * value_bytes;
    let bytes = row_bytes * trials as u128;
    if bytes <= u128::from(limit_bytes) {
        return Ok(());
    }
    Err(Error::Memory {
        outputs,
        trials,
        bytes,
        limit_bytes,
        fitting_trials: u128::from(limit_bytes) / row_bytes,
    })
}
